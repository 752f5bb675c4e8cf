// Bounds on the differences of numbers: x - y is at most N, closed under addition, each with the conditions that imply it.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "compiler/check/program/program.h"

namespace meld::lint {

using check::Term;

// A difference bound matrix (Dill, "Timing Assumptions and Verification of Finite-State Concurrent Systems", 1989). For values with an
// order but no differences, x < y is x - y at most -1.
class Differences {
  public:
    using Reasons = std::vector<const Term*>;
    struct Bound {
        std::size_t x = 0, y = 0;
        std::int64_t most = 0;  // x - y is at most this.
    };
    // Bodies with more comparisons than this are generated; the time for a bound grows with the square.
    static constexpr std::size_t kMaxNodes = 64;
    // The maximum of a bound, so that the sum along any path fits.
    static constexpr std::int64_t kLargest = std::int64_t{1} << 50;

    // The index of this name, made on first use; none if there are too many.
    std::optional<std::size_t> node(const std::string& name);
    bool knows(const std::string& name) const { return nodes_.contains(name); }
    // The conditions that contradict the bound, if there are any.
    std::optional<Reasons> refutes(const Bound& bound) const;
    // The best known upper bound of x - y, with the conditions that imply it.
    std::optional<std::pair<std::int64_t, Reasons>> most(std::size_t x, std::size_t y) const;
    // Returns whether it was unknown before. Assumes that it is not refuted.
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

// The union, without duplicates, in the order of the text.
Differences::Reasons joined(Differences::Reasons a, const Differences::Reasons& b);

}  // namespace meld::lint
