#include "runtime/show/render/chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "runtime/show/render/surface.h"

namespace meld::render {

namespace {

// Colours that people with any kind of sight tell apart (Okabe and Ito, 2008), without the yellow, which is too light for lines.
constexpr std::array<std::array<double, 3>, 7> kSeriesColours = {
    {{0, 0.45, 0.70}, {0.84, 0.37, 0}, {0, 0.62, 0.45}, {0.80, 0.47, 0.65}, {0.34, 0.71, 0.91}, {0.90, 0.62, 0}, {0.2, 0.2, 0.2}}};
constexpr double kLetter = 13, kRoom = 0.06, kInk = 0.2, kGrid = 0.88;

cairo_status_t append_bytes(void* to, const unsigned char* bytes, unsigned int count) {
    static_cast<std::string*>(to)->append(reinterpret_cast<const char*>(bytes), count);
    return CAIRO_STATUS_SUCCESS;
}

// One axis: from numbers to a part of its length.
class ChartAxis {
  public:
    ChartAxis(double low, double high, bool logarithmic) : log_(logarithmic), low_(moved(low)), high_(moved(high)) {
        if (high_ - low_ < 1e-12) {
            low_ -= 0.5;
            high_ += 0.5;
        }
        const double room = kRoom * (high_ - low_);
        low_ -= room;
        high_ += room;
    }
    double part(double value) const { return (moved(value) - low_) / (high_ - low_); }
    // Round numbers on it, some five.
    std::vector<double> marks() const {
        std::vector<double> all;
        if (log_) {
            for (const std::vector<double>& steps : {std::vector<double>{1}, {1, 3}, {1, 2, 5}, {1, 2, 3, 4, 5, 6, 7, 8, 9}}) {
                all.clear();
                for (double decade = std::floor(low_); decade <= high_; ++decade)
                    for (const double step : steps)
                        if (const double value = step * std::pow(10, decade); moved(value) >= low_ && moved(value) <= high_)
                            all.push_back(value);
                if (all.size() >= 3) break;
            }
            return all;
        }
        const double raw = (high_ - low_) / 5, decade = std::pow(10, std::floor(std::log10(raw)));
        const double step = decade * (raw / decade < 1.5 ? 1 : raw / decade < 3.5 ? 2 : raw / decade < 7.5 ? 5 : 10);
        for (double i = std::ceil(low_ / step); i * step <= high_; ++i) all.push_back(i * step + 0.0);
        return all;
    }

  private:
    double moved(double value) const { return log_ ? std::log10(value) : value; }
    bool log_;
    double low_, high_;
};

class ChartPen {
  public:
    ChartPen(cairo_t* pen, const Chart& chart, int width, int height)
        : pen_(pen),
          chart_(chart),
          x_(axis(true)),
          y_(axis(false)),
          left_(5.5 * kLetter),
          top_(2.5 * kLetter),
          width_(width),
          height_(height) {
        right_ = width_ - kLetter;
        bottom_ = height_ - 3.6 * kLetter - names_lines() * 1.4 * kLetter;
    }

    void draw() {
        cairo_set_source_rgb(pen_, 1, 1, 1);
        cairo_paint(pen_);
        cairo_select_font_face(pen_, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
        cairo_set_font_size(pen_, kLetter);
        draw_axes();
        for (std::size_t i = 0; i < chart_.series.size(); ++i) draw_series(i);
        draw_names();
    }

  private:
    double names_lines() const { return chart_.series.size() > 1 ? static_cast<double>(chart_.series.size()) : 0; }
    ChartAxis axis(bool of_x) const {
        double low = HUGE_VAL, high = -HUGE_VAL;
        for (const ChartSeries& series : chart_.series)
            for (const ChartPoint& point : series.points) {
                low = std::min(low, of_x ? point.x : point.low);
                high = std::max(high, of_x ? point.x : point.high);
            }
        return {low, high, of_x ? chart_.log_x : chart_.log_y};
    }
    double at_x(double value) const { return left_ + x_.part(value) * (right_ - left_); }
    double at_y(double value) const { return bottom_ - y_.part(value) * (bottom_ - top_); }
    void ink(double grey) { cairo_set_source_rgb(pen_, grey, grey, grey); }
    void colour(std::size_t series, double alpha = 1) {
        const auto& c = kSeriesColours[series % kSeriesColours.size()];
        cairo_set_source_rgba(pen_, c[0], c[1], c[2], alpha);
    }
    // `part` of its width is left of x.
    void words(const std::string& text, double x, double y, double part) {
        cairo_text_extents_t size;
        cairo_text_extents(pen_, text.c_str(), &size);
        cairo_move_to(pen_, x - part * size.x_advance, y);
        cairo_show_text(pen_, text.c_str());
    }
    void line(double x1, double y1, double x2, double y2) {
        cairo_move_to(pen_, x1, y1);
        cairo_line_to(pen_, x2, y2);
        cairo_stroke(pen_);
    }

    void draw_axes() {
        cairo_set_line_width(pen_, 1);
        for (const double mark : x_.marks()) {
            ink(kGrid);
            line(at_x(mark), top_, at_x(mark), bottom_);
            ink(kInk);
            words(fmt::format("{:.6g}", mark), at_x(mark), bottom_ + 1.3 * kLetter, 0.5);
        }
        for (const double mark : y_.marks()) {
            ink(kGrid);
            line(left_, at_y(mark), right_, at_y(mark));
            ink(kInk);
            words(fmt::format("{:.6g}", mark), left_ - 0.4 * kLetter, at_y(mark) + 0.35 * kLetter, 1);
        }
        ink(kInk);
        cairo_rectangle(pen_, left_, top_, right_ - left_, bottom_ - top_);
        cairo_stroke(pen_);
        words(chart_.title, (left_ + right_) / 2, 1.6 * kLetter, 0.5);
        words(chart_.x_title, (left_ + right_) / 2, bottom_ + 2.8 * kLetter, 0.5);
        cairo_save(pen_);
        cairo_translate(pen_, 1.2 * kLetter, (top_ + bottom_) / 2);
        cairo_rotate(pen_, -M_PI / 2);
        words(chart_.y_title, 0, 0, 0.5);
        cairo_restore(pen_);
    }

    void draw_series(std::size_t number) {
        const ChartSeries& series = chart_.series[number];
        if (series.points.empty()) return;
        colour(number, 0.2);
        // Text leaves the pen at its end, and the band would begin there.
        cairo_move_to(pen_, at_x(series.points.front().x), at_y(series.points.front().high));
        for (const ChartPoint& point : series.points) cairo_line_to(pen_, at_x(point.x), at_y(point.high));
        for (std::size_t i = series.points.size(); i-- > 0;) cairo_line_to(pen_, at_x(series.points[i].x), at_y(series.points[i].low));
        cairo_close_path(pen_);
        cairo_fill(pen_);
        colour(number);
        cairo_set_line_width(pen_, 1.5);
        for (const ChartPoint& point : series.points) cairo_line_to(pen_, at_x(point.x), at_y(point.middle));
        cairo_stroke(pen_);
        for (const ChartPoint& point : series.points) {
            line(at_x(point.x), at_y(point.low), at_x(point.x), at_y(point.high));
            cairo_arc(pen_, at_x(point.x), at_y(point.middle), 3, 0, 2 * M_PI);
            cairo_fill(pen_);
        }
        const double dashes[] = {5, 4};
        cairo_save(pen_);
        cairo_rectangle(pen_, left_, top_, right_ - left_, bottom_ - top_);
        cairo_clip(pen_);
        cairo_set_dash(pen_, dashes, 2, 0);
        for (const auto& [x, y] : series.line) cairo_line_to(pen_, at_x(x), at_y(y));
        cairo_stroke(pen_);
        cairo_restore(pen_);
    }

    // Below the chart, so that nothing is hidden.
    void draw_names() {
        for (std::size_t i = 0; i < chart_.series.size() && chart_.series.size() > 1; ++i) {
            const double y = bottom_ + 4.4 * kLetter + static_cast<double>(i) * 1.4 * kLetter;
            colour(i);
            cairo_rectangle(pen_, left_, y - 0.6 * kLetter, 1.6 * kLetter, 0.4 * kLetter);
            cairo_fill(pen_);
            ink(kInk);
            words(chart_.series[i].name, left_ + 2.2 * kLetter, y, 0);
        }
    }

    cairo_t* pen_;
    const Chart& chart_;
    ChartAxis x_, y_;
    double left_, top_, width_, height_, right_ = 0, bottom_ = 0;
};

}  // namespace

std::string chart_svg(const Chart& chart, int width, int height) {
    std::string out;
    {
        const Surface surface(cairo_svg_surface_create_for_stream(append_bytes, &out, width, height), cairo_surface_destroy);
        const Pen pen = pen_for(surface);
        ChartPen(pen.get(), chart, width, height).draw();
        cairo_surface_finish(surface.get());
    }
    return out;
}

std::string chart_png(const Chart& chart, int width, int height) {
    Image image{static_cast<std::size_t>(width), static_cast<std::size_t>(height),
                std::vector<std::uint32_t>(static_cast<std::size_t>(width) * static_cast<std::size_t>(height))};
    {
        const Surface surface = surface_of(image);
        const Pen pen = pen_for(surface);
        ChartPen(pen.get(), chart, width, height).draw();
        cairo_surface_flush(surface.get());
    }
    return png_of(image);
}

}  // namespace meld::render
