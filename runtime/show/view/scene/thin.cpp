#include "runtime/show/view/scene/thin.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <unordered_map>
#include <utility>

#include "runtime/show/render/cells.h"
#include "runtime/show/view/scene/block.h"

namespace meld::view {

namespace {

using render::Scene;
using render::Vec;

// Between balls one sees as far as the neighbours of those outside.
constexpr int kSeenThrough = 1;

// Values of the catoms that stay, at their new places.
template <class T>
void keep_values(std::vector<std::pair<std::size_t, T>>& values, std::span<const std::size_t> kept) {
    std::erase_if(values, [&](const auto& value) { return !std::ranges::binary_search(kept, value.first); });
    for (auto& [place, value] : values) place = static_cast<std::size_t>(std::ranges::lower_bound(kept, place) - kept.begin());
}

// Only these catoms stay, given in order.
void keep(picture::Frame& frame, std::span<const std::size_t> kept) {
    Scene& scene = frame.scene;
    const std::vector<std::uint32_t> owners = catoms_of_notes(scene);
    std::vector<render::Note> notes;
    for (std::size_t i = 0; i < owners.size(); ++i)
        if (std::ranges::binary_search(kept, owners[i])) notes.push_back(std::move(scene.notes[i]));
    scene.notes = std::move(notes);
    for (std::size_t i = 0; i < kept.size(); ++i) {
        scene.places[i] = scene.places[kept[i]];
        scene.colours[i] = scene.colours[kept[i]];
        frame.ids[i] = frame.ids[kept[i]];
        if (!scene.diameters.empty()) scene.diameters[i] = scene.diameters[kept[i]];
        if (!scene.rounded.empty()) scene.rounded[i] = scene.rounded[kept[i]];
    }
    scene.places.resize(kept.size());
    scene.colours.resize(kept.size());
    frame.ids.resize(kept.size());
    if (!scene.diameters.empty()) scene.diameters.resize(kept.size());
    if (!scene.rounded.empty()) scene.rounded.resize(kept.size());
    keep_values(frame.numbers, kept);
    keep_values(frame.words, kept);
}

// Which ball is in each cube: in a table of all of them, or, where they are far apart, of those in which there are catoms.
class Cubes {
  public:
    static constexpr std::uint32_t kNone = 0xffffffff;
    // Cubes are counted from the lowest place, so that one is enough if it is as large as all.
    Cubes(const std::vector<Vec>& places, int side) : side_(static_cast<float>(side)), low_(places.front().array()) {
        Eigen::Array3f high = low_;
        for (const Vec& place : places) {
            low_ = low_.min(place.array());
            high = high.max(place.array());
        }
        const Eigen::Array3d sizes = ((high - low_) / side_).floor().cast<double>() + 1;
        if (sizes.prod() > kCubesToACatom * static_cast<double>(places.size())) return;
        sizes_ = sizes.cast<std::uint64_t>();
        table_.resize(static_cast<std::size_t>(sizes.prod()), kNone);
    }
    // It is kNone at first.
    std::uint32_t& ball_at(const Vec& place) {
        const Eigen::Array<std::uint64_t, 3, 1> at = ((place.array() - low_) / side_).cast<std::uint64_t>();
        if (!table_.empty()) return table_[at.x() + sizes_.x() * (at.y() + sizes_.y() * at.z())];
        return apart_.try_emplace((at.x() & kMask) << 42 | (at.y() & kMask) << 21 | (at.z() & kMask), kNone).first->second;
    }

  private:
    static constexpr double kCubesToACatom = 8;
    static constexpr std::uint64_t kMask = (1 << 21) - 1;
    float side_;
    Eigen::Array3f low_;
    Eigen::Array<std::uint64_t, 3, 1> sizes_;
    std::vector<std::uint32_t> table_;
    std::unordered_map<std::uint64_t, std::uint32_t> apart_;
};

std::vector<Cover> leave_out_hidden(picture::Frame& frame) {
    const Scene& scene = frame.scene;
    // Smaller ones can be seen between.
    const std::optional<render::Cells> cells =
        scene.diameters.empty() && !scene.ways.empty() ? render::Cells::of(scene, scene.ways) : std::nullopt;
    if (!cells) return {};
    const int seen = layers_seen(scene.form);
    const std::vector<std::uint8_t> depths = cells->depths(seen + 1);
    std::vector<std::size_t> kept;
    std::vector<Cover> covers;
    for (std::size_t i = 0; i < depths.size(); ++i) {
        if (depths[i] > seen) continue;
        kept.push_back(i);
        covers.push_back(cover_of(scene.ways, [&](std::size_t way) { return cells->has_next(i, way); }));
    }
    keep(frame, kept);
    return covers;
}

}  // namespace

int layers_seen(render::Form form) { return form == render::Form::Cube ? 0 : kSeenThrough; }

Balls::Balls(const Scene& scene, std::span<const Cover> covers, std::size_t most) {
    ball_of_.resize(scene.places.size());
    do {
        first_.clear();
        Cubes cubes(scene.places, ++side_);
        for (std::size_t i = 0; i < scene.places.size(); ++i) {
            std::uint32_t& ball = cubes.ball_at(scene.places[i]);
            if (ball == Cubes::kNone) {
                ball = static_cast<std::uint32_t>(first_.size());
                first_.push_back(i);
            }
            ball_of_[i] = ball;
        }
    } while (first_.size() > most);
    collect(scene, covers);
}

// Places and covers do not change while catoms stay where they are.
void Balls::collect(const Scene& scene, std::span<const Cover> covers) {
    std::vector<Eigen::Array3d> places(first_.size(), Eigen::Array3d::Zero());
    std::vector<Eigen::Array4d> covered(first_.size(), Eigen::Array4d::Zero());
    counts_.assign(first_.size(), 0);
    for (std::size_t i = 0; i < ball_of_.size(); ++i) {
        const std::uint32_t ball = ball_of_[i];
        ++counts_[ball];
        places[ball] += scene.places[i].cast<double>().array();
        if (!covers.empty()) covered[ball] += Eigen::Array4d(covers[i][0], covers[i][1], covers[i][2], covers[i][3]);
    }
    covers_.resize(first_.size());
    for (std::size_t ball = 0; ball < first_.size(); ++ball) {
        const double count = counts_[ball];
        places_.emplace_back((places[ball] / count).cast<float>().matrix());
        for (int part = 0; part < 4; ++part)
            covers_[ball][static_cast<std::size_t>(part)] = static_cast<std::int8_t>(std::lround(covered[ball][part] / count));
    }
}

void Balls::put(picture::Frame& frame) const {
    Scene& scene = frame.scene;
    // Sums of whole numbers, in whichever order.
    std::vector<std::array<std::uint64_t, 3>> sums(first_.size());
    for (std::size_t i = 0; i < ball_of_.size(); ++i) {
        const render::Rgb colour = scene.colours[i];
        std::array<std::uint64_t, 3>& sum = sums[ball_of_[i]];
        sum[0] += colour.r, sum[1] += colour.g, sum[2] += colour.b;
    }
    // Those of one of many say nothing about a ball.
    frame.numbers.clear();
    frame.words.clear();
    keep(frame, first_);
    scene.diameters.assign(first_.size(), static_cast<float>(side_));
    scene.rounded.clear();
    scene.places = places_;
    for (std::size_t ball = 0; ball < first_.size(); ++ball) {
        const auto mean = [&](std::uint64_t sum) {
            return static_cast<std::uint8_t>(std::lround(static_cast<double>(sum) / counts_[ball]));
        };
        scene.colours[ball] = {mean(sums[ball][0]), mean(sums[ball][1]), mean(sums[ball][2])};
    }
}

Thinned thin(picture::Frame& frame, std::size_t most) {
    Thinned out;
    if (frame.scene.places.size() <= most) return out;
    out.covers = leave_out_hidden(frame);
    if (frame.scene.places.size() <= most) return out;
    const Balls balls(frame.scene, out.covers, most);
    balls.put(frame);
    out.covers.assign(balls.covers().begin(), balls.covers().end());
    out.coarse = balls.coarse();
    return out;
}

}  // namespace meld::view
