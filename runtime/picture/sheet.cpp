#include "runtime/picture/sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "runtime/base/units.h"
#include "runtime/render/caption.h"
#include "runtime/render/geometry.h"

namespace meld::picture {

namespace {

constexpr float kBorder = 0.03F;  // Around what is in a frame, as a part of it.

// Where frames are on a sheet, in pixels.
struct Panels {
    std::size_t left = 0, top = 0, width = 0, height = 0;  // Of the first one.
    std::size_t columns = 1;
};

// The columns that leave the most room for a square in each.
std::size_t best_columns(std::size_t frames, std::size_t width, std::size_t height) {
    std::size_t best = 1, largest = 0;
    for (std::size_t columns = 1; columns <= frames; ++columns) {
        const std::size_t rows = (frames + columns - 1) / columns, side = std::min(width / columns, height / rows);
        if (side > largest) std::tie(best, largest) = std::pair(columns, side);
    }
    return best;
}

Panels panels_of(std::size_t frames, const SheetOptions& options, const render::Margins& margins) {
    const auto part = [](float of, std::size_t whole) { return static_cast<std::size_t>(of * static_cast<float>(whole)); };
    Panels out{.left = part(margins.left, options.width), .top = part(margins.top, options.height)};
    const std::size_t width = options.width - out.left - part(margins.right, options.width);
    const std::size_t height = options.height - out.top - part(margins.bottom, options.height);
    out.columns = options.columns > 0 ? std::min(options.columns, frames) : best_columns(frames, width, height);
    out.width = width / out.columns;
    out.height = height / ((frames + out.columns - 1) / out.columns);
    return out;
}

}  // namespace

Result<render::Image> paint_sheet(std::span<Frame> frames, const Look& look, const SheetOptions& options, Workers& workers) {
    const std::optional<render::Legend> legend = colour(frames, look);
    const render::Rgb paper = options.background.value_or(render::Rgb{255, 255, 255});
    const render::Rgb ink = render::brightness(paper) > 0.45 ? render::Rgb{51, 51, 51} : render::Rgb{235, 235, 235};
    const render::Caption around{.title = options.title, .legend = options.words ? legend : std::nullopt, .ink = ink};
    const Panels panels = panels_of(frames.size(), options, render::margins(around, options.width, options.height));
    if (panels.width < 8 || panels.height < 8)
        return fail(fmt::format("a picture of {} x {} pixels has no room for {} frames", options.width, options.height, frames.size()),
                    "Raise --size, or give fewer ticks");

    const render::Caption within{.line = options.words ? fmt::format("tick {}", grouped(0)) : "",
                                 .catom_metres = options.catom_metres,
                                 .scale = options.words && options.scale,
                                 .ink = ink};
    render::Margins margins = render::margins(within, panels.width, panels.height);
    for (float* side : {&margins.left, &margins.right, &margins.top, &margins.bottom}) *side += kBorder;
    render::Camera camera(options.view, panels.width, panels.height, margins);
    for (const Frame& frame : frames) camera.include(frame.scene);
    if (options.aim)
        camera.aim(*options.aim);
    else
        camera.fit();

    const std::uint32_t empty =
        options.background ? 0xff000000U | static_cast<std::uint32_t>(paper.r) << 16 | static_cast<std::uint32_t>(paper.g) << 8 | paper.b
                           : 0;
    render::Painted sheet{.image = {.width = options.width, .height = options.height}, .distances = {}};
    sheet.image.pixels.assign(options.width * options.height, empty);
    for (std::size_t i = 0; i < frames.size(); ++i) {
        const Frame& frame = frames[i];
        const Result<render::Geometry> geometry = render::Geometry::build(frame.scene, workers.threads());
        if (!geometry) return tl::unexpected<Error>(geometry.error());
        render::Painted painted =
            render::paint(frame.scene, *geometry, camera, panels.width, panels.height, options.background, options.quality, workers);
        render::Caption caption = within;
        if (options.words) caption.line = "tick " + grouped(static_cast<std::uint64_t>(frame.tick));
        render::write_over(painted, frame.scene, camera, caption);
        const std::size_t left = panels.left + i % panels.columns * panels.width, top = panels.top + i / panels.columns * panels.height;
        for (std::size_t y = 0; y < panels.height; ++y)
            std::copy_n(painted.image.pixels.begin() + static_cast<std::ptrdiff_t>(y * panels.width), panels.width,
                        sheet.image.pixels.begin() + static_cast<std::ptrdiff_t>((top + y) * options.width + left));
    }
    render::write_over(sheet, {}, camera, around);
    return std::move(sheet.image);
}

}  // namespace meld::picture
