#include "runtime/driver/grade/grade_page.h"

#include <fmt/format.h>

#include <string_view>

#include "runtime/base/version.h"
#include "runtime/driver/grade/grade_table.h"
#include "runtime/driver/study/html_text.h"

namespace meld::driver {

namespace {

constexpr std::size_t kMostShown_bytes = 4000;

// Text of students is data in the page, and its letters have contrast on both backgrounds.
constexpr std::string_view kPageStyle =
    ":root{color-scheme:light dark}body{font:16px/1.5 sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem}"
    "table{border-collapse:collapse;display:block;overflow-x:auto}th,td{padding:.2rem .7rem;border-bottom:1px solid #8888;text-align:left;"
    "white-space:nowrap}pre{background:#8882;padding:.6rem;overflow-x:auto;white-space:pre-wrap}td:last-child{white-space:normal;min-width:"
    "16rem}section{border-top:1px solid #8888;margin-top:1.5rem}";

std::string cut(const std::string& text) {
    if (text.size() <= kMostShown_bytes) return text;
    std::size_t end = kMostShown_bytes;
    while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) --end;
    return text.substr(0, end) + "\n...";
}

std::string pre(const std::string& text) { return text.empty() ? "" : "<pre>" + html(cut(text)) + "</pre>\n"; }

// A page may be opened from a disk, and loads and runs nothing.
std::string begin(const std::string& title) {
    return fmt::format(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">"
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'\">"
        "<title>{0}</title><style>{1}</style></head>\n<body>\n<h1>{0}</h1>\n",
        html(title), kPageStyle);
}

std::string end() { return fmt::format("<p>By Claymeld {}.</p>\n</body></html>\n", kVersion); }

std::string describe(const GradedRun& run) {
    const std::string& o = run.outcome;
    return o == "fine"     ? "Everything is as expected"
           : o == "wrong"  ? "Something is not as expected"
           : o == "error"  ? "The run ends with an error"
           : o == "limit"  ? "The run reaches a limit: it may not end, or make ever more facts"
           : o == "time"   ? "The run takes too long"
           : o == "memory" ? "The run needs too much memory"
           : o == "output" ? "The program prints too much"
           : o.empty()     ? "It was not run"
                           : "The run crashes";
}

std::string world_section(const ExerciseWorld& world, const GradedRun& run, bool shown) {
    std::string text =
        fmt::format("<section><h2>{}{}: {} of {} points</h2>\n<p>{}.</p>\n", html(world.name), world.hidden ? " (hidden)" : "",
                    run.outcome == "fine" ? world.points : 0, world.points, html(describe(run)));
    if (!shown) return text + "</section>\n";
    text += pre(run.reason);
    for (std::size_t c = 0; c < run.checks.size(); ++c) {
        const GradedCheck& check = run.checks[c];
        if (check.fine) continue;
        text += fmt::format("<h3>{}</h3>\n<p>{}: <code>{}</code></p>\n", html(world.checks[c].name),
                            world.checks[c].never ? "It may never hold" : "It must hold", html(world.checks[c].text));
        text += pre(check.found) + pre(check.why);
    }
    if (!run.page.empty()) text += fmt::format("<p><a href=\"{0}\">The run, to be turned and played</a></p>\n", html(run.page));
    if (run.outcome != "fine" && !run.said.empty()) text += "<h3>What it printed</h3>\n" + pre(run.said);
    return text + "</section>\n";
}

}  // namespace

std::string student_page(const Grading& g, std::size_t submission, bool reveal) {
    const Submission& each = g.submissions[submission];
    const Grade& grade = g.grades[submission];
    std::string text = begin(g.exercise.title + ": " + each.name);
    text += fmt::format("<p><strong>{} of {} points</strong></p>\n", grade.points, g.exercise.points());
    if (!grade.problem.empty()) text += "<p>Not run: " + html(grade.problem) + "</p>\n" + pre(grade.messages);
    if (grade.problem.empty())
        for (std::size_t w = 0; w < g.exercise.worlds.size(); ++w)
            text += world_section(g.exercise.worlds[w], grade.runs[w], reveal || !g.exercise.worlds[w].hidden);
    return text + end();
}

std::string overview_page(const Grading& g) {
    std::string text = begin(g.exercise.title) + "<table>\n<tr><th>student</th><th>points</th>";
    for (const ExerciseWorld& world : g.exercise.worlds)
        text += fmt::format("<th>{}{}</th>", html(world.name), world.hidden ? " (hidden)" : "");
    text += "<th>remark</th></tr>\n";
    for (std::size_t i = 0; i < g.submissions.size(); ++i) {
        text += fmt::format("<tr><td><a href=\"{}/index.html\">{}</a></td><td>{}/{}</td>", student_folder(g.submissions[i]),
                            html(g.submissions[i].name), g.grades[i].points, g.exercise.points());
        for (const GradedRun& run : g.grades[i].runs) text += fmt::format("<td>{}</td>", outcome_word(run));
        text += fmt::format("<td>{}</td></tr>\n", html(remark(g, i)));
    }
    return text + "</table>\n" + end();
}

}  // namespace meld::driver
