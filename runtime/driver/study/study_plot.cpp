#include "runtime/driver/study/study_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string_view>
#include <utility>

#include "runtime/base/did_you_mean.h"
#include "runtime/base/files/output_file.h"
#include "runtime/driver/study/fit.h"
#include "runtime/driver/study/quantiles.h"

namespace meld::driver {

namespace {

constexpr int kPlotWidth = 760, kPlotHeight = 480;
constexpr std::size_t kMostPlotted = 14;

using PlotName = std::vector<std::string>;
using XY = std::pair<double, double>;

Result<std::size_t> plotted_column(const StudyTable& table, std::string_view name, const std::string& what) {
    if (const auto found = table.column(name)) return *found;
    const std::vector<std::string_view> names(table.columns.begin(), table.columns.end());
    return fail(fmt::format("--plot {}: the table has no column '{}'", what, name), did_you_mean(name, names));
}

using LineColumns = std::optional<std::vector<std::size_t>>;

Result<LineColumns> no_choice() { return LineColumns(); }

// Of "world,loss": the columns whose values have lines of their own.
Result<LineColumns> line_columns(const StudyTable& table, std::string_view names, const std::string& what) {
    std::vector<std::size_t> columns;
    for (std::size_t at = 0; at <= names.size();) {
        const std::size_t end = std::min(names.find(',', at), names.size());
        const auto column = plotted_column(table, names.substr(at, end - at), what);
        if (!column) return tl::unexpected<Error>(column.error());
        columns.push_back(*column);
        at = end + 1;
    }
    return columns;
}

// "0.98, 95% confidence 0.95 to 1.01"
std::string exponent_text(const PowerFit& fit) {
    return fmt::format("exponent {:.3g}, 95% confidence {:.3g} to {:.3g}", fit.exponent, fit.low, fit.high);
}

class Plotter {
  public:
    // `by`: the columns whose values have lines of their own; nothing: those of programs, worlds and other parameters that differ.
    Plotter(const StudyTable& table, std::size_t y, std::size_t x, LineColumns by) : table_(table), y_(y), x_(x), by_(std::move(by)) {}

    void read() {
        const std::size_t status = *table_.column("status");
        const std::vector<std::size_t> names = by_ ? *by_ : name_columns();
        for (const auto& row : table_.rows) {
            const bool fine = text_of(row[status]) == "fine";
            failed_ += fine ? 0 : 1;
            const auto x = number_of(row[x_]), y = number_of(row[y_]);
            if (!x || !y || !fine) continue;
            PlotName name;
            for (const std::size_t c : names) name.push_back(text_of(row[c]));
            if (!lines_.contains(name)) order_.push_back(name);
            lines_[name].emplace_back(*x, *y);
            positive_ = positive_ && *x > 0 && *y > 0;
            // The same run of another program.
            PlotName run;
            for (std::size_t c = 2; c < table_.first_measure; ++c) run.push_back(text_of(row[c]));
            pairs_[run][text_of(row[1])] = *y;
        }
        for (const std::size_t c : names) labels_.push_back(c == 1 || c == 2 ? "" : table_.columns[c] + " = ");
    }
    bool empty() const { return lines_.empty(); }
    std::size_t lines() const { return lines_.size(); }

    StudyPlot plot() const {
        StudyPlot plot;
        plot.chart.x_title = table_.columns[x_];
        plot.chart.y_title = table_.columns[y_];
        plot.chart.log_x = plot.chart.log_y = positive_;
        for (const PlotName& name : order_) add(name, plot);
        compare(plot);
        if (failed_ > 0) plot.said += fmt::format("{} without {} row{} that failed\n", what_of(plot), failed_, failed_ == 1 ? "" : "s");
        return plot;
    }

  private:
    static std::string what_of(const StudyPlot& plot) { return plot.chart.y_title + " ~ " + plot.chart.x_title; }

    // Those of programs, worlds and other parameters that differ.
    std::vector<std::size_t> name_columns() const {
        std::vector<std::size_t> names;
        for (std::size_t c = 1; c + 1 < table_.first_measure; ++c)
            if (c != x_ && std::ranges::any_of(table_.rows, [&](const auto& row) { return row[c] != table_.rows.front()[c]; }))
                names.push_back(c);
        return names;
    }

    void add(const PlotName& name, StudyPlot& plot) const {
        const std::vector<XY>& points = lines_.at(name);
        render::ChartSeries series;
        for (std::size_t i = 0; i < name.size(); ++i) series.name += (i > 0 ? ", " : "") + (name[i].empty() ? "-" : labels_[i] + name[i]);
        std::map<double, std::vector<double>> by_x;
        for (const auto& [x, y] : points) by_x[x].push_back(y);
        for (const auto& [x, values] : by_x) {
            const Quartiles q = quartiles(values);
            series.points.push_back({x, q.low, q.median, q.high});
        }
        std::optional<PowerFit> fit;
        if (positive_) fit = fit_power(points);
        const std::string what = what_of(plot) + (series.name.empty() ? "" : ", " + series.name);
        if (positive_ && !fit) plot.said += what + ": no exponent, since there are not three rows at two places\n";
        if (fit) {
            for (const double x : {by_x.begin()->first, by_x.rbegin()->first})
                series.line.emplace_back(x, fit->factor * std::pow(x, fit->exponent));
            plot.said += fmt::format("{}: {}\n", what, exponent_text(*fit));
            const std::string exponent = fmt::format("exponent {:.3g} [{:.3g}, {:.3g}]", fit->exponent, fit->low, fit->high);
            if (order_.size() == 1) plot.chart.title = exponent;
            series.name += (series.name.empty() ? "" : ": ") + exponent;
        }
        plot.chart.series.push_back(std::move(series));
    }

    // Two programs in the same worlds, with the same parameters and seeds.
    void compare(StudyPlot& plot) const {
        std::set<std::string> programs;
        for (const auto& [run, by_program] : pairs_)
            for (const auto& [program, y] : by_program) programs.insert(program);
        if (programs.size() != 2) return;
        const std::string &a = *programs.begin(), &b = *programs.rbegin();
        std::vector<double> differences;
        for (const auto& [run, by_program] : pairs_)
            if (by_program.size() == 2) differences.push_back(by_program.at(a) - by_program.at(b));
        if (differences.empty()) return;
        const double p = signed_rank_test(differences);
        const std::string text = fmt::format("{}: {} minus {} in {} pairs: median {:.4g}, signed-rank test p = {:.2g}", plot.chart.y_title,
                                             a, b, differences.size(), quartiles(differences).median, p);
        plot.said += text + "\n";
        plot.chart.title = text;
    }

    const StudyTable& table_;
    std::size_t y_, x_;
    LineColumns by_;
    std::size_t failed_ = 0;
    std::vector<PlotName> order_;
    std::vector<std::string> labels_;
    std::map<PlotName, std::vector<XY>> lines_;
    std::map<PlotName, std::map<std::string, double>> pairs_;
    bool positive_ = true;
};

}  // namespace

Result<StudyPlot> plot_of(const StudyTable& table, const std::string& what) {
    const std::size_t tilde = what.find('~');
    if (tilde == std::string::npos) return fail(fmt::format("--plot {}: it does not say over what", what), "Write --plot rounds~n");
    const std::size_t bar = std::min(what.find('|', tilde), what.size());
    const auto y = plotted_column(table, what.substr(0, tilde), what);
    const auto x = plotted_column(table, what.substr(tilde + 1, bar - tilde - 1), what);
    for (const auto* each : {&y, &x})
        if (!*each) return tl::unexpected<Error>(each->error());
    const auto by = bar < what.size() ? line_columns(table, what.substr(bar + 1), what) : no_choice();
    if (!by) return tl::unexpected<Error>(by.error());
    Plotter plotter(table, *y, *x, *by);
    plotter.read();
    if (plotter.empty())
        return fail(fmt::format("--plot {}: no row that is fine has numbers in both columns", what),
                    "Plot a measure over a parameter whose values are numbers");
    if (plotter.lines() > kMostPlotted)
        return fail(fmt::format("--plot {}: {} lines are more than one can tell apart", what, plotter.lines()),
                    fmt::format("Name the columns that shall have lines of their own, as '{}|world'", what.substr(0, bar)));
    return plotter.plot();
}

Result<void> write_plot(const StudyPlot& plot, const std::string& path) {
    if (path.ends_with(".svg")) return write_file(path, render::chart_svg(plot.chart, kPlotWidth, kPlotHeight));
    if (path.ends_with(".png")) return write_file(path, render::chart_png(plot.chart, kPlotWidth, kPlotHeight));
    return fail(fmt::format("{} is neither .svg nor .png", path), "Name the plot so");
}

}  // namespace meld::driver
