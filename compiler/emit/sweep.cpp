// Emits the pass of a linear rule over all messages of a catom (compiler/plan/passes/sweep.cpp), ahead of the code that fires it once.
#include "compiler/emit/rule_emitter.h"

namespace meld::emit {

void RuleEmitter::sweep() {
    const Scope before = scope_;
    const std::string state = predicate_name(plan_.program, rule_plan_.sweep.state);
    const std::string messages = predicate_name(plan_.program, rule_plan_.sweep.messages);
    w_.raw("// All messages in one pass, if there is one state.");
    w_.line("load_{}(s);", state);
    w_.line("load_{}(s);", messages);
    w_.line("if (s.{}.list.count == 0) return false;", messages);
    w_.open(fmt::format("if (s.{}.list.count == 1 && s.{}.list.count > 1) {{", state, messages));
    w_.line("s.{}.arrange(*s.e);", messages);
    w_.line("{} state = s.{}.list.rows[0];", row_type(rule_plan_.sweep.state), state);
    w_.line("const auto* const messages = s.{}.list.rows;", messages);
    w_.line("const u32 count = s.{}.list.count;", messages);
    w_.raw("u32 taken = 0;");
    w_.open("for (u32 k = 0; k < count; ++k) {");
    const std::size_t each = w_.depth();
    w_.raw("const u32 taken_before = taken;");
    sweeping_ = true;
    steps(rule_plan_.steps);
    w_.raw("if (s.e->trap != Trap::None) return false;");
    w_.raw("++taken;");
    about_to_fire();
    if (plan_.counts)
        for (const PredicateId p : {rule_plan_.sweep.messages, rule_plan_.sweep.state}) w_.line("count_consumed(*s.e, {}, 1);", p.index());
    heads(rule_plan_.heads);
    sweeping_ = false;
    close_to(each);
    w_.open("if (taken == taken_before) {");
    w_.line("s.{}.own(*s.e);", messages);
    w_.line("s.{}.list.rows[k - taken] = messages[k];", messages);
    w_.close();
    w_.close();
    w_.open("if (taken > 0) {");
    w_.line("s.{}.become(*s.e, state);", state);
    w_.line("s.{}.list.count = count - taken;", messages);
    w_.line("if (s.{0}.stored) s.{0}.list.capacity = 0;", messages);
    w_.line("s.{}.changed = true;", messages);
    w_.raw("s.e->derivations += taken;");
    lower(rule_plan_.sweep.messages);
    lower(rule_plan_.sweep.state);
    raise(rule_plan_.sweep.state);
    w_.raw("s.fired += taken - 1;");
    if (plan_.counts) w_.line("s.e->counters->rules[{}].evaluations += taken - 1;", rule_number(plan_, rule_plan_.rule));
    w_.raw("return true;");
    w_.close();
    w_.close();
    restore(before);
}

// In a sweep the state is one fact, which changes in place, and the messages are visited in turn.
void RuleEmitter::match_in_sweep(const Match& s) {
    const std::string f = fresh("f");
    w_.line("[[maybe_unused]] const {} {} = {};", row_type(s.predicate), f,
            s.predicate == rule_plan_.sweep.state ? "state" : "messages[k]");
    use(s, [&](std::size_t i) { return fmt::format("{}.{}", f, field_name(i)); });
}

void RuleEmitter::next_state(const MakeFact& h) {
    make_row(h);
    w_.raw("state = row;");
    if (plan_.counts) w_.line("count_gained(*s.e, {});", h.predicate.index());
}

}  // namespace meld::emit
