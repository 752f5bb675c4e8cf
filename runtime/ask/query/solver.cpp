#include "runtime/ask/query/solver.h"

#include <algorithm>
#include <map>
#include <utility>

#include "runtime/ask/query/aggregates.h"
#include "runtime/base/process/interrupt.h"
#include "runtime/module/kernel/lists.h"

namespace meld::inspect {

using check::Clause;
using check::Term;
using check::Type;
using check::VariableId;

namespace {

// A signal is looked for after so many facts.
constexpr u64 kFactsBetweenLooks = 1 << 14;

// A table of fewer facts is looked through each time. One that has been so many times gets an index, if all of them together have no more
// rows than that: some 40 bytes and 8 for each argument.
constexpr u64 kScannedFacts = 32;
constexpr u32 kScansBefore = 2;
constexpr std::size_t kMostTableRows = 8'000'000;

// Of the arguments that are known those by which an index can go: values that have the same form in the facts. None, if another one has to
// be computed: for some facts that may fail, and then all must be looked at.
std::vector<std::size_t> key_at(const Step& step) {
    std::vector<std::size_t> key;
    for (const std::size_t i : step.key) {
        const Argument& a = step.arguments[i];
        if (!a.term->is_variable() && !a.term->operands.empty()) return {};
        if (a.term->is_variable() && a.term->type == a.type) key.push_back(i);
    }
    return key;
}

// The variables that get their values in a step.
std::vector<VariableId> binds(const Step& step) {
    std::vector<VariableId> out;
    for (const Argument& a : step.arguments)
        if (a.use == Argument::Use::Bind) out.push_back(a.term->variable);
    if (step.kind == Step::Kind::Bind) out.push_back(step.variable);
    if ((step.kind == Step::Kind::Element || step.kind == Step::Kind::Aggregate) && !step.known) out.push_back(step.clause->variable);
    if (step.kind == Step::Kind::Element && step.clause->position.valid()) out.push_back(step.clause->position);
    return out;
}

tl::unexpected<Error> interrupted() { return fail("interrupted before there was an answer", "", ExitCode::Interrupted); }

}  // namespace

class Solver::Search {
  public:
    Search(Solver& solver, const check::Rule& rule, std::size_t clauses, Values values, Bound given, const Found& found,
           const SearchOptions& options)
        : solver_(solver),
          terms_(solver.terms_),
          rule_(rule),
          found_(found),
          options_(options),
          values_(std::move(values)),
          given_(std::move(given)),
          facts_(clauses, nullptr) {}

    bool run(const std::vector<Step>& steps) {
        top_ = &steps;
        const Scratch::Mark before = terms_.scratch.mark();
        const bool all = take(steps, 0, [this] { return found_({values_, facts_}); });
        terms_.scratch.release(before);
        return all;
    }
    void begin_at(VariableId start, u64 catom) { values_[start.index()].catom = catom; }
    bool interrupted() const { return interrupted_; }
    const Values& values() const { return values_; }

  private:
    using Then = std::function<bool()>;

    // Takes the steps from this one on in every way, and then calls `then`. False: enough has been found.
    bool take(const std::vector<Step>& steps, std::size_t i, const Then& then) {
        if (&steps == top_) note_attempt(i);
        if (i == steps.size()) return then();
        const Step& step = steps[i];
        const auto next = [&] { return take(steps, i + 1, then); };
        // Values that are made here are needed only by the steps behind, but for those of aggregates.
        const Scratch::Mark mark = terms_.scratch.mark();
        const bool more = one(step, next);
        if (aggregating_ == 0) terms_.scratch.release(mark);
        return more;
    }

    template <class Next>
    bool one(const Step& step, const Next& next) {
        switch (step.kind) {
            case Step::Kind::Here:
            case Step::Kind::Each:
            case Step::Kind::Back:
            case Step::Kind::Indexed:
                return match(step, next);
            case Step::Kind::Test: {
                const bool holds = terms_.value(*step.term, values_).integer != 0;
                return !well() || !holds || next();
            }
            case Step::Kind::Bind: {
                const Value v = terms_.element(*step.term, rule_.variables[step.variable].type, values_);
                if (!well()) return true;
                values_[step.variable.index()] = v;
                return next();
            }
            case Step::Kind::TakeApart:
                return take_apart(step, next);
            case Step::Kind::Element:
                return elements(step, next);
            case Step::Kind::Not:
                return absent(step, next);
            case Step::Kind::Aggregate:
                return aggregate(step, next);
        }
        return true;
    }

    // Whether what was computed has a value. Within a part of the body a failure is one of the whole part, as in rules.
    bool well() { return inside_ > 0 ? terms_.scratch.trap == Trap::None : terms_.scratch.went_well(); }

    bool use(const Argument& a, Value value) {
        if (a.use == Argument::Use::Skip) return true;
        if (a.use == Argument::Use::Bind) {
            const VariableId v = a.term->variable;
            // Those of an order's own have the type of the argument.
            const Type& type = v.index() < rule_.variables.count() ? rule_.variables[v].type : a.type;
            values_[v.index()] = Terms::converted(value, a.type, type);
            return true;
        }
        const Type& type = a.term->type;
        const Value wanted = terms_.value(*a.term, values_);
        if (!well()) return false;
        if (a.type == Type::Int && type == Type::Float) return static_cast<double>(value.integer) == wanted.real;
        return terms_.equal(a.type, value, Terms::converted(wanted, type, a.type));
    }

    template <class Next>
    bool match(const Step& step, const Next& next) {
        const bool top = inside_ == 0;
        u64 visited = 0;
        const auto visit = [&](const Fact& fact) {
            ++visited;
            if (++seen_ % kFactsBetweenLooks == 0) look_up();
            // A part of the body in which something has no value ends there.
            if (interrupted_ || (!top && terms_.scratch.trap != Trap::None)) return false;
            if (!use(step.arguments[0], {.catom = fact.catom})) return true;
            for (std::size_t i = 1; i < step.arguments.size(); ++i)
                if (!use(step.arguments[i], fact.arguments[i - 1])) return true;
            if (options_.readable && !options_.readable(*step.clause, fact)) return true;
            if (!top) return next();
            if (options_.allowed && !options_.allowed(*step.clause, fact)) return true;
            facts_[step.number] = &fact;
            const bool more = next();
            facts_[step.number] = nullptr;
            return more;
        };
        Facts& facts = options_.from ? options_.from(*step.clause) : solver_.facts_;
        const auto known = [&](std::size_t argument) {
            return terms_.value_as(*step.arguments[argument].term, step.arguments[argument].type, values_);
        };
        switch (step.kind) {
            case Step::Kind::Here: {
                const u64 catom = known(0).catom;
                if (!step.key.empty() && !solver_.tables_.empty())
                    if (const Index* const index = solver_.index_at(facts, step, key_of(step), catom)) {
                        std::vector<Value> key;
                        for (const std::size_t argument : key_of(step)) key.push_back(known(argument));
                        return index->each(key, std::ref(visit));
                    }
                const bool more = facts.at(step.source, catom, std::ref(visit));
                if (visited > kScannedFacts && !key_of(step).empty()) solver_.note_scan(facts, step, key_of(step), catom);
                return more;
            }
            case Step::Kind::Back: {
                const u64 to = known(1).catom;
                return !well() || facts.back(step.source, to, std::ref(visit));
            }
            case Step::Kind::Indexed: {
                // An index of what is here so far would be taken for one of all in the searches that follow.
                if (!facts.has_all(step.source)) return facts.each(step.source, std::ref(visit));
                std::vector<Value> key;
                for (const std::size_t argument : step.key) key.push_back(known(argument));
                return !well() || solver_.index_of(facts, step).each(key, std::ref(visit));
            }
            default:
                return facts.each(step.source, std::ref(visit));
        }
    }

    const std::vector<std::size_t>& key_of(const Step& step) {
        const auto known = keys_.find(&step);
        return known != keys_.end() ? known->second : keys_.emplace(&step, key_at(step)).first->second;
    }

    template <class Next>
    bool take_apart(const Step& step, const Next& next) {
        const ListRef whole = values_[step.variable.index()].list;
        const bool cons = step.term->op == check::Op::Cons;
        const std::size_t parts = step.arguments.size();
        const u32 count = count_of(whole);
        if (cons ? count == 0 : count != parts) return true;
        for (std::size_t i = 0; i < parts; ++i) {
            const bool rest = cons && i == 1;
            const Value part = rest ? Value{.list = meld::tail(terms_.scratch, whole)} : tuple::item(whole, i);
            if (!use(step.arguments[i], part)) return true;
        }
        return next();
    }

    template <class Next>
    bool elements(const Step& step, const Next& next) {
        const Clause& c = *step.clause;
        const ListRef list = terms_.value(c.test, values_).list;
        if (!well()) return true;
        const Type& type = c.test.type.parts[0];
        const Type& wanted = rule_.variables[c.variable].type;
        for (u32 i = 0; i < count_of(list); ++i) {
            const Value v = Terms::converted(tuple::item(list, i), type, wanted);
            if (step.known && !terms_.equal(wanted, v, values_[c.variable.index()])) continue;
            if (!step.known) values_[c.variable.index()] = v;
            if (c.position.valid()) values_[c.position.index()] = {.integer = i};
            if (!next()) return false;
        }
        return true;
    }

    template <class Next>
    bool absent(const Step& step, const Next& next) {
        bool any = false;
        ++inside_;
        take(step.inner, 0, [&] {
            any = true;
            return false;
        });
        --inside_;
        if (interrupted_) return false;
        return !well() || any || next();
    }

    template <class Next>
    bool aggregate(const Step& step, const Next& next) {
        const Clause& c = *step.clause;
        const Type& type = rule_.variables[c.variable].type;
        ++inside_;
        ++aggregating_;
        const auto all = accumulator(solver_.program_, terms_, c, type, values_);
        take(step.inner, 0, [&] {
            const Value v = c.test.op == check::Op::Anonymous ? Value{.integer = 1} : terms_.element(c.test, all->value_type(), values_);
            all->add(v);
            return terms_.scratch.trap == Trap::None;
        });
        --inside_;
        const std::optional<Value> result = all->result();
        const bool fine = well();
        --aggregating_;
        if (interrupted_) return false;
        if (!fine || !result) return true;
        if (step.known && !terms_.equal(type, *result, values_[c.variable.index()])) return true;
        if (!step.known) values_[c.variable.index()] = *result;
        return next();
    }

    void look_up() {
        interrupted_ = options_.patient ? interrupt::overdue() : interrupt::received() != 0;
        if (options_.looked) options_.looked(seen_);
    }

    void note_attempt(std::size_t taken) {
        Attempt* const best = options_.best;
        if (best == nullptr || (noted_ && taken <= best->taken)) return;
        noted_ = true;
        best->taken = taken;
        best->failed = taken < top_->size() ? (*top_)[taken].clause : nullptr;
        best->values = values_;
        best->bound = given_;
        best->bound.resize(values_.size());
        best->met.clear();
        for (std::size_t i = 0; i < taken; ++i) {
            const Step& step = (*top_)[i];
            for (const VariableId v : binds(step)) best->bound[v.index()] = true;
            if (best->met.empty() || best->met.back() != step.clause) best->met.push_back(step.clause);
        }
        if (options_.further) options_.further(*best);
    }

    Solver& solver_;
    Terms& terms_;
    const check::Rule& rule_;
    const Found& found_;
    const SearchOptions& options_;
    Values values_;
    Bound given_;  // Which of them were known before the first step.
    std::vector<const Fact*> facts_;
    std::map<const Step*, std::vector<std::size_t>> keys_;  // By key_at(), of steps in long tables.
    const std::vector<Step>* top_ = nullptr;
    int inside_ = 0, aggregating_ = 0;
    u64 seen_ = 0;
    bool interrupted_ = false, noted_ = false;
};

std::vector<Type> Solver::types_of(const Step& step) const {
    std::vector<Type> types;
    for (std::size_t i = 1; i < step.arguments.size(); ++i) types.push_back(step.arguments[i].type);
    return types;
}

const Index& Solver::index_of(Facts& facts, const Step& step) {
    for (const auto& [of, index] : indexes_)
        if (of == &facts && index->is(step.source, step.key)) return *index;
    indexes_.push_back({&facts, std::make_unique<Index>(facts, step.source, terms_.types, types_of(step), step.key)});
    return *indexes_.back().index;
}

Solver::Tables* Solver::tables_of(const Facts& facts, const Step& step, const std::vector<std::size_t>& key) {
    for (Tables& t : tables_)
        if (t.facts == &facts && t.source == step.source && t.key == key) return &t;
    return nullptr;
}

const Index* Solver::index_at(const Facts& facts, const Step& step, const std::vector<std::size_t>& key, u64 catom) {
    Tables* const tables = key.empty() ? nullptr : tables_of(facts, step, key);
    if (tables == nullptr) return nullptr;
    const auto found = tables->by_catom.find(catom);
    if (found == tables->by_catom.end()) return nullptr;
    Tables::Table& table = found->second;
    if (table.index == nullptr && table.scans >= kScansBefore && table_rows_ < kMostTableRows) {
        table.index = std::make_unique<Index>(*tables->facts, step.source, terms_.types, types_of(step), key, catom);
        table_rows_ += table.index->rows();
    }
    return table.index.get();
}

void Solver::note_scan(Facts& facts, const Step& step, const std::vector<std::size_t>& key, u64 catom) {
    if (table_rows_ >= kMostTableRows) return;
    Tables* tables = tables_of(facts, step, key);
    if (tables == nullptr) tables = &tables_.emplace_back(Tables{.facts = &facts, .source = step.source, .key = key});
    ++tables->by_catom[catom].scans;
}

Result<void> Solver::search(const check::Rule& rule, const std::vector<Clause>& body, Values values, Bound bound, const Found& found,
                            const SearchOptions& options) {
    bound.resize(std::max(bound.size(), rule.variables.count()));
    Bound given = bound;
    const std::vector<Step> steps = order(program_, rule, body, bound);
    values.resize(bound.size());
    Search search(*this, rule, body.size(), std::move(values), std::move(given), found, options);
    search.run(steps);
    return search.interrupted() ? interrupted() : Result<void>{};
}

Result<void> Solver::search_from(const check::Rule& rule, const std::vector<Clause>& body, VariableId start, std::span<const u64> catoms,
                                 const Found& found, const std::function<bool(std::size_t)>& done, const SearchOptions& options) {
    Bound bound(rule.variables.count());
    bound[start.index()] = true;
    Bound given = bound;
    const std::vector<Step> steps = order(program_, rule, body, bound, false);
    Search search(*this, rule, body.size(), Values(bound.size()), std::move(given), found, options);
    for (std::size_t i = 0; i < catoms.size(); ++i) {
        search.begin_at(start, catoms[i]);
        search.run(steps);
        if (search.interrupted()) return interrupted();
        if (!done(i)) break;
    }
    return {};
}

}  // namespace meld::inspect
