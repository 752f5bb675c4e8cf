#include "runtime/results/facts/fact_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <string_view>

#include "runtime/engine/tuple/value_text.h"

namespace meld::record {

namespace {

CellType cell_type(ValueType type) {
    switch (type) {
        case ValueType::Int:
            return CellType::Int;
        case ValueType::Float:
            return CellType::Float;
        case ValueType::Bool:
            return CellType::Bool;
        case ValueType::Node:
            return CellType::Node;
        default:
            return CellType::Text;
    }
}

std::vector<TableColumn> columns_of(const PredicateInfo& p) {
    std::vector<TableColumn> columns;
    for (u16 i = 0; i < p.arity; ++i) {
        const std::string name = argument_name(p, i);
        if (p.fields[i].type != ValueType::Vec3) {
            columns.push_back({name, cell_type(p.fields[i].type), i, 0});
            continue;
        }
        for (const u16 item : {u16{0}, u16{1}, u16{2}})
            columns.push_back({fmt::format("{}.{}", name, "xyz"[item]), CellType::Float, i, item});
    }
    return columns;
}

// Names that tables have for themselves; "arg1" and so on are those of arguments without a name.
bool reserved(std::string_view name) {
    if (name == kCatomColumn || name == kFactsColumn || name == "tick") return true;
    return name.starts_with("arg") && name.find_first_not_of("0123456789", 3) == std::string_view::npos;
}

}  // namespace

bool shown(const PredicateInfo& p) { return !p.auxiliary && p.column != kNone16 && p.kind != PredicateKind::Action; }

std::string argument_name(const PredicateInfo& p, u16 argument) {
    const std::string_view name = p.fields[argument].name;
    int namesakes = 0;
    for (u16 i = 0; i < p.arity; ++i) namesakes += p.fields[i].name == name;
    return name.empty() || namesakes > 1 || reserved(name) ? fmt::format("arg{}", argument + 1) : std::string(name);
}

std::string column_type(const ModuleInfo& module, const FactTable& table, const TableColumn& column) {
    const tuple::Type type = tuple::type_of(module, module.predicates[table.predicate].fields[column.argument]);
    return tuple::type_name(type.kind() == ValueType::Vec3 ? type.item(column.item) : type);
}

std::vector<FactTable> fact_tables(const ModuleInfo& module) {
    std::vector<u32> order;
    for (u32 i = 0; i < module.predicate_count; ++i)
        if (shown(module.predicates[i])) order.push_back(i);
    std::sort(order.begin(), order.end(), [&](u32 a, u32 b) {
        const PredicateInfo &x = module.predicates[a], &y = module.predicates[b];
        const int names = std::strcmp(x.name, y.name);
        return names != 0 ? names < 0 : x.arity < y.arity;
    });
    const auto has_name = [&](std::size_t i, const char* name) {
        return i < order.size() && std::strcmp(module.predicates[order[i]].name, name) == 0;
    };
    std::vector<FactTable> tables;
    for (std::size_t i = 0; i < order.size(); ++i) {
        const PredicateInfo& p = module.predicates[order[i]];
        const bool alone = !has_name(i + 1, p.name) && !(i > 0 && has_name(i - 1, p.name));
        tables.push_back({alone ? std::string(p.name) : fmt::format("{}.{}", p.name, p.arity + 1), order[i], columns_of(p)});
    }
    return tables;
}

}  // namespace meld::record
