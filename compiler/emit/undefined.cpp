// Emits the checks of linear rules and actions, which cannot be undone and so must not read facts while a derivation of them has no value.
#include <algorithm>
#include <map>
#include <set>

#include "compiler/emit/writer.h"

namespace meld::emit {

using namespace check;
using plan::as;
using plan::HeadPlan;
using plan::Match;
using plan::Step;
using plan::StratumPlan;

namespace {

// Calls visit(predicate) for every match at the execution site, including those inside negations and aggregates.
template <class Visit>
void each_read(const std::vector<Step>& steps, const Visit& visit) {
    plan::each_step(steps, [&](const Step& s) {
        if (const Match* m = as<Match>(s); m != nullptr && m->at_site) visit(m->predicate);
    });
}
template <class Visit>
void each_read(const std::vector<HeadPlan>& heads, const Visit& visit) {
    plan::each_head_plan(heads, [&](const HeadPlan& h) {
        if (const std::vector<Step>* steps = plan::steps_of(h)) each_read(*steps, visit);
    });
}
// Calls visit(predicate) for the predicates that a view rule derives.
template <class Visit>
void each_head(const RulePlan& rule, const Visit& visit) {
    for (const HeadPlan& h : rule.heads)
        if (const auto* fact = as<plan::MakeFact>(h)) visit(fact->predicate);
    for (const RulePlan& b : rule.branches) each_head(b, visit);
}

// Which predicates a catom derives from which in one tick, and which rules may fail.
class Readers {
  public:
    explicit Readers(const plan::Plan& plan) {
        for (const StratumPlan& s : plan.strata) {
            // A fold names the first rule of its predicate.
            const bool folds = std::any_of(s.predicates.begin(), s.predicates.end(),
                                           [&](PredicateId p) { return plan::fold_may_fail(plan.program.predicates[p]); });
            for (const RulePlan& r : s.rules) {
                each_head(r, [&](PredicateId head) { add(r, head, folds || plan::may_fail(plan.program, r)); });
            }
        }
    }
    // The rules that may fail and derive one of these predicates, or a predicate from which one of them is derived at the same catom.
    std::set<std::size_t> failing(std::vector<PredicateId> read) const {
        std::set<PredicateId> seen(read.begin(), read.end());
        std::set<std::size_t> rules;
        while (!read.empty()) {
            const PredicateId p = read.back();
            read.pop_back();
            if (const auto found = failing_.find(p); found != failing_.end()) rules.insert(found->second.begin(), found->second.end());
            if (const auto found = reads_.find(p); found != reads_.end())
                for (const PredicateId from : found->second)
                    if (seen.insert(from).second) read.push_back(from);
        }
        return rules;
    }

  private:
    void add(const RulePlan& rule, PredicateId head, bool fails) {
        const auto note = [&](PredicateId p) { reads_[head].push_back(p); };
        each_read(rule.steps, note);
        for (const RulePlan& b : rule.branches) each_read(b.steps, note);
        if (!fails) return;
        failing_[head].push_back(rule.rule.index());
        for (const RulePlan& b : rule.branches) failing_[head].push_back(b.rule.index());
    }

    std::map<PredicateId, std::vector<PredicateId>> reads_;    // By head.
    std::map<PredicateId, std::vector<std::size_t>> failing_;  // The same.
};

// `failed` is one of these rules.
std::string is_one_of(const plan::Plan& plan, const std::set<std::size_t>& rules) {
    std::string text;
    for (const std::size_t rule : rules)
        text += fmt::format("{}failed == {}", text.empty() ? "" : " || ", rule_number(plan, plan::RuleId(rule)));
    return text;
}

// The linear facts that the rule consumes or reads are there.
std::string may_fire(const plan::Plan& plan, const RulePlan& rule) {
    std::string there;
    for (const Step& step : rule.steps)
        if (const Match* m = as<Match>(step); m != nullptr && plan.program.predicates[m->predicate].linear())
            there += fmt::format(" && (load_{0}(s), s.{0}.list.count > 0)", predicate_name(plan.program, m->predicate));
    return there;
}

}  // namespace

void emit_stops(const plan::Plan& plan, Writer& w) {
    if (!plan::may_fail(plan)) return;
    const Readers readers(plan);
    w.raw("");
    w.raw("// A derivation that has no value is an error where `reads` says that what cannot be undone is about to read it.");
    w.raw("template <class Reads>");
    w.open("[[gnu::noinline, gnu::cold]] static void stop_where(Eval& e, const Reads& reads) {");
    w.open("for (u32 i = 0; e.trap == Trap::None && e.host->undefined_rule(&e, i) != kNone32; ++i) {");
    w.raw("if (reads(e.host->undefined_rule(&e, i))) e.host->stop_undefined(&e, i);");
    w.close();
    w.close();
    w.raw("");
    w.raw("// Whether a linear rule whose linear facts are there reads what a derivation of the rule that has failed belongs to.");
    w.open("[[maybe_unused]] static bool would_read([[maybe_unused]] Self& s, [[maybe_unused]] u32 failed) {");
    for (const RulePlan& rule : plan.linear_rules) {
        std::vector<PredicateId> read;
        each_read(rule.steps, [&](PredicateId p) { read.push_back(p); });
        each_read(rule.heads, [&](PredicateId p) { read.push_back(p); });
        const std::set<std::size_t> failing = readers.failing(read);
        if (!failing.empty()) w.line("if (({}){}) return true;", is_one_of(plan, failing), may_fire(plan, rule));
    }
    w.raw("return false;");
    w.close();
    std::vector<PredicateId> actions;
    for (const PredicateId id : plan.program.predicates.ids())
        if (plan.program.predicates[id].kind == PredicateKind::Action && has_view(plan, id)) actions.push_back(id);
    const std::set<std::size_t> failing = readers.failing(actions);
    w.raw("");
    w.raw("// Whether an action is derived from it.");
    w.line("static bool would_act([[maybe_unused]] u32 failed) {{ return {}; }}", failing.empty() ? "false" : is_one_of(plan, failing));
}

}  // namespace meld::emit
