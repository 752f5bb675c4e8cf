// Passes on the standard output and error of a child, and to it what is typed at a terminal. The child never meets a full disk or a reader
// that has left, which would crash mpirun.
#pragma once

#include <unistd.h>

#include <array>
#include <cstdint>

namespace meld::comm {

class Relay {
  public:
    enum class Input { Inherited, Typed };
    // Makes the pipes; of one that fails (no descriptors left), the child gets our stream.
    explicit Relay(Input input = Input::Inherited);
    ~Relay();
    Relay(const Relay&) = delete;
    Relay& operator=(const Relay&) = delete;

    // In the child, between fork and exec: its standard output and error are the pipes, and its input if that is typed. Async-signal-safe.
    void enter_child() const;
    // In the parent, after fork.
    void leave_child();
    // Passes on what is available, waiting at most this long for something.
    void pass(int milliseconds);
    // Passes on all remaining output of a child that has ended.
    void finish();
    // Why our standard output can no longer be written, an errno, or 0. Later output is then read and dropped.
    int output_error() const { return channels_[0].error; }
    // The bytes of standard output so far.
    std::uint64_t shown() const { return channels_[0].bytes; }

  private:
    struct Channel {
        int to;
        int read_end = -1;
        int write_end = -1;
        int error = 0;
        std::uint64_t bytes = 0;
    };
    void pass(Channel& channel);
    // A child in a process group of its own must not read from the terminal itself.
    void pass_typed();
    std::array<Channel, 2> channels_;
    Channel typed_{STDIN_FILENO};
};

}  // namespace meld::comm
