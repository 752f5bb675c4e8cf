#include "runtime/show/render/paint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "runtime/show/render/lines.h"

namespace meld::render {

namespace {

constexpr std::size_t kTile = 16;  // Pixels along the side of what one worker paints at a time.

// The light that a place gets: from the sky, if nothing is in the way, and from the sun, if it is seen straight on.
constexpr float kSky = 0.66F, kSun = 0.48F;
// Of the sky's light this much comes into the deepest corner.
constexpr float kLeast = 0.3F;
// Pixels to a catom from which on flat ones that touch have a line between them.
constexpr float kOutlined = 8;
constexpr std::size_t kLeastSky = 4;  // Rays to the sky for each pixel, at least; also where one ray goes through it.
// Of catoms with fewer pixels across, the grain of one ray to the sky from each place is not seen among their own edges.
constexpr float kGrain = 8;
constexpr float kSunWidth = 0.05F;  // Half of it, as a slope.
// Rays begin this far from what they leave, in catom diameters.
constexpr float kOff = 2e-3F;

const std::array<float, 256> kLinear = [] {
    std::array<float, 256> out{};
    for (std::size_t i = 0; i < out.size(); ++i) {
        const float c = static_cast<float>(i) / 255;
        out[i] = c <= 0.04045F ? c / 12.92F : std::pow((c + 0.055F) / 1.055F, 2.4F);
    }
    return out;
}();

Eigen::Array3f linear(Rgb c) { return {kLinear[c.r], kLinear[c.g], kLinear[c.b]}; }

std::uint32_t screen(float c) {
    const float light = std::clamp(c, 0.0F, 1.0F);
    const float out = light <= 0.0031308F ? 12.92F * light : 1.055F * std::pow(light, 1 / 2.4F) - 0.055F;
    return static_cast<std::uint32_t>(std::lround(255 * out));
}

// Of lines at edges, for so many pixels of the picture; never less than one.
float line_width(std::size_t width, std::size_t height) { return std::max(static_cast<float>(std::min(width, 2 * height)) / 800, 1.0F); }

// Numbers of a pixel that fill the square evenly: a Hammersley set, turned so that pixels side by side differ evenly too (Jimenez, "Next
// Generation Post Processing in Call of Duty", 2014: interleaved gradient noise).
class Spread {
  public:
    Spread(std::size_t x, std::size_t y, std::size_t count) : count_(count) {
        const auto turn = [&](float shift) {
            const float along = 0.06711056F * (static_cast<float>(x) + shift) + 0.00583715F * (static_cast<float>(y) + shift);
            const float spread = 52.9829189F * (along - std::floor(along));
            return spread - std::floor(spread);
        };
        turn_u_ = turn(0);
        turn_v_ = turn(47.0F);
    }
    struct Pair {
        float u, v;
    };
    Pair at(std::size_t i) const {
        std::uint32_t back = static_cast<std::uint32_t>(i);
        back = back << 16 | back >> 16;
        back = (back & 0x00ff00ff) << 8 | (back & 0xff00ff00) >> 8;
        back = (back & 0x0f0f0f0f) << 4 | (back & 0xf0f0f0f0) >> 4;
        back = (back & 0x33333333) << 2 | (back & 0xcccccccc) >> 2;
        back = (back & 0x55555555) << 1 | (back & 0xaaaaaaaa) >> 1;
        return {wrapped(static_cast<float>(i) / static_cast<float>(count_) + turn_u_), wrapped(part(back) + turn_v_)};
    }

  private:
    static float part(std::uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1p-24F; }
    static float wrapped(float x) { return x >= 1 ? x - 1 : x; }
    std::size_t count_;
    float turn_u_, turn_v_;
};

// Two directions at right angles to a third and to each other (Duff et al., "Building an Orthonormal Basis, Revisited", 2017).
std::array<Vec, 2> beside(const Vec& n) {
    const float sign = std::copysign(1.0F, n.z()), a = -1 / (sign + n.z()), b = n.x() * n.y() * a;
    return {Vec(1 + sign * n.x() * n.x() * a, sign * b, -sign * n.x()), Vec(b, sign + n.y() * n.y() * a, -n.y())};
}

class Painter {
  public:
    Painter(const Scene& scene, const Geometry& geometry, const Camera& camera, const Quality& quality, float line)
        : scene_(scene),
          geometry_(geometry),
          camera_(camera),
          quality_(quality),
          count_(quality.samples * quality.samples),
          sky_(std::max(camera.scale() < kGrain ? 1 : quality.sky, kLeastSky / count_)),
          sun_((Vec::UnitZ() * 0.9F - camera.right() * 0.5F - camera.forward() * 0.45F).normalized()),
          reach_(std::max(4.0F, 0.2F * camera.extent())) {
        across_sun_ = beside(sun_);
        if (quality.edges) lines_.emplace(geometry, camera, quality.samples, line);
    }

    struct Seen {
        Eigen::Array4f light = Eigen::Array4f::Zero();  // Red, green and blue, times how much of the pixel they fill; and that.
        float distance = std::numeric_limits<float>::infinity();
        std::uint32_t thing = 0;  // At that distance.
    };
    // What light falls on: where a ray met something, or the floor.
    struct Place {
        Vec at = Vec::Zero(), normal = Vec::UnitZ();
        std::uint32_t pixel = 0, sample = 0;
        std::optional<Rgb> colour = {};  // None: the floor.
        bool shines = false;
    };
    // Room for the rays of a tile, so that they can be followed together.
    struct Room {
        std::vector<Geometry::Ray> rays;
        std::vector<std::optional<Geometry::Hit>> hits;
        std::vector<Spread> spreads;  // Of each pixel.
        std::vector<Place> places;
        std::vector<std::uint32_t> askers;  // The place that each ray leaves.
        std::vector<std::uint8_t> met;
        std::vector<float> sky, sun;  // How much of each reaches each place.
        Lines::Room edges;
        std::vector<float> lines;  // How dark a line each ray through a pixel ends in; empty: no lines are drawn.
    };
    // The pixels from `left` and `top` on, in rows, `width` of them each.
    void tile(std::size_t left, std::size_t top, std::size_t width, std::span<Seen> out, Room& room) const {
        find_places(left, top, width, out, room);
        look_at_sun(room);
        look_at_sky(room);
        room.lines.clear();
        if (lines_) lines_->at(left, top, width, out.size() / width, room.lines, room.edges);
        for (std::size_t i = 0; i < room.places.size(); ++i) {
            const Place& place = room.places[i];
            Seen& seen = out[place.pixel];
            // What a line covers is black; so it adds to how much of the pixel is filled, and nothing to the light.
            const float line = room.lines.empty() ? 0 : std::exchange(room.lines[place.pixel * count_ + place.sample], 0);
            if (place.colour) {
                const float falls_on = place.shines ? 1 : light(place.normal, room.sky[i], room.sun[i]);
                seen.light.head<3>() += (1 - line) * linear(*place.colour) * falls_on;
                seen.light.w() += 1;
            } else {
                seen.light.w() += line + (1 - line) * shade_of_floor(room.sky[i], room.sun[i]);
            }
        }
        // Also beside things, where there is nothing.
        for (std::size_t i = 0; i < room.lines.size(); ++i) out[i / count_].light.w() += room.lines[i];
        for (Seen& seen : out) seen.light /= static_cast<float>(count_);
    }

  private:
    void find_places(std::size_t left, std::size_t top, std::size_t width, std::span<Seen> out, Room& room) const {
        const std::size_t side = quality_.samples;
        room.rays.clear();
        room.spreads.clear();
        for (std::size_t pixel = 0; pixel < out.size(); ++pixel) {
            const std::size_t x = left + pixel % width, y = top + pixel / width;
            room.spreads.emplace_back(x, y, count_ * sky_);
            for (std::size_t i = 0; i < count_; ++i) {
                const auto within = [&](std::size_t at, std::size_t step) {
                    return static_cast<float>(at) + (static_cast<float>(step) + 0.5F) / static_cast<float>(side);
                };
                const Camera::Ray ray = camera_.ray(within(x, i % side), within(y, i / side));
                room.rays.push_back({ray.from, ray.along});
            }
        }
        geometry_.hits(room.rays, room.hits);
        room.places.clear();
        for (std::size_t i = 0; i < room.rays.size(); ++i) {
            const Geometry::Ray& ray = room.rays[i];
            Place place;
            place.pixel = static_cast<std::uint32_t>(i / count_);
            place.sample = static_cast<std::uint32_t>(i % count_);
            if (const auto& hit = room.hits[i]) {
                Seen& seen = out[place.pixel];
                if (hit->distance < seen.distance) std::tie(seen.distance, seen.thing) = std::pair(hit->distance, hit->thing);
                place.at = ray.from + hit->distance * ray.along + kOff * hit->normal;
                place.normal = hit->normal;
                place.colour = hit->colour;
                place.shines = hit->shines;
            } else {
                const float way = scene_.ground ? (*scene_.ground - ray.from.z()) / ray.along.z() : -1;
                if (!(way > 0) || !std::isfinite(way)) continue;
                place.at = ray.from + way * ray.along + kOff * place.normal;
            }
            room.places.push_back(place);
        }
    }
    void look_at_sun(Room& room) const {
        room.rays.clear();
        room.askers.clear();
        for (std::size_t i = 0; i < room.places.size(); ++i) {
            const Place& place = room.places[i];
            if (place.normal.dot(sun_) <= 0) continue;
            const Spread::Pair pair = room.spreads[place.pixel].at(place.sample * sky_);
            const Vec along = sun_ + kSunWidth * ((2 * pair.v - 1) * across_sun_[0] + (2 * pair.u - 1) * across_sun_[1]);
            room.rays.push_back({place.at, along.normalized()});
            room.askers.push_back(static_cast<std::uint32_t>(i));
        }
        geometry_.meets(room.rays, std::numeric_limits<float>::infinity(), room.met);
        room.sun.assign(room.places.size(), 0);
        for (std::size_t i = 0; i < room.met.size(); ++i) room.sun[room.askers[i]] = room.met[i] != 0 ? 0.0F : 1.0F;
    }
    // The share of the sky that a place sees.
    void look_at_sky(Room& room) const {
        room.rays.clear();
        for (const Place& place : room.places) {
            const auto [u, v] = beside(place.normal);
            const Spread& numbers = room.spreads[place.pixel];
            for (std::size_t i = 0; i < sky_; ++i) {
                const Spread::Pair pair = numbers.at(place.sample * sky_ + i);
                const float radius = std::sqrt(pair.u), angle = 2 * std::numbers::pi_v<float> * pair.v;
                room.rays.push_back(
                    {place.at, radius * std::cos(angle) * u + radius * std::sin(angle) * v + std::sqrt(1 - pair.u) * place.normal});
            }
        }
        geometry_.meets(room.rays, reach_, room.met);
        room.sky.assign(room.places.size(), 0);
        for (std::size_t i = 0; i < room.met.size(); ++i) room.sky[i / sky_] += room.met[i] != 0 ? 0.0F : 1.0F / static_cast<float>(sky_);
    }
    float light(const Vec& normal, float sky, float sun) const {
        const float above = kSky * (kLeast + (1 - kLeast) * sky) * (0.85F + 0.15F * normal.z());
        return above + sun * kSun * std::max(normal.dot(sun_), 0.0F);
    }
    // How dark a floor is that is seen only where it is in the shade.
    float shade_of_floor(float sky, float sun) const {
        const float whole = kSky + kSun * sun_.z();
        return 0.75F * (1 - (kSky * sky + sun * kSun * sun_.z()) / whole);
    }

    const Scene& scene_;
    const Geometry& geometry_;
    const Camera& camera_;
    const Quality& quality_;
    std::size_t count_, sky_;  // Of rays through a pixel, and of those to the sky from where each of them ends.
    Vec sun_;
    std::array<Vec, 2> across_sun_;
    std::optional<Lines> lines_;
    float reach_;  // How far away what darkens a place may be.
};

// What makes it easier to see what is in front, without lines: pixels at its rim are darker.
class Rims {
  public:
    Rims(const std::vector<Painter::Seen>& seen, std::size_t width, std::size_t height, bool flat)
        : seen_(seen), width_(width), height_(height), flat_(flat) {}

    // What is left of a pixel's light.
    float at(std::size_t x, std::size_t y) const {
        const Painter::Seen& here = seen_[y * width_ + x];
        if (!std::isfinite(here.distance)) return 1;
        float behind = 0;
        bool other = false;
        const auto look = [&](std::size_t u, std::size_t v) {
            const Painter::Seen& there = seen_[v * width_ + u];
            behind = std::max(behind, there.distance - here.distance);
            other |= there.thing < here.thing;
        };
        if (x > 0) look(x - 1, y);
        if (x + 1 < width_) look(x + 1, y);
        if (y > 0) look(x, y - 1);
        if (y + 1 < height_) look(x, y + 1);
        return (1 - 0.45F * std::clamp((behind - 1.2F) / 2, 0.0F, 1.0F)) * (flat_ && other ? 0.72F : 1);
    }

  private:
    const std::vector<Painter::Seen>& seen_;
    std::size_t width_, height_;
    bool flat_;  // Things side by side are told apart too.
};

}  // namespace

Painted paint(const Scene& scene, const Geometry& geometry, const Camera& camera, std::size_t width, std::size_t height,
              std::optional<Rgb> background, const Quality& quality, Workers& workers) {
    const Painter painter(scene, geometry, camera, quality, line_width(width, height));
    std::vector<Painter::Seen> seen(width * height);
    Painted out{.image = {.width = width, .height = height}, .distances = std::vector<float>(width * height)};
    const std::size_t across = (width + kTile - 1) / kTile, tiles = across * ((height + kTile - 1) / kTile);
    struct Worker {
        Painter::Room room;
        std::vector<Painter::Seen> seen;
    };
    std::vector<Worker> rooms(static_cast<std::size_t>(workers.threads()));
    workers.run(tiles, [&](int worker, std::size_t tile) {
        Worker& own = rooms[static_cast<std::size_t>(worker)];
        const std::size_t left = tile % across * kTile, top = tile / across * kTile;
        const std::size_t row = std::min(kTile, width - left), rows = std::min(kTile, height - top);
        own.seen.assign(row * rows, {});
        painter.tile(left, top, row, own.seen, own.room);
        for (std::size_t i = 0; i < own.seen.size(); ++i) {
            const std::size_t pixel = (top + i / row) * width + left + i % row;
            seen[pixel] = own.seen[i];
            out.distances[pixel] = own.seen[i].distance;
        }
    });
    const bool flat = (scene.form == Form::Hexagon || scene.form == Form::Cube) && camera.scale() >= kOutlined;
    const Rims rims(seen, width, height, flat);
    const Eigen::Array3f behind = background ? linear(*background) : Eigen::Array3f::Zero().eval();
    out.image.pixels.resize(width * height);
    workers.run(height, [&](int, std::size_t y) {
        for (std::size_t x = 0; x < width; ++x) {
            Eigen::Array4f light = seen[y * width + x].light;
            if (!quality.edges) light.head<3>() *= rims.at(x, y);
            if (background) light.head<3>() += (1 - light.w()) * behind;
            const float alpha = background ? 1 : light.w();
            std::uint32_t pixel = static_cast<std::uint32_t>(std::lround(255 * alpha));
            for (int i = 0; i < 3; ++i) {
                // Screens mix colours as they show them.
                const float colour = alpha > 0 ? light[i] / alpha : 0;
                pixel = pixel << 8 | static_cast<std::uint32_t>(std::lround(static_cast<float>(screen(colour)) * alpha));
            }
            out.image.pixels[y * width + x] = pixel;
        }
    });
    return out;
}

}  // namespace meld::render
