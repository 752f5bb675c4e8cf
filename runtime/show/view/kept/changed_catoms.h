// What a frame shows of the catoms of one process that have changed since the last frame.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "runtime/ask/query/catom_question.h"
#include "runtime/base/error.h"
#include "runtime/show/picture/catom_values.h"
#include "runtime/show/picture/frame.h"
#include "runtime/show/view/kept/cell_box.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::view {

// Catoms that are shown, and their values.
struct ShownCatoms {
    struct Row {
        std::uint64_t id = 0;
        std::uint64_t value = 0;  // The bits of a number, or the place of a word in `words`.
        std::uint32_t cell = 0;
        bool has_value = false;
    };
    std::vector<Row> rows = {};
    std::vector<std::string> words = {};
};

class ChangedCatoms {
  public:
    // Nothing: a body of the look does not say what it says of each catom from that catom alone, or has a mistake. The same on every
    // process. The look outlives it.
    static std::optional<ChangedCatoms> make(const ModuleInfo& module, const picture::Look& look);

    // What colours mean: the name of the value, and of which kind values are.
    const std::string& coloured_by() const { return coloured_by_; }
    picture::CatomValues::Kind kind() const { return value_.kind; }

    // Takes those that have been touched since the last call; at first all. Returns the numbers of catoms that were shown and are not here
    // any more; what has them now, or where they are, comes with look().
    std::vector<std::uint64_t> begin(sim::Subdomain& subdomain, sim::Touched& touched);
    // Calls shown(catoms) and hidden(id) for those that have been touched and are here, some at a time; hidden() only of those that were
    // shown. Errors: a signal has asked for the end; then what was shown is not known any more. Cost: the bodies at each of them.
    Result<void> look(sim::Subdomain& subdomain, const CellBox& box, const std::function<void(const ShownCatoms&)>& shown,
                      const std::function<void(std::uint64_t)>& hidden);

  private:
    // The rows of a table by their catoms.
    class Answers;
    explicit ChangedCatoms(const picture::Look& look) : look_(look) {}
    Result<Answers> ask(sim::Subdomain& subdomain, const inspect::CatomQuestion& question, bool all) const;
    void add_value(Answers& colour, ShownCatoms& some) const;

    const picture::Look& look_;
    std::optional<inspect::CatomQuestion> only_, hide_, colour_;
    picture::CatomValues value_;
    std::string coloured_by_;
    std::vector<std::uint32_t> ids_;      // By index of a catom: the number under which it is shown; kHidden: it is not.
    std::vector<sim::Catom> changed_;     // Those that are looked at.
    std::vector<std::uint64_t> numbers_;  // Of some of them.
};

}  // namespace meld::view
