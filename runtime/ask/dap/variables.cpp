#include "runtime/ask/dap/variables.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

namespace meld::dap {

namespace {

// A value of a table; catoms are their numbers there.
std::string cell_text(const Json& column, const Json& cell) {
    if (column.at("type") == "node" && cell.is_number()) return "@" + cell.dump();
    return cell.dump();
}

std::string row_text(const Json& columns, const Json& row) {
    std::string out;
    for (std::size_t i = 0; i < columns.size(); ++i)
        out += fmt::format("{}{} = {}", i == 0 ? "" : ", ", columns[i].at("name").get<std::string>(), cell_text(columns[i], row.at(i)));
    return out;
}

Variables cells_of(const Json& columns, const Json& row) {
    Variables out;
    for (std::size_t i = 0; i < columns.size(); ++i)
        out.push_back({.name = columns[i].at("name").get<std::string>(),
                       .value = cell_text(columns[i], row.at(i)),
                       .type = columns[i].at("type").get<std::string>()});
    return out;
}

std::string without_stop(std::string fact) {
    if (fact.ends_with('.')) fact.pop_back();
    return fact;
}

Variable fact_variable(std::string name, const std::string& fact) {
    const std::string bare = without_stop(fact);
    return {.name = std::move(name), .value = bare, .expression = bare};
}

// Already made: they are only handed out.
VariableTable::Make given(Variables variables) {
    return [variables = std::move(variables)] { return variables; };
}

void left_out(const Json& answer, std::size_t shown, Variables& out) {
    const auto count = answer.at("count").get<std::uint64_t>();
    if (count > shown) out.push_back({.name = "...", .value = fmt::format("and {} more", count - shown)});
}

}  // namespace

Result<Variables> VariableTable::list(std::int64_t reference) const {
    if (reference < first_ || std::cmp_greater_equal(reference - first_, makers_.size()))
        return fail(fmt::format("there is no variable {} in this tick", reference));
    // What is made may add to the table.
    const Make make = makers_[static_cast<std::size_t>(reference - first_)];
    return make();
}

std::string predicate_of(const std::string& fact) { return fact.substr(0, fact.find('(')); }

Variables rows_of(const Json& answer, VariableTable& table) {
    const Json &columns = answer.at("columns"), &rows = answer.at("rows");
    Variables out;
    // One row is its values.
    if (rows.size() == 1) return cells_of(columns, rows[0]);
    for (std::size_t i = 0; i < rows.size(); ++i)
        out.push_back(
            {.name = std::to_string(i), .value = row_text(columns, rows[i]), .reference = table.add(given(cells_of(columns, rows[i])))});
    left_out(answer, rows.size(), out);
    return out;
}

std::string summary_of(const Json& answer) {
    const Json &columns = answer.at("columns"), &rows = answer.at("rows");
    const auto count = answer.at("count").get<std::uint64_t>();
    if (columns.empty()) return count > 0 ? "yes" : "no";
    if (count == 1 && columns.size() == 1) return cell_text(columns[0], rows.at(0).at(0));
    if (count == 1) return row_text(columns, rows.at(0));
    return count == 0 ? "none" : fmt::format("{} rows", count);
}

Variables facts_by_predicate(const Json& answer, VariableTable& table) {
    std::map<std::string, Variables> by_name;
    const Json& facts = answer.at("facts");
    for (const Json& each : facts) {
        const auto fact = each.get<std::string>();
        Variables& of = by_name[predicate_of(fact)];
        of.push_back(fact_variable(std::to_string(of.size()), fact));
    }
    Variables out;
    for (auto& [name, of] : by_name) {
        const std::size_t count = of.size();
        if (count == 1) {
            Variable one = of.front();
            one.name = name;
            out.push_back(std::move(one));
        } else {
            out.push_back(
                {.name = name, .value = fmt::format("{} facts", count), .reference = table.add(given(std::move(of))), .count = count});
        }
    }
    left_out(answer, facts.size(), out);
    return out;
}

Variables catom_variables(const Json& catom, VariableTable& table) {
    Variables out, links, actions, coming;
    const bool on_lattice = !catom.at("cell").is_null();
    out.push_back({.name = on_lattice ? "[cell]" : "[position]", .value = catom.at(on_lattice ? "cell" : "position").dump()});
    std::string touches;
    for (const Json& link : catom.at("links")) {
        const std::string other = "@" + link.at("catom").dump();
        links.push_back({.name = "port " + link.at("port").dump(), .value = other, .expression = other});
        touches += (touches.empty() ? "" : ", ") + other;
    }
    for (const Json& action : catom.at("actions"))
        actions.push_back({.name = std::to_string(actions.size()), .value = action.get<std::string>()});
    for (const Json& fact : catom.at("coming"))
        coming.push_back({.name = "tick " + fact.at("tick").dump(), .value = fact.at("fact").get<std::string>()});
    out.push_back({.name = "[touches]", .value = touches.empty() ? "nothing" : touches});
    if (!links.empty()) out.back().reference = table.add(given(std::move(links)));
    for (auto& [name, of] : {std::pair{"[asks for]", &actions}, std::pair{"[comes]", &coming}})
        if (!of->empty()) out.push_back({.name = name, .value = std::to_string(of->size()), .reference = table.add(given(std::move(*of)))});
    return out;
}

Json to_json(const Variable& variable) {
    Json out = {{"name", variable.name}, {"value", variable.value}, {"variablesReference", variable.reference}};
    if (!variable.type.empty()) out["type"] = variable.type;
    if (!variable.expression.empty()) out["evaluateName"] = variable.expression;
    if (variable.count > 0) out["indexedVariables"] = variable.count;
    if (!variable.changeable) out["presentationHint"] = {{"attributes", Json::array({"readOnly"})}};
    return out;
}

Json to_json(const Variables& variables, std::uint64_t start, std::uint64_t count) {
    Json out = Json::array();
    for (std::uint64_t i = start; i < variables.size() && (count == 0 || i - start < count); ++i) out.push_back(to_json(variables[i]));
    return out;
}

}  // namespace meld::dap
