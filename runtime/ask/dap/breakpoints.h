// Where the run is to stop: what the client asks for, as breaks and watches of the session.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "runtime/ask/dap/rules.h"
#include "runtime/ask/dap/run.h"

namespace meld::dap {

class Breakpoints {
  public:
    // The run and the rules outlive this.
    Breakpoints(Run& run, Rules& rules) : run_(run), rules_(rules) {}

    // Replaces those of a file, or those that are named. Each answer says whether it is one, and where or why not. A line means the rule
    // that it is part of, or the next one. A name is that of a predicate, of which all rules are meant; a body is watched. Errors: the run
    // has ended.
    Result<Json> set_lines(const std::string& path, const Json& asked);
    Result<Json> set_names(const Json& asked);

    // The client's numbers of those that have ended a way; a number of the session that is no longer known has none.
    Json numbers_of(const Json& stops) const;

  private:
    struct Set {
        std::int64_t id = 0;
        std::uint64_t number = 0;  // Of the session.
    };
    Result<void> drop(std::vector<Set>& sets);
    Result<Json> set(const std::string& command, std::vector<Set>& sets);

    Run& run_;
    Rules& rules_;
    std::int64_t last_id_ = 0;
    std::map<std::string, std::vector<Set>> by_file_;
    std::vector<Set> named_;
};

}  // namespace meld::dap
