// Emits a function for each stratum, which derives the facts of its predicates at one catom.
#include <algorithm>

#include "compiler/emit/writer.h"
#include "compiler/plan/picks.h"

namespace meld::emit {

using namespace check;
using plan::Recursion;
using plan::StratumPlan;

std::string now_at(const plan::Plan& plan, const RulePlan& r) {
    const std::string number = rule_number(plan, r.rule), rule = fmt::format("s.e->rule = {};", number);
    return plan.places ? fmt::format("{} note_place(*s.e, {});", rule, number) : rule;
}

bool calls_catom(const plan::Plan& plan, PredicateId id) {
    return combines_at_catom(plan.program.predicates[id]) && !plan::picks(plan, id);
}

namespace {

std::string view(const plan::Plan& plan, PredicateId id) { return "s." + predicate_name(plan.program, id); }

// The rule reported for a recursion that does not end: one that reads a predicate it helps to derive.
RuleId culprit(const plan::Plan& plan, const StratumPlan& stratum) {
    MELD_EXPECT(!stratum.rules.empty(), "a stratum that nothing derives");
    const auto recursive = [&](const RulePlan& r) {
        bool reads = false;
        each_atom(plan.program.rules[r.rule].body, [&](const Atom& a, bool) {
            reads = reads || std::find(stratum.predicates.begin(), stratum.predicates.end(), a.predicate) != stratum.predicates.end();
        });
        return reads;
    };
    const auto found = std::find_if(stratum.rules.begin(), stratum.rules.end(), recursive);
    return found == stratum.rules.end() ? stratum.rules.back().rule : found->rule;
}

// From here on the facts of a predicate follow from what its rules have proposed.
void decides(const plan::Plan& plan, PredicateId id, Writer& w) {
    if (plan.places) w.line("note_place(*s.e, kPlaceDecides + {});", id.index());
}

void run_all_rules(const plan::Plan& plan, const StratumPlan& stratum, Writer& w) {
    if (plan::may_fail(plan.program, stratum)) w.raw("derive_anew(*s.e);");
    for (const RulePlan& r : stratum.rules) w.line("{} {}(s);", now_at(plan, r), rule_function(plan, r.rule));
    if (!stratum.predicates.empty()) decides(plan, stratum.predicates[0], w);
}

std::string own_bit(const plan::Plan& plan, PredicateId id) { return hex(plan.columns[plan.of(id).column].own_dirty); }

// A combination that needs the catom, or the neighbours that an aggregate waits for.
void emit_reduction(const plan::Plan& plan, const StratumPlan& stratum, PredicateId id, Writer& w) {
    const Predicate& p = plan.program.predicates[id];
    const std::string name = predicate_name(plan.program, id);
    if (calls_catom(plan, id)) {
        const std::string value = field_name(p.aggregate_at);
        const Type& type = p.arguments[p.aggregate_at].type;
        const RuleId first = stratum.rules[0].rule;
        const Scope scope{plan, plan.program.rules[first], first.index()};
        w.raw("");
        w.open(fmt::format("static void combine_{0}(Self& s, const {0}_t::Row* rows, u32 n, {0}_t::Row& out) {{", name));
        if (p.aggregate == Aggregate::Custom) {
            const std::string next = call_with(scope, p.fold, {"out." + value, "rows[i]." + value});
            w.line("for (u32 i = 1; i < n && s.e->trap == Trap::None; ++i) out.{} = {};", value,
                   type == Type::Float ? fmt::format("checked_real(*s.e, {}, {})", scope.site(), next) : next);
        } else {
            w.line("{};", aggregate_object(p.aggregate, type, type, term(scope, p.parameter), "made"));
            w.line("out.{0} = combine_rows(*s.e, {1}, made, rows, n, [](const {2}_t::Row& row) {{ return row.{0}; }});", value,
                   scope.site(), name);
        }
        w.close();
    }
    if (!p.complete_link.valid()) return;
    w.raw("");
    w.line("// The ports of the neighbours that {} waits for.", p.name);
    w.open(fmt::format("static u32 needed_{}(Self& s) {{", name));
    w.raw("u32 ports = 0;");
    if (plan.program.predicates[p.complete_link].world != WorldSource::None) {
        w.raw("for (i32 port = 0; port < ports_of(s); ++port) ports |= u32{s.neighbour[port] >= 0} << port;");
    } else {
        const std::string link = predicate_name(plan.program, p.complete_link);
        w.line("load_{}(s);", link);
        w.line("for (u32 i = 0; i < s.{0}.count; ++i) ports |= {1};", link,
               plan.of(p.complete_link).storage == Storage::PerLink
                   ? fmt::format("u32{{s.neighbour[s.{0}.rows[i].a1] >= 0}} << s.{0}.rows[i].a1", link)
                   : fmt::format("port_bit(s, s.{}.rows[i].a1)", link));
    }
    w.raw("return ports;");
    w.close();
}
// The further arguments of the kernel's functions.
std::string reduction(const plan::Plan& plan, PredicateId id) {
    const Predicate& p = plan.program.predicates[id];
    const std::string name = predicate_name(plan.program, id);
    std::string text;
    if (calls_catom(plan, id))
        text = fmt::format(", [&s](Eval&, const {0}_t::Row* rows, u32 n, {0}_t::Row& out) {{ combine_{0}(s, rows, n, out); }}", name);
    else if (plan.in_pieces() && combines(p.aggregate) && !combines_at_catom(p))
        text = fmt::format(", OwnCombine<{}_t>{{{}}}", name, first_rule(plan, id));
    else if (p.complete_link.valid())
        text = fmt::format(", OwnCombine<{}_t>{{}}", name);
    return p.complete_link.valid() ? text + fmt::format(", needed_{}(s)", name) : text;
}

// Not recursive, or sums along a tree: the proposals are complete.
void evaluate_plainly(const plan::Plan& plan, const StratumPlan& stratum, Writer& w) {
    MELD_EXPECT(stratum.predicates.size() == 1, "{} predicates are evaluated one by one", stratum.predicates.size());
    const PredicateId p = stratum.predicates[0];
    run_all_rules(plan, stratum, w);
    w.line("if (evaluate_plain(*s.e, {}{})) changed |= {};", view(plan, p), reduction(plan, p), own_bit(plan, p));
}

// Each round is computed from those before it, so after as many passes as there are rounds nothing changes any more.
void evaluate_in_rounds(const plan::Plan& plan, const StratumPlan& stratum, Writer& w) {
    for (const PredicateId p : stratum.predicates) {
        const std::string name = predicate_name(plan.program, p);
        w.line("const auto* before_{0} = s.{0}.rows;", name);
        w.line("const u32 before_{0}_count = s.{0}.count;", name);
    }
    w.raw("u64 passes = 0;");
    w.open("for (bool again = true; again && s.e->trap == Trap::None;) {");
    w.raw("again = false;");
    run_all_rules(plan, stratum, w);
    for (const PredicateId p : stratum.predicates)
        w.line("again = evaluate_plain(*s.e, {}{}) || again;", view(plan, p), reduction(plan, p));
    w.line(
        "if (++passes > s.e->subdomain->max_growing_derivations) trap(*s.e, Trap::TooManyDerivations, {}, "
        "static_cast<i64>(s.e->subdomain->max_growing_derivations));",
        rule_number(plan, culprit(plan, stratum)));
    w.close();
    for (const PredicateId p : stratum.predicates) {
        const std::string name = predicate_name(plan.program, p);
        w.line("if (s.{0}.rows != before_{0} && s.{0}.end_rounds(before_{0}, before_{0}_count)) changed |= {1};", name, own_bit(plan, p));
    }
}

// Where a recursion within the catom does not end: the first of its rules that still derives something new. Each is run by itself
// once more, for the message.
void emit_guilty(const plan::Plan& plan, const StratumPlan& stratum, std::size_t number, Writer& w) {
    w.raw("");
    w.open(fmt::format("[[gnu::noinline, gnu::cold]] static u32 guilty_{}(Self& s) {{", number));
    const bool by_round = !stratum.semi_naive.empty();
    // What the last round has derived is taken in first, so that only what follows from it counts.
    const auto grew = [&](PredicateId p, const char* ask) {
        return by_round ? fmt::format("{0}_rounds.{1}(*s.e, {0})", view(plan, p), ask) : fmt::format("gather(*s.e, {})", view(plan, p));
    };
    for (const PredicateId p : stratum.predicates) w.line("{};", grew(p, "end_round"));
    const auto try_rule = [&](RuleId rule, const std::string& function) {
        w.line("{}(s);", function);
        for (const PredicateId p : stratum.predicates) w.line("if ({}) return {};", grew(p, "grew"), rule_number(plan, rule));
    };
    for (std::size_t i = 0; i < stratum.semi_naive.size(); ++i) {
        const RuleId rule = stratum.semi_naive[i].rule;
        try_rule(rule, fmt::format("{}_semi_naive{}", rule_function(plan, rule), i));
    }
    for (const RulePlan& r : stratum.rules)
        if (!by_round) try_rule(r.rule, rule_function(plan, r.rule));
    w.line("return {};", rule_number(plan, culprit(plan, stratum)));
    w.close();
}

void evaluate_local_sets(const plan::Plan& plan, const StratumPlan& stratum, std::size_t number, Writer& w) {
    const bool by_round = !stratum.semi_naive.empty();
    for (const PredicateId p : stratum.predicates)
        MELD_EXPECT(!plan.of(p).ranked, "{} is derived from scratch and has ranks", plan.program.predicates[p].name);
    for (const PredicateId p : stratum.predicates) {
        const std::string name = predicate_name(plan.program, p);
        w.line("const auto* before_{0} = s.{0}.rows;", name);
        w.line("const u32 before_{0}_count = s.{0}.count;", name);
        if (by_round) {
            w.line("s.{0}_rounds.start(s.{0});", name);
        } else {
            w.line("s.{0}.rows = nullptr;", name);
            w.line("s.{0}.count = 0;", name);
        }
    }
    if (by_round) each_rounds_index(plan, stratum, [&](const std::string& index) { w.line("s.{}.reset();", index); });
    w.raw("const u64 derivations = s.e->derivations;");
    if (by_round) run_all_rules(plan, stratum, w);
    w.open("for (bool grew = true; grew && s.e->trap == Trap::None;) {");
    w.raw("grew = false;");
    if (!by_round) run_all_rules(plan, stratum, w);
    for (const PredicateId p : stratum.predicates)
        w.line(fmt::runtime(by_round ? "grew = {0}_rounds.end_round(*s.e, {0}) || grew;" : "grew = gather(*s.e, {0}) || grew;"),
               view(plan, p));
    for (std::size_t i = 0; i < stratum.semi_naive.size(); ++i)
        w.line("if (grew) {}{}_semi_naive{}(s);",
               plan.places ? fmt::format("note_place(*s.e, {}), ", rule_number(plan, stratum.semi_naive[i].rule)) : "",
               rule_function(plan, stratum.semi_naive[i].rule), i);
    const std::string most = fmt::format("s.e->subdomain->max_{}_derivations", plan::may_grow(plan, stratum) ? "growing" : "finite");
    std::string many;
    for (const PredicateId p : stratum.predicates)
        if (by_round) many += fmt::format(" || s.{0}.count > view_limit<{0}_t>(*s.e)", predicate_name(plan.program, p));
    w.open(fmt::format("if ((s.e->derivations - derivations > {}{}) && s.e->trap == Trap::None) {{", most, many));
    w.line("const u32 guilty = guilty_{}(s);", number);
    // Its rounds may have met another limit.
    w.raw("s.e->trap = Trap::None;");
    for (const PredicateId p : stratum.predicates)
        if (by_round) w.line("check_view_limit<{0}_t>(*s.e, s.{0}.count, guilty);", predicate_name(plan.program, p));
    w.open("if (s.e->trap == Trap::None) {");
    w.line("trap(*s.e, Trap::TooManyDerivations, guilty, static_cast<i64>({}));", most);
    w.close();
    w.close();
    w.close();
    for (const PredicateId p : stratum.predicates) {
        const std::string name = predicate_name(plan.program, p);
        w.line("if (s.{0}{1}) changed |= {2};", name,
               fmt::format(fmt::runtime(by_round ? "_rounds.finish(*s.e, s.{0}, before_{0}, before_{0}_count)"
                                                 : ".end_rounds(before_{0}, before_{0}_count)"),
                           name),
               own_bit(plan, p));
    }
}

void evaluate_mutually(const plan::Plan& plan, const StratumPlan& stratum, Writer& w) {
    for (const PredicateId p : stratum.predicates)
        MELD_EXPECT(plan.of(p).ranked, "{} recurs and has no ranks", plan.program.predicates[p].name);
    const auto each = [&](const char* format) {
        for (const PredicateId p : stratum.predicates) w.raw(fmt::format(fmt::runtime(format), predicate_name(plan.program, p)));
    };
    for (const PredicateId p : stratum.predicates)
        w.line("{0}<{1}_t> m_{1}(s.{1});", plan.program.predicates[p].front != Aggregate::None ? "Front" : "Mutual",
               predicate_name(plan.program, p));
    w.raw("u64 rounds = 0;");
    w.open("for (bool again = true; again && s.e->trap == Trap::None;) {");
    w.raw("again = false;");
    each("m_{0}.start(*s.e);");
    w.open("for (bool grew = true; grew && s.e->trap == Trap::None;) {");
    w.raw("grew = false;");
    run_all_rules(plan, stratum, w);
    // All must have seen the same round before any view grows.
    for (const PredicateId p : stratum.predicates)
        w.raw(fmt::format("const bool kept_{0} = m_{0}.keep(*s.e);", predicate_name(plan.program, p)));
    each("grew = grew || kept_{0};");
    w.raw("if (grew) {");
    each("    s.{0}.proposed.reset();");
    w.raw("}");
    w.close();
    each("m_{0}.lose(*s.e);");
    w.open("for (bool grew = true; grew && s.e->trap == Trap::None;) {");
    w.raw("grew = false;");
    run_all_rules(plan, stratum, w);
    for (const PredicateId p : stratum.predicates)
        w.raw(fmt::format("const bool took_{0} = m_{0}.take(*s.e);", predicate_name(plan.program, p)));
    each("grew = grew || took_{0};");
    w.line(
        "if (++rounds > s.e->subdomain->max_growing_derivations) trap(*s.e, Trap::TooManyDerivations, {}, "
        "static_cast<i64>(s.e->subdomain->max_growing_derivations));",
        rule_number(plan, culprit(plan, stratum)));
    w.close();
    each("again = again || m_{0}.replaced;");
    w.close();
    for (const PredicateId p : stratum.predicates)
        w.line("if (m_{}.finish(*s.e)) changed |= {};", predicate_name(plan.program, p), own_bit(plan, p));
}

// Whether the catom may read the rows of a view after its stratum.
bool read_later(const plan::Plan& plan, PredicateId id) {
    const std::uint64_t own = plan.column_of(id).own_dirty;
    return !plan.linear_rules.empty() || plan.program.predicates[id].kind == PredicateKind::Action ||
           std::ranges::any_of(plan.strata, [&](const StratumPlan& s) { return (s.inputs & own) != 0; });
}

// If neighbours have only gained rows, and the catom has lost none: what follows from these rows, and all others stay.
void emit_gains(const plan::Plan& plan, const StratumPlan& stratum, Writer& w) {
    const std::string name = predicate_name(plan.program, stratum.predicates[0]);
    w.open((stratum.deltas.inputs & kDirtyGroups) != 0 ? "if ((todo & kDirtyGroups) == 0 && has_lost_nothing(*s.e)) {"
                                                       : "if (has_lost_nothing(*s.e)) {");
    w.line("Gains<{}_t> gains;", name);
    w.raw("bool only_gains = true;");
    for (std::size_t i = 0; i < stratum.deltas.affected.size(); ++i) {
        const RulePlan& r = stratum.deltas.affected[i];
        if (plan.places) w.line("note_place(*s.e, {});", rule_number(plan, r.rule));
        w.line("if (todo & {}) only_gains = only_gains && {}_gains{}(s, gains);", hex(r.inputs), rule_function(plan, r.rule), i);
    }
    decides(plan, stratum.predicates[0], w);
    w.open(fmt::format("if (only_gains && s.e->trap == Trap::None && gains.merge(*s.e, s.{})) {{", name));
    w.line("if (take_gains<{}>(*s.e, s.{}, gains)) changed |= {};", read_later(plan, stratum.predicates[0]), name,
           own_bit(plan, stratum.predicates[0]));
    w.raw("return true;");
    w.close();
    w.raw("s.e->trap = Trap::None;");
    w.close();
}

// If only rows have changed: the groups that they affect, derived again. A failure there is not a failure of the program, because rows are
// read in a different order: the whole stratum is then evaluated, which reports it.
void emit_row_evaluation(const plan::Plan& plan, const StratumPlan& stratum, std::size_t number, Writer& w) {
    MELD_EXPECT(stratum.predicates.size() == 1 && !stratum.deltas.affected.empty(), "a stratum without delta rules");
    MELD_EXPECT(stratum.deltas.regroup.size() >= stratum.rules.size(), "{} of {} rules derive one group", stratum.deltas.regroup.size(),
                stratum.rules.size());
    const std::string name = predicate_name(plan.program, stratum.predicates[0]);
    w.raw("");
    w.open(fmt::format("MELD_STEP static bool evaluate_{}_rows(Self& s, u64 todo, u64& changed) {{", number));
    if (takes_gains(plan, stratum)) emit_gains(plan, stratum, w);
    w.line("AffectedGroups<{}_t> affected;", name);
    if (stratum.deltas.inputs & kDirtyGroups)
        w.line("if (todo & kDirtyGroups) affected.add_woken(*s.e, s.e->subdomain->changes[{}][s.catom]);",
               plan.of(stratum.predicates[0]).column.index());
    for (std::size_t i = 0; i < stratum.deltas.affected.size(); ++i) {
        const RulePlan& r = stratum.deltas.affected[i];
        w.open(fmt::format("if (todo & {}) {{", hex(r.inputs)));
        if (r.unchanged != 0) w.line("if (todo & {}) return false;", hex(r.unchanged));
        if (plan.places) w.line("note_place(*s.e, {});", rule_number(plan, r.rule));
        w.line("{}_affected{}(s, affected);", rule_function(plan, r.rule), i);
        w.close();
    }
    w.line("if (s.e->trap != Trap::None || !affected.few(*s.e, s.{})) {{", name);
    w.raw("    s.e->trap = Trap::None;");
    w.raw("    return false;");
    w.raw("}");
    w.line("affected.find_places(*s.e, s.{});", name);
    // In a world of links neighbours are listed elsewhere.
    if (plan.of(stratum.predicates[0]).exported && !plan.program.by_links)
        w.line("affected.ask_around(s.{}, &rows_of(s, {}, 0), s.neighbour, ports_of(s));", name,
               plan.of(stratum.predicates[0]).column.index());
    w.open("for (u32 i = 0; i < affected.groups.count; ++i) {");
    w.line("affected.first[i] = s.{}.proposed.count;", name);
    w.line("const Near near = {{affected.at[i], s.{}.count}};", name);
    for (const RulePlan& r : stratum.deltas.regroup) {
        if (plan.places) w.line("note_place(*s.e, {});", rule_number(plan, r.rule));
        w.line("{}_group(s, affected.groups.rows[i], near);", rule_function(plan, r.rule));
    }
    w.close();
    decides(plan, stratum.predicates[0], w);
    w.line("affected.first[affected.groups.count] = s.{}.proposed.count;", name);
    w.open("if (s.e->trap != Trap::None) {");
    w.raw("s.e->trap = Trap::None;");
    w.line("s.{}.proposed.reset();", name);
    w.raw("return false;");
    w.close();
    w.line("if (evaluate_affected(*s.e, s.{}, affected{})) changed |= {};", name, reduction(plan, stratum.predicates[0]),
           own_bit(plan, stratum.predicates[0]));
    w.raw("return true;");
    w.close();
}

void emit_stratum(const plan::Plan& plan, const StratumPlan& stratum, std::size_t number, Writer& w) {
    std::string names;
    for (const PredicateId p : stratum.predicates) names += " " + name_without_line(plan.program.predicates[p]);
    const bool rows = stratum.deltas.inputs != 0;
    for (const PredicateId p : stratum.predicates) emit_reduction(plan, stratum, p, w);
    if (rows) emit_row_evaluation(plan, stratum, number, w);
    if (stratum.recursion == Recursion::LocalSets) emit_guilty(plan, stratum, number, w);
    w.raw("");
    w.line("// Stratum {}:{}. Returns the dirty bits of what changed.", number, names);
    w.open(fmt::format("MELD_STEP {}u64 evaluate_{}(Self& s{}) {{", shared(plan), number, rows ? ", u64 todo" : ""));
    w.raw("u64 changed = 0;");
    for (const PredicateId p : stratum.predicates) w.line("load_{}(s);", predicate_name(plan.program, p));
    const bool fails = plan::may_fail(plan.program, stratum);
    if (fails) w.line("s.e->stratum = {};", number);
    if (rows)
        w.line("if ((todo & {}) == 0 && !s.again && s.e->trap == Trap::None && {}evaluate_{}_rows(s, todo, changed)) return changed;",
               hex((stratum.inputs | kDirtyBorn | kDirtyLinks) & ~stratum.deltas.inputs),
               fails ? fmt::format("(s.e->undefined & undefined_bit({})) == 0 && ", number) : "", number);
    switch (stratum.recursion) {
        case Recursion::None:
        case Recursion::Tree:
            evaluate_plainly(plan, stratum, w);
            break;
        case Recursion::LocalSets:
            evaluate_local_sets(plan, stratum, number, w);
            break;
        case Recursion::Ranked:
            MELD_EXPECT(stratum.predicates.size() == 1, "{} predicates support themselves alone", stratum.predicates.size());
            run_all_rules(plan, stratum, w);
            w.line("if (evaluate_ranked(*s.e, {})) changed |= {};", view(plan, stratum.predicates[0]),
                   own_bit(plan, stratum.predicates[0]));
            break;
        case Recursion::Mutual:
            evaluate_mutually(plan, stratum, w);
            break;
        case Recursion::Rounds:
            evaluate_in_rounds(plan, stratum, w);
            break;
    }
    w.raw("return changed;");
    w.close();
}

}  // namespace

void emit_strata(const plan::Plan& plan, Writer& w) {
    for (std::size_t i = 0; i < plan.strata.size(); ++i) {
        w.part(part_of(plan, plan.strata[i].predicates[0]));
        emit_stratum(plan, plan.strata[i], i, w);
    }
}

}  // namespace meld::emit
