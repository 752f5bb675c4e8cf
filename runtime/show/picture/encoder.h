// ffmpeg as a process that makes a film of the pictures it gets. The only use of ffmpeg.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <string>

#include "runtime/base/error.h"
#include "runtime/show/render/image.h"

namespace meld::picture {

class Encoder {
  public:
    struct Options {
        std::string path;   // Of a file that exists and is overwritten; it ends with .mp4 or .webm.
        std::string shown;  // What it is called in errors.
        std::size_t width = 0, height = 0;
        double fps = 30;
    };
    // Errors: there is none on the PATH.
    static Result<void> check();
    static Result<Encoder> start(const Options& options);
    Encoder(Encoder&& other) noexcept;
    Encoder& operator=(Encoder&&) = delete;
    // Ends it if it has not finished.
    ~Encoder();

    // One more picture, opaque. Errors: those of finish().
    Result<void> add(const render::Image& image);
    // There are no more; waits until the file is whole. Errors: what ffmpeg says is wrong, such as a full disk (4).
    Result<void> finish();

  private:
    explicit Encoder(std::string shown) : shown_(std::move(shown)) {}
    std::string shown_;
    pid_t process_ = -1;
    int pictures_ = -1;  // A pipe to it.
    int said_ = -1;      // A file without a name that it writes its errors to.
};

}  // namespace meld::picture
