#include "runtime/driver/grade/grade_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "runtime/base/csv_row.h"
#include "runtime/base/terminal/terminal_text.h"
#include "runtime/base/units.h"
#include "runtime/driver/study/first_line.h"

namespace meld::driver {

namespace {

using Json = nlohmann::ordered_json;

std::vector<std::string> copies(const Grading& grading, std::size_t submission) {
    std::vector<std::string> names;
    for (const std::size_t other : grading.grades[submission].same_as) names.push_back(grading.submissions[other].name);
    return names;
}

// The compiler's first message, with its place on the same line.
std::string first_message(const std::string& messages) {
    const std::string first = first_line(messages);
    const std::size_t arrow = messages.find("--> ");
    return arrow == std::string::npos ? first : first_line(messages.substr(arrow + 4)) + ": " + first;
}

std::vector<std::vector<std::string>> lines_of(const Grading& g) {
    std::vector<std::vector<std::string>> lines;
    lines.push_back({"student", "points"});
    for (const ExerciseWorld& world : g.exercise.worlds) lines.back().push_back(world.name);
    for (std::size_t i = 0; i < g.submissions.size(); ++i) {
        lines.push_back({g.submissions[i].name, fmt::format("{}/{}", g.grades[i].points, g.exercise.points())});
        for (const GradedRun& run : g.grades[i].runs) lines.back().push_back(outcome_word(run));
    }
    return lines;
}

// In columns of a terminal, as far as characters have one each.
std::size_t width(const std::string& text) {
    return static_cast<std::size_t>(std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

}  // namespace

std::string outcome_word(const GradedRun& run) { return run.outcome.empty() ? "-" : run.outcome; }

std::string remark(const Grading& grading, std::size_t submission) {
    const Grade& grade = grading.grades[submission];
    std::string text;
    const auto add = [&](const std::string& more) { text += (text.empty() ? "" : "; ") + more; };
    if (!grade.problem.empty()) add(first_line(grade.problem) + (grade.messages.empty() ? "" : ": " + first_message(grade.messages)));
    if (grade.as_start) add("the program that students begin with");
    if (!grade.same_as.empty()) {
        const std::vector<std::string> others = copies(grading, submission);
        add(fmt::format("the same program as {}{}", fmt::join(others, ", "), grade.as_solution ? ", and as the solution" : ""));
    }
    return text;
}

std::string grade_table(const Grading& g) {
    const std::vector<std::vector<std::string>> lines = lines_of(g);
    std::vector<std::size_t> widths(lines[0].size());
    for (const auto& line : lines)
        for (std::size_t c = 0; c < line.size(); ++c) widths[c] = std::max(widths[c], width(visible(line[c])));
    std::string text;
    for (const auto& line : lines) {
        std::string row;
        for (std::size_t c = 0; c < line.size(); ++c) {
            const std::string cell = visible(line[c]);
            row += cell + std::string(widths[c] + 2 - width(cell), ' ');
        }
        row.erase(row.find_last_not_of(' ') + 1);
        text += row + "\n";
    }
    for (std::size_t i = 0; i < g.submissions.size(); ++i)
        if (const std::string said = remark(g, i); !said.empty())
            text += fmt::format("{}: {}\n", visible(g.submissions[i].name), visible(said));
    return text;
}

std::string grade_csv(const Grading& g) {
    std::vector<std::vector<std::string>> lines = lines_of(g);
    lines[0].insert(lines[0].begin() + 2, "of");
    lines[0].emplace_back("remark");
    for (std::size_t i = 0; i < g.submissions.size(); ++i) {
        std::vector<std::string>& line = lines[i + 1];
        line[1] = std::to_string(g.grades[i].points);
        line.insert(line.begin() + 2, std::to_string(g.exercise.points()));
        line.push_back(remark(g, i));
    }
    std::string text;
    for (const auto& line : lines) {
        std::string row;
        for (const std::string& cell : line) row += (row.empty() ? "" : ",") + csv_field(cell);
        text += row + "\n";
    }
    return text;
}

std::string grade_json(const Grading& g, bool reveal) {
    Json students = Json::array();
    for (std::size_t i = 0; i < g.submissions.size(); ++i) {
        const Grade& grade = g.grades[i];
        Json worlds = Json::array();
        for (std::size_t w = 0; w < g.exercise.worlds.size(); ++w) {
            const ExerciseWorld& world = g.exercise.worlds[w];
            const GradedRun& run = grade.runs[w];
            Json entry = {{"world", world.name},
                          {"hidden", world.hidden},
                          {"outcome", outcome_word(run)},
                          {"points", run.outcome == "fine" ? world.points : 0},
                          {"of", world.points}};
            if (reveal || !world.hidden) {
                entry["reason"] = run.reason;
                entry["checks"] = Json::array();
                for (std::size_t c = 0; c < run.checks.size(); ++c) {
                    const GradedCheck& check = run.checks[c];
                    entry["checks"].push_back(
                        {{"name", world.checks[c].name}, {"fine", check.fine}, {"found", check.found}, {"why", check.why}});
                }
            }
            worlds.push_back(std::move(entry));
        }
        students.push_back({{"student", g.submissions[i].name},
                            {"points", grade.points},
                            {"of", g.exercise.points()},
                            {"problem", grade.problem},
                            {"messages", grade.messages},
                            {"same_as", copies(g, i)},
                            {"as_solution", grade.as_solution},
                            {"as_start", grade.as_start},
                            {"page", student_folder(g.submissions[i]) + "/index.html"},
                            {"worlds", std::move(worlds)}});
    }
    const Json all = {{"exercise", g.exercise.title}, {"without_network", g.without_network}, {"students", std::move(students)}};
    return all.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace meld::driver
