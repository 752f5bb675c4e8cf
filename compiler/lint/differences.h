// What is known of the differences of numbers: x - y is at most so much, closed under addition, each with the conditions that say so.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "compiler/check/program.h"

namespace meld::lint {

using check::Term;

// A difference bound matrix (Dill, "Timing Assumptions and Verification of Finite-State Concurrent Systems", 1989). Of values
// that have an order and no differences, x is less than y where x - y is at most -1.
class Differences {
  public:
    using Reasons = std::vector<const Term*>;
    struct Bound {
        std::size_t x = 0, y = 0;
        std::int64_t most = 0;  // x - y is at most this.
    };
    // Bodies that compare more than these are made by machines; a bound is squared in its time.
    static constexpr std::size_t kMaxNodes = 64;
    // What a bound may be, so that the sum of all of a path fits.
    static constexpr std::int64_t kLargest = std::int64_t{1} << 50;

    // The number of this name, made on first use; none where there are too many.
    std::optional<std::size_t> node(const std::string& name);
    bool knows(const std::string& name) const { return nodes_.contains(name); }
    // The conditions with which the bound cannot hold, if so.
    std::optional<Reasons> refutes(const Bound& bound) const;
    // The least that x - y is known to be at most, with the conditions that say so.
    std::optional<std::pair<std::int64_t, Reasons>> most(std::size_t x, std::size_t y) const;
    // Returns whether it was not known before. Assumes that it is not refuted.
    bool learn(const Bound& bound, const Reasons& why);

  private:
    struct Entry {
        std::int64_t most = 0;
        Reasons why = {};
        bool known = false;
    };
    static bool better(std::int64_t most, std::size_t reasons, const Entry& than) {
        return !than.known || most < than.most || (most == than.most && reasons < than.why.size());
    }

    std::map<std::string, std::size_t> nodes_;
    std::vector<std::vector<Entry>> bounds_;  // By x and y.
};

// Both, each once, in the order of the text.
Differences::Reasons joined(Differences::Reasons a, const Differences::Reasons& b);

}  // namespace meld::lint
