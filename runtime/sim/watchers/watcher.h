// The action `watch`: a line for each fact of a predicate that appears or disappears at a catom, on standard output.
#pragma once

#include <cstdio>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "runtime/module/abi/module_abi.h"
#include "runtime/sim/core/extension.h"

namespace meld::sim {

class Watcher : public SimModule {
  public:
    // Process 0 writes the lines; the others send it what their catoms hold. Without a file it only knows what is watched and what has been
    // there, for a run that is saved and goes on elsewhere.
    explicit Watcher(std::FILE* to) : to_(to) {}
    Result<void> start(Subdomain& subdomain) override;
    // After each tick: the changes since the previous one, by catom and predicate. When a watch begins, all facts are new. Errors: a watch
    // names no predicate. Cost: reads the watched facts in every tick.
    Result<void> after(Subdomain& subdomain) override;

    bool leaves_facts_alone(const Subdomain&) const override { return !watch_ && !watch_all_ && !watching_; }
    Result<void> saveable() const override { return {}; }
    // What is watched and what was reported of it, which process 0 knows of all.
    void save_rest(const Subdomain& subdomain, ByteWriter& out) const override;
    Result<void> load_rest(Subdomain& subdomain, ByteReader& in) override;

  private:
    // The number of a catom and a predicate of the program.
    using Watch = std::pair<u64, u32>;
    using Facts = std::vector<std::string>;
    static void save_watch(const Subdomain& subdomain, const Watch& watch, ByteWriter& out);
    static std::optional<Watch> load_watch(const Subdomain& subdomain, ByteReader& in);
    Result<void> begin(Subdomain& subdomain);
    Result<void> add(Subdomain& subdomain, u64 id, const std::string& name);
    Facts facts_of(Subdomain& subdomain, const Watch& watch) const;
    // As receive() reads it; not here: the catom has left this process.
    static void write_facts(const Watch& watch, const Facts& facts, bool here, ByteWriter& out);
    std::vector<std::byte> changes(Subdomain& subdomain);
    void receive(std::span<const std::byte> bytes, std::map<Watch, Facts>& now) const;
    Result<void> print(Subdomain& subdomain, const std::map<Watch, Facts>& now);

    std::FILE* to_;
    std::optional<u32> watch_, watch_all_;  // As in the program; none if it does not use it.
    std::set<Watch> named_, watched_;       // By name, and in all; the same on all processes.
    std::set<u64> everything_;              // Catoms of which all predicates are watched.
    bool watching_ = false;                 // There were any in the last tick.
    std::map<Watch, Facts> reported_;       // What process 0 has received about catoms of this one.
    std::map<Watch, Facts> known_;          // On process 0, about all.
};

}  // namespace meld::sim
