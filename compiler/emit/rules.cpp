// Emits one function per rule: nested loops over the plan's steps, with the heads innermost.
#include <algorithm>

#include "compiler/emit/rule_emitter.h"

namespace meld::emit {

namespace {

constexpr const char* kLetters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_'";

}  // namespace

void RuleEmitter::view() {
    MELD_EXPECT(!scope_.rule.linear, "rule {} is linear", scope_.rule.name);
    MELD_EXPECT(rule_plan_.branches.empty() ? rule_plan_.heads.size() == 1 : rule_plan_.heads.empty(), "view {} has {} heads",
                scope_.rule.name, rule_plan_.heads.size());
    if (rule_plan_.branches.empty()) comment(scope_.rule);
    for (const RulePlan& b : rule_plan_.branches) comment(plan_.program.rules[b.rule]);
    w_.open(fmt::format("{} void {}(Self& s) {{", linkage(plan_, plan_.program.rules.count()), rule_function(plan_, rule_plan_.rule)));
    const std::size_t outside = w_.depth();
    leaves_out_ = true;
    if (rule_plan_.branches.empty()) count(rule_plan_.rule, Part::Whole);
    for (const RulePlan& b : rule_plan_.branches) count_evaluation(b.rule);
    steps(rule_plan_.steps);
    if (rule_plan_.branches.empty())
        propose(rule_plan_.derived());
    else
        branches();
    close_to(outside);
    w_.close();
}

bool RuleEmitter::grows(PredicateId p) const {
    return std::ranges::any_of(plan_.strata, [&](const plan::StratumPlan& s) {
        return s.grows(p) && std::ranges::any_of(s.rules, [&](const RulePlan& r) {
                   return r.rule == rule_plan_.rule ||
                          std::ranges::any_of(r.branches, [&](const RulePlan& b) { return b.rule == rule_plan_.rule; });
               });
    });
}

void RuleEmitter::branches() {
    const Scope before = scope_;
    for (const RulePlan& b : rule_plan_.branches) {
        w_.open("{");
        const std::size_t outside = w_.depth();
        scope_.rule_index = b.rule.index();
        w_.line("s.e->rule = {};", rule_number(plan_, b.rule));
        count(b.rule, Part::Branch);
        steps(b.steps);
        propose(b.derived());
        close_to(outside);
        w_.close();
        restore(before);
    }
    scope_.rule_index = before.rule_index;
}

void RuleEmitter::affected(std::size_t number, const RulePlan* offer) {
    MELD_EXPECT(rule_plan_.heads.size() == 1 && rule_plan_.inputs != 0, "rule {} is no delta rule", scope_.rule.name);
    const MakeFact& head = rule_plan_.derived();
    w_.raw("");
    w_.open(fmt::format("{} void {}_affected{}(Self& s, AffectedGroups<{}_t>& affected) {{", linkage(plan_, plan_.program.rules.count()),
                        rule_function(plan_, rule_plan_.rule), number, predicate_name(plan_.program, head.predicate)));
    const std::size_t outside = w_.depth();
    steps(rule_plan_.steps);
    if (offer != nullptr) {
        steps({offer->steps.begin() + 2, offer->steps.end()});
        make_row(head);
        w_.line("row.rank = rank_above({}.rank);", last_changed_.row);
        w_.line("if (affected.concerns(s.{}, row, {})) affected.add(*s.e, row);", predicate_name(plan_.program, head.predicate),
                last_changed_.gone);
    } else {
        w_.line("{} row{{}};", row_type(head.predicate));
        for (std::size_t i = 1; i <= plan::group_arguments(plan_.program.predicates[head.predicate]); ++i)
            w_.line("row.{} = {};", field_name(i), head_value(head.predicate, i, head.arguments[i - 1]));
        w_.raw("affected.add(*s.e, row);");
    }
    close_to(outside);
    w_.close();
}

void RuleEmitter::gains(std::size_t number) {
    MELD_EXPECT(rule_plan_.heads.size() == 1 && rule_plan_.steps.size() >= 2, "rule {} offers nothing", scope_.rule.name);
    const Match& match = *as<Match>(rule_plan_.steps[1]);
    const MakeFact& head = rule_plan_.derived();
    const std::string changes = fresh("changes"), to = fresh("to"), i = fresh("k"), f = fresh("f"), row = row_type(match.predicate);
    w_.raw("");
    w_.open(fmt::format("{} bool {}_gains{}(Self& s, Gains<{}_t>& gains) {{", linkage(plan_, plan_.program.rules.count()),
                        rule_function(plan_, rule_plan_.rule), number, predicate_name(plan_.program, head.predicate)));
    const std::size_t outside = w_.depth();
    step(*as<plan::EachNeighbour>(rule_plan_.steps[0]));
    w_.open(fmt::format("for (const RowChanges* {0} = s.e->subdomain->changes[{1}][{2}]; {0} != nullptr; {0} = {0}->next) {{", changes,
                        plan_.of(match.predicate).column.index(), scope_.at(match.place)));
    w_.line("if ({}->removed != 0) return false;", changes);
    w_.line("{}* {} = gains.room(*s.e, {}->added);", row_type(head.predicate), to, changes);
    const std::size_t before = w_.depth();
    w_.open(fmt::format("for (u32 {0} = 0; {0} < {1}->added; ++{0}) {{", i, changes));
    w_.line("[[maybe_unused]] const {0}& {1} = rows_in<{0}>({2})[{3}];", row, f, changes, i);
    use(match, [&](std::size_t k) { return fmt::format("{}.{}", f, field_name(k)); });
    steps({rule_plan_.steps.begin() + 2, rule_plan_.steps.end()});
    make_row(head);
    w_.line("row.rank = rank_above({}.rank);", f);
    w_.line("*{}++ = row;", to);
    close_to(before);
    w_.line("gains.end(*s.e, {});", to);
    close_to(outside);
    w_.raw("return true;");
    w_.close();
}

void RuleEmitter::semi_naive(std::size_t number) {
    MELD_EXPECT(rule_plan_.heads.size() == 1 && rule_plan_.given.empty(), "rule {} is not semi-naive", scope_.rule.name);
    w_.raw("");
    w_.open(fmt::format("{} void {}_semi_naive{}(Self& s) {{", linkage(plan_, plan_.program.rules.count()),
                        rule_function(plan_, rule_plan_.rule), number));
    const std::size_t outside = w_.depth();
    leaves_out_ = true;
    count(rule_plan_.rule, Part::Whole);
    steps(rule_plan_.steps);
    if (const Match* changed = as<Match>(rule_plan_.steps[0]); changed != nullptr && changed->lookup.kind == plan::Lookup::Kind::Alike)
        each_of_kind(*changed);
    propose(rule_plan_.derived());
    close_to(outside);
    w_.close();
}

void RuleEmitter::group() {
    const MakeFact& head = rule_plan_.derived();
    MELD_EXPECT(rule_plan_.given.size() == plan::group_arguments(plan_.program.predicates[head.predicate]),
                "rule {} is given {} of a group", scope_.rule.name, rule_plan_.given.size());
    w_.raw("");
    w_.open(fmt::format("{} void {}_group(Self& s, const {}& group, [[maybe_unused]] Near near) {{",
                        linkage(plan_, plan_.program.rules.count()), rule_function(plan_, rule_plan_.rule), row_type(head.predicate)));
    const std::size_t outside = w_.depth();
    near_ = head.predicate;
    count(rule_plan_.rule, Part::Whole);
    for (std::size_t i = 0; i < rule_plan_.given.size(); ++i) bind(rule_plan_.given[i], fmt::format("group.{}", field_name(i + 1)));
    steps(rule_plan_.steps);
    propose(head);
    close_to(outside);
    w_.close();
}

void RuleEmitter::linear(bool marks) {
    marks_ = marks;
    MELD_EXPECT(scope_.rule.linear && rule_plan_.branches.empty(), "view {} among linear rules", scope_.rule.name);
    comment(scope_.rule);
    w_.open(fmt::format("{} bool {}(Self& s) {{", plan_.in_pieces() ? "" : linkage(plan_, plan_.program.rules.count()),
                        rule_function(plan_, rule_plan_.rule)));
    const std::size_t outside = w_.depth();
    count(rule_plan_.rule, Part::Whole);
    if (rule_plan_.sweep.applies()) sweep();
    if (rule_plan_.search.applies()) {
        all_firings();
        return w_.close();
    }
    declare_indexes();
    if (scope_.rule.select != Select::None) choose();
    steps(rule_plan_.steps);
    if (scope_.rule.select == Select::Random)
        w_.open("if (chosen-- == 0) {");
    else if (scope_.rule.select != Select::None)
        w_.open(fmt::format("if ({}) {{",
                            equal(scope_.rule.variables[scope_.rule.selected].type, scope_.value(scope_.rule.selected), "chosen")));
    w_.raw("if (s.e->trap != Trap::None) return false;");
    about_to_fire();
    consume();
    freeze();
    heads(rule_plan_.heads);
    for (const PredicateId b : held_) w_.line("s.{}.release(*s.e);", predicate_name(plan_.program, b));
    w_.raw("return true;");
    const bool always = w_.depth() == outside;
    close_to(outside);
    if (!always) w_.raw("return false;");
    w_.close();
}

void RuleEmitter::about_to_fire() {
    if (plan_.counts) w_.line("++s.e->counters->rules[{}].firings;", rule_number(plan_, rule_plan_.rule));
    tell_firing();
}

// Out of the way: nobody but a debugger asks.
void RuleEmitter::tell_firing() {
    std::string variables, values;
    std::size_t count = 0;
    for (const VariableId v : scope_.rule.variables.ids()) {
        const auto& [name, span, type] = scope_.rule.variables[v];
        // Those of the compiler have names that nobody can write.
        const bool written = name.find_first_not_of(kLetters) == std::string::npos && !name.starts_with('_');
        if ((!scope_.values.contains(v) && !scope_.places.contains(v)) || !written) continue;
        variables += fmt::format("{}{{{}, {}}}", count == 0 ? "" : ", ", quoted(name), type_symbol(type));
        values += fmt::format("{}{{.{} = {}}}", count == 0 ? "" : ", ", value_member(type), scope_.value(v));
        ++count;
    }
    w_.open("if (s.e->tells_firings) [[unlikely]] {");
    if (count > 0) {
        w_.line("static constexpr BoundVariable kBound[] = {{{}}};", variables);
        w_.line("const Value bound[] = {{{}}};", values);
    }
    w_.line("tell_fired(*s.e, {}, {}, {});", rule_number(plan_, rule_plan_.rule), count, count > 0 ? "kBound, bound" : "nullptr, nullptr");
    w_.close();
}

void RuleEmitter::count_evaluation(RuleId rule) {
    if (plan_.counts) w_.line("++s.e->counters->rules[{}].evaluations;", rule_number(plan_, rule));
}
void RuleEmitter::count(RuleId rule, Part part) {
    if (plan_.counts) {
        if (part == Part::Whole) count_evaluation(rule);
        w_.line("const CountedRule counted(*s.e, {});", rule_number(plan_, rule));
    }
    if (plan_.places && part == Part::Branch) w_.line("note_place(*s.e, {});", rule_number(plan_, rule));
}

void RuleEmitter::choose() {
    MELD_EXPECT(scope_.rule.selected.valid() || scope_.rule.select == Select::Random, "rule {} chooses by nothing", scope_.rule.name);
    const Scope before = scope_;
    const bool random = scope_.rule.select == Select::Random;
    const Type type = scope_.rule.variables[scope_.rule.selected].type;
    w_.raw("u64 matches = 0;");
    if (!random) w_.line("{} chosen{{}};", cpp_type(type));
    // The same steps follow once more: their names belong only to this pass.
    w_.open("{");
    const std::size_t outside = w_.depth();
    steps(rule_plan_.steps);
    if (!random) {
        const std::string value = scope_.value(scope_.rule.selected);
        const char* sign = scope_.rule.select == Select::Ascending ? "<" : ">";
        const std::string better =
            type.compound() ? fmt::format("{} {} 0", compared(type, value, "chosen"), sign) : fmt::format("{} {} chosen", value, sign);
        w_.line("if (matches == 0 || {}) chosen = {};", better, value);
    }
    w_.raw("++matches;");
    close_to(outside);
    w_.close();
    w_.raw("if (matches == 0) return false;");
    if (random) w_.raw("u64 chosen = draw_below(*s.e, matches);");
    restore(before);
    consumed_.clear();
    kept_.clear();
}

void RuleEmitter::restore(const Scope& before) {
    scope_.values = before.values;
    scope_.places = before.places;
    scope_.ranks = before.ranks;
    scope_.kept = before.kept;
    scope_.last_fact = before.last_fact;
}

void RuleEmitter::comment(const check::Rule& rule) {
    w_.raw("");
    // A piece is to stay the same where lines before it come and go, and texts of rules that the compiler made name lines. All texts are
    // in the module's table of rules.
    if (plan_.in_pieces()) return;
    w_.line("// {}", rule.line ? fmt::format("Line {}", rule.line) : std::string("Made by the compiler"));
    std::string line;
    for (const char c : rule.text + "\n") {
        if (c != '\n') {
            line += c == '\\' ? '/' : c;  // A backslash at the end of a line would continue the comment on the next one.
            continue;
        }
        w_.line("//     {}", line);
        line.clear();
    }
}

void RuleEmitter::freeze() {
    std::vector<PredicateId> made, read;
    plan::each_head_plan(rule_plan_.heads, [&](const HeadPlan& h) {
        if (const MakeFact* fact = as<MakeFact>(h); fact != nullptr && fact->place == scope_.rule.site) made.push_back(fact->predicate);
        if (const std::vector<Step>* steps = plan::steps_of(h))
            plan::each_step(*steps, [&](const Step& step) {
                if (const Match* m = as<Match>(step); m != nullptr && m->at_site) read.push_back(m->predicate);
            });
    });
    std::sort(read.begin(), read.end());
    read.erase(std::unique(read.begin(), read.end()), read.end());
    for (const PredicateId p : read) {
        const std::string name = predicate_name(plan_.program, p);
        if (std::find(made.begin(), made.end(), p) == made.end()) continue;
        w_.line("load_{}(s);", name);
        if (plan_.program.predicates[p].linear()) {
            w_.line("s.{}.hold();", name);
            held_.push_back(p);
        } else {
            w_.line("const auto* const seen_{0} = s.{0}.rows;", name);
            w_.line("const u32 seen_{0}_count = s.{0}.count;", name);
            frozen_.push_back(p);
        }
    }
}

void RuleEmitter::close_to(std::size_t depth) {
    MELD_EXPECT(w_.depth() >= depth, "rule {}: a block of the caller is closed", scope_.rule.name);
    while (w_.depth() > depth) w_.close();
}

void RuleEmitter::steps(const std::vector<Step>& all) {
    for (const Step& s : all) plan::visit_step(s, [&](const auto& one) { step(one); });
}

void RuleEmitter::step(const plan::Test& s) {
    w_.open(fmt::format("if ({}) {{", defined(term(scope_, s.condition), plan::may_fail(plan_.program, s.condition))));
}

void RuleEmitter::step(const plan::Set& s) {
    const Type type = scope_.rule.variables[s.variable].type;
    const std::string value = term_as(scope_, s.value, type);
    bind(s.variable, type == Type::Float ? fmt::format("checked_real(*s.e, {}, {})", scope_.site(), value) : value);
    only_if_defined(plan::may_fail(plan_.program, s.value));
}

void RuleEmitter::bind(VariableId v, const std::string& value) {
    MELD_EXPECT(!scope_.values.contains(v), "rule {}: {} would be declared twice", scope_.rule.name, scope_.rule.variables[v].name);
    w_.line("const {} {} = {};", cpp_type(scope_.rule.variables[v].type), scope_.local(v), value);
    scope_.values.insert(v);
}

void RuleEmitter::step(const plan::EachNeighbour& s) {
    const bool named = s.place.valid();
    MELD_EXPECT(!named || !scope_.places.contains(s.place), "rule {}: {} is known", scope_.rule.name, scope_.rule.variables[s.place].name);
    MELD_EXPECT(!named || s.only.op == Op::Anonymous, "rule {}: a neighbour is named twice", scope_.rule.name);
    const std::string port = named ? scope_.port(s.place) : fresh("port");
    w_.open(fmt::format("for (i32 {0} = 0; {0} < ports_of(s); ++{0}) {{", port));
    w_.line("if (s.neighbour[{}] < 0) continue;", port);
    if (named) {
        scope_.places.insert(s.place);
        w_.line("[[maybe_unused]] const u32 {} = static_cast<u32>(s.neighbour[{}]);", scope_.at(s.place), port);
    } else if (s.only.op != Op::Anonymous) {
        w_.open(fmt::format("if ({}) {{",
                            defined(fmt::format("id_of(*s.g, static_cast<u32>(s.neighbour[{}])) == {}", port, term(scope_, s.only)),
                                    plan::may_fail(plan_.program, s.only))));
    }
    port_use(s.port, port);
}

void RuleEmitter::step(const plan::FindNeighbour& s) {
    const std::string port = scope_.port(s.place);
    if (!scope_.places.contains(s.place)) {
        w_.line("const i32 {} = port_of(s, {});", port, scope_.value(s.place));
        w_.open(fmt::format("if ({} >= 0) {{", port));
        scope_.places.insert(s.place);
        w_.line("[[maybe_unused]] const u32 {} = static_cast<u32>(s.neighbour[{}]);", scope_.at(s.place), port);
    }
    port_use(s.port, port);
}

void RuleEmitter::port_use(const plan::PortUse& use, const std::string& port) {
    const std::string number = fmt::format("i64{{{}}}", use.from_other_side ? fmt::format("port_there(*s.g, s.catom, {})", port) : port);
    if (use.bind.valid())
        bind(use.bind, number);
    else if (use.equals.op != Op::Anonymous)
        w_.open(fmt::format("if ({}) {{",
                            defined(fmt::format("{} == {}", number, term(scope_, use.equals)), plan::may_fail(plan_.program, use.equals))));
}

void emit_view_rule(const plan::Plan& plan, const RulePlan& rule, Writer& w) { RuleEmitter(plan, rule, w).view(); }
bool is_delta_offer(const plan::Plan& plan, const plan::StratumPlan& stratum, std::size_t number) {
    return keeps_best(plan, stratum) && stratum.deltas.affected[number].steps.size() == 2 &&
           is_offer(plan, stratum.deltas.whole[number], stratum.predicates[0]);
}
bool takes_gains(const plan::Plan& plan, const plan::StratumPlan& stratum) {
    // Counters are told of each group that is derived again.
    if (plan.counts || stratum.deltas.affected.empty()) return false;
    for (std::size_t i = 0; i < stratum.deltas.affected.size(); ++i)
        if (!is_delta_offer(plan, stratum, i)) return false;
    return true;
}
void emit_deltas(const plan::Plan& plan, const plan::StratumPlan& stratum, Writer& w) {
    for (std::size_t i = 0; i < stratum.semi_naive.size(); ++i) RuleEmitter(plan, stratum.semi_naive[i], w).semi_naive(i);
    for (std::size_t i = 0; i < stratum.deltas.affected.size(); ++i) {
        const RulePlan& whole = stratum.deltas.whole[i];
        const bool offers = is_delta_offer(plan, stratum, i);
        RuleEmitter(plan, stratum.deltas.affected[i], w).affected(i, offers ? &whole : nullptr);
        if (takes_gains(plan, stratum)) RuleEmitter(plan, whole, w).gains(i);
    }
    for (const RulePlan& r : stratum.deltas.regroup) RuleEmitter(plan, r, w).group();
}
void emit_linear_rule(const plan::Plan& plan, const RulePlan& rule, bool marks, Writer& w) { RuleEmitter(plan, rule, w).linear(marks); }

}  // namespace meld::emit
