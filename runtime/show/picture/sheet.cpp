#include "runtime/show/picture/sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "runtime/base/units.h"
#include "runtime/show/render/geometry.h"

namespace meld::picture {

namespace {

constexpr float kBorder = 0.03F;  // Around what is in a frame, as a part of it.

// The columns that leave the most room for a square in each.
std::size_t best_columns(std::size_t frames, std::size_t width, std::size_t height) {
    std::size_t best = 1, largest = 0;
    for (std::size_t columns = 1; columns <= frames; ++columns) {
        const std::size_t rows = (frames + columns - 1) / columns, side = std::min(width / columns, height / rows);
        if (side > largest) std::tie(best, largest) = std::pair(columns, side);
    }
    return best;
}

// The colour of what is behind all; transparent without one.
std::uint32_t empty_pixel(const SheetOptions& options) {
    if (!options.background) return 0;
    const auto [r, g, b] = *options.background;
    return 0xff000000U | static_cast<std::uint32_t>(r) << 16 | static_cast<std::uint32_t>(g) << 8 | b;
}

}  // namespace

void Callouts::include(const Frame& frame) {
    most_ = std::max(most_, frame.scene.callouts.size());
    for (const render::Note& note : frame.scene.callouts) widest_ = std::max(widest_, render::letters_wide(note.text));
    if (!missing_)
        missing_ = frame.missing;
    else
        std::erase_if(*missing_, [&](std::uint64_t id) { return std::ranges::find(frame.missing, id) == frame.missing.end(); });
}

Result<void> Callouts::check() const {
    if (!missing_ || missing_->empty()) return {};
    return fail(fmt::format("--callout: there is no catom @{}", missing_->front()), "`meldsim query` lists catoms and what they have");
}

Layout::Panels Layout::panels_of(std::size_t frames, const SheetOptions& options, const render::Margins& margins) {
    const auto part = [](float of, std::size_t whole) { return static_cast<std::size_t>(of * static_cast<float>(whole)); };
    Panels out{.left = part(margins.left, options.width), .top = part(margins.top, options.height)};
    const std::size_t width = options.width - out.left - part(margins.right, options.width);
    const std::size_t height = options.height - out.top - part(margins.bottom, options.height);
    out.columns = options.columns > 0 ? std::min(options.columns, frames) : best_columns(frames, width, height);
    out.width = width / out.columns;
    out.height = height / ((frames + out.columns - 1) / out.columns);
    return out;
}

Result<Layout> Layout::make(std::size_t frames, const std::optional<render::Legend>& legend, const Callouts& callouts,
                            const SheetOptions& options) {
    if (const auto known = callouts.check(); !known) return tl::unexpected<Error>(known.error());
    const render::Rgb paper = options.background.value_or(render::Rgb{255, 255, 255});
    const render::Rgb ink = render::brightness(paper) > 0.45 ? render::Rgb{51, 51, 51} : render::Rgb{235, 235, 235};
    Layout out;
    out.options_ = options;
    out.around_ = {.title = options.title, .legend = options.words ? legend : std::nullopt, .ink = ink};
    out.panels_ = panels_of(frames, options, render::margins(out.around_, options.width, options.height));
    if (out.panels_.width < 8 || out.panels_.height < 8)
        return fail(fmt::format("a picture of {} x {} pixels has no room for {} frames", options.width, options.height, frames),
                    "Raise --size, or give fewer ticks");
    out.within_ = {.line = options.words ? fmt::format("tick {}", grouped(0)) : "",
                   .catom_metres = options.catom_metres,
                   .scale = options.words && options.scale,
                   .callouts = callouts.widest(),
                   .ink = ink};
    const std::size_t room = render::room_for_callouts(out.panels_.width, out.panels_.height);
    if (callouts.most() > room)
        return fail(fmt::format("--callout: {} x {} pixels have room for {} callouts, not for {}", out.panels_.width, out.panels_.height,
                                room, callouts.most()),
                    "Raise --size, or name fewer catoms");
    out.margins_ = render::margins(out.within_, out.panels_.width, out.panels_.height);
    for (float* side : {&out.margins_.left, &out.margins_.right, &out.margins_.top, &out.margins_.bottom}) *side += kBorder;
    return out;
}

render::Camera Layout::camera(const render::View& view) const { return {view, panels_.width, panels_.height, margins_}; }

Result<render::Image> Layout::paint(std::span<const Frame> frames, const render::Camera& camera, Workers& workers) const {
    render::Painted sheet{.image = {.width = options_.width, .height = options_.height}, .distances = {}};
    sheet.image.pixels.assign(options_.width * options_.height, empty_pixel(options_));
    for (std::size_t i = 0; i < frames.size(); ++i) {
        const Frame& frame = frames[i];
        const Result<render::Geometry> geometry = render::Geometry::build(frame.scene, workers.threads());
        if (!geometry) return tl::unexpected<Error>(geometry.error());
        render::Painted painted =
            render::paint(frame.scene, *geometry, camera, panels_.width, panels_.height, options_.background, options_.quality, workers);
        render::Caption caption = within_;
        if (options_.words) caption.line = "tick " + grouped(static_cast<std::uint64_t>(frame.tick));
        render::write_over(painted, frame.scene, camera, caption);
        const std::size_t left = panels_.left + i % panels_.columns * panels_.width;
        const std::size_t top = panels_.top + i / panels_.columns * panels_.height;
        for (std::size_t y = 0; y < panels_.height; ++y)
            std::copy_n(painted.image.pixels.begin() + static_cast<std::ptrdiff_t>(y * panels_.width), panels_.width,
                        sheet.image.pixels.begin() + static_cast<std::ptrdiff_t>((top + y) * options_.width + left));
    }
    render::write_over(sheet, {}, camera, around_);
    return std::move(sheet.image);
}

Result<render::Image> paint_sheet(std::span<Frame> frames, const Look& look, const SheetOptions& options, Workers& workers) {
    Callouts callouts;
    for (const Frame& frame : frames) callouts.include(frame);
    const Result<Layout> layout = Layout::make(frames.size(), colour(frames, look), callouts, options);
    if (!layout) return tl::unexpected<Error>(layout.error());
    render::Camera camera = layout->camera(options.view);
    for (const Frame& frame : frames) camera.include(frame.scene);
    if (options.aim)
        camera.aim(*options.aim);
    else
        camera.fit();
    return layout->paint(frames, camera, workers);
}

}  // namespace meld::picture
