#include "runtime/driver/study/study_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <string_view>

#include "runtime/base/csv_row.h"
#include "runtime/base/terminal/terminal_text.h"
#include "runtime/driver/study/quantiles.h"

namespace meld::driver {

std::optional<std::size_t> StudyTable::column(std::string_view name) const {
    const auto found = std::ranges::find(columns, name);
    return found == columns.end() ? std::nullopt : std::optional(static_cast<std::size_t>(found - columns.begin()));
}

StudyCell cell_of(const std::string& text) {
    if (text.empty()) return {};
    const char* const end = text.data() + text.size();
    std::int64_t whole = 0;
    if (const auto read = std::from_chars(text.data(), end, whole); read.ec == std::errc{} && read.ptr == end) return whole;
    double number = 0;
    if (const auto read = std::from_chars(text.data(), end, number); read.ec == std::errc{} && read.ptr == end && std::isfinite(number))
        return number;
    return text;
}

std::string text_of(const StudyCell& cell) {
    if (const auto* whole = std::get_if<std::int64_t>(&cell)) return std::to_string(*whole);
    if (const auto* number = std::get_if<double>(&cell)) return fmt::format("{}", *number);
    if (const auto* text = std::get_if<std::string>(&cell)) return *text;
    return "";
}

namespace {

StudyCell cell_of(const nlohmann::ordered_json& value) {
    if (value.is_null() || value.is_object()) return {};
    if (value.is_boolean()) return std::int64_t{value.get<bool>()};
    if (value.is_number_integer()) return value.get<std::int64_t>();
    if (value.is_number()) return value.get<double>();
    if (value.is_string()) return value.get<std::string>();
    return value.dump();
}

StudyCell value_in(const nlohmann::ordered_json& values, const std::string& key) {
    const auto found = values.find(key);
    return found == values.end() ? StudyCell{} : cell_of(*found);
}

}  // namespace

std::string failure_of(const RowResult& result, const Study& study) {
    if (!result.fine) return result.reason.empty() ? fmt::format("it ended with the exit code {}", result.exit) : result.reason;
    for (const StudyDemand& demand : study.demands)
        if (const std::string found = result.demands.value(demand_key(demand), ""); !found.empty())
            return fmt::format("{} {}: {}", demand.never ? "never" : "expect", demand.name, found);
    for (const StudyMeasure& measure : study.measures)
        for (const std::int64_t tick : measure.ticks.empty() ? std::vector<std::int64_t>{0} : measure.ticks)
            if (const auto found = result.measures.find(measure_key(measure, tick)); found != result.measures.end() && found->is_object())
                return fmt::format("measure {}: {}", measure.name, found->value("error", ""));
    return "";
}

StudyTable table_of(const StudyPlan& plan, const RowStore& store) {
    const Study& study = plan.study();
    StudyTable table;
    table.columns = {"row", "program", "world"};
    for (const StudyAxis& axis : study.axes) table.columns.push_back(axis.name);
    table.columns.emplace_back("seed");
    table.first_measure = table.columns.size();
    for (const StudyMeasure& measure : study.measures) {
        if (measure.ticks.empty()) table.columns.push_back(measure.name);
        for (const std::int64_t tick : measure.ticks) table.columns.push_back(fmt::format("{}@{}", measure.name, tick));
    }
    table.measures = table.columns.size() - table.first_measure;
    for (const char* name : {"status", "reason", "digest", "seconds", "memory", "key"}) table.columns.emplace_back(name);

    for (std::size_t number = 0; number < plan.rows().size(); ++number) {
        const StudyRow& row = plan.rows()[number];
        const RowResult* const result = store.find(row, study);
        if (result == nullptr) continue;
        std::vector<StudyCell> cells = {static_cast<std::int64_t>(number + 1), study.programs[row.program].name, row.world};
        for (const std::string& value : row.values) cells.push_back(cell_of(value));
        cells.push_back(row.seed ? StudyCell(static_cast<std::int64_t>(*row.seed)) : StudyCell());
        for (const StudyMeasure& measure : study.measures) {
            if (measure.ticks.empty()) cells.push_back(value_in(result->measures, measure_key(measure)));
            for (const std::int64_t tick : measure.ticks) cells.push_back(value_in(result->measures, measure_key(measure, tick)));
        }
        const std::string failure = failure_of(*result, study);
        for (const StudyCell& cell : {StudyCell(failure.empty() ? "fine" : "failed"), StudyCell(failure), StudyCell(result->digest),
                                      StudyCell(result->seconds), StudyCell(static_cast<std::int64_t>(result->memory)), StudyCell(row.key)})
            cells.push_back(cell);
        table.rows.push_back(std::move(cells));
    }
    return table;
}

std::string csv_text(const StudyTable& table) {
    std::string text;
    for (std::size_t i = 0; i < table.columns.size(); ++i) text += (i > 0 ? "," : "") + csv_field(table.columns[i]);
    text += "\n";
    for (const auto& row : table.rows) {
        for (std::size_t i = 0; i < row.size(); ++i) {
            // A field ends on its line.
            std::string cell = text_of(row[i]);
            std::ranges::replace(cell, '\n', ' ');
            text += (i > 0 ? "," : "") + csv_field(cell);
        }
        text += "\n";
    }
    return text;
}

std::vector<std::vector<std::string>> summary_lines(const StudyTable& table) {
    // Columns that say something: one whose cells are all the same is left out.
    std::vector<std::size_t> shown;
    for (std::size_t c = 1; c + 1 < table.first_measure; ++c) {
        const bool parameter = c >= 3;
        const bool differs = std::ranges::any_of(table.rows, [&](const auto& row) { return row[c] != table.rows.front()[c]; });
        if (parameter || differs) shown.push_back(c);
    }
    struct Group {
        std::size_t runs = 0, failed = 0;
        std::vector<std::vector<double>> values;
    };
    std::vector<std::pair<std::vector<std::string>, Group>> groups;
    std::map<std::vector<std::string>, std::size_t> numbers;
    const std::size_t status = *table.column("status");
    for (const auto& row : table.rows) {
        std::vector<std::string> name;
        for (const std::size_t c : shown) name.push_back(text_of(row[c]));
        const auto [found, fresh] = numbers.emplace(name, groups.size());
        if (fresh) groups.emplace_back(name, Group{.values = std::vector<std::vector<double>>(table.measures)});
        Group& group = groups[found->second].second;
        ++group.runs;
        const bool fine = text_of(row[status]) == "fine";
        group.failed += fine ? 0 : 1;
        // What a run has measured that went wrong says nothing about those that went well.
        if (!fine) continue;
        for (std::size_t m = 0; m < table.measures; ++m)
            if (const auto value = number_of(row[table.first_measure + m])) group.values[m].push_back(*value);
    }
    std::vector<std::vector<std::string>> lines(1);
    for (const std::size_t c : shown) lines[0].push_back(table.columns[c]);
    lines[0].emplace_back("runs");
    lines[0].emplace_back("failed");
    for (std::size_t m = 0; m < table.measures; ++m) lines[0].push_back(table.columns[table.first_measure + m]);
    for (auto& [name, group] : groups) {
        std::vector<std::string> line = name;
        line.push_back(std::to_string(group.runs));
        line.push_back(std::to_string(group.failed));
        for (std::vector<double>& values : group.values) {
            const Quartiles q = quartiles(values);
            line.push_back(values.empty()    ? "-"
                           : q.low == q.high ? fmt::format("{:.6g}", q.median)
                                             : fmt::format("{:.6g} [{:.6g}, {:.6g}]", q.median, q.low, q.high));
        }
        lines.push_back(std::move(line));
    }
    return lines;
}

std::string summary_text(const StudyTable& table) {
    const std::vector<std::vector<std::string>> lines = summary_lines(table);
    std::vector<std::size_t> widths(lines[0].size());
    for (const auto& line : lines)
        for (std::size_t i = 0; i < line.size(); ++i) widths[i] = std::max(widths[i], line[i].size());
    std::string text;
    for (const auto& line : lines) {
        std::string out;
        for (std::size_t i = 0; i < line.size(); ++i) out += fmt::format("{}{:<{}}", i > 0 ? "  " : "", visible(line[i]), widths[i]);
        out.erase(out.find_last_not_of(' ') + 1);
        text += out + "\n";
    }
    return text;
}

}  // namespace meld::driver
