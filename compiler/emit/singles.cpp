// Emits the linear rules a second time, for a catom that holds at most one fact of each predicate (compiler/plan/passes/singles.cpp): its
// facts are variables, `one`, that the compiler of C++ keeps in registers.
#include <algorithm>

#include "compiler/emit/marks.h"
#include "compiler/emit/rule_emitter.h"

namespace meld::emit {

namespace {

void emit_struct(const plan::Plan& plan, Writer& w) {
    w.raw("");
    w.raw("// The linear facts of a catom that holds at most one of each predicate, and the messages that it takes in one pass.");
    w.open("struct Singles {");
    for (const PredicateId p : plan.singles.facts) w.line("Single<{0}_t> {0};", predicate_name(plan.program, p));
    for (const PredicateId p : plan.singles.messages) w.line("Messages<{0}_t> {0};", predicate_name(plan.program, p));
    w.raw("bool full;  // A rule would make a second fact, or leave a message out that comes before one that it takes.");
    w.close("};");
}

void each_predicate(const plan::Plan& plan, const std::function<void(PredicateId, const std::string&)>& visit) {
    for (const auto* some : {&plan.singles.facts, &plan.singles.messages})
        for (const PredicateId p : *some) visit(p, predicate_name(plan.program, p));
}

void emit_evaluate_singles(const plan::Plan& plan, Writer& w) {
    w.raw("");
    w.raw("// The linear rules in order, as in evaluate_catom. Returns false if the catom holds more facts than that, before it does.");
    w.open(fmt::format("[[gnu::always_inline]] inline bool evaluate_singles(Self& s, u64 (&all_active)[{}]) {{", words_of_rules(plan)));
    // Of its own: a word whose address nobody else has is in a register.
    w.line("u64 active[{}];", words_of_rules(plan));
    for (std::size_t i = 0; i < words_of_rules(plan); ++i) w.line("active[{0}] = all_active[{0}];", i);
    w.raw("Eval& e = *s.e;");
    w.raw("Singles one;");
    w.raw("one.full = false;");
    each_predicate(plan, [&](PredicateId p, const std::string& name) {
        if (plan.pulls(p))
            w.line("one.{0}.open(s.{0}_heard.rows, s.{0}_heard.count, s.{0}_heard.come);", name);
        else
            w.line("if (!one.{}.open(rows_of(s, {}, s.catom))) return false;", name, plan.of(p).column.index());
    });
    w.open("for (;;) {");
    w.raw("bool fired = false;");
    w.open("do {");
    emit_tries(plan, true, "_single(s, one)", " || one.full", w);
    w.close("} while (false);");
    w.raw("if (!fired || e.trap != Trap::None) break;");
    w.open("if (++s.fired > e.subdomain->max_derivations) {");
    w.raw("trap(e, Trap::TooManyDerivations, e.rule, static_cast<i64>(e.subdomain->max_derivations));");
    w.raw("break;");
    w.close();
    w.close();
    w.raw("if (e.trap != Trap::None) return true;");
    w.open("if (one.full) [[unlikely]] {");
    for (std::size_t i = 0; i < words_of_rules(plan); ++i) w.line("all_active[{0}] = active[{0}];", i);
    each_predicate(plan, [&](PredicateId, const std::string& name) {
        w.open(fmt::format("if (one.{}.changed) {{", name));
        w.line("load_{}(s);", name);
        w.line("one.{0}.give_to(e, s.{0});", name);
        w.close();
    });
    w.raw("return false;");
    w.close();
    each_predicate(plan, [&](PredicateId p, const std::string& name) {
        w.line("one.{}.store<{}>(e, {});", name, has_lists(plan.of(p)), plan.of(p).column.index());
    });
    w.raw("return true;");
    w.close();
}

}  // namespace

void RuleEmitter::single() {
    single_ = true;
    w_.raw("");
    w_.open(fmt::format("[[gnu::always_inline]] inline bool {}_single(Self& s, Singles& one) {{", rule_function(plan_, rule_plan_.rule)));
    const std::size_t outside = w_.depth();
    if (rule_plan_.sweep.applies() && std::ranges::count(plan_.singles.messages, rule_plan_.sweep.messages) != 0) {
        sweep_single();
    } else {
        steps(rule_plan_.steps);
        w_.raw("if (s.e->trap != Trap::None) return false;");
        need_room();
        for (const Matched& c : consumed_) w_.line("one.{}.take();", predicate_name(plan_.program, c.predicate));
        heads(rule_plan_.heads);
        w_.raw("return true;");
        const bool always = w_.depth() == outside;
        close_to(outside);
        if (!always) w_.raw("return false;");
    }
    w_.close();
}

// What it makes and does not consume must not be there.
void RuleEmitter::need_room() {
    plan::each_head_plan(rule_plan_.heads, [&](const HeadPlan& h) {
        const MakeFact* fact = as<MakeFact>(h);
        if (fact == nullptr || fact->place != scope_.rule.site) return;
        if (plan_.program.predicates[fact->predicate].kind == PredicateKind::Action) return;
        if (std::ranges::any_of(consumed_, [&](const Matched& c) { return c.predicate == fact->predicate; })) return;
        w_.open(fmt::format("if (one.{}.holds) [[unlikely]] {{", predicate_name(plan_.program, fact->predicate)));
        w_.raw("one.full = true;");
        w_.raw("return false;");
        w_.close();
    });
}

void RuleEmitter::match_single(const Match& s) {
    const std::string name = predicate_name(plan_.program, s.predicate), f = fresh("f");
    w_.open(fmt::format("if (one.{}.holds) {{", name));
    w_.line("[[maybe_unused]] const {} {} = one.{}.row;", row_type(s.predicate), f, name);
    if (consumes(s)) consumed_.push_back({s.predicate, ""});
    use(s, [&](std::size_t k) { return fmt::format("{}.{}", f, field_name(k)); });
}

namespace {

// How often a variable occurs in a term.
std::size_t uses_of(VariableId v, const Term& term) {
    std::size_t uses = 0;
    check::each_variable(term, [&](VariableId each) { uses += each == v; });
    return uses;
}

// Whether a sum is never -0.0 if this variable is not, and whether that is all that the sign of a zero in it can change: rounding never
// makes a -0.0 of anything else.
bool keeps_sign(const Term& term, VariableId v) {
    if (term.is_variable()) return term.variable == v;
    if (term.type != Type::Float || (term.op != Op::Add && term.op != Op::Subtract)) return false;
    return keeps_sign(term.operands[0], v) || (term.op == Op::Add && keeps_sign(term.operands[1], v));
}

}  // namespace

// The arguments of the state to which a sweep only adds, or from which it only takes, and that the rule reads for nothing else. If they are
// not -0.0 before it, they never are, so that it can leave out the addition by which checked_real() makes 0.0 of -0.0, for which the next
// message would wait.
void RuleEmitter::find_sums() {
    const PredicateId state = rule_plan_.sweep.state;
    const MakeFact* next = nullptr;
    for (const HeadPlan& h : rule_plan_.heads)
        if (const auto* fact = plan::as<MakeFact>(h); fact != nullptr && fact->predicate == state) next = fact;
    if (next == nullptr || rule_plan_.heads.size() != 1) return;
    for (std::size_t i = 1; i <= next->arguments.size(); ++i) {
        VariableId v;
        std::size_t read = 0, made = 0;
        for (const Step& s : rule_plan_.steps)
            if (const Match* m = as<Match>(s); m != nullptr && m->predicate == state && m->uses[i - 1] == ArgumentUse::Bind)
                v = m->arguments[i - 1].variable;
        if (!v.valid() || !keeps_sign(next->arguments[i - 1], v)) continue;
        plan::each_step(rule_plan_.steps, [&](const Step& s) {
            plan::each_part(s, [&](const Term& t) { read += uses_of(v, t); }, [&](VariableId each) { read += each == v; });
        });
        for (const Term& t : next->arguments) made += uses_of(v, t);
        if (read == 1 && made == 1) sums_.push_back(i);
    }
}

// The messages that it takes are the first ones: mostly all, or those of the earlier of two rounds. Where one fits that comes after one
// that does not, the lists take over, and nothing is to be undone, since the rule makes its state alone.
void RuleEmitter::sweep_single() {
    const Scope before = scope_;
    const PredicateId state = rule_plan_.sweep.state, messages = rule_plan_.sweep.messages;
    const std::string state_name = predicate_name(plan_.program, state), messages_name = predicate_name(plan_.program, messages);
    w_.line("if (!one.{}.holds) return false;", state_name);
    w_.line("{} state = one.{}.row;", row_type(state), state_name);
    find_sums();
    for (const std::size_t i : sums_) w_.line("state.{} += 0.0;", field_name(i));
    w_.line("const auto* const messages = one.{}.rows;", messages_name);
    w_.line("const u32 count = one.{}.count;", messages_name);
    w_.raw("u32 taken = 0;");
    sweeping_ = true;
    w_.open("for (u32 k = 0; k < count; ++k) {");
    std::size_t each = w_.depth();
    steps(rule_plan_.steps);
    // The first trap counts, and numbers cannot lead to a limit, which would count more.
    if (has_lists(plan_.of(state)) || has_lists(plan_.of(messages))) w_.raw("if (s.e->trap != Trap::None) return false;");
    heads(rule_plan_.heads);
    w_.raw("++taken;");
    w_.raw("continue;");
    close_to(each);
    w_.raw("break;");
    w_.close();
    w_.raw("if (s.e->trap != Trap::None) return false;");
    restore(before);
    w_.open("for (u32 k = taken; k < count; ++k) {");
    each = w_.depth();
    steps(rule_plan_.steps);
    w_.raw("one.full = true;");
    w_.raw("return false;");
    close_to(each);
    w_.close();
    sweeping_ = false;
    w_.raw("if (taken == 0) return false;");
    w_.line("one.{}.become(state);", state_name);
    w_.line("one.{}.take(taken);", messages_name);
    w_.raw("s.e->derivations += taken;");
    w_.raw("s.fired += taken - 1;");
    w_.raw("return true;");
}

void emit_singles(const plan::Plan& plan, Writer& w) {
    if (!plan.singles.apply()) return;
    MELD_EXPECT(fixed_marks(plan) && !plan.counts, "singles of a program whose rules wake others in different ways");
    emit_struct(plan, w);
    for (const RulePlan& r : plan.linear_rules) RuleEmitter(plan, r, w).single();
    emit_evaluate_singles(plan, w);
}

}  // namespace meld::emit
