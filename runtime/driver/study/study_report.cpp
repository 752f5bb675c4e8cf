#include "runtime/driver/study/study_report.h"

#include <fmt/format.h>

#include <filesystem>
#include <sstream>

#include "runtime/base/units.h"
#include "runtime/base/version.h"
#include "runtime/driver/study/html_text.h"
#include "runtime/driver/study/shell_words.h"
#include "runtime/show/render/chart.h"

namespace meld::driver {

namespace {

constexpr std::size_t kFailuresShown = 200;
constexpr int kReportPlotWidth = 760, kReportPlotHeight = 480;

constexpr std::string_view kStyle =
    "body{font:16px/1.5 sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;color:#222;background:#fff}"
    "table{border-collapse:collapse;display:block;overflow-x:auto}th,td{padding:.2rem .7rem;border-bottom:1px solid #ddd;text-align:left;"
    "white-space:nowrap}pre{background:#f4f4f4;padding:.6rem;overflow-x:auto}svg{max-width:100%;height:auto}";

// Without the declaration of XML, which has no place in a page.
std::string inline_svg(const StudyPlot& plot) {
    const std::string svg = render::chart_svg(plot.chart, kReportPlotWidth, kReportPlotHeight);
    return svg.substr(svg.find("<svg"));
}

std::string html_table(const std::vector<std::vector<std::string>>& lines) {
    std::string out = "<table>\n";
    for (std::size_t i = 0; i < lines.size(); ++i) {
        out += "<tr>";
        for (const std::string& cell : lines[i]) out += fmt::format("<{0}>{1}</{0}>", i == 0 ? "th" : "td", html(cell));
        out += "</tr>\n";
    }
    return out + "</table>\n";
}

}  // namespace

std::string report_page(const StudyPlan& plan, const StudyTable& table, const std::vector<StudyPlot>& plots) {
    namespace fs = std::filesystem;
    const std::string name = fs::path(plan.study().path).filename().string();
    std::string page = fmt::format(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" content=\"width=device-width\">"
        "<title>{0}</title><style>{1}</style></head>\n<body>\n<h1>{0}</h1>\n<p>{2} of {3} runs, by Claymeld {4}.</p>\n",
        html(name), kStyle, grouped(table.rows.size()), grouped(plan.rows().size()), kVersion);
    for (const StudyPlot& plot : plots) page += fmt::format("<figure>{}</figure>\n<pre>{}</pre>\n", inline_svg(plot), html(plot.said));
    page += "<h2>Medians and quartiles</h2>\n" + html_table(summary_lines(table));

    const std::size_t status = *table.column("status"), reason = *table.column("reason");
    std::string failures;
    std::size_t failed = 0;
    for (const auto& row : table.rows) {
        if (text_of(row[status]) == "fine") continue;
        if (++failed > kFailuresShown) continue;
        const auto number = static_cast<std::size_t>(std::get<std::int64_t>(row[0]));
        const std::string folder = plan.study().folder.empty() ? "." : plan.study().folder;
        failures += fmt::format("<h3>Row {}</h3>\n<p>{}</p>\n<pre>{}</pre>\n", number, html(text_of(row[reason])),
                                html(shell_words(plan.command(plan.rows()[number - 1], folder))));
    }
    if (failed > kFailuresShown) failures += fmt::format("<p>And {} more.</p>\n", grouped(failed - kFailuresShown));
    if (!failures.empty())
        page +=
            "<h2>Rows that have failed</h2>\n<p>Each with the command that makes it again, in the folder of the study.</p>\n" + failures;
    page += "<h2>The study</h2>\n<pre>" + html(plan.study().text) + "</pre>\n";
    return page + "</body></html>\n";
}

}  // namespace meld::driver
