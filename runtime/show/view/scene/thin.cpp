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

// Of a catom among its neighbours.
Cover cover_of(const render::Cells& cells, std::span<const Vec> ways, std::size_t catom) {
    Vec sum = Vec::Zero();
    float neighbours = 0;
    for (std::size_t way = 0; way < ways.size(); ++way)
        if (cells.has_next(catom, way)) {
            sum += ways[way];
            neighbours += 1;
        }
    const float scale = 127.0F * 4 / static_cast<float>(ways.size());
    const auto part = [&](float x) { return static_cast<std::int8_t>(std::lround(std::clamp(scale * x, -127.0F, 127.0F))); };
    return {part(0.5F * sum.x()), part(0.5F * sum.y()), part(0.5F * sum.z()), part(0.25F * neighbours)};
}

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

std::vector<Cover> leave_out_hidden(picture::Frame& frame) {
    const Scene& scene = frame.scene;
    // Smaller ones can be seen between.
    const std::optional<render::Cells> cells =
        scene.diameters.empty() && !scene.ways.empty() ? render::Cells::of(scene, scene.ways) : std::nullopt;
    if (!cells) return {};
    const int seen = scene.form == render::Form::Cube ? 0 : kSeenThrough;
    const std::vector<std::uint8_t> depths = cells->depths(seen + 1);
    std::vector<std::size_t> kept;
    std::vector<Cover> covers;
    for (std::size_t i = 0; i < depths.size(); ++i) {
        if (depths[i] > seen) continue;
        kept.push_back(i);
        covers.push_back(cover_of(*cells, scene.ways, i));
    }
    keep(frame, kept);
    return covers;
}

// The ball that stands for the catoms in a cube.
struct Ball {
    std::size_t first = 0;
    double count = 0;
    Eigen::Array3d place = Eigen::Array3d::Zero(), colour = place;
    Eigen::Array4d cover = Eigen::Array4d::Zero();
};

std::vector<Ball> balls_of(const Scene& scene, std::span<const Cover> covers, int side) {
    std::vector<Ball> balls;
    std::unordered_map<std::uint64_t, std::size_t> by_cube;
    // Cubes are counted from the lowest place, so that one is enough if it is as large as all.
    Eigen::Array3f low = scene.places.front().array();
    for (const Vec& place : scene.places) low = low.min(place.array());
    for (std::size_t i = 0; i < scene.places.size(); ++i) {
        std::uint64_t cube = 0;
        for (const float along : (scene.places[i].array() - low) / static_cast<float>(side))
            cube = cube << 21 | (static_cast<std::uint64_t>(along) & 0x1fffff);
        const auto [at, fresh] = by_cube.try_emplace(cube, balls.size());
        if (fresh) balls.push_back({.first = i});
        Ball& ball = balls[at->second];
        const render::Rgb colour = scene.colours[i];
        ball.count += 1;
        ball.place += scene.places[i].cast<double>().array();
        ball.colour += Eigen::Array3d(colour.r, colour.g, colour.b);
        if (!covers.empty()) ball.cover += Eigen::Array4d(covers[i][0], covers[i][1], covers[i][2], covers[i][3]);
    }
    return balls;
}

}  // namespace

Thinned thin(picture::Frame& frame, std::size_t most) {
    Thinned out;
    Scene& scene = frame.scene;
    if (scene.places.size() <= most) return out;
    out.covers = leave_out_hidden(frame);
    if (scene.places.size() <= most) return out;
    std::vector<Ball> balls;
    do {
        ++out.coarse;
        balls = balls_of(scene, out.covers, out.coarse);
    } while (balls.size() > most);
    std::vector<std::size_t> first;
    for (const Ball& ball : balls) first.push_back(ball.first);
    keep(frame, first);
    // Those of one of many say nothing about a ball.
    frame.numbers.clear();
    frame.words.clear();
    scene.diameters.assign(balls.size(), static_cast<float>(out.coarse));
    scene.rounded.clear();
    out.covers.resize(balls.size());
    for (std::size_t i = 0; i < balls.size(); ++i) {
        const Ball& ball = balls[i];
        const auto mean = [&](double sum) { return std::lround(sum / ball.count); };
        scene.places[i] = (ball.place / ball.count).cast<float>().matrix();
        scene.colours[i] = {static_cast<std::uint8_t>(mean(ball.colour[0])), static_cast<std::uint8_t>(mean(ball.colour[1])),
                            static_cast<std::uint8_t>(mean(ball.colour[2]))};
        for (int part = 0; part < 4; ++part)
            out.covers[i][static_cast<std::size_t>(part)] = static_cast<std::int8_t>(mean(ball.cover[part]));
    }
    return out;
}

}  // namespace meld::view
