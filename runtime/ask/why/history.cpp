#include "runtime/ask/why/history.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <tuple>
#include <utility>

#include "compiler/syntax/aggregates.h"
#include "runtime/ask/facts/all_facts.h"
#include "runtime/ask/why/earlier_states.h"
#include "runtime/ask/why/explainer.h"
#include "runtime/ask/why/firings.h"
#include "runtime/base/natural_order.h"
#include "runtime/comm/transport/collective_result.h"

namespace meld::inspect {

namespace {

using check::Clause;
using check::Rule;
using Change = Comings::Change;
using How = Change::How;
using Way = Explanation::Way;

struct Natural {
    bool operator()(const std::string& a, const std::string& b) const { return natural_less(a, b); }
};
using Matches = std::map<std::string, Known, Natural>;

// The facts of one state that match what is asked.
Result<Matches> matches(Explainer& e, std::size_t age) {
    const Rule& question = e.program().question();
    PartialMatch whole{.of = &question, .rule = question, .body = question.body, .own = question.body.size()};
    whole.values.resize(question.variables.count());
    whole.bound.resize(question.variables.count());
    const auto atom = std::ranges::find(question.body, Clause::Kind::Atom, &Clause::kind);
    const auto number = static_cast<std::size_t>(atom - question.body.begin());
    Matches out;
    const Result<bool> done = e.search(whole, {.age = age}, [&](const Solution& found) {
        Known fact = e.keep(atom->atom.predicate, *found.facts[number], age);
        std::string text = e.text(fact);
        out.emplace(std::move(text), std::move(fact));
        return true;
    });
    if (!done) return tl::unexpected<Error>(done.error());
    return out;
}

// What made facts come and go in one tick, by the state after it and those before it.
class Causes {
  public:
    explicit Causes(Explainer& explainer) : e_(explainer) {}

    Result<std::vector<Change>> find() {
        auto now = matches(e_, 0), before = matches(e_, 1);
        for (const auto* one : {&now, &before})
            if (!*one) return tl::unexpected<Error>(one->error());
        std::vector<Change> out;
        for (const auto& [text, fact] : *before)
            if (!now->contains(text)) {
                Change& change = out.emplace_back(Change{.came = false, .fact = text});
                if (auto done = went(fact, *now, change); !done) return tl::unexpected<Error>(done.error());
            }
        for (const auto& [text, fact] : *now)
            if (!before->contains(text)) {
                Change& change = out.emplace_back(Change{.came = true, .fact = text});
                if (auto done = came(fact, change); !done) return tl::unexpected<Error>(done.error());
            }
        return out;
    }

  private:
    // Each rule once for each catom at which it fired.
    static void add(const Way& way, Change& change) {
        const auto same = [&](const Way& other) { return std::tie(other.rule, other.catom) == std::tie(way.rule, way.catom); };
        if (std::ranges::none_of(change.rules, same)) change.rules.push_back(way);
    }
    static Result<void> fired(Result<Firings> found, How how, Change& change) {
        if (!found) return tl::unexpected<Error>(found.error());
        // Of several rules that can have done it none is known to have; an event is not known either.
        if (found->ways.empty()) {
            if (!found->rules.empty()) change.how = How::Unknown;
            return {};
        }
        change.how = how;
        for (const Way& way : found->ways) add(way, change);
        if (found->count > found->ways.size()) change.more = found->count - found->ways.size();
        return {};
    }
    bool sensed(const check::Predicate& p) const { return p.world != WorldSource::None || p.sensed; }

    Result<void> came(const Known& fact, Change& change) {
        const check::Predicate& p = e_.predicate(fact.predicate);
        if (sensed(p)) return say(How::Sensed, change);
        if (!p.linear()) {
            if (auto done = by_views(fact, change); !done) return done;
            if (!change.rules.empty()) return say(How::Derived, change);
        }
        // An event gives it, if no rule makes it.
        change.how = e_.linear_rules(fact.predicate).empty() && (p.linear() || e_.is_base(fact)) ? How::Given : How::Unknown;
        return fired(that_made(e_, fact), How::Made, change);
    }
    Result<void> went(const Known& fact, const Matches& now, Change& change) {
        const check::Predicate& p = e_.predicate(fact.predicate);
        if (!e_.facts(0).exists(*fact.catom)) return say(How::Gone, change);
        if (sensed(p) && !p.linear()) return say(How::Sensed, change);
        if (p.linear()) {
            change.how = How::Taken;
            return fired(that_took(e_, fact), How::Consumed, change);
        }
        if (p.aggregate != check::Aggregate::None)
            for (const auto& [text, other] : now)
                if (same_group(p, fact, other)) {
                    change.by = text;
                    return say(How::Replaced, change);
                }
        if (e_.is_base(fact)) return say(How::Taken, change);
        if (auto done = by_views(fact, change); !done) return done;
        return say(change.rules.empty() ? How::Unknown : How::Lost, change);
    }
    static Result<void> say(How how, Change& change) {
        change.how = how;
        return {};
    }
    bool same_group(const check::Predicate& p, const Known& a, const Known& b) const {
        if (a.catom != b.catom) return false;
        for (std::size_t i = 1; i < p.aggregate_at; ++i)
            if (!e_.terms().equal(p.arguments[i].type, *a.arguments[i - 1], *b.arguments[i - 1])) return false;
        return true;
    }

    // What a view has read of neighbours: what had come over links, what they were a tick before, or what they are in the same state.
    enum class Neighbours { AsHeard, Before, Now };
    // The views that give the fact in the state of its age.
    Result<void> by_views(const Known& fact, Change& change) {
        Known wanted = fact;
        const check::Predicate& p = e_.predicate(fact.predicate);
        const bool combined = p.aggregate != check::Aggregate::None && syntax::combines(p.aggregate);
        if (combined) wanted.arguments[p.aggregate_at - 1].reset();
        for (const bool by_rank : {true, false})
            for (const Neighbours neighbours : {Neighbours::AsHeard, Neighbours::Before, Neighbours::Now}) {
                if (neighbours == Neighbours::AsHeard && !e_.states().apart) continue;
                // One that is enough, but of what is combined all.
                if (!change.rules.empty()) continue;
                for (const Rule* rule : combined ? e_.views(fact.predicate) : e_.derivations(fact.predicate)) {
                    if (!change.rules.empty() && !combined) break;
                    if (auto done = by_view(wanted, *rule, neighbours, by_rank, change); !done) return done;
                }
            }
        return {};
    }
    Result<void> by_view(const Known& fact, const Rule& rule, Neighbours neighbours, bool by_rank, Change& change) {
        const std::optional<PartialMatch> match = e_.match_head(rule, rule.heads[0].atom, fact, false);
        if (!match || !e_.cannot(match->body).empty()) return {};
        const check::Stratum* const recursion = e_.recursion_of(fact.predicate);
        Explainer::Search search{.age = fact.age,
                                 .spread = neighbours == Neighbours::Before,
                                 .as_heard = neighbours == Neighbours::AsHeard,
                                 .recursion = recursion};
        if (by_rank && recursion != nullptr && fact.rank != kAbsent)
            search.allowed = [&](const Clause& c, const Fact& f) {
                return !recursion->contains(c.atom.predicate) || f.rank == kAbsent || f.rank < fact.rank;
            };
        const Result<bool> done = e_.search(*match, search, [&](const Solution&) {
            add(e_.way_of(rule), change);
            return false;
        });
        if (!done) return tl::unexpected<Error>(done.error());
        return {};
    }

    Explainer& e_;
};

// Whether the facts that match are others than before; the same on every process. Process 0 has them.
Result<bool> look(sim::Subdomain& subdomain, const Program& program, std::vector<std::string>& facts) {
    std::vector<std::string> now;
    sim::Subdomain* const states[] = {&subdomain};
    const Result<void> asked = ask(states, [&](std::span<Facts* const> of_states) -> Result<void> {
        Terms terms(program, subdomain.view());
        Explainer e(program, {.facts = of_states, .tick = subdomain.tick()}, terms);
        if (auto one = e.asked(); !one) return tl::unexpected<Error>(one.error());
        const auto found = matches(e, 0);
        if (!found) return tl::unexpected<Error>(found.error());
        for (const auto& [text, fact] : *found) now.push_back(text);
        return {};
    });
    if (!asked) return tl::unexpected<Error>(asked.error());
    const bool changed = now != facts;
    facts = std::move(now);
    return comm::value_of_first(subdomain.comm, changed);
}

// What each change between this state and the one before it came from, and how many states before this one that asked for.
struct Explained {
    std::vector<Change> changes;
    std::size_t wanted = 0;
};

// By this state and those before it. Every process gets the same number of states.
Result<Explained> explain(std::span<sim::Subdomain* const> states, const Program& program, std::int64_t first_tick) {
    Explained out;
    sim::Subdomain& now = *states.front();
    const Result<void> asked = ask(states, [&](std::span<Facts* const> facts) -> Result<void> {
        Terms terms(program, now.view());
        Explainer e(program, {.facts = facts, .tick = now.tick(), .first_tick = first_tick, .apart = now.world.apart()}, terms);
        auto found = Causes(e).find();
        if (!found) return tl::unexpected<Error>(found.error());
        out = {.changes = std::move(*found), .wanted = e.wanted()};
        return {};
    });
    if (!asked) return tl::unexpected<Error>(asked.error());
    out.wanted = comm::value_of_first(now.comm, out.wanted);
    return out;
}

// Simulations that follow the one of a timeline: each a tick behind the one before it, from change to change.
class Followers {
  public:
    Followers(timeline::Timeline& timeline, const Program& program) : timeline_(timeline), program_(program) {}

    // What changed in the tick of `now`, which is not the first.
    Result<std::vector<Change>> explain(sim::Simulation& now) {
        const i64 tick = now.subdomain().tick(), first = timeline_.first_tick();
        std::vector<sim::Subdomain*> states = {&now.subdomain()};
        while (true) {
            for (std::size_t behind = states.size(); behind <= wanted_ && tick - static_cast<i64>(behind) >= first; ++behind) {
                if (followers_.size() < behind) {
                    auto from = timeline_.beside(first);
                    if (!from) return tl::unexpected<Error>(from.error());
                    followers_.push_back(std::move(*from));
                }
                sim::Simulation& follower = *followers_[behind - 1];
                if (auto done = timeline_.run_apart(follower, tick - static_cast<i64>(behind)); !done)
                    return tl::unexpected<Error>(done.error());
                states.push_back(&follower.subdomain());
            }
            Result<Explained> found = inspect::explain(states, program_, first);
            if (!found) return tl::unexpected<Error>(found.error());
            const auto before = static_cast<std::size_t>(tick - first);
            if (std::min({found->wanted, kMostStates - 1, before}) < states.size()) return std::move(found->changes);
            wanted_ = std::min(found->wanted, kMostStates - 1);
        }
    }

  private:
    timeline::Timeline& timeline_;
    const Program& program_;
    std::vector<std::unique_ptr<sim::Simulation>> followers_;
    // What a fact rested on may have gone a tick before it; more where a rule reads facts over several links.
    std::size_t wanted_ = 2;
};

}  // namespace

Result<Comings> history(timeline::Timeline& timeline, const std::string& fact) {
    const Result<Program> program = Program::read(timeline.simulation().subdomain().module, fact);
    if (!program) return tl::unexpected<Error>(program.error());
    if (auto can = program->can_ask(program->question().body); !can) return tl::unexpected<Error>(can.error());
    Comings out{.asked = fact, .first_tick = timeline.first_tick(), .last_tick = timeline.tick()};
    std::vector<std::string> facts;
    Followers followers(timeline, *program);
    const Result<void> walked = timeline.walk(out.first_tick, out.last_tick, [&](sim::Simulation& now) -> Result<bool> {
        const Result<bool> changed = look(now.subdomain(), *program, facts);
        if (!changed) return tl::unexpected<Error>(changed.error());
        const std::int64_t tick = now.subdomain().tick();
        if (tick == out.first_tick) {
            out.at_first = facts;
            return true;
        }
        if (!*changed) return true;
        auto changes = followers.explain(now);
        if (!changes) return tl::unexpected<Error>(changes.error());
        out.ticks.push_back({.tick = tick, .changes = std::move(*changes)});
        return true;
    });
    if (!walked) return tl::unexpected<Error>(walked.error());
    return out;
}

}  // namespace meld::inspect
