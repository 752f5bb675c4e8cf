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
    std::string name = clean(program.predicates[id].name);
    if (name.empty() || !std::islower(static_cast<unsigned char>(name[0]))) name = "p" + name;
    return fmt::format("{}_{}", name, id.index());
}

std::string record_name(plan::ColumnId id) { return fmt::format("record_{}", id.index()); }

std::string rule_function(const Program& program, plan::RuleId id) {
    const Rule& rule = program.rules[id];
    const std::string head = rule.name.substr(0, rule.name.find('@'));
    return fmt::format("{}_at_line_{}_r{}", "rule_" + clean(head), rule.line, id.index());
}

const char* linkage(std::size_t functions) {
    constexpr std::size_t kMany = 100;
    return functions > kMany ? "[[gnu::noinline]] static" : "static";
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

std::string Scope::site() const { return caller.empty() ? std::to_string(rule_index) : caller; }

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
