#include "runtime/show/picture/film_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string_view>
#include <utility>

#include "runtime/base/files/output_file.h"
#include "runtime/base/files/output_lock.h"
#include "runtime/show/picture/encoder.h"

namespace meld::picture {

namespace {

namespace fs = std::filesystem;

bool is_frame(const std::string& name) {
    return name.size() == std::string_view("00000.png").size() && name.ends_with(".png") &&
           std::ranges::all_of(name.substr(0, 5), [](char c) { return c >= '0' && c <= '9'; });
}

Result<void> check_folder(const std::string& path) {
    std::error_code error;
    for (fs::directory_iterator at(path, error), end; !error && at != end; at.increment(error))
        if (is_frame(at->path().filename().string()))
            return fail(fmt::format("there are frames in {} already, such as {}", path, at->path().filename().string()),
                        "Remove them, or choose another folder");
    return {};
}

class Folder : public FilmFile {
  public:
    Folder(std::string path, OutputLock lock) : path_(std::move(path)), lock_(std::move(lock)) {}
    Result<void> add(render::Image& image) override {
        auto file = OutputFile::open(fmt::format("{}/{:05}.png", path_, next_++), Appears::Whole);
        if (!file) return tl::unexpected<Error>(file.error());
        if (auto written = render::write_png(image, *file); !written) return written;
        return file->commit();
    }
    Result<void> commit() override { return {}; }

  private:
    std::string path_;
    OutputLock lock_;  // Otherwise the pictures of two films would be numbered by turns.
    std::size_t next_ = 0;
};

class Encoded : public FilmFile {
  public:
    Encoded(OutputFile file, Encoder encoder) : file_(std::move(file)), encoder_(std::move(encoder)) {}
    Result<void> add(render::Image& image) override { return encoder_.add(image); }
    Result<void> commit() override {
        if (auto done = encoder_.finish(); !done) return done;
        file_.note_written();
        return file_.commit();
    }

  private:
    OutputFile file_;  // Goes last, when nothing is written to it any more.
    Encoder encoder_;
};

}  // namespace

bool FilmFile::is_folder(const std::string& path) {
    std::error_code error;
    return path.ends_with('/') || fs::is_directory(path, error);
}

Result<void> FilmFile::check(const std::string& path, std::size_t width, std::size_t height) {
    if (is_folder(path)) return check_folder(path);
    if (!path.ends_with(".mp4") && !path.ends_with(".webm"))
        return fail(fmt::format("a film is an .mp4 or .webm file, or a folder, and {} is none", path),
                    "Write -o FILE.mp4, -o FILE.webm, or -o FOLDER/ for numbered pictures; meldsim shot makes a single picture");
    if (OutputFile::names_stream(path))
        return fail(fmt::format("cannot write {}: a film is no stream, and this is no regular file", path), "Choose another path");
    if (width % 2 != 0 || height % 2 != 0)
        return fail(
            fmt::format("a film of {} x {} pixels cannot be encoded: it has to have an even number of rows and columns", width, height),
            fmt::format("Write --size {}x{}", width + width % 2, height + height % 2));
    return Encoder::check();
}

Result<std::unique_ptr<FilmFile>> FilmFile::open(const std::string& path, std::size_t width, std::size_t height, double fps) {
    if (auto can = check(path, width, height); !can) return tl::unexpected<Error>(can.error());
    if (is_folder(path)) {
        std::error_code error;
        fs::create_directories(path, error);
        if (error) return tl::unexpected<Error>(cannot_write(path, error.value()));
        const std::string folder = path.substr(0, std::max<std::size_t>(path.find_last_not_of('/') + 1, 1));
        Result<OutputLock> lock = OutputLock::take((fs::path(folder) / "film").string(), path);
        if (!lock) return tl::unexpected<Error>(lock.error());
        // Another film may have been written until now.
        if (auto free = check_folder(path); !free) return tl::unexpected<Error>(free.error());
        return std::make_unique<Folder>(folder, std::move(*lock));
    }
    auto file = OutputFile::open(path, Appears::Whole);
    if (!file) return tl::unexpected<Error>(file.error());
    const Result<std::string> place = file->place();
    if (!place) return tl::unexpected<Error>(place.error());
    Result<Encoder> encoder = Encoder::start({.path = *place, .shown = path, .width = width, .height = height, .fps = fps});
    if (!encoder) return tl::unexpected<Error>(encoder.error());
    return std::make_unique<Encoded>(std::move(*file), std::move(*encoder));
}

}  // namespace meld::picture
