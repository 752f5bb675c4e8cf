#include "runtime/ask/debug/depends.h"

#include <fmt/format.h>

#include <limits>
#include <memory>
#include <utility>

#include "runtime/ask/debug/by_hand.h"
#include "runtime/ask/debug/facts.h"
#include "runtime/ask/why/ground.h"
#include "runtime/engine/tuple/facts.h"

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

// Whether this process has the fact among those that are given.
bool has(sim::Subdomain& subdomain, const OneFact& fact, u32 predicate) {
    const ModuleInfo& module = subdomain.module;
    const std::optional<sim::Catom> catom = subdomain.ensemble.find(fact.catom);
    if (!catom || !subdomain.owned(*catom)) return false;
    PredicateInfo p = module.predicates[predicate];
    p.name = fact.given.predicate.c_str();
    bool found = false;
    tuple::each_fact(module, subdomain.columns, subdomain.geometry(), predicate, *catom,
                     [&](const Value* arguments) { found = found || tuple::print_fact(module, p, fact.catom, arguments) == fact.text; });
    return found;
}

tl::unexpected<Error> not_given(const std::string& fact) {
    return fail(fmt::format("{} is not given from outside: rules derive it, or the program's text says it", fact),
                fmt::format("why {} says what it rests on; ask what depends on that", fact));
}

// Facts that no world could give.
Result<void> may_be_given(sim::Subdomain& subdomain, const std::string& text) {
    const Result<inspect::Ground> ground = inspect::read_ground(subdomain, text);
    if (!ground) return tl::unexpected<Error>(ground.error());
    const ModuleInfo& module = subdomain.module;
    const std::optional<u32> predicate = tuple::find_predicate(module, ground->predicate, ground->arguments.size());
    const bool derived = predicate && module.predicates[*predicate].base == kNone16;
    return derived ? Result<void>(not_given(ground->text)) : Result<void>{};
}

Result<void> is_given(sim::Subdomain& subdomain, const OneFact& fact) {
    subdomain.refresh();
    const ModuleInfo& module = subdomain.module;
    const std::optional<u32> predicate = tuple::find_predicate(module, fact.given.predicate, fact.given.arguments.size());
    MELD_CHECK(predicate.has_value(), "{} was checked", fact.text);
    const u32 base = module.predicates[*predicate].base;
    const std::byte mine{static_cast<unsigned char>((has(subdomain, fact, base) ? 2 : 0) | (has(subdomain, fact, *predicate) ? 1 : 0))};
    std::byte all{0};
    for (const std::byte each : subdomain.comm.allgather({&mine, 1})) all |= each;
    if ((all & std::byte{2}) != std::byte{0}) return {};
    if (all == std::byte{0}) return fail(fmt::format("{} does not hold after tick {}", fact.text, subdomain.tick()), "why-not tells more");
    return not_given(fact.text);
}

}  // namespace

Result<Answer> depends(timeline::Timeline& timeline, world::World& world, const DependsAsked& asked) {
    sim::Subdomain& present = timeline.simulation().subdomain();
    const std::string text = asked.fact.ends_with('.') ? asked.fact.substr(0, asked.fact.size() - 1) : asked.fact;
    if (auto may = may_be_given(present, text); !may) return tl::unexpected<Error>(may.error());
    const Result<OneFact> fact = read_fact(present, text, "depends");
    if (!fact) return tl::unexpected<Error>(fact.error());
    if (auto is = is_given(present, *fact); !is) return tl::unexpected<Error>(is.error());
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
