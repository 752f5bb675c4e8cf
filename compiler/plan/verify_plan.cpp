// The promises of the passes over plans: storage does not overlap, and steps use only known variables.
#include <algorithm>
#include <optional>

#include "compiler/plan/access.h"
#include "compiler/plan/verify.h"

namespace meld::plan {

using namespace check;

namespace {

// Which bytes of one record or row belong to which predicate.
class Bytes {
  public:
    Bytes(std::string column, std::uint32_t size) : column_(std::move(column)), taken_(size, false) {}
    void take(std::uint32_t offset, std::uint32_t bytes, std::uint32_t count = 1) {
        MELD_CHECK(bytes > 0 && offset % bytes == 0, "column {}: {} bytes at {} are not aligned", column_, bytes, offset);
        MELD_CHECK(offset + bytes * count <= taken_.size(), "column {}: {} bytes at {} are beyond its {}", column_, bytes * count, offset,
                   taken_.size());
        for (std::uint32_t i = offset; i < offset + bytes * count; ++i) {
            MELD_CHECK(!taken_[i], "column {}: byte {} is used twice", column_, i);
            taken_[i] = true;
        }
    }

  private:
    std::string column_;
    std::vector<bool> taken_;
};

void verify_column(const Plan& plan, const Column& c) {
    MELD_CHECK(c.stride > 0 && !c.predicates.empty() && (!c.rows || c.predicates.size() == 1), "column {}", c.name);
    MELD_CHECK(c.own_dirty >= kFirstModuleBit && (c.own_dirty >> kDirtyWordBits) == 0, "column {} has the dirty bits {:#x}", c.name,
               c.own_dirty);
    MELD_CHECK(c.exported == (c.reader_dirty != 0), "column {} is exported, or has readers, not both", c.name);
    Bytes bytes(c.name, c.rows ? c.row_bytes : c.stride);
    std::vector<std::pair<std::uint32_t, std::uint32_t>> words;  // Presence: offset and mask.
    for (const PredicateId p : c.predicates) {
        const Stored& s = plan.of(p);
        const bool per_link = s.storage == Storage::PerLink;
        MELD_CHECK(s.exported == c.exported && c.rows == (s.storage == Storage::Rows), "{} does not fit column {}",
                   plan.program.predicates[p].name, c.name);
        MELD_CHECK(s.fields.size() + 1 == plan.program.predicates[p].arguments.size(), "{} has {} fields", plan.program.predicates[p].name,
                   s.fields.size());
        for (std::size_t i = per_link ? 1 : 0; i < s.fields.size(); ++i)
            bytes.take(s.fields[i].offset, s.fields[i].bytes, per_link ? kMaxPorts : 1);
        if (s.ranked) bytes.take(s.rank_offset, kRankBytes);
        if (s.waits && c.rows) bytes.take(s.from_offset, kWaitedPortsBytes);
        if (c.rows || s.ranked) continue;
        if (per_link) {
            bytes.take(s.presence_offset, kPortMaskBytes);
            continue;
        }
        const auto shared = std::find_if(words.begin(), words.end(), [&](const auto& w) { return w.first == s.presence_offset; });
        if (shared == words.end()) {
            bytes.take(s.presence_offset, kPresenceBytes);
            words.push_back({s.presence_offset, s.presence_mask});
            continue;
        }
        MELD_CHECK((shared->second & s.presence_mask) == 0, "column {}: two predicates share a presence bit", c.name);
        shared->second |= s.presence_mask;
    }
}

// Follows the known variables from step to step, as emission does.
class Scoping {
  public:
    Scoping(const Plan& plan, const RulePlan& r)
        : plan_(plan),
          joined_(r.more.empty() ? std::nullopt : std::optional(rule_of(plan, r))),
          rule_(joined_ ? *joined_ : plan.program.rules[r.rule]) {
        known_.places.insert(rule_.site);
        known_.values.insert(r.given.begin(), r.given.end());
    }

    // `on_heads`: whether what the heads make is known too. Those of delta rules say what is affected; the rest is unknown.
    enum class Heads { All, Group };
    void run(const RulePlan& r, Heads which) {
        steps(r.steps);
        MELD_CHECK(r.branches.empty() || r.heads.empty(), "rule {} has heads and branches", rule_.name);
        const Known shared = known_;
        for (const RulePlan& b : r.branches) {
            MELD_CHECK(b.branches.empty(), "rule {} branches twice", rule_.name);
            known_ = shared;
            steps(b.steps);
            heads(b.heads, which);
        }
        heads(r.heads, which);
    }

  private:
    void expect(VariableId v, std::string_view what) const {
        MELD_CHECK(v.valid() && known_.has(v), "rule {}: {} uses {} before it is known", rule_.name, what,
                   v.valid() ? rule_.variables[v].name : "nothing");
    }
    void expect(const Term& term, std::string_view what) const {
        each_free_use(term, [&](const Term& use) { expect(use.variable, what); });
    }
    void bind(VariableId v) {
        MELD_CHECK(v.valid() && !known_.has(v), "rule {}: {} gets a second value", rule_.name,
                   v.valid() ? rule_.variables[v].name : "nothing");
        known_.values.insert(v);
    }

    void steps(const std::vector<Step>& all) {
        for (const Step& s : all) visit_step(s, [&](const auto& one) { step(one); });
    }
    void step(const EachNeighbour& s) {
        expect(s.only, "a link");
        if (s.place.valid()) {
            MELD_CHECK(!known_.places.contains(s.place), "rule {}: goes to {} twice", rule_.name, rule_.variables[s.place].name);
            known_.places.insert(s.place);
        }
        port(s.port);
    }
    void step(const FindNeighbour& s) {
        expect(s.place, "a link");
        known_.places.insert(s.place);
        port(s.port);
    }
    void port(const PortUse& p) {
        expect(p.equals, "a port");
        if (p.bind.valid()) bind(p.bind);
    }
    void step(const Match& s) {
        const Predicate& p = plan_.program.predicates[s.predicate];
        const Stored& stored = plan_.of(s.predicate);
        MELD_CHECK(s.uses.size() == s.arguments.size() && s.arguments.size() + 1 == p.arguments.size(), "rule {}, {}", rule_.name, p.name);
        MELD_CHECK(known_.places.contains(s.place) && s.at_site == (s.place == rule_.site), "rule {} reads {} at no place", rule_.name,
                   p.name);
        MELD_CHECK(stored.storage != Storage::Unused, "rule {} reads {}, which is stored nowhere", rule_.name, p.name);
        MELD_CHECK(s.at_site || (p.world == WorldSource::None && stored.exported),
                   "rule {} reads {} at a neighbour, and it is not exported", rule_.name, p.name);
        MELD_CHECK(!s.changed || stored.storage == Storage::Rows, "rule {} follows the rows of {}, which has none", rule_.name, p.name);
        MELD_CHECK(!s.ranks || stored.ranked, "rule {} counts the rank of {}, which has none", rule_.name, p.name);
        for (std::size_t i = 0; i < s.arguments.size(); ++i) {
            if (s.uses[i] == ArgumentUse::Compare) expect(s.arguments[i], p.name);
            if (s.uses[i] != ArgumentUse::Bind) continue;
            MELD_CHECK(s.arguments[i].is_variable(), "rule {} gives no variable a value of {}", rule_.name, p.name);
            bind(s.arguments[i].variable);
            if (i == 0 && stored.storage == Storage::PerLink) known_.places.insert(s.arguments[i].variable);
        }
    }
    void step(const Test& s) {
        MELD_CHECK(s.condition.type == Type::Bool, "rule {} tests what is no bool", rule_.name);
        expect(s.condition, "a test");
    }
    void step(const Set& s) {
        expect(s.value, "an equality");
        bind(s.variable);
    }
    void step(const Unless& s) { inside(s.steps); }
    void step(const EachElement& s) {
        expect(s.list, "an element");
        known_.values.insert(s.variable);
        if (s.position.valid()) bind(s.position);
    }
    void step(const AggregateOver& s) {
        MELD_CHECK(s.aggregate != Aggregate::None && (s.aggregate == Aggregate::Custom) == s.function.valid(),
                   "rule {}: an aggregate without a function", rule_.name);
        expect(s.parameter, "an aggregate");
        const Known before = known_;
        steps(s.steps);
        expect(s.value, "an aggregate");
        known_ = before;
        if (!known_.has(s.variable)) known_.values.insert(s.variable);
    }
    void step(const ChangeSince& s) {
        expect(s.variable, "a change");
        expect(s.bound, "a change");
        for (const Term& t : s.arguments) expect(t, "a change");
    }
    void inside(const std::vector<Step>& all) {
        const Known before = known_;
        steps(all);
        known_ = before;
    }

    void heads(const std::vector<HeadPlan>& all, Heads which) {
        for (const HeadPlan& h : all) head(h, which);
    }
    void head(const HeadPlan& h, Heads which) {
        const Known before = known_;
        visit_head(
            h, [&](const MakeFact& f) { fact(f, which); }, [&](const ForAll& all) { matches(all, {}, which); },
            [&](const AggregateAll& all) {
                MELD_CHECK(!all.aggregates.empty(), "rule {}: a head aggregates nothing", rule_.name);
                matches(all.each, all.aggregates, which);
                for (const HeadAggregate& a : all.aggregates) bind(a.result);
                heads(all.results, which);
            },
            [&](const Choose& choose) {
                expect(choose.condition, "a head");
                heads(choose.heads, which);
                heads(choose.others, which);
            },
            [&](const With& with) {
                expect(with.value, "a head");
                bind(with.variable);
                heads(with.heads, which);
            });
        known_ = before;
    }
    void matches(const ForAll& all, const std::vector<HeadAggregate>& aggregates, Heads which) {
        const Known before = known_;
        steps(all.steps);
        for (const HeadAggregate& a : aggregates) {
            expect(a.parameter, "an aggregate in a head");
            if (a.each.valid()) expect(a.each, "an aggregate in a head");
        }
        heads(all.heads, which);
        known_ = before;
    }
    void fact(const MakeFact& h, Heads which) {
        const Predicate& p = plan_.program.predicates[h.predicate];
        MELD_CHECK(h.arguments.size() + 1 == p.arguments.size(), "rule {} derives {}", rule_.name, p.signature());
        expect(h.place, p.name);
        const std::size_t end = which == Heads::All ? h.arguments.size() : group_arguments(p);
        for (std::size_t i = 0; i < end; ++i) expect(h.arguments[i], p.name);
    }

    const Plan& plan_;
    const std::optional<Rule> joined_;  // Of several rules.
    const Rule& rule_;
    Known known_;
};

void verify_changed_first(const Plan& plan, const RulePlan& r) {
    std::size_t changed = 0;
    for (const Step& s : r.steps)
        if (const Match* m = as<Match>(s)) changed += m->changed ? 1 : 0;
    MELD_CHECK(changed == 1, "delta rule {} follows {} predicates", plan.program.rules[r.rule].name, changed);
}

void verify_stratum(const Plan& plan, const StratumPlan& s) {
    const std::string& name = plan.program.predicates[s.predicates[0]].name;
    for (const RulePlan& r : s.rules) {
        Scoping(plan, r).run(r, Scoping::Heads::All);
        MELD_CHECK((r.inputs & ~s.inputs) == 0, "stratum {} does not look at all that its rules do", name);
    }
    for (const RulePlan& r : s.deltas.affected) {
        Scoping(plan, r).run(r, Scoping::Heads::Group);
        verify_changed_first(plan, r);
        MELD_CHECK((r.inputs & ~s.deltas.inputs) == 0 && (r.inputs & r.unchanged) == 0, "a delta rule of {} has the inputs {:#x}", name,
                   r.inputs);
    }
    MELD_CHECK(s.deltas.whole.size() == s.deltas.affected.size(), "stratum {} has {} delta rules of {} rules", name,
               s.deltas.affected.size(), s.deltas.whole.size());
    for (const RulePlan& r : s.deltas.whole) Scoping(plan, r).run(r, Scoping::Heads::All);
    for (const RulePlan& r : s.deltas.regroup) Scoping(plan, r).run(r, Scoping::Heads::All);
    for (const RulePlan& r : s.semi_naive) {
        Scoping(plan, r).run(r, Scoping::Heads::All);
        verify_changed_first(plan, r);
    }
    MELD_CHECK((s.deltas.inputs & ~s.inputs) == 0 || s.deltas.inputs == 0, "stratum {} has delta rules for what it does not look at", name);
    MELD_CHECK(s.deltas.affected.empty() == (s.deltas.inputs == 0), "stratum {} has {} delta rules", name, s.deltas.affected.size());
    MELD_CHECK(s.semi_naive.empty() || s.recursion == Recursion::LocalSets, "stratum {} is not evaluated in rounds", name);
    for (const PredicateId p : s.predicates)
        MELD_CHECK((s.recursion == Recursion::Ranked || s.recursion == Recursion::Mutual) == plan.of(p).ranked, "{} of stratum {}: ranks",
                   plan.program.predicates[p].name, name);
}

}  // namespace

void verify_layout(const Plan& plan) {
    MELD_CHECK(plan.stored.size() == plan.program.predicates.count(), "{} of {} predicates have storage", plan.stored.size(),
               plan.program.predicates.count());
    for (const PredicateId p : plan.program.predicates.ids()) {
        const Stored& s = plan.of(p);
        const bool in_column = s.storage != Storage::Unused && s.storage != Storage::World;
        MELD_CHECK(in_column == s.column.valid(), "{} is {}", plan.program.predicates[p].name, storage_name(s.storage));
        if (!in_column) continue;
        const std::vector<PredicateId>& all = plan.column_of(p).predicates;
        MELD_CHECK(std::find(all.begin(), all.end(), p) != all.end(), "{} is not in its column", plan.program.predicates[p].name);
    }
    for (const Column& c : plan.columns) verify_column(plan, c);
}

void verify_steps(const Plan& plan) {
    for (const StratumPlan& s : plan.strata) verify_stratum(plan, s);
    for (const auto* all : {&plan.linear_rules, &plan.initial_facts})
        for (const RulePlan& r : *all) {
            MELD_CHECK(plan.program.rules[r.rule].linear, "view {} among linear rules", plan.program.rules[r.rule].name);
            Scoping(plan, r).run(r, Scoping::Heads::All);
        }
}

// A sweep knows one state and one message at a time.
void verify_sweeps(const Plan& plan) {
    for (const RulePlan& r : plan.linear_rules) {
        if (!r.sweep.applies()) continue;
        for (const PredicateId p : {r.sweep.state, r.sweep.messages}) {
            std::size_t read = 0;
            each_step(r.steps, [&](const Step& s) {
                const Match* m = as<Match>(s);
                read += m != nullptr && m->predicate == p ? 1 : 0;
            });
            MELD_CHECK(read == 1, "rule {} takes all {} in one pass, and reads {} {} times", plan.program.rules[r.rule].name,
                       plan.program.predicates[r.sweep.messages].name, plan.program.predicates[p].name, read);
        }
    }
}

}  // namespace meld::plan
