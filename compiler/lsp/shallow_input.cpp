// A byte filter that knows where messages begin (`Content-Length: N`, an empty line, N bytes) and what is inside a string.
#include "compiler/lsp/shallow_input.h"

#include <unistd.h>

#include <strings.h>
#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <memory>
#include <string>

namespace meld::lsp {

namespace {

constexpr int kMaxDepth = 1000;

class Filter {
  public:
    explicit Filter(int file) : file_(file) {}

    ssize_t read(char* buffer, std::size_t size) {
        ssize_t count = 0;
        do count = ::read(file_, buffer, size);
        while (count < 0 && errno == EINTR);
        for (ssize_t i = 0; i < count; ++i) pass(buffer[i]);
        return count;
    }

  private:
    void pass(char& c) {
        if (body_left_ == 0) return header(c);
        if (--body_left_ == 0) line_.clear();
        if (in_string_) {
            in_string_ = escaped_ || c != '"';
            escaped_ = !escaped_ && c == '\\';
        } else if (c == '"') {
            in_string_ = true;
        } else if (c == '[' || c == '{') {
            if (++depth_ > kMaxDepth) c = ' ';
        } else if (c == ']' || c == '}') {
            --depth_;
        }
    }
    void header(char c) {
        static constexpr char kLength[] = "content-length:";
        if (c != '\n') {
            // Longer lines say nothing that counts.
            if (line_.size() < 80) line_ += c;
            return;
        }
        if (strncasecmp(line_.c_str(), kLength, sizeof kLength - 1) == 0)
            length_ = std::strtoull(line_.c_str() + sizeof kLength - 1, nullptr, 10);
        if (line_ == "\r" || line_.empty()) {
            body_left_ = length_;
            length_ = 0;
            depth_ = 0;
            in_string_ = escaped_ = false;
        }
        line_.clear();
    }

    int file_;
    std::string line_;
    unsigned long long length_ = 0, body_left_ = 0;
    long long depth_ = 0;
    bool in_string_ = false, escaped_ = false;
};

}  // namespace

std::FILE* open_shallow(std::FILE* in) {
    auto filter = std::make_unique<Filter>(fileno(in));
    const cookie_io_functions_t functions{
        .read = [](void* cookie, char* buffer, std::size_t size) { return static_cast<Filter*>(cookie)->read(buffer, size); },
        .write = nullptr,
        .seek = nullptr,
        .close =
            [](void* cookie) {
                delete static_cast<Filter*>(cookie);
                return 0;
            }};
    std::FILE* stream = fopencookie(filter.get(), "r", functions);
    if (stream != nullptr) static_cast<void>(filter.release());
    return stream;
}

}  // namespace meld::lsp
