// Emits for a column whom of the neighbours a change of a record concerns.
//     dist(B, D + 1, A) :- neighbor(A, B), dist(A, D, _).          type dist(node, min int, node).
// If the rules that read a column at neighbours are all of this form, a catom that has a distance does not need to be evaluated for a
// neighbour whose distance offers nothing better and has not been what its own rests on: nearly all changes that it is told.
#include <algorithm>
#include <set>

#include "compiler/check/program/op_info.h"
#include "compiler/emit/rule_emitter.h"

namespace meld::emit {

namespace {

// Whether a term is computed from these variables and literals alone.
bool follows_from(const Term& term, const std::set<plan::VariableId>& known) {
    return check::all_subterms(
        term, [&](const Term& t) { return t.is_variable() ? known.contains(t.variable) : check::info(t.op).has(check::OpInfo::kOffers); });
}

}  // namespace

bool is_offer(const plan::Plan& plan, const RulePlan& r, PredicateId predicate) {
    if (!r.branches.empty() || r.steps.size() < 2) return false;
    const auto* each = as<plan::EachNeighbour>(r.steps[0]);
    const auto* match = as<Match>(r.steps[1]);
    if (each == nullptr || !each->place.valid() || each->port.bind.valid() || each->port.equals.op != Op::Anonymous) return false;
    if (match == nullptr || match->predicate != predicate || match->at_site || match->place != each->place || !match->ranks) return false;
    std::set<plan::VariableId> known = {each->place};  // The neighbour itself: a value may remember whom it came from.
    for (std::size_t i = 0; i < match->arguments.size(); ++i) {
        if (match->uses[i] == ArgumentUse::Compare) return false;
        if (match->uses[i] == ArgumentUse::Bind) known.insert(match->arguments[i].variable);
    }
    for (const Step& s : std::span(r.steps).subspan(2)) {
        const auto* set = as<plan::Set>(s);
        const auto* test = as<plan::Test>(s);
        if (set != nullptr ? !follows_from(set->value, known) : test == nullptr || !follows_from(test->condition, known)) return false;
        if (set != nullptr) known.insert(set->variable);
    }
    const MakeFact& head = r.derived();
    return head.predicate == predicate && head.place == plan.program.rules[r.rule].site &&
           std::ranges::all_of(head.arguments, [&](const Term& t) { return follows_from(t, known); });
}

bool keeps_best(const plan::Plan& plan, const plan::StratumPlan& s) {
    const std::string_view reduction = info(plan.program.predicates[s.predicates[0]].aggregate).reduction_name;
    return s.recursion == plan::Recursion::Ranked && !plan.of(s.predicates[0]).waits && (reduction == "Best" || reduction == "Set");
}

namespace {

bool holds_lists(const Stored& s) {
    return std::ranges::any_of(s.fields, [](const plan::Field& f) { return f.type.compound(); });
}

// Whether a neighbour's value is offered as it is. Such values meet from all sides, and on a lattice, where links are few, nearly every
// neighbour of a change is concerned by another one: to ask took leader election a fifth longer. A value that gets worse with each link
// goes over a catom in one wave, and does not concern those that it came from.
bool hands_on(const plan::Plan& plan, const RulePlan& r) {
    const MakeFact& head = r.derived();
    return head.arguments[plan.program.predicates[head.predicate].aggregate_at - 1].is_variable();
}

// Whether what a rule offers depends on which catom offers it.
bool names_itself(const RulePlan& r) {
    const plan::VariableId itself = as<plan::EachNeighbour>(r.steps[0])->place;
    bool named = false;
    const auto look = [&](const Term& t) { check::each_variable(t, [&](plan::VariableId v) { named = named || v == itself; }); };
    for (const Step& s : std::span(r.steps).subspan(2)) {
        if (const auto* set = as<plan::Set>(s)) look(set->value);
        if (const auto* test = as<plan::Test>(s)) look(test->condition);
    }
    for (const Term& t : r.derived().arguments) look(t);
    return named;
}

std::string offer_function(const plan::Plan& plan, const RulePlan& r) { return rule_function(plan, r.rule) + "_offer"; }

}  // namespace

std::vector<const RulePlan*> offers_of(const plan::Plan& plan, plan::ColumnId id) {
    const plan::Column& column = plan.columns[id];
    if (!column.exported || column.rows) return {};
    for (const PredicateId p : column.predicates)
        if (holds_lists(plan.of(p))) return {};
    for (const auto* rules : {&plan.linear_rules, &plan.initial_facts})
        for (const RulePlan& r : *rules)
            if ((r.inputs & column.reader_dirty) != 0) return {};
    std::vector<const RulePlan*> offers;
    for (const plan::StratumPlan& s : plan.strata) {
        if ((s.inputs & column.reader_dirty) == 0) continue;
        const PredicateId p = s.predicates[0];
        const Stored& stored = plan.of(p);
        if (!keeps_best(plan, s) || stored.storage != Storage::Single || stored.column != id || !offers.empty()) return {};
        for (const RulePlan& r : s.rules) {
            if ((r.inputs & column.reader_dirty) == 0) continue;
            if (!is_offer(plan, r, p) || (!plan.program.by_links && hands_on(plan, r))) return {};
            offers.push_back(&r);
        }
    }
    return offers;
}

std::string concerned_function(plan::ColumnId column) { return fmt::format("concerned_{}", column.index()); }

void RuleEmitter::offer() {
    const Match& match = *as<Match>(rule_plan_.steps[1]);
    const MakeFact& head = rule_plan_.derived();
    const Stored& stored = plan_.of(match.predicate);
    const std::string name = predicate_name(plan_.program, match.predicate);
    w_.raw("");
    w_.open(fmt::format("inline bool {}([[maybe_unused]] Self& s, const {}& f, {}& out) {{", offer_function(plan_, rule_plan_),
                        record_name(stored.column), row_type(match.predicate)));
    const std::size_t outside = w_.depth();
    w_.open(fmt::format("if (f.{}_rank != kAbsent) {{", name));
    scope_.ranks.push_back(fmt::format("f.{}_rank", name));
    if (names_itself(rule_plan_)) bind(as<plan::EachNeighbour>(rule_plan_.steps[0])->place, "id_of(*s.g, s.catom)");
    use(match, [&](std::size_t k) { return fmt::format("f.{}_{}", name, field_name(k)); });
    steps({rule_plan_.steps.begin() + 2, rule_plan_.steps.end()});
    make_row(head);
    w_.line("row.rank = rank_above({});", scope_.ranks[0]);
    w_.raw("out = row;");
    w_.raw("return true;");
    close_to(outside);
    w_.raw("return false;");
    w_.close();
}

void declare_concerned(const plan::Plan& plan, Writer& w) {
    for (const plan::ColumnId id : plan.columns.ids())
        if (!offers_of(plan, id).empty())
            w.line("u32 {}(Eval* e, u32 catom, const void* before, const void* after, const i32* neighbours, u32 count, u32* out);",
                   concerned_function(id));
}

void emit_concerned(const plan::Plan& plan, Writer& w) {
    for (const plan::ColumnId id : plan.columns.ids()) {
        const std::vector<const RulePlan*> offers = offers_of(plan, id);
        if (offers.empty()) continue;
        for (const RulePlan* r : offers) RuleEmitter(plan, *r, w).offer();
        const PredicateId p = offers[0]->derived().predicate;
        const std::string name = predicate_name(plan.program, p), record = record_name(id);
        w.raw("");
        w.line("// The neighbours that a change of {} concerns.", plan.program.predicates[p].name);
        w.open(fmt::format(
            "{}u32 {}(Eval* e, u32 catom, const void* before, const void* after, const i32* neighbours, u32 count, u32* out) {{",
            shared(plan), concerned_function(id)));
        w.raw("Self s;");
        w.raw("s.e = e;");
        w.raw("s.g = &e->subdomain->geometry;");
        w.raw("s.columns = e->subdomain->columns;");
        w.raw("s.catom = catom;");
        if (!plan.program.functions.empty()) w.raw("s.calls = 0;");
        w.line("const {0}& was = *static_cast<const {0}*>(before);", record);
        w.line("const {0}& is = *static_cast<const {0}*>(after);", record);
        w.line("Offer<{}_t> offers[{}];", name, offers.size());
        for (std::size_t i = 0; i < offers.size(); ++i) {
            const std::string function = offer_function(plan, *offers[i]);
            w.line("offers[{0}].had = {1}(s, was, offers[{0}].before);", i, function);
            w.line("offers[{0}].has = {1}(s, is, offers[{0}].after);", i, function);
        }
        w.line("const auto* const records = reinterpret_cast<const {}*>(s.columns[{}]);", record, id.index());
        w.open(fmt::format("return concerned_by(*e, offers, neighbours, count, out, [&](u32 other, {}_t::Row& row) {{", name));
        w.line("const {}& r = records[other];", record);
        for (std::size_t i = 1; i <= plan.of(p).fields.size(); ++i) w.line("row.{0} = r.{1}_{0};", field_name(i), name);
        w.line("row.rank = r.{}_rank;", name);
        w.line("return r.{}_rank != kAbsent;", name);
        w.close("});");
        w.close();
    }
}

}  // namespace meld::emit
