#include "runtime/ask/debug/depends.h"

#include <fmt/format.h>

#include <limits>
#include <memory>
#include <utility>

#include "runtime/ask/debug/by_hand.h"
#include "runtime/ask/debug/facts.h"

namespace meld::debug {

namespace {

constexpr std::int64_t kLastTick = std::numeric_limits<std::int64_t>::max() - 1;

// A fact is taken at the start of a tick, as long as this lives.
class Without {
  public:
    Without(world::World& world, std::int64_t tick, const world::GivenFact& fact) : world_(world), before_(world.events.size()) {
        world_.events.push_back({.tick = tick, .give = {}, .take = {fact}});
    }
    ~Without() { world_.events.resize(before_); }
    Without(const Without&) = delete;
    Without& operator=(const Without&) = delete;

  private:
    world::World& world_;
    std::size_t before_;
};

}  // namespace

Result<Answer> depends(timeline::Timeline& timeline, world::World& world, const DependsAsked& asked) {
    sim::Subdomain& present = timeline.simulation().subdomain();
    const std::string text = asked.fact.ends_with('.') ? asked.fact.substr(0, asked.fact.size() - 1) : asked.fact;
    const Result<OneFact> fact = read_given_fact(present, text, "depends");
    if (!fact) return tl::unexpected<Error>(fact.error());
    const std::int64_t now = timeline.tick(), last = now > kLastTick - asked.ticks ? kLastTick : now + asked.ticks;
    Consequences out{.fact = fact->text, .tick = now};
    const auto run = [&](sim::Simulation& simulation, Consequences::Run& how) -> Result<void> {
        if (auto done = timeline.run_apart(simulation, last); !done) return done;
        how = {.tick = simulation.subdomain().tick(), .ended = simulation.ended({}).value_or(sim::Ending::Ticks)};
        return {};
    };
    // The run as it is may be over.
    std::unique_ptr<sim::Simulation> goes_on;
    if (timeline.ended() != sim::Ending::Quiet) {
        auto from_here = timeline.beside(now);
        if (!from_here) return tl::unexpected<Error>(from_here.error());
        goes_on = std::move(*from_here);
    }
    sim::Simulation& with = goes_on ? *goes_on : timeline.simulation();
    if (goes_on) {
        if (auto done = run(with, out.with); !done) return tl::unexpected<Error>(done.error());
    } else {
        out.with = {.tick = now, .ended = sim::Ending::Quiet};
    }
    auto without = timeline.beside(now);
    if (!without) return tl::unexpected<Error>(without.error());
    {
        const Without taken(world, now + 1, fact->given);
        (*without)->subdomain().expect_event();
        if (auto done = run(**without, out.without); !done) return tl::unexpected<Error>(done.error());
    }
    ChangedFacts changed = find_changed_facts(with.subdomain(), (*without)->subdomain(), asked.most_lines);
    out.predicates = std::move(changed.predicates);
    out.gone = std::move(changed.gone);
    out.came = std::move(changed.come);
    return out;
}

}  // namespace meld::debug
