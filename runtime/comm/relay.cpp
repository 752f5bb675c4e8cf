#include "runtime/comm/relay.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <string_view>
#include <utility>

namespace meld::comm {

namespace {

constexpr std::size_t kBlockBytes = 1 << 16;

void close_end(int& descriptor) {
    if (descriptor >= 0) close(std::exchange(descriptor, -1));
}

// 0, or why it could not be written.
int write_all(int to, std::string_view text) {
    while (!text.empty()) {
        const ssize_t written = write(to, text.data(), text.size());
        if (written > 0) {
            text.remove_prefix(static_cast<std::size_t>(written));
            continue;
        }
        if (written < 0 && errno == EAGAIN) {
            pollfd writable = {.fd = to, .events = POLLOUT, .revents = 0};
            poll(&writable, 1, -1);
        } else if (written < 0 && errno != EINTR) {
            return errno;
        }
    }
    return 0;
}

}  // namespace

Relay::Relay() : channels_{Channel{STDOUT_FILENO}, Channel{STDERR_FILENO}} {
    for (Channel& channel : channels_) {
        std::array<int, 2> ends{};
        if (pipe2(ends.data(), O_CLOEXEC) != 0) continue;
        channel.read_end = ends[0];
        channel.write_end = ends[1];
    }
}

Relay::~Relay() {
    for (Channel& channel : channels_) {
        close_end(channel.read_end);
        close_end(channel.write_end);
    }
}

void Relay::enter_child() const {
    for (const Channel& channel : channels_)
        if (channel.write_end >= 0) dup2(channel.write_end, channel.to);
}

void Relay::leave_child() {
    for (Channel& channel : channels_) close_end(channel.write_end);
}

void Relay::pass(Channel& channel) {
    std::array<char, kBlockBytes> block;
    const ssize_t size = read(channel.read_end, block.data(), block.size());
    if (size < 0 && errno == EINTR) return;
    if (size <= 0) return close_end(channel.read_end);
    if (channel.error == 0) channel.error = write_all(channel.to, {block.data(), static_cast<std::size_t>(size)});
}

void Relay::pass(int milliseconds) {
    // A closed end is a negative descriptor, which poll ignores.
    std::array<pollfd, 2> ends = {pollfd{channels_[0].read_end, POLLIN, 0}, pollfd{channels_[1].read_end, POLLIN, 0}};
    if (poll(ends.data(), ends.size(), milliseconds) <= 0) return;
    for (std::size_t i = 0; i < ends.size(); ++i)
        if (ends[i].revents != 0) pass(channels_[i]);
}

// A grandchild may hold the pipe open for longer; only output that is already there is waited for.
void Relay::finish() {
    for (Channel& channel : channels_) {
        pollfd end = {channel.read_end, POLLIN, 0};
        while (channel.read_end >= 0 && poll(&end, 1, 0) > 0) {
            pass(channel);
            end.fd = channel.read_end;
        }
    }
}

}  // namespace meld::comm
