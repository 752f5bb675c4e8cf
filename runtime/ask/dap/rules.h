// The rules of the program with the files where a client finds them, and which of them a line means.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "runtime/ask/dap/message.h"

namespace meld::dap {

struct Rule {
    std::string name = {}, text = {};
    std::string file = {};  // From the folder of the program.
    std::string path = {};  // Empty: nobody has said where it is, or it is of a library.
    bool library = false;
    std::int64_t line = 0, last_line = 0;
};

class Rules {
  public:
    Rules() = default;
    // From the answer to `rules`. The files are in this folder; an empty one is not known, as that of a recording's program.
    Rules(const Json& answer, const std::string& folder);

    const std::vector<Rule>& all() const { return rules_; }
    // The rules of a file as the client names it, by line. If the folder is not known, a file is one of the program's if its path ends
    // with theirs, and it is known from then on.
    std::vector<const Rule*> of_file(const std::string& path);
    // Null: there is none.
    const Rule* named(const std::string& name) const;
    // Whether some rule gives facts of this predicate.
    bool derive(const std::string& predicate) const;

  private:
    std::vector<Rule> rules_;
};

// The rule at this line, or the first one after it; null if there is none. Rules are by line.
const Rule* rule_at(const std::vector<const Rule*>& rules, std::int64_t line);

// A file as the protocol writes it; null where it is not known.
Json source_of(const Rule& rule);

}  // namespace meld::dap
