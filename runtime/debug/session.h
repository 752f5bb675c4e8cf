// A session of the debugger: carries out commands on the timeline of a run. Nothing is read or printed here.
#pragma once

#include <cstdint>

#include "runtime/base/error.h"
#include "runtime/debug/answer.h"
#include "runtime/debug/command.h"
#include "runtime/timeline/timeline.h"

namespace meld::debug {

// Every process of the run has one and gives it the same commands in the same order.
class Session {
  public:
    // The timeline has been started, and outlives the session. Beyond so many lines, facts are only counted.
    Session(timeline::Timeline& timeline, std::uint64_t most_lines)
        : timeline_(timeline), most_lines_(most_lines), came_from_(timeline.tick()) {}

    // Process 0 has all of the answer. Nothing is to be done for Quit. Errors: it cannot be done, and the session stays where it was; the
    // program fails; a tick is not what it was before.
    Result<Answer> execute(const Command& command);

  private:
    Result<Answer> go(std::int64_t tick);
    Result<Answer> back(std::int64_t ticks);
    Result<Answer> stand() const;
    Result<Answer> compare(std::int64_t since);

    timeline::Timeline& timeline_;
    std::uint64_t most_lines_;
    std::int64_t came_from_;  // Where the last command that moved began.
};

}  // namespace meld::debug
