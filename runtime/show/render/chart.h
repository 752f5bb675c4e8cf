// A chart of numbers over numbers: points with bands, and lines fitted to them.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace meld::render {

struct ChartPoint {
    double x = 0;
    double low = 0, middle = 0, high = 0;  // The band, and what is in it.
};

struct ChartSeries {
    std::string name;
    std::vector<ChartPoint> points;                    // By x.
    std::vector<std::pair<double, double>> line = {};  // Dashed; empty: none.
};

struct Chart {
    std::string title, x_title, y_title;
    bool log_x = false, log_y = false;  // All numbers on such an axis are above zero.
    std::vector<ChartSeries> series;    // At least one point in all.
};

// As SVG or PNG, so many pixels large.
std::string chart_svg(const Chart& chart, int width, int height);
std::string chart_png(const Chart& chart, int width, int height);

}  // namespace meld::render
