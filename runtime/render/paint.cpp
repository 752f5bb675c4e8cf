#include "runtime/render/paint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>
#include <utility>

namespace meld::render {

namespace {

constexpr std::size_t kTile = 16;  // Pixels along the side of what one worker paints at a time.

// The light that a place gets: from the sky, if nothing is in the way, and from the sun, if it is seen straight on.
constexpr float kSky = 0.66F, kSun = 0.48F;
// Of the sky's light this much comes into the deepest corner.
constexpr float kLeast = 0.3F;
// Pixels to a catom from which on flat ones that touch have a line between them.
constexpr float kOutlined = 8;
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
    Painter(const Scene& scene, const Geometry& geometry, const Camera& camera, const Quality& quality)
        : scene_(scene),
          geometry_(geometry),
          camera_(camera),
          quality_(quality),
          sun_((Vec::UnitZ() * 0.9F - camera.right() * 0.5F - camera.forward() * 0.45F).normalized()),
          reach_(std::max(4.0F, 0.2F * camera.extent())) {
        across_sun_ = beside(sun_);
    }

    struct Seen {
        Eigen::Array4f light = Eigen::Array4f::Zero();  // Red, green and blue, times how much of the pixel they fill; and that.
        float distance = std::numeric_limits<float>::infinity();
        std::uint32_t thing = 0;  // At that distance.
    };
    Seen pixel(std::size_t x, std::size_t y) const {
        const std::size_t side = quality_.samples, count = side * side;
        const Spread spread(x, y, count * quality_.sky);
        Seen out;
        for (std::size_t i = 0; i < count; ++i) {
            const auto within = [&](std::size_t at, std::size_t step) {
                return static_cast<float>(at) + (static_cast<float>(step) + 0.5F) / static_cast<float>(side);
            };
            const Camera::Ray ray = camera_.ray(within(x, i % side), within(y, i / side));
            const auto hit = geometry_.hit(ray.from, ray.along);
            if (hit) {
                if (hit->distance < out.distance) std::tie(out.distance, out.thing) = std::pair(hit->distance, hit->thing);
                const Vec at = ray.from + hit->distance * ray.along + kOff * hit->normal;
                out.light.head<3>() += linear(hit->colour) * light(at, hit->normal, spread, i);
                out.light.w() += 1;
            } else if (scene_.ground) {
                out.light.w() += shade_of_floor(ray, spread, i);
            }
        }
        out.light /= static_cast<float>(count);
        return out;
    }

  private:
    // The share of the sky that a place sees.
    float sky(const Vec& at, const Vec& normal, const Spread& spread, std::size_t sample) const {
        const auto [u, v] = beside(normal);
        std::size_t free = 0;
        for (std::size_t i = 0; i < quality_.sky; ++i) {
            const Spread::Pair pair = spread.at(sample * quality_.sky + i);
            const float radius = std::sqrt(pair.u), angle = 2 * std::numbers::pi_v<float> * pair.v;
            const Vec along = radius * std::cos(angle) * u + radius * std::sin(angle) * v + std::sqrt(1 - pair.u) * normal;
            free += geometry_.meets(at, along, reach_) ? 0 : 1;
        }
        return static_cast<float>(free) / static_cast<float>(quality_.sky);
    }
    bool sees_sun(const Vec& at, const Spread& spread, std::size_t sample) const {
        const Spread::Pair pair = spread.at(sample * quality_.sky);
        const Vec along = sun_ + kSunWidth * ((2 * pair.v - 1) * across_sun_[0] + (2 * pair.u - 1) * across_sun_[1]);
        return !geometry_.meets(at, along.normalized(), std::numeric_limits<float>::infinity());
    }
    float light(const Vec& at, const Vec& normal, const Spread& spread, std::size_t sample) const {
        const float above = kSky * (kLeast + (1 - kLeast) * sky(at, normal, spread, sample)) * (0.85F + 0.15F * normal.z());
        const float facing = normal.dot(sun_);
        return above + (facing > 0 && sees_sun(at, spread, sample) ? kSun * facing : 0);
    }
    // How dark a floor is that is seen only where it is in the shade.
    float shade_of_floor(const Camera::Ray& ray, const Spread& spread, std::size_t sample) const {
        const float way = (*scene_.ground - ray.from.z()) / ray.along.z();
        if (!(way > 0) || !std::isfinite(way)) return 0;
        const Vec at = ray.from + way * ray.along + kOff * Vec::UnitZ();
        const float whole = kSky + kSun * sun_.z();
        const float here = kSky * sky(at, Vec::UnitZ(), spread, sample) + (sees_sun(at, spread, sample) ? kSun * sun_.z() : 0);
        return 0.75F * (1 - here / whole);
    }

    const Scene& scene_;
    const Geometry& geometry_;
    const Camera& camera_;
    const Quality& quality_;
    Vec sun_;
    std::array<Vec, 2> across_sun_;
    float reach_;  // How far away what darkens a place may be.
};

// Lines at the edges of things, which make a pixel darker.
class Edges {
  public:
    Edges(const std::vector<Painter::Seen>& seen, std::size_t width, std::size_t height, bool flat)
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
    const Painter painter(scene, geometry, camera, quality);
    std::vector<Painter::Seen> seen(width * height);
    Painted out{.image = {.width = width, .height = height}, .distances = std::vector<float>(width * height)};
    const std::size_t across = (width + kTile - 1) / kTile, tiles = across * ((height + kTile - 1) / kTile);
    workers.run(tiles, [&](int, std::size_t tile) {
        const std::size_t left = tile % across * kTile, top = tile / across * kTile;
        for (std::size_t y = top; y < std::min(top + kTile, height); ++y)
            for (std::size_t x = left; x < std::min(left + kTile, width); ++x) {
                seen[y * width + x] = painter.pixel(x, y);
                out.distances[y * width + x] = seen[y * width + x].distance;
            }
    });
    const bool flat = (scene.form == Form::Hexagon || scene.form == Form::Cube) && camera.scale() >= kOutlined;
    const Edges edges(seen, width, height, flat);
    const Eigen::Array3f behind = background ? linear(*background) : Eigen::Array3f::Zero().eval();
    out.image.pixels.resize(width * height);
    workers.run(height, [&](int, std::size_t y) {
        for (std::size_t x = 0; x < width; ++x) {
            Eigen::Array4f light = seen[y * width + x].light;
            light.head<3>() *= edges.at(x, y);
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
