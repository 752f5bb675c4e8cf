// What a film is written to: numbered pictures in a folder, or a file that ffmpeg makes of them.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <memory>
#include <string>

#include "runtime/base/error.h"
#include "runtime/show/render/image.h"

namespace meld::picture {

class FilmFile {
  public:
    // The path of a folder, which ends with a slash or is one; or of an .mp4 or .webm file.
    static bool is_folder(const std::string& path);
    // Whether this can be written, before there is anything to write. Errors: the name says neither; there is no ffmpeg; the size does not
    // suit it; the folder has other frames.
    static Result<void> check(const std::string& path, std::size_t width, std::size_t height);

    // Errors: those of check(), and of the files.
    static Result<std::unique_ptr<FilmFile>> open(const std::string& path, std::size_t width, std::size_t height, double fps);

    virtual ~FilmFile() = default;
    FilmFile(const FilmFile&) = delete;
    FilmFile& operator=(const FilmFile&) = delete;
    // The next picture. A file is seen when it is whole only; numbered pictures one by one.
    virtual Result<void> add(render::Image& image) = 0;
    virtual Result<void> commit() = 0;

  protected:
    FilmFile() = default;
};

}  // namespace meld::picture
