#include "compiler/emit/writer.h"

#include <algorithm>
#include <cctype>

namespace meld::emit {

using namespace check;

std::string clean(const std::string& name) {
    std::string out;
    for (const char c : name) out += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
    return out;
}

std::string predicate_name(const Program& program, PredicateId id) {
    std::string name = clean(name_without_line(program.predicates[id]));
    if (name.empty() || !std::islower(static_cast<unsigned char>(name[0]))) name = "p" + name;
    return fmt::format("{}_{}", name, id.index());
}

std::string name_without_line(const Predicate& predicate) { return predicate.name.substr(0, predicate.name.find('@')); }

std::string record_name(plan::ColumnId id) { return fmt::format("record_{}", id.index()); }

std::string rule_function(const plan::Plan& plan, plan::RuleId id) {
    if (plan.in_pieces()) return plan.stable_names[id.index()];
    const Rule& rule = plan.program.rules[id];
    const std::string head = rule.name.substr(0, rule.name.find('@'));
    return fmt::format("{}_at_line_{}_r{}", "rule_" + clean(head), rule.line, id.index());
}

std::string rule_number(const plan::Plan& plan, plan::RuleId id) {
    return plan.in_pieces() ? kRuleNumber + plan.stable_names[id.index()] : std::to_string(id.index());
}

const char* linkage(const plan::Plan& plan, std::size_t functions) {
    constexpr std::size_t kMany = 100;
    return functions > kMany || plan.in_pieces() ? "[[gnu::noinline]] static" : "static";
}

const char* shared(const plan::Plan& plan) { return plan.in_pieces() ? "" : "static "; }
const char* shared_table(const plan::Plan& plan) { return plan.in_pieces() ? "extern const" : "static constexpr"; }

std::string part_of(const plan::Plan& plan, PredicateId id) {
    PredicateId first = id;
    for (const plan::StratumPlan& s : plan.strata)
        if (std::ranges::find(s.predicates, id) != s.predicates.end()) first = s.predicates[0];
    const Predicate& p = plan.program.predicates[first];
    return fmt::format("{}/{}", name_without_line(p), p.arguments.size());
}

void Writer::close_namespace() {
    if (in_namespace_) raw("}");
    in_namespace_ = false;
}

void Writer::part(const std::string& name, Where where) {
    if (!in_pieces_) return;
    close_namespace();
    parts_.push_back({out_.size(), name});
    if (where == Where::Kernel) return;
    raw("namespace program {");
    in_namespace_ = true;
}

std::string cpp_type(const Type& type) {
    switch (type.kind) {
        case Type::Kind::Int:
            return "i64";
        case Type::Kind::Float:
            return "double";
        case Type::Kind::Bool:
            return "bool";
        case Type::Kind::Node:
            return "u64";
        case Type::Kind::Error:
            break;
        default:
            return "ListRef";
    }
    MELD_CHECK(false, "a value of type {} reached emission", type_name(type));
}

std::string aggregate_object(Aggregate aggregate, const Type& value, const Type& result, const std::string& limit,
                             const std::string& name) {
    const AggregateInfo& about = info(aggregate);
    const bool sums = about.values == AggregateInfo::Values::Summable, appends = about.values == AggregateInfo::Values::Lists;
    const std::string type = value == Type::Error               ? "i64"
                             : value == Type::Vec3 && sums      ? "Vector"
                             : value == Type::String && appends ? "Text"
                                                                : cpp_type(value);
    std::string arguments;
    if (about.has(AggregateInfo::kTyped))
        arguments = "kTypes, " + type_symbol(result.parts[0]);
    else if (about.values == AggregateInfo::Values::Ordered && value.compound())
        arguments = "kTypes, " + type_symbol(value);
    if (!limit.empty()) arguments += ", " + limit;
    return fmt::format("{}Of<{}> {}{{{}}}", about.kind, type, name, arguments);
}

std::string field_name(std::size_t argument) {
    MELD_EXPECT(argument > 0, "the catom is no field");
    return fmt::format("a{}", argument);
}

std::string hex(std::uint64_t bits) { return fmt::format("{:#x}ull", bits); }

std::string quoted(const std::string& text) {
    std::string out = "\"";
    for (const char c : text) {
        const unsigned char u = static_cast<unsigned char>(c);
        if (c == '"' || c == '\\')
            out += std::string("\\") + c;
        else if (c == '\n')
            out += "\\n";
        else if (u < 32 || u > 126 || c == '?')
            out += fmt::format("\\{:03o}", u);
        else
            out += c;
    }
    return out + "\"";
}

std::string Scope::local(plan::VariableId v) const { return fmt::format("{}_{}", clean(rule.variables[v].name), v.index()); }

std::string Scope::site() const { return caller.empty() ? rule_number(plan, plan::RuleId(rule_index)) : caller; }

std::string Scope::at(plan::VariableId v) const {
    MELD_EXPECT(v == rule.site || places.contains(v), "rule {}: {} is no place that is known", rule.name, rule.variables[v].name);
    return v == rule.site ? "s.catom" : local(v) + "_at";
}

std::string Scope::port(plan::VariableId v) const {
    MELD_EXPECT(v != rule.site, "rule {}: no port leads to the execution site", rule.name);
    return local(v) + "_port";
}

std::string Scope::value(plan::VariableId v) const {
    if (values.contains(v)) return local(v);
    MELD_CHECK(v == rule.site || places.contains(v), "rule {}: {} has no value", rule.name, rule.variables[v].name);
    return fmt::format("id_of(*s.g, {})", at(v));
}

bool has_deltas(const plan::Plan& plan) {
    return std::any_of(plan.strata.begin(), plan.strata.end(),
                       [](const plan::StratumPlan& s) { return !s.deltas.affected.empty() || !s.semi_naive.empty(); });
}

bool keeps_fronts(const plan::Plan& plan) {
    return std::any_of(plan.program.predicates.begin(), plan.program.predicates.end(),
                       [](const Predicate& p) { return p.front != Aggregate::None; });
}

bool combines_at_catom(const Predicate& p) { return p.aggregate == Aggregate::Custom || info(p.aggregate).has(AggregateInfo::kParameter); }

bool has_view(const plan::Plan& plan, PredicateId id) {
    const Storage s = plan.of(id).storage;
    return s != Storage::Unused && s != Storage::World;
}

bool has_lists(const plan::Stored& stored) {
    return std::ranges::any_of(stored.fields, [](const plan::Field& f) { return f.type.compound(); });
}

}  // namespace meld::emit
