// Where a way forward through a run ends: rules, and bodies that begin to hold.
//
// A view fires in a tick after which there is a derivation by it that there was not after the tick before: a way to satisfy its body in the
// state of the whole run. So a break is a watch of the rule's body, and the same on any number of processes and each time that a tick is
// run again. Of a linear rule the run itself says when it fires (fired.h).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "runtime/ask/debug/answer.h"
#include "runtime/ask/debug/command.h"
#include "runtime/ask/debug/fired.h"
#include "runtime/ask/watch/watches.h"
#include "runtime/base/error.h"
#include "runtime/comm/transport/communicator.h"

namespace meld::debug {

// A body that is typed, to be watched.
front::WatchRule rule_of(const std::string& body, front::WatchRule::Verb verb);

// Every process has one and calls all of this at the same time.
class BreakList {
  public:
    // Errors: there is no such rule, or it has no body; mistakes in the condition or the body.
    Result<Answer> add(const ModuleInfo& module, const Break& asked);
    Result<Answer> add(const ModuleInfo& module, const Watch& asked);
    // Errors: there is none with this number.
    Result<Answer> remove(std::optional<std::uint64_t> number);
    // The program is another one now: all are set again, by what was typed, under their numbers. Returns those that cannot be, which are
    // gone.
    std::vector<BreaksFound::One> reread(const ModuleInfo& module);
    BreaksFound all() const;
    bool empty() const { return entries_.empty(); }

    // A way forward begins here, of this run. Cost: a look at all of it, unless it goes on where the last one ended.
    Result<void> begin(sim::Subdomain& subdomain);
    // What is new after a tick, on process 0. Cost: proportional to what has changed.
    Result<std::vector<Stop>> after(sim::Subdomain& subdomain);
    // The run that was looked at is not there any more: another one goes on from another tick.
    void forget() { watches_.reset(); }

  private:
    struct Entry {
        std::variant<Break, Watch> asked;
        BreaksFound::One shown;
        std::vector<front::WatchRule> rules = {};  // Bodies that are watched,
        std::vector<LinearBreak> linear = {};      // and linear rules.
    };
    Result<Answer> add(const ModuleInfo& module, Entry entry);

    void tell_firings(sim::Subdomain& subdomain) const;
    Result<void> add_fired(sim::Subdomain& subdomain, std::vector<Stop>& stops) const;

    std::vector<Entry> entries_;
    std::uint64_t last_number_ = 0;
    const ModuleInfo* module_ = nullptr;
    std::unique_ptr<inspect::Watches> watches_;  // Of all entries, in their order; null: to be made anew.
};

}  // namespace meld::debug
