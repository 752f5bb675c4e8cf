#include "runtime/show/picture/camera_path.h"

#include <algorithm>
#include <cmath>

namespace meld::picture {

namespace {

// The slope of a curve through three points that has its ups and downs at the points alone (Fritsch and Butland, "A Method for Constructing
// Local Monotone Piecewise Cubic Interpolants", 1984).
double slope(double before_width, double before_rise, double after_width, double after_rise) {
    const double before = before_rise / before_width, after = after_rise / after_width;
    if (before * after <= 0) return 0;
    const double w1 = 2 * after_width + before_width, w2 = after_width + 2 * before_width;
    return (w1 + w2) / (w1 / before + w2 / after);
}

}  // namespace

render::View CameraPath::at(std::int64_t tick, std::size_t frame, std::size_t frames) const {
    render::View view = view_;
    if (keys_.empty()) {
        view.azimuth_deg +=
            static_cast<float>(turn_deg_ * static_cast<double>(frame) / static_cast<double>(std::max<std::size_t>(frames, 1)));
        return view;
    }
    const std::size_t last = keys_.size() - 1;
    const auto after = std::ranges::upper_bound(keys_, tick, {}, &Key::tick);
    const std::size_t right = static_cast<std::size_t>(after - keys_.begin());
    const auto value = [&](const auto& of) {
        if (right == 0) return of(keys_.front());
        if (right > last) return of(keys_.back());
        const auto width = [&](std::size_t i) { return static_cast<double>(keys_[i + 1].tick - keys_[i].tick); };
        const auto rise = [&](std::size_t i) { return of(keys_[i + 1]) - of(keys_[i]); };
        // At rest where it begins and ends.
        const auto slope_at = [&](std::size_t i) { return i == 0 || i == last ? 0 : slope(width(i - 1), rise(i - 1), width(i), rise(i)); };
        const std::size_t left = right - 1;
        const double h = width(left), t = static_cast<double>(tick - keys_[left].tick) / h;
        return of(keys_[left]) + t * t * (3 - 2 * t) * rise(left) + t * (1 - t) * (1 - t) * h * slope_at(left) -
               t * t * (1 - t) * h * slope_at(right);
    };
    view.azimuth_deg = static_cast<float>(value([](const Key& key) { return key.azimuth_deg; }));
    view.elevation_deg = static_cast<float>(value([](const Key& key) { return key.elevation_deg; }));
    view.zoom = static_cast<float>(std::exp(value([](const Key& key) { return std::log(key.zoom); })));
    return view;
}

}  // namespace meld::picture
