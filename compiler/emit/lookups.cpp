// Emits how the rows of a match are found: by their group, by how they begin, with an index, or one after the other
// (compiler/plan/passes/indexes.cpp).
#include <algorithm>
#include <set>

#include "compiler/emit/rule_emitter.h"

namespace meld::emit {

using plan::Lookup;

namespace {

// The struct that describes a search: route_3_by_1_2.
std::string search_type(const plan::Plan& plan, const Match& m) {
    return fmt::format("{}_by_{}", predicate_name(plan.program, m.predicate), fmt::join(m.lookup.by, "_"));
}
// The member of Self with the index of the catom's own rows, or of a neighbour's.
std::string index_member(const plan::Plan& plan, const Match& m) {
    const char* const which = !m.at_site ? "_there" : m.lookup.kind == Lookup::Kind::Rounds ? "_rounds" : "";
    return "index_" + search_type(plan, m) + which;
}

// Every match that is looked up, of all rules.
template <class Visit>
void each_lookup(const plan::Plan& plan, const Visit& visit) {
    const auto on_steps = [&](const std::vector<Step>& steps) {
        plan::each_step(steps, [&](const Step& s) {
            if (const Match* m = as<Match>(s); m != nullptr && m->lookup.kind != Lookup::Kind::Scan) visit(*m);
        });
    };
    const auto on_rule = [&](const RulePlan& r, const auto& again) -> void {
        on_steps(r.steps);
        plan::each_head_plan(r.heads, [&](const HeadPlan& h) {
            if (const std::vector<Step>* steps = plan::steps_of(h)) on_steps(*steps);
        });
        for (const RulePlan& b : r.branches) again(b, again);
    };
    for (const plan::StratumPlan& s : plan.strata)
        for (const auto* rules : {&s.rules, &s.semi_naive, &s.deltas.affected, &s.deltas.regroup})
            for (const RulePlan& r : *rules) on_rule(r, on_rule);
    for (const auto* rules : {&plan.linear_rules, &plan.initial_facts})
        for (const RulePlan& r : *rules) on_rule(r, on_rule);
}

void emit_search(const plan::Plan& plan, const Match& m, Writer& w) {
    const Predicate& p = plan.program.predicates[m.predicate];
    w.open(fmt::format("struct {} {{", search_type(plan, m)));
    w.line("using Row = {}_t::Row;", predicate_name(plan.program, m.predicate));
    std::string order, hash = "kGroupHash";
    for (const std::size_t i : m.lookup.by) {
        order += fmt::format("if (const int c = {}) return c; ", compared(p.arguments[i].type, "a." + field_name(i), "b." + field_name(i)));
        hash = fmt::format("mix({}, {})", hash, hashed(p.arguments[i].type, "row." + field_name(i)));
    }
    w.line("static int order(const Row& a, const Row& b) {{ {}return 0; }}", order);
    w.line("static u64 hash(const Row& row) {{ return {}; }}", hash);
    w.close("};");
}

}  // namespace

bool has_lookups(const plan::Plan& plan) {
    bool found = false;
    each_lookup(plan, [&](const Match&) { found = true; });
    return found;
}

void emit_searches(const plan::Plan& plan, Writer& w) {
    std::set<std::string> known;
    each_lookup(plan, [&](const Match& m) {
        if (!known.insert(search_type(plan, m)).second) return;
        if (known.size() == 1) w.raw("");
        emit_search(plan, m, w);
    });
}

void each_index_member(const plan::Plan& plan, const std::function<void(const std::string& type, const std::string& name)>& visit) {
    std::set<std::string> known;
    each_lookup(plan, [&](const Match& m) {
        if (m.lookup.kind == Lookup::Kind::Prefix || m.lookup.kind == Lookup::Kind::Alike) return;
        if (plan.program.predicates[m.predicate].linear()) return;
        if (known.insert(index_member(plan, m)).second) visit(search_type(plan, m), index_member(plan, m));
    });
}

void each_rounds_index(const plan::Plan& plan, const plan::StratumPlan& stratum,
                       const std::function<void(const std::string& name)>& visit) {
    std::set<std::string> known;
    each_lookup(plan, [&](const Match& m) {
        if (m.lookup.kind == Lookup::Kind::Rounds && stratum.grows(m.predicate) && known.insert(index_member(plan, m)).second)
            visit(index_member(plan, m));
    });
}

// ---- in a rule

bool RuleEmitter::whole_key(const Match& s) const {
    const Predicate& p = plan_.program.predicates[s.predicate];
    const std::size_t end = p.aggregate == Aggregate::None ? p.arguments.size() : p.aggregate_at;
    if (end <= 1) return false;
    for (std::size_t i = 1; i < end; ++i)
        if (s.uses[i - 1] != ArgumentUse::Compare || !same_type(s.arguments[i - 1], p.arguments[i].type)) return false;
    return true;
}

std::string RuleEmitter::group_row(const Match& s) {
    MELD_EXPECT(whole_key(s), "rule {}: the group of {} is not known", scope_.rule.name, plan_.program.predicates[s.predicate].name);
    const Predicate& p = plan_.program.predicates[s.predicate];
    std::vector<std::size_t> arguments;
    for (std::size_t i = 1; i < (p.aggregate == Aggregate::None ? p.arguments.size() : p.aggregate_at); ++i) arguments.push_back(i);
    const std::string group = known_row(s, arguments);
    only_if_defined(plan::may_fail(plan_.program, s.arguments));
    return group;
}

std::string RuleEmitter::known_row(const Match& s, const std::vector<std::size_t>& arguments) {
    const Predicate& p = plan_.program.predicates[s.predicate];
    const std::string group = fresh("group");
    w_.line("{} {}{{}};", row_type(s.predicate), group);
    const Stored& stored = plan_.of(s.predicate);
    fits_.clear();
    for (const std::size_t i : arguments) {
        const std::string value = term(scope_, s.arguments[i - 1]);
        const bool narrow = p.arguments[i].type == Type::Int && stored.fields[i - 1].bytes < 8;
        const std::string field = fmt::format("{}.{}", group, field_name(i));
        w_.line("{} = {};", field, narrow ? fmt::format("static_cast<decltype({})>({})", field, value) : value);
        // A value that does not fit is in no row.
        if (narrow) fits_ += fmt::format(" && {} == {}", field, value);
    }
    return group;
}

std::string RuleEmitter::search_type(const Match& s) const { return emit::search_type(plan_, s); }

// Rows that are asked for by all arguments but the last: a set that grows may have them in a bitmap.
bool RuleEmitter::by_all_but_last(const Match& s) const {
    return s.lookup.kind == Lookup::Kind::Rounds && s.lookup.by.size() + 1 == s.arguments.size() &&
           s.lookup.by.back() == s.lookup.by.size();
}

void RuleEmitter::each_but_last(const Match& s, const std::string& row) {
    const std::string name = predicate_name(plan_.program, s.predicate), group = known_row(s, s.lookup.by), at = fresh("at");
    w_.line("auto {0} = s.{1}_rounds.among(*s.e, s.{2}, s.{1}, {3});", at, name, index_member(plan_, s), group);
    w_.open(fmt::format("while ({}.next(){}) {{", at, fits_));
    w_.line("[[maybe_unused]] const {} {} = {}.row;", row_type(s.predicate), row, at);
}

void RuleEmitter::each_row(const Match& s, const std::string& i, const std::string& rows, const std::string& count) {
    if (!s.lookup.found()) return w_.open(fmt::format("for (u32 {0} = 0; {0} < {1}; ++{0}) {{", i, count));
    const std::string group = known_row(s, s.lookup.by), at = fresh("at");
    // A value that no row can hold is in none.
    const std::string last = s.lookup.kind == Lookup::Kind::Prefix ? at + ".end" : count;
    if (s.lookup.kind == Lookup::Kind::Prefix) {
        w_.line("const Span {} = span_of<{}>({}, {}, {});", at, search_type(s), rows, count, group);
        w_.open(fmt::format("for (u32 {0} = {1}.first; {0} < {2}{3}; ++{0}) {{", i, at, last, fits_));
        return;
    }
    const auto bag = bag_indexes_.find(&s);
    const std::string index = bag != bag_indexes_.end() ? bag->second : "s." + index_member(plan_, s);
    w_.line("const Found {} = {}.{}(*s.e, {}, {}, {});", at, index, s.lookup.kind == Lookup::Kind::Rounds ? "find_among_more" : "find",
            rows, count, group);
    w_.open(fmt::format("for (u32 {0} = {1}.first; {0} < {2}{3}; {0} = {1}.after({0})) {{", i, at, last, fits_));
}

void RuleEmitter::each_kind(const Match& s) {
    const std::string name = predicate_name(plan_.program, s.predicate), type = search_type(s), f = fresh("f");
    alike_ = {.rows = fresh("rows"), .first = fresh("k"), .end = fresh("end")};
    w_.line("const {}* const {} = s.{}_rounds.kinds<{}>(*s.e);", row_type(s.predicate), alike_.rows, name, type);
    w_.line("const u32 {0}_count = s.{1}.count - s.{1}_rounds.last;", alike_.rows, name);
    w_.open(fmt::format("for (u32 {0} = 0, {1} = 0; {0} < {2}_count; {0} = {1}) {{", alike_.first, alike_.end, alike_.rows));
    w_.line("{} = end_of_alike<{}>({}, {}, {}_count);", alike_.end, type, alike_.rows, alike_.first, alike_.rows);
    w_.line("[[maybe_unused]] const {}& {} = {}[{}];", row_type(s.predicate), f, alike_.rows, alike_.first);
    Match shared = s;
    for (std::size_t i = 1; i <= s.uses.size(); ++i)
        if (std::ranges::find(s.lookup.by, i) == s.lookup.by.end()) shared.uses[i - 1] = ArgumentUse::Skip;
    use(shared, [&](std::size_t k) { return fmt::format("{}.{}", f, field_name(k)); });
}

void RuleEmitter::each_of_kind(const Match& s) {
    const std::string i = fresh("k"), f = fresh("f");
    w_.open(fmt::format("for (u32 {0} = {1}; {0} < {2}; ++{0}) {{", i, alike_.first, alike_.end));
    w_.line("const {}& {} = {}[{}];", row_type(s.predicate), f, alike_.rows, i);
    Match rest = s;
    for (const std::size_t k : s.lookup.by) rest.uses[k - 1] = ArgumentUse::Skip;
    use(rest, [&](std::size_t k) { return fmt::format("{}.{}", f, field_name(k)); });
}

void RuleEmitter::declare_indexes() {
    plan::each_step(rule_plan_.steps, [&](const Step& s) {
        const Match* m = as<Match>(s);
        if (m == nullptr || m->lookup.kind != Lookup::Kind::Index || !plan_.program.predicates[m->predicate].linear()) return;
        w_.line("Index<{}> {};", search_type(*m), bag_indexes_[m] = fresh("index"));
    });
}

}  // namespace meld::emit
