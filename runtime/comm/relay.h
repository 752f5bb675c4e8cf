// Passes on the standard output and error of a child. The child never meets a full disk or a reader that has left, which would crash
// mpirun.
#pragma once

#include <array>

namespace meld::comm {

class Relay {
  public:
    // Makes two pipes; if that fails (no descriptors left), the child writes to our streams.
    Relay();
    ~Relay();
    Relay(const Relay&) = delete;
    Relay& operator=(const Relay&) = delete;

    // In the child, between fork and exec: its standard output and error are the pipes. Async-signal-safe.
    void enter_child() const;
    // In the parent, after fork.
    void leave_child();
    // Passes on what is available, waiting at most this long for something.
    void pass(int milliseconds);
    // Passes on all remaining output of a child that has ended.
    void finish();
    // Why our standard output can no longer be written, an errno, or 0. Later output is then read and dropped.
    int output_error() const { return channels_[0].error; }

  private:
    struct Channel {
        int to;
        int read_end = -1;
        int write_end = -1;
        int error = 0;
    };
    void pass(Channel& channel);
    std::array<Channel, 2> channels_;
};

}  // namespace meld::comm
