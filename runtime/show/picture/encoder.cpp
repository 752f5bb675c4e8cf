#include "runtime/show/picture/encoder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <system_error>
#include <utility>
#include <vector>

#include "runtime/base/files/output_file.h"
#include "runtime/base/terminal/terminal_text.h"

namespace meld::picture {

namespace {

constexpr std::size_t kMostSaid = 1 << 16;

std::vector<std::string> command(const Encoder::Options& options) {
    std::vector<std::string> out = {"ffmpeg", "-hide_banner", "-nostats", "-loglevel", "error", "-xerror", "-y"};
    const auto add = [&](std::initializer_list<std::string> words) { out.insert(out.end(), words); };
    add({"-f", "rawvideo", "-pixel_format", "bgr0", "-video_size", fmt::format("{}x{}", options.width, options.height)});
    add({"-framerate", fmt::format("{}", options.fps), "-i", "pipe:0", "-an"});
    // Players take colours to be these; without saying so, greens and reds come out wrong.
    add({"-vf", "scale=out_color_matrix=bt709:out_range=tv", "-pix_fmt", "yuv420p", "-colorspace", "bt709", "-color_primaries", "bt709",
         "-color_trc", "bt709", "-color_range", "tv"});
    if (options.path.ends_with(".webm"))
        add({"-c:v", "libvpx-vp9", "-crf", "24", "-b:v", "0", "-row-mt", "1", "-deadline", "good", "-cpu-used", "4"});
    else
        // It begins to play before all of it has come over a network.
        add({"-c:v", "libx264", "-crf", "17", "-preset", "medium", "-movflags", "+faststart"});
    // The same bits each time.
    add({"-map_metadata", "-1", "-fflags", "+bitexact", "-flags:v", "+bitexact", "file:" + options.path});
    return out;
}

// As a shell finds it.
bool on_path(const std::string& name) {
    const char* const path = std::getenv("PATH");
    const std::string all = path != nullptr ? path : "/usr/local/bin:/usr/bin:/bin";
    for (std::size_t at = 0; at <= all.size();) {
        const std::size_t end = std::min(all.find(':', at), all.size());
        const std::string folder = all.substr(at, end - at), file = (folder.empty() ? "." : folder) + "/" + name;
        struct stat status{};
        if (stat(file.c_str(), &status) == 0 && S_ISREG(status.st_mode) && access(file.c_str(), X_OK) == 0) return true;
        at = end + 1;
    }
    return false;
}

// The last that was written to it, without the end of the line.
std::string end_of(int file) {
    const off_t size = lseek(file, 0, SEEK_END);
    std::string text(std::min<std::size_t>(size > 0 ? static_cast<std::size_t>(size) : 0, kMostSaid), '\0');
    const ssize_t read = pread(file, text.data(), text.size(), size - static_cast<off_t>(text.size()));
    text.resize(read > 0 ? static_cast<std::size_t>(read) : 0);
    text.resize(text.find_last_not_of(" \r\n") + 1);
    return text;
}

}  // namespace

Result<void> Encoder::check() {
    if (on_path("ffmpeg")) return {};
    return fail("there is no ffmpeg, which .mp4 and .webm films are made with",
                "Install it (apt-get install ffmpeg), or write -o FOLDER/ for numbered pictures");
}

Result<Encoder> Encoder::start(const Options& options) {
    Encoder out(options.shown);
    int ends[2] = {-1, -1};
    out.said_ = memfd_create("ffmpeg", MFD_CLOEXEC);
    if (out.said_ < 0 || pipe2(ends, O_CLOEXEC) != 0) return tl::unexpected<Error>(cannot_write(options.shown, errno));
    out.pictures_ = ends[1];
    // Fewer turns between the two processes.
    fcntl(out.pictures_, F_SETPIPE_SZ, 1 << 20);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, ends[0], STDIN_FILENO);
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&files, out.said_, STDERR_FILENO);
    posix_spawnattr_t how;
    posix_spawnattr_init(&how);
    sigset_t none, usual;
    sigemptyset(&none);
    sigemptyset(&usual);
    sigaddset(&usual, SIGPIPE);
    posix_spawnattr_setsigmask(&how, &none);
    posix_spawnattr_setsigdefault(&how, &usual);
    // A group of its own: Ctrl-C ends the film after the frames that there are, and ffmpeg has to see their end.
    posix_spawnattr_setpgroup(&how, 0);
    posix_spawnattr_setflags(&how, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
    const std::vector<std::string> words = command(options);
    std::vector<char*> arguments;
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    const int error = posix_spawnp(&out.process_, "ffmpeg", &files, &how, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&how);
    ::close(ends[0]);
    if (error == 0) return out;
    out.process_ = -1;
    return fail(fmt::format("ffmpeg cannot be started: {}", std::generic_category().message(error)));
}

Encoder::Encoder(Encoder&& other) noexcept
    : shown_(std::move(other.shown_)),
      process_(std::exchange(other.process_, -1)),
      pictures_(std::exchange(other.pictures_, -1)),
      said_(std::exchange(other.said_, -1)) {}

Encoder::~Encoder() {
    if (pictures_ >= 0) ::close(pictures_);
    if (process_ > 0) {
        kill(process_, SIGKILL);
        while (waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
        }
    }
    if (said_ >= 0) ::close(said_);
}

Result<void> Encoder::add(const render::Image& image) {
    const char* at = reinterpret_cast<const char*>(image.pixels.data());
    std::size_t left = image.pixels.size() * sizeof(std::uint32_t);
    while (left > 0) {
        const ssize_t written = ::write(pictures_, at, left);
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) {
            // It has ended before its time, and has said why.
            auto done = finish();
            return done ? tl::unexpected<Error>(cannot_write(shown_, EPIPE)) : done;
        }
        at += written;
        left -= static_cast<std::size_t>(written);
    }
    return {};
}

Result<void> Encoder::finish() {
    if (pictures_ >= 0) ::close(std::exchange(pictures_, -1));
    int status = 0;
    while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
    }
    process_ = -1;
    std::string said = end_of(said_);
    // It ends well after some errors of disks, and has only said so.
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0 && said.empty()) return {};
    for (const int error : {ENOSPC, EDQUOT, EFBIG})
        if (said.find(std::generic_category().message(error)) != std::string::npos)
            return tl::unexpected<Error>(cannot_write(shown_, error));
    said = said.substr(said.rfind('\n') + 1);
    if (said.empty())
        said = WIFSIGNALED(status) ? fmt::format("it was killed by signal {}", WTERMSIG(status))
                                   : fmt::format("it ended with exit code {}", WEXITSTATUS(status));
    return fail(fmt::format("ffmpeg cannot make {}: {}", shown_, visible(said)), "Or write -o FOLDER/ for numbered pictures",
                ExitCode::LimitHit);
}

}  // namespace meld::picture
