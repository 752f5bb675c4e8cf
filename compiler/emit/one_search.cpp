// Emits a linear rule that does all its firings in one search (compiler/plan/passes/one_search.cpp): the loops over its facts go on after a
// firing. Facts that are taken stay in their bags until the search ends.
#include <algorithm>

#include "compiler/emit/rule_emitter.h"

namespace meld::emit {

using plan::Lookup;
using plan::OneSearch;

bool RuleEmitter::puts_back(const Match& s) const {
    return std::ranges::any_of(rule_plan_.search.put_back, [&](const OneSearch::MadeAgain& m) { return &search_match(m.step) == &s; });
}

bool RuleEmitter::changes(const Match& s) const {
    const std::size_t step = rule_plan_.search.changed.step;
    return step != OneSearch::kNone && &search_match(step) == &s;
}

bool RuleEmitter::takes(const Match& s) const {
    const bool consumes = s.at_site && !s.read_only && plan_.program.predicates[s.predicate].linear();
    return consumes && !puts_back(s) && !changes(s);
}

bool RuleEmitter::takes_from(PredicateId p) const {
    return std::ranges::any_of(rule_plan_.steps, [&](const Step& step) {
        const Match* m = as<Match>(step);
        return m != nullptr && m->predicate == p && takes(*m);
    });
}

// The outermost loop whose fact is another one after a firing, or is no more.
const Match& RuleEmitter::goes_on_at() const {
    if (rule_plan_.search.changed.step != OneSearch::kNone) return search_match(rule_plan_.search.changed.step);
    for (const Step& step : rule_plan_.steps)
        if (const Match* m = as<Match>(step); m != nullptr && takes(*m)) return *m;
    MELD_CHECK(false, "rule {} takes nothing away", scope_.rule.name);
}

void RuleEmitter::all_firings() {
    const Match* at = &goes_on_at();
    std::vector<PredicateId> read;
    for (const Step& step : rule_plan_.steps)
        if (const Match* m = as<Match>(step); m != nullptr && m->at_site && plan_.program.predicates[m->predicate].linear())
            if (std::ranges::find(read, m->predicate) == read.end()) read.push_back(m->predicate);
    declare_indexes();
    for (const PredicateId p : read) {
        const std::string name = predicate_name(plan_.program, p);
        w_.line("load_{}(s);", name);
        // Most catoms hold none.
        w_.line("if (s.{}.list.count == 0) return false;", name);
        w_.line("s.{}.arrange(*s.e);", name);
    }
    for (const PredicateId p : read)
        if (takes_from(p)) w_.line("Taken taken_{};", predicate_name(plan_.program, p));
    w_.raw("u64 firings = 0;");
    w_.open("const auto end = [&]() -> bool {");
    end_search(read);
    w_.raw("return true;");
    w_.close("};");
    const std::size_t outside = w_.depth();
    searching_ = at;
    steps(rule_plan_.steps);
    fire_in_search();
    searching_ = nullptr;
    close_to(outside);
    w_.raw("return firings > 0 && end();");
}

void RuleEmitter::end_search(const std::vector<PredicateId>& read) {
    for (const PredicateId p : read) {
        if (takes_from(p)) {
            const std::string name = predicate_name(plan_.program, p);
            w_.line("s.{0}.drop(*s.e, taken_{0});", name);
            lower(p);
        }
    }
    if (const OneSearch::MadeAgain& c = rule_plan_.search.changed; c.step != OneSearch::kNone) {
        lower(search_match(c.step).predicate);
        raise(search_match(c.step).predicate);
    }
    const std::size_t again = rule_plan_.search.put_back.size() + (rule_plan_.search.changed.step != OneSearch::kNone ? 1 : 0);
    if (again > 0) w_.line("s.e->derivations += {}firings;", again == 1 ? "" : fmt::format("{} * ", again));
    w_.raw("s.fired += firings - 1;");
    if (plan_.counts) w_.line("s.e->counters->rules[{}].evaluations += firings - 1;", rule_number(plan_, rule_plan_.rule));
}

// The loop over the facts of a match, without those that are taken.
void RuleEmitter::each_in_search(const Match& s, const std::string& i, const std::string& name) {
    const std::string rows = fmt::format("s.{}.list.rows", name), count = fmt::format("s.{}.list.count", name), taken = "taken_" + name;
    const bool some_taken = takes_from(s.predicate);
    std::string first = some_taken ? taken + ".from(0)" : "0", last = count,
                next = some_taken ? fmt::format("{}.from({} + 1)", taken, i) : "";
    if (s.lookup.found()) {
        const std::string group = known_row(s, s.lookup.by), at = fresh("at");
        if (s.lookup.kind == Lookup::Kind::Prefix) {
            w_.line("const Span {} = span_of<{}>({}, {}, {});", at, search_type(s), rows, count, group);
            first = some_taken ? fmt::format("{}.from({}.first)", taken, at) : at + ".first";
            last = at + ".end" + fits_;
        } else {
            const std::string rest = some_taken ? fmt::format("{}, {}", count, taken) : "";
            w_.line("const Found {} = {}.find(*s.e, {}, {}, {}{});", at, bag_indexes_.at(&s), rows, count, group,
                    some_taken ? ", " + taken : "");
            first = some_taken ? fmt::format("{}.start({})", at, rest) : at + ".first";
            last += fits_;
            next = fmt::format("{}.after({}{})", at, i, some_taken ? ", " + rest : "");
        }
    }
    const std::string step = next.empty() ? "++" + i : fmt::format("{} = {}", i, next);
    if (&s != searching_) return w_.open(fmt::format("for (u32 {0} = {1}; {0} < {2}; {3}) {{", i, first, last, step));
    w_.line("u32 {} = {};", i, first);
    w_.line("go_on_{}:", i);
    w_.open(fmt::format("for (; {0} < {1}; {2}) {{", i, last, step));
    if (takes(s)) goes_on_ = step + "; ";
    goes_on_ += fmt::format("goto go_on_{};", i);
}

void RuleEmitter::fire_in_search() {
    const OneSearch& search = rule_plan_.search;
    w_.raw("if (s.e->trap != Trap::None) return false;");
    about_to_fire();
    w_.raw("++firings;");
    std::string changed;  // The position of the fact that changes.
    for (const auto& [m, position] : found_at_) {
        const std::string name = predicate_name(plan_.program, m->predicate);
        if (changes(*m)) changed = position;
        if (takes(*m)) w_.line("taken_{0}.take(*s.e, s.{0}.list.count, {1});", name, position);
        if (plan_.counts && !m->read_only) w_.line("count_consumed(*s.e, {}, 1);", m->predicate.index());
    }
    for (std::size_t i = 0; i < rule_plan_.heads.size(); ++i) {
        const bool again = std::ranges::any_of(search.put_back, [&](const OneSearch::MadeAgain& m) { return m.head == i; });
        if (again && plan_.counts) w_.line("count_gained(*s.e, {});", as<MakeFact>(rule_plan_.heads[i])->predicate.index());
        if (!again && i != search.changed.head) head_block(rule_plan_.heads[i]);
    }
    if (!changed.empty()) {
        const MakeFact& head = *as<MakeFact>(rule_plan_.heads[search.changed.head]);
        const std::string name = predicate_name(plan_.program, head.predicate);
        make_row(head);
        if (plan_.counts) w_.line("count_gained(*s.e, {});", head.predicate.index());
        w_.raw("// The rule ends here where its firings exceed the limit, or where the fact has another place from now on.");
        w_.open(fmt::format("if (s.fired + firings > s.e->subdomain->max_derivations || !s.{}.change(*s.e, {}, row)) {{", name, changed));
        w_.line("s.{}.remove(*s.e, {});", name, changed);
        w_.line("s.{}.insert(*s.e, row);", name);
        w_.raw("return end();");
        w_.close();
    }
    w_.raw(goes_on_);
}

}  // namespace meld::emit
