#include "runtime/driver/shot.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <string_view>
#include <tuple>
#include <utility>

#include "runtime/base/interrupt.h"
#include "runtime/base/output_file.h"
#include "runtime/base/parallel_for.h"
#include "runtime/base/progress.h"
#include "runtime/base/standard_streams.h"
#include "runtime/base/units.h"
#include "runtime/comm/outcome.h"
#include "runtime/driver/report.h"
#include "runtime/picture/frame.h"
#include "runtime/picture/sheet.h"
#include "runtime/render/image.h"

namespace meld::driver {

namespace {

constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 28;  // Two GiB while it is painted.

struct Size {
    std::size_t width = 0, height = 0;
};

Result<Size> parse_size(const std::string& text) {
    const std::size_t by = text.find('x');
    const auto width = parse_count(text.substr(0, by));
    const auto height = by == std::string::npos ? width : parse_count(text.substr(by + 1));
    if (by == std::string::npos || !width || !height || *width < 16 || *height < 16 || *width > 32767 || *height > 32767 ||
        *width * *height > kMostPixels)
        return fail(fmt::format("--size: '{}' is no size of a picture", text),
                    "Write width and height in pixels, from 16x16 to 32767x8192, as in 1280x720");
    return Size{*width, *height};
}

Result<std::optional<std::pair<double, double>>> parse_range(const std::string& text) {
    if (text.empty()) return std::nullopt;
    const std::size_t colon = text.find(':');
    const auto read = [](const std::string& part) -> Result<double> {
        const bool negative = part.starts_with('-');
        return parse_number(negative ? part.substr(1) : part).map([&](double x) { return negative ? -x : x; });
    };
    const auto low = read(text.substr(0, colon));
    const auto high = colon == std::string::npos ? low : read(text.substr(colon + 1));
    if (!low || !high || !(*low < *high)) return fail(fmt::format("--range: '{}' is no range", text), "Write LOW:HIGH, as in 0:50");
    return std::pair(*low, *high);
}

Result<std::optional<render::Form>> parse_form(const std::string& text) {
    using Form = render::Form;
    if (text.empty()) return std::nullopt;
    for (const auto& [name, form] : {std::pair("sphere", Form::Sphere), std::pair("cube", Form::Cube), std::pair("disc", Form::Disc),
                                     std::pair("hexagon", Form::Hexagon)})
        if (text == name) return form;
    return fail(fmt::format("--form: '{}' is none", text), "Write sphere, cube, disc or hexagon");
}

Result<std::optional<render::Rgb>> parse_background(const std::string& text) {
    if (text == "transparent") return std::nullopt;
    const auto colour = render::parse_colour(text);
    if (!colour) return fail(fmt::format("--background: '{}' is no colour", text), "Write #RRGGBB, white, black, grey or transparent");
    return colour;
}

// -1 for the end.
Result<std::vector<std::int64_t>> parse_ticks(const std::vector<std::string>& texts) {
    std::vector<std::int64_t> out;
    for (const std::string& text : texts) {
        const auto number = text == "end" ? Result<std::uint64_t>(0) : parse_count(text);
        if (!number || *number >= static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()))
            return fail(fmt::format("--tick: '{}' is no tick", text), "Write whole numbers or end, as in 0,20,end");
        out.push_back(text == "end" ? -1 : static_cast<std::int64_t>(*number));
    }
    if (out.empty()) out.push_back(-1);
    return out;
}

// What of a run is shown, and how the picture is made.
struct Orders {
    std::vector<std::int64_t> ticks;
    picture::Look look;
    picture::SheetOptions sheet;
};

Result<Orders> orders(const ShotOptions& shot) {
    Orders out;
    const auto ticks = parse_ticks(shot.ticks);
    if (!ticks) return tl::unexpected<Error>(ticks.error());
    out.ticks = *ticks;
    const Result<Size> size = parse_size(shot.size);
    if (!size) return tl::unexpected<Error>(size.error());
    const auto range = parse_range(shot.range);
    if (!range) return tl::unexpected<Error>(range.error());
    const auto form = parse_form(shot.form);
    if (!form) return tl::unexpected<Error>(form.error());
    const auto background = parse_background(shot.background);
    if (!background) return tl::unexpected<Error>(background.error());
    const auto map = render::ColourMap::named(shot.map);
    if (!map)
        return fail(fmt::format("--map: there is no '{}'", shot.map),
                    fmt::format("There are {}", fmt::join(render::ColourMap::names(), ", ")));
    for (const auto& [option, value, least, most] :
         {std::tuple("--zoom", shot.zoom, 1e-3, 1e6), std::tuple("--catom-size", shot.catom_size.value_or(1), 1e-3, 1.0),
          std::tuple("--azimuth", shot.azimuth.value_or(0), -1e6, 1e6), std::tuple("--elevation", shot.elevation.value_or(0), -90.0, 90.0),
          std::tuple("--angle", shot.angle.value_or(0), 0.0, 120.0)})
        if (!(value >= least && value <= most)) return fail(fmt::format("{}: {} is not from {} to {}", option, value, least, most));
    out.look = {.colour = shot.colour,
                .only = shot.only,
                .hide = shot.hide,
                .links = shot.links,
                .arrows = shot.arrows,
                .labels = shot.labels,
                .map = *map,
                .range = *range,
                .form = *form,
                .ground = shot.ground};
    if (shot.catom_size) out.look.size = static_cast<float>(*shot.catom_size);
    out.sheet.width = size->width;
    out.sheet.height = size->height;
    out.sheet.columns = static_cast<std::size_t>(shot.columns);
    out.sheet.quality.samples = static_cast<std::size_t>(shot.samples);
    out.sheet.background = *background;
    out.sheet.title = shot.title;
    out.sheet.scale = shot.scale;
    out.sheet.words = !shot.bare;
    return out;
}

// From above where all is in a plane; otherwise from the side.
render::View view_of(const ShotOptions& shot, const world::World& world) {
    const bool flat = !world.is_free() && world::Lattice(world.lattice).flat();
    render::View view;
    if (flat) view = {.azimuth_deg = -90, .elevation_deg = 90, .angle_deg = 0};
    const auto set = [](float& value, const std::optional<double>& given) {
        if (given) value = static_cast<float>(*given);
    };
    set(view.azimuth_deg, shot.azimuth);
    set(view.elevation_deg, shot.elevation);
    set(view.angle_deg, shot.angle);
    view.zoom = static_cast<float>(shot.zoom);
    return view;
}

// As many as this process may use at once.
int processors() {
    const long available = sysconf(_SC_NPROCESSORS_ONLN);
    return static_cast<int>(std::clamp(available, 1L, 64L));
}

// Paints the frames and writes the picture.
Result<render::Image> paint(std::vector<picture::Frame>& frames, const ShotOptions& shot, const world::World& world, Orders& ordered,
                            OutputFile& file) {
    picture::SheetOptions& sheet = ordered.sheet;
    sheet.view = view_of(shot, world);
    // Positions are in diameters; an ensemble without physics has no size that matters.
    if (world.is_free()) sheet.catom_metres = 2 * world.radius;
    Workers workers(processors());
    Result<render::Image> image = picture::paint_sheet(frames, ordered.look, sheet, workers);
    if (!image) return image;
    if (auto written = render::write_png(*image, file); !written) return tl::unexpected<Error>(written.error());
    if (auto written = file.commit(); !written) return tl::unexpected<Error>(written.error());
    return image;
}

Result<void> go_to(std::int64_t tick, bool at_checkpoint, timeline::Timeline& timeline) {
    if (tick < 0 && at_checkpoint) return {};
    if (auto there = timeline.to(tick < 0 ? std::numeric_limits<std::int64_t>::max() : tick); !there) return there;
    if (timeline.ended() == sim::Ending::Interrupted)
        return fail(fmt::format("interrupted after tick {}", timeline.tick()), "", ExitCode::Interrupted);
    if (tick >= 0 && timeline.tick() != tick) return fail(fmt::format("the run ends with tick {}, before tick {}", timeline.tick(), tick));
    return {};
}

}  // namespace

Result<std::int64_t> last_tick_of(const ShotOptions& options) {
    return orders(options).map([](const Orders& orders) { return std::ranges::max(orders.ticks); });
}

Result<int> take_shot(const RunOptions& options, const world::World& world, comm::Communicator& comm, timeline::Timeline& timeline,
                      const std::function<record::Drawing&()>& drawing) {
    const ShotOptions& shot = *options.debug->shot;
    Result<Orders> ordered = orders(shot);
    if (!ordered) return tl::unexpected<Error>(ordered.error());
    const bool speaks = comm.process() == 0;
    // Reserved before the work begins.
    std::optional<OutputFile> file;
    Result<void> opened;
    if (speaks) opened = OutputFile::open(shot.file, Appears::Whole).map([&](OutputFile&& out) { file.emplace(std::move(out)); });
    if (const auto all = comm::outcome_of_first(comm, opened); !all) return tl::unexpected<Error>(all.error());

    std::optional<Progress> progress;
    if (speaks && !options.quiet) progress.emplace();
    Pace pace(timeline.simulation().summary());
    timeline.each([&](sim::Simulation& simulation) {
        if (interrupt::received() != 0) simulation.subdomain().request_stop();
        if (progress) progress->update([&] { return progress_line(simulation, pace, options.ticks); });
    });
    // Nothing is looked at twice: the run goes forward only.
    std::vector<std::size_t> order(ordered->ticks.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    const bool at_checkpoint = !options.resume.empty();
    std::ranges::stable_sort(order, {}, [&](std::size_t i) {
        const std::int64_t tick = ordered->ticks[i];
        // Where a checkpoint is, is its first tick; where a run ends, its last.
        return tick >= 0 || at_checkpoint ? tick : std::numeric_limits<std::int64_t>::max();
    });
    std::vector<picture::Frame> frames(speaks ? order.size() : 0);
    for (const std::size_t i : order) {
        const std::int64_t tick = ordered->ticks[i];
        if (auto there = go_to(tick, at_checkpoint, timeline); !there) return tl::unexpected<Error>(there.error());
        Result<picture::Frame> frame = picture::look_at(timeline.simulation().subdomain(), drawing(), ordered->look);
        if (!frame) return tl::unexpected<Error>(frame.error());
        if (speaks) frames[i] = std::move(*frame);
    }
    const Result<void> taken = [&]() -> Result<void> {
        if (!speaks) return {};
        if (progress) progress->update([] { return "painting"; });
        const Result<render::Image> image = paint(frames, shot, world, *ordered, *file);
        if (!image) return tl::unexpected<Error>(image.error());
        progress.reset();
        std::uint64_t shown = 0, catoms = 0;
        std::vector<std::int64_t> ticks;
        for (const picture::Frame& frame : frames) {
            if (frame.scene.places.size() >= shown) std::tie(shown, catoms) = std::pair(frame.scene.places.size(), frame.catoms);
            ticks.push_back(frame.tick);
        }
        std::FILE* const talk = shot.file == "-" ? stderr : stdout;
        if (options.json)
            return print(talk, nlohmann::ordered_json{{"file", shot.file},
                                                      {"width", image->width},
                                                      {"height", image->height},
                                                      {"ticks", ticks},
                                                      {"catoms", catoms},
                                                      {"shown", shown}}
                                       .dump() +
                                   "\n");
        if (options.quiet) return {};
        return print(
            talk, fmt::format("{}: {} x {} pixels, {} of {} catom{}, tick{} {}\n", shot.file, image->width, image->height, grouped(shown),
                              grouped(catoms), catoms == 1 ? "" : "s", ticks.size() == 1 ? "" : "s", fmt::join(ticks, ", ")));
    }();
    if (const auto all = comm::outcome_of_first(comm, taken); !all) return tl::unexpected<Error>(all.error());
    return static_cast<int>(ExitCode::Fine);
}

Result<void> check_view(const ShotOptions& options) {
    return orders(options).map([](const Orders&) {});
}

Result<void> shoot_start(const ShotOptions& shot, const world::World& world, sim::Subdomain& subdomain, record::Drawing& drawing) {
    Result<Orders> ordered = orders(shot);
    if (!ordered) return tl::unexpected<Error>(ordered.error());
    Result<OutputFile> file = OutputFile::open(shot.file, Appears::Whole);
    if (!file) return tl::unexpected<Error>(file.error());
    Result<picture::Frame> frame = picture::look_at(subdomain, drawing, ordered->look);
    if (!frame) return tl::unexpected<Error>(frame.error());
    std::vector<picture::Frame> frames;
    frames.push_back(std::move(*frame));
    const Result<render::Image> image = paint(frames, shot, world, *ordered, *file);
    if (!image) return tl::unexpected<Error>(image.error());
    return print(shot.file == "-" ? stderr : stdout, fmt::format("{}: {} x {} pixels\n", shot.file, image->width, image->height));
}

}  // namespace meld::driver
