// The whole module, part by part.
#include "compiler/emit/emit.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <set>
#include <string_view>

#include "compiler/emit/marks.h"
#include "compiler/emit/writer.h"

namespace meld::emit {

namespace {

ModulePart::Kind kind_of(const std::string& part) {
    if (part == kTablesPart) return ModulePart::Kind::Tables;
    return part.starts_with(kKernelPart) ? ModulePart::Kind::Kernel : ModulePart::Kind::Rules;
}

// Declares the numbers of rules that the text uses, which the tables define: so a text stays the same when other rules come and go.
std::string rule_numbers_in(std::string_view text) {
    std::set<std::string_view> names;
    const auto is_letter = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
    for (std::size_t at = text.find(kRuleNumber); at != std::string_view::npos; at = text.find(kRuleNumber, at)) {
        const std::size_t begin = at;
        while (at < text.size() && is_letter(text[at])) ++at;
        if (begin == 0 || !is_letter(text[begin - 1])) names.insert(text.substr(begin, at - begin));
    }
    std::string declared;
    for (const std::string_view name : names) declared += fmt::format("extern const u32 {};\n", name);
    return declared.empty() ? "" : "namespace program {\n" + declared + "}\n";
}

std::vector<PartBegin> emit_all(const plan::Plan& plan, std::string& text) {
    MELD_EXPECT(plan.stored.size() == plan.program.predicates.count(), "a plan without a layout reached emission");
    Writer w(plan.in_pieces());
    // What pieces have in common does not depend on the name of the program.
    const std::string name = plan.in_pieces() ? "A long program" : clean(plan.program.name);
    w.line("// {}, compiled by meldc. Bytes a catom: {}.", name, plan::bytes_per_catom(plan));
    if (plan.counts) w.raw("#define MELD_COUNTS");
    if (plan.checked) w.raw("#define MELD_CHECKED");
    if (plan.program.by_links) w.raw("#define MELD_BY_LINKS");
    w.line("#include \"runtime/module/kernel/{}.h\"", has_deltas(plan) ? "deltas" : "views");
    if (plan.singles.apply()) w.raw("#include \"runtime/module/kernel/singles.h\"");
    if (!plan.pulled.empty() && !plan.in_pieces()) w.raw("#include \"runtime/module/kernel/broadcasts.h\"");
    if (has_lookups(plan)) w.raw("#include \"runtime/module/kernel/index.h\"");
    if (std::ranges::any_of(plan.strata, [](const plan::StratumPlan& s) { return !s.semi_naive.empty(); }))
        w.raw("#include \"runtime/module/kernel/rounds.h\"");
    if (keeps_fronts(plan)) w.raw("#include \"runtime/module/kernel/fronts.h\"");
    if (plan.counts) w.raw("#include \"runtime/module/kernel/counts.h\"");
    if (plan.places) w.raw("#include \"runtime/module/abi/counts_abi.h\"");
    w.raw("");
    w.raw("using namespace meld;");
    w.part("");
    emit_externs(plan, w);
    if (!plan.in_pieces()) w.raw("namespace {");
    emit_types(plan, w);
    emit_records(plan, w);
    const std::map<PredicateId, std::string> row_types = emit_predicates(plan, w);
    emit_searches(plan, w);
    emit_self(plan, w);
    if (plan.in_pieces()) emit_kernels(plan, row_types, w);
    w.part("");
    emit_load_and_save(plan, w);
    emit_functions(plan, w);
    emit_facts(plan, w);
    for (const plan::StratumPlan& s : plan.strata) {
        w.part(part_of(plan, s.predicates[0]));
        for (const RulePlan& r : s.rules) emit_view_rule(plan, r, w);
    }
    for (const plan::StratumPlan& s : plan.strata) {
        w.part(part_of(plan, s.predicates[0]));
        emit_deltas(plan, s, w);
    }
    const bool marks = !fixed_marks(plan);
    for (const auto* rules : {&plan.initial_facts, &plan.linear_rules})
        for (const RulePlan& r : *rules) {
            w.part(rule_function(plan, r.rule));
            emit_linear_rule(plan, r, marks || rules == &plan.initial_facts, w);
        }
    w.part(kMainPart);
    emit_singles(plan, w);
    emit_strata(plan, w);
    w.part("concerned");
    emit_concerned(plan, w);
    w.part(kMainPart);
    emit_stops(plan, w);
    emit_evaluate(plan, w);
    emit_schema(plan, w);
    const std::string entry = "extern \"C\" __attribute__((visibility(\"default\"))) const void* claymeld_module() { return &kModule; }";
    if (plan.in_pieces()) {
        w.raw(entry);
        w.end_parts();
    } else {
        w.raw("");
        w.raw("}  // namespace");
        w.raw("");
        w.raw(entry);
    }
    text = w.text();
    return w.parts();
}

}  // namespace

std::size_t functions_of_rules(const plan::Plan& plan) {
    std::size_t count = plan.linear_rules.size() + plan.initial_facts.size();
    for (const plan::StratumPlan& s : plan.strata)
        count += s.rules.size() + s.semi_naive.size() + s.deltas.affected.size() + s.deltas.regroup.size();
    return count;
}

// A name says which of the rules of its head a rule is. The number of a rule, or its line, would change with every rule before it, not
// only with those of its head.
void name_for_pieces(plan::Plan& plan) {
    std::map<std::string, std::size_t> met;
    plan.stable_names.clear();
    for (const check::Rule& rule : plan.program.rules) {
        const std::string head = clean(rule.name.substr(0, rule.name.find('@')));
        plan.stable_names.push_back(fmt::format("rule_{}_n{}", head, met[head]++));
    }
}

std::string emit_module(const plan::Plan& plan) {
    std::string text;
    if (!plan.in_pieces()) {
        emit_all(plan, text);
        return text;
    }
    const ModuleParts all = emit_parts(plan);
    text = all.shared;
    for (const ModulePart& part : all.parts) text += part.text;
    return text;
}

ModuleParts emit_parts(const plan::Plan& plan) {
    MELD_EXPECT(plan.in_pieces(), "parts of a module in one piece");
    ModuleParts out;
    std::string text;
    const std::vector<PartBegin> begins = emit_all(plan, text);
    const std::string includes = text.substr(0, begins[0].at);
    std::map<std::string, std::size_t> known;
    for (std::size_t i = 0; i < begins.size(); ++i) {
        const std::size_t end = i + 1 < begins.size() ? begins[i + 1].at : text.size();
        const std::string_view chunk = std::string_view(text).substr(begins[i].at, end - begins[i].at);
        if (begins[i].name.empty()) {
            out.shared += chunk;
            continue;
        }
        const auto [at, fresh] = known.try_emplace(begins[i].name, out.parts.size());
        if (fresh) out.parts.push_back({begins[i].name, "", kind_of(begins[i].name)});
        out.parts[at->second].text += chunk;
    }
    out.shared = includes + rule_numbers_in(out.shared) + out.shared;
    for (ModulePart& part : out.parts)
        if (part.kind != ModulePart::Kind::Tables) part.text = rule_numbers_in(part.text) + part.text;
    return out;
}

}  // namespace meld::emit
