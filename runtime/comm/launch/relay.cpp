#include "runtime/comm/launch/relay.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
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

Relay::Relay(Input input) : channels_{Channel{STDOUT_FILENO}, Channel{STDERR_FILENO}} {
    const auto open = [](Channel& channel) {
        std::array<int, 2> ends{};
        if (pipe2(ends.data(), O_CLOEXEC) != 0) return;
        channel.read_end = ends[0];
        channel.write_end = ends[1];
    };
    for (Channel& channel : channels_) open(channel);
    if (input == Input::Typed) open(typed_);
}

Relay::~Relay() {
    for (Channel& channel : channels_) {
        close_end(channel.read_end);
        close_end(channel.write_end);
    }
    close_end(typed_.read_end);
    close_end(typed_.write_end);
}

void Relay::enter_child() const {
    if (typed_.read_end >= 0) dup2(typed_.read_end, typed_.to);
    for (const Channel& channel : channels_)
        if (channel.write_end >= 0) dup2(channel.write_end, channel.to);
}

void Relay::leave_child() {
    for (Channel& channel : channels_) close_end(channel.write_end);
    close_end(typed_.read_end);
}

void Relay::pass(Channel& channel) {
    std::array<char, kBlockBytes> block;
    const ssize_t size = read(channel.read_end, block.data(), block.size());
    if (size < 0 && errno == EINTR) return;
    if (size <= 0) return close_end(channel.read_end);
    channel.bytes += static_cast<std::uint64_t>(size);
    if (channel.error == 0) channel.error = write_all(channel.to, {block.data(), static_cast<std::size_t>(size)});
}

void Relay::pass_typed() {
    // What is typed waits in the terminal as long as the child reads nothing.
    pollfd room = {typed_.write_end, POLLOUT, 0};
    if (poll(&room, 1, 0) <= 0 || (room.revents & (POLLOUT | POLLERR)) == 0) return;
    std::array<char, PIPE_BUF> block;
    const ssize_t size = read(typed_.to, block.data(), block.size());
    if (size < 0 && errno == EINTR) return;
    if (size <= 0 || write_all(typed_.write_end, {block.data(), static_cast<std::size_t>(size)}) != 0) close_end(typed_.write_end);
}

void Relay::pass(int milliseconds) {
    // A closed end is a negative descriptor, which poll ignores.
    std::array<pollfd, 3> ends = {pollfd{channels_[0].read_end, POLLIN, 0}, pollfd{channels_[1].read_end, POLLIN, 0},
                                  pollfd{typed_.write_end >= 0 ? typed_.to : -1, POLLIN, 0}};
    if (poll(ends.data(), ends.size(), milliseconds) <= 0) return;
    for (std::size_t i = 0; i < channels_.size(); ++i)
        if (ends[i].revents != 0) pass(channels_[i]);
    if (ends[2].revents != 0) pass_typed();
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
