// Work that may go wrong in any way, in a process of its own: with limits, without network, and in a folder. What it finds out is a text.
// A process that has not ended is killed with its Confined, and what it has started.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "runtime/base/error.h"
#include "runtime/base/process/copied_process.h"

namespace meld::driver {

struct Confines {
    std::string folder;            // Where the process is.
    double seconds = 0;            // Of processor time; by the clock on the wall it may take some times as long.
    std::uint64_t memory = 0;      // Bytes that it may take beyond what this process has.
    std::uint64_t output = 0;      // Bytes that it may print.
    std::uint64_t file_bytes = 0;  // Of each file that it writes.
};

// How it ended.
struct ConfinedEnd {
    enum class Is { Answered, OutOfTime, OutOfMemory, TooMuchOutput, Crashed } is = Is::Crashed;
    std::string answer = {};  // What the work returned.
    std::string said = {};    // What it printed, as far as it may.
    std::string how = {};     // Of a crash: "signal 11", "exit code 70".
    double seconds = 0;       // Of processor time, with its children.
};

// Whether processes can be cut off from the network here, as root or by a user namespace: tries it once.
bool can_cut_network();

class Confined {
  public:
    // Starts the work; it is a copy of this process and sees everything that this has. Errors: there can be no further process.
    static Result<Confined> start(const std::function<std::string()>& work, const Confines& confines);

    // Readable when it prints or has ended.
    int descriptor() const { return process_.pipe(); }
    // To be called often, whether there is something to read or not: how it ended, when it has.
    std::optional<ConfinedEnd> look();

  private:
    Confined(CopiedProcess process, const Confines& confines);
    void read_said();
    ConfinedEnd finish(int status, double seconds);

    Confines confines_;
    CopiedProcess process_;
    double begun_ = 0;
    std::optional<ConfinedEnd::Is> ended_by_us_;
    ConfinedEnd end_;
};

}  // namespace meld::driver
