#include "runtime/ask/debug/line_history.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <optional>

namespace meld::debug {

namespace {

namespace fs = std::filesystem;

// So many lines are kept, and the file is shortened when it has twice as many; what is longer is no history of ours.
constexpr std::size_t kKeptLines = 1000;
constexpr std::size_t kMaxHistory_bytes = std::size_t{1} << 24;

class Descriptor {
  public:
    // Never waits, as for the reader of a pipe. Only a file of this user counts.
    Descriptor(const std::string& path, int flags) : number_(::open(path.c_str(), flags | O_CLOEXEC | O_NONBLOCK | O_NOCTTY, 0600)) {
        struct stat status{};
        if (number_ >= 0 && (::fstat(number_, &status) != 0 || !S_ISREG(status.st_mode) || status.st_uid != ::geteuid())) close();
    }
    ~Descriptor() { close(); }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;

    explicit operator bool() const { return number_ >= 0; }
    // Nothing if it cannot be read, or is too large.
    std::optional<std::string> read() const {
        std::string text;
        std::array<char, 4096> block;
        while (text.size() <= kMaxHistory_bytes) {
            const ssize_t size = ::read(number_, block.data(), block.size());
            if (size == 0) return text;
            if (size < 0 && errno == EINTR) continue;
            if (size < 0) return std::nullopt;
            text.append(block.data(), static_cast<std::size_t>(size));
        }
        return std::nullopt;
    }
    // In one piece, so that the lines of two sessions do not mix. Whatever mode it had, it is for this user's eyes.
    bool write(std::string_view text) const {
        return ::fchmod(number_, 0600) == 0 && ::write(number_, text.data(), text.size()) == static_cast<ssize_t>(text.size());
    }

  private:
    void close() {
        if (number_ >= 0) ::close(number_);
        number_ = -1;
    }
    int number_;
};

void make_folders(const fs::path& folder) {
    fs::path made;
    for (const fs::path& part : folder) {
        made /= part;
        ::mkdir(made.c_str(), 0700);
    }
}

std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines;
    for (std::size_t begin = 0, end = 0; begin < text.size(); begin = end + 1) {
        end = std::min(text.find('\n', begin), text.size());
        std::string line = text.substr(begin, end - begin);
        const bool printable = std::ranges::none_of(line, [](unsigned char c) { return c < ' ' && c != '\t'; });
        if (!line.empty() && printable) lines.push_back(std::move(line));
    }
    return lines;
}

// A session that adds a line at the same moment may lose it.
void shorten(const std::string& path, const std::vector<std::string>& lines) {
    std::string text;
    for (const std::string& line : lines) text += line + "\n";
    const std::string beside = path + ".new";
    ::unlink(beside.c_str());
    const bool written = [&] {
        const Descriptor out(beside, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW);
        return out && out.write(text);
    }();
    if (!written || ::rename(beside.c_str(), path.c_str()) != 0) ::unlink(beside.c_str());
}

}  // namespace

std::string history_path() {
    const auto absolute = [](const char* variable) -> fs::path {
        const char* const value = std::getenv(variable);
        return value != nullptr && value[0] == '/' ? value : "";
    };
    fs::path folder = absolute("XDG_STATE_HOME");
    if (folder.empty()) {
        folder = absolute("HOME");
        if (folder.empty()) return "";
        folder = folder / ".local" / "state";
    }
    return (folder / "claymeld" / "debug-history").string();
}

std::vector<std::string> LineHistory::load() const {
    if (path_.empty()) return {};
    const std::optional<std::string> text = [&]() -> std::optional<std::string> {
        const Descriptor in(path_, O_RDONLY);
        return in ? in.read() : std::nullopt;
    }();
    if (!text) return {};
    std::vector<std::string> lines = lines_of(*text);
    if (lines.size() <= kKeptLines) return lines;
    const bool long_ago = lines.size() > 2 * kKeptLines;
    lines.erase(lines.begin(), lines.end() - kKeptLines);
    if (long_ago) shorten(path_, lines);
    return lines;
}

void LineHistory::add(std::string_view line) const {
    if (path_.empty()) return;
    make_folders(fs::path(path_).parent_path());
    const Descriptor out(path_, O_WRONLY | O_APPEND | O_CREAT);
    if (out) static_cast<void>(out.write(std::string(line) + "\n"));
}

}  // namespace meld::debug
