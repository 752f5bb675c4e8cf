#include "runtime/show/view/looks.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <utility>

namespace meld::view {

namespace {

constexpr double kFar = 1e9;  // No world is so large, in diameters.

Result<std::optional<picture::Cut>> cut_of(const Json& json) {
    if (json.empty()) return std::nullopt;
    Fields fields(json, "cut");
    std::int64_t axis = 0;
    double at = 0;
    picture::Cut cut;
    fields.read("axis", axis, 0, 2);
    fields.read("at", at, -kFar, kFar);
    fields.read("above", cut.above);
    if (auto right = fields.done(); !right) return tl::unexpected<Error>(right.error());
    cut.axis = static_cast<int>(axis);
    cut.at = static_cast<float>(at);
    return cut;
}

}  // namespace

Result<picture::Look> look_of(const Json& json) {
    picture::Look look;
    Fields fields(json, "look");
    std::string map = "viridis";
    std::vector<double> range;
    std::optional<double> size;
    std::string form;
    const Result<std::optional<picture::Cut>> cut = cut_of(fields.object("cut"));
    fields.read("colour", look.colour);
    fields.read("only", look.only);
    fields.read("hide", look.hide);
    fields.read("links", look.links);
    fields.read("arrows", look.arrows);
    fields.read("labels", look.labels);
    fields.read("exposed", look.exposed);
    fields.read("form", form);
    fields.read("map", map);
    fields.read("range", range, 2, -1e300, 1e300);
    fields.read("size", size, 1e-3, 1);
    if (auto right = fields.done(); !right) return tl::unexpected<Error>(right.error());
    if (!cut) return tl::unexpected<Error>(cut.error());
    look.cut = *cut;
    if (!form.empty()) {
        look.form = render::form_named(form);
        if (!look.form)
            return fail(fmt::format("look: there is no form \"{}\"", form),
                        fmt::format("There are {}", fmt::join(render::kFormNames, ", ")));
    }
    const auto known = render::ColourMap::named(map);
    if (!known)
        return fail(fmt::format("look: there is no map \"{}\"", map),
                    fmt::format("There are {}", fmt::join(render::ColourMap::names(), ", ")));
    look.map = *known;
    if (!range.empty()) {
        if (!(range[0] < range[1])) return fail(fmt::format("look: the range begins at {} and ends at {}", range[0], range[1]));
        look.range = std::pair(range[0], range[1]);
    }
    if (size) look.size = static_cast<float>(*size);
    return look;
}

Result<picture::SheetOptions> sheet_of(const Json& camera, const std::vector<double>& size, bool flat) {
    // The page has its own background, light or dark.
    picture::SheetOptions sheet{.background = std::nullopt, .words = false};
    if (!size.empty()) {
        sheet.width = static_cast<std::size_t>(size[0]);
        sheet.height = static_cast<std::size_t>(size[1]);
    }
    if (flat) sheet.view = {.azimuth_deg = -90, .elevation_deg = 90, .angle_deg = 0};
    Fields fields(camera, "camera");
    std::optional<double> azimuth, elevation, angle, zoom, height;
    std::vector<double> target;
    fields.read("azimuth", azimuth, -1e6, 1e6);
    fields.read("elevation", elevation, -90, 90);
    fields.read("angle", angle, 0, 120);
    fields.read("zoom", zoom, 1e-3, 1e6);
    fields.read("target", target, 3, -kFar, kFar);
    fields.read("height", height, 1e-3, kFar);
    if (auto right = fields.done(); !right) return tl::unexpected<Error>(right.error());
    for (const auto& [value, given] : {std::pair(&sheet.view.azimuth_deg, azimuth), std::pair(&sheet.view.elevation_deg, elevation),
                                       std::pair(&sheet.view.angle_deg, angle), std::pair(&sheet.view.zoom, zoom)})
        if (given) *value = static_cast<float>(*given);
    if (target.empty() != !height) return fail("camera: \"target\" and \"height\" belong together");
    if (height) {
        const auto at = [&](std::size_t i) { return static_cast<float>(target[i]); };
        sheet.aim = render::Aim{.target = {at(0), at(1), at(2)}, .half_height = static_cast<float>(*height)};
    }
    return sheet;
}

}  // namespace meld::view
