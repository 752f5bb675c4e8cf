#include "runtime/driver/pictures/picture_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <limits>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

#include "runtime/base/units.h"
#include "runtime/show/library/view_library.h"
#include "runtime/show/picture/film_file.h"
#include "runtime/show/picture/model_file.h"

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

Result<double> parse_signed(const std::string& text) {
    const bool negative = text.starts_with('-');
    return parse_number(negative ? text.substr(1) : text).map([&](double x) { return negative ? -x : x; });
}

Result<std::optional<std::pair<double, double>>> parse_range(const std::string& text) {
    if (text.empty()) return std::nullopt;
    const std::size_t colon = text.find(':');
    const auto low = parse_signed(text.substr(0, colon));
    const auto high = colon == std::string::npos ? low : parse_signed(text.substr(colon + 1));
    if (!low || !high || !(*low < *high)) return fail(fmt::format("--range: '{}' is no range", text), "Write LOW:HIGH, as in 0:50");
    return std::pair(*low, *high);
}

Result<std::optional<render::Form>> parse_form(const std::string& text) {
    if (text.empty()) return std::nullopt;
    if (const auto form = render::form_named(text)) return form;
    return fail(fmt::format("--form: '{}' is none", text), "Write sphere, cube, rounded, disc or hexagon");
}

Result<picture::Callout> parse_callout(const std::string& text) {
    if (!text.starts_with('@')) return picture::Callout{.body = text};
    const std::size_t equals = text.find('=');
    const std::string name = text.substr(0, equals);
    const auto id = parse_count(name.substr(1));
    if (!id || equals + 1 == text.size())
        return fail(fmt::format("--callout: '{}' is no callout", text),
                    "Write @12, @12='the source', or a body in Meld, as in 'leader(A), T = \"leader\"'");
    return picture::Callout{.catom = *id, .text = equals == std::string::npos ? name : text.substr(equals + 1)};
}

Result<std::optional<render::Rgb>> parse_background(const std::string& text) {
    if (text == "transparent") return std::nullopt;
    const auto colour = render::parse_colour(text);
    if (!colour) return fail(fmt::format("--background: '{}' is no colour", text), "Write #RRGGBB, white, black, grey or transparent");
    return colour;
}

Result<std::int64_t> parse_tick(const std::string& option, const std::string& text) {
    const auto number = text == "end" ? Result<std::uint64_t>(0) : parse_count(text);
    if (!number || *number >= static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()))
        return fail(fmt::format("{}: '{}' is no tick", option, text),
                    option == "--tick" ? "Write whole numbers or end, as in 0,20,end" : "Write a whole number or end");
    return text == "end" ? kEnd : static_cast<std::int64_t>(*number);
}

Result<void> within(const char* option, double value, double least, double most) {
    if (value >= least && value <= most) return {};
    return fail(fmt::format("{}: {} is not from {} to {}", option, value, least, most));
}

Result<picture::CameraPath::Key> parse_key(const std::string& text) {
    std::vector<std::string> parts = {""};
    for (const char c : text)
        if (c == ',')
            parts.emplace_back();
        else
            parts.back() += c;
    const auto bad = fail(fmt::format("--key: '{}' is no place of the camera", text),
                          "Write TICK,AZIMUTH,ELEVATION or TICK,AZIMUTH,ELEVATION,ZOOM, as in 20,-60,25,1.5");
    if (parts.size() != 3 && parts.size() != 4) return bad;
    const auto tick = parse_count(parts[0]);
    const auto azimuth = parse_signed(parts[1]), elevation = parse_signed(parts[2]);
    const auto zoom = parts.size() == 4 ? parse_number(parts[3]) : Result<double>(1);
    if (!tick || *tick >= static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()) || !azimuth || !elevation || !zoom)
        return bad;
    for (const auto& check : {within("--key: azimuth", *azimuth, -1e6, 1e6), within("--key: elevation", *elevation, -90, 90),
                              within("--key: zoom", *zoom, 1e-3, 1e6)})
        if (!check) return tl::unexpected<Error>(check.error());
    return picture::CameraPath::Key{static_cast<std::int64_t>(*tick), *azimuth, *elevation, *zoom};
}

Result<void> check(const MovieOptions& movie, const PictureOptions& options) {
    for (const auto& fits : {within("--fps", movie.fps, 0.1, 240), within("--seconds", movie.seconds.value_or(kMovieSeconds), 0.1, 1e5),
                             within("--hold", movie.hold, 0, 1e5), within("--turn", movie.turn, -1e6, 1e6)})
        if (!fits) return fits;
    if (const auto orders = movie_of(movie); !orders) return tl::unexpected<Error>(orders.error());
    if (!picture::FilmFile::is_folder(options.file) && options.background == "transparent")
        return fail("--background: a film has no transparent one", "Choose a colour, or write -o FOLDER/ for numbered pictures");
    return parse_size(options.size).and_then([&](Size size) { return picture::FilmFile::check(options.file, size.width, size.height); });
}

}  // namespace

Result<std::vector<std::int64_t>> ticks_of(const std::vector<std::string>& texts) {
    std::vector<std::int64_t> out;
    for (const std::string& text : texts) {
        const Result<std::int64_t> tick = parse_tick("--tick", text);
        if (!tick) return tl::unexpected<Error>(tick.error());
        out.push_back(*tick);
    }
    if (out.empty()) out.push_back(kEnd);
    return out;
}

std::vector<std::size_t> order_of(const std::vector<std::int64_t>& ticks, bool at_checkpoint) {
    std::vector<std::size_t> order(ticks.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, [&](std::size_t i) {
        // Where a checkpoint is, is its first tick; where a run ends, its last.
        return ticks[i] != kEnd || at_checkpoint ? ticks[i] : std::numeric_limits<std::int64_t>::max();
    });
    return order;
}

Result<MovieOrders> movie_of(const MovieOptions& options) {
    MovieOrders out;
    for (const auto& [name, text, tick] : {std::tuple("--from", &options.from, &out.from), std::tuple("--to", &options.to, &out.to)}) {
        if (text->empty()) continue;
        const Result<std::int64_t> parsed = parse_tick(name, *text);
        if (!parsed) return tl::unexpected<Error>(parsed.error());
        *tick = *parsed;
    }
    if (out.from && out.to && *out.to != kEnd && (*out.from == kEnd || *out.to < *out.from))
        return fail(fmt::format("--to: tick {} is before {}, where the film begins", options.to,
                                *out.from == kEnd ? "the end" : "tick " + options.from),
                    "Write a later tick");
    for (const std::string& text : options.keys) {
        const auto key = parse_key(text);
        if (!key) return tl::unexpected<Error>(key.error());
        out.keys.push_back(*key);
    }
    std::ranges::stable_sort(out.keys, {}, &picture::CameraPath::Key::tick);
    const auto twice = std::ranges::adjacent_find(out.keys, {}, &picture::CameraPath::Key::tick);
    if (twice != out.keys.end()) return fail(fmt::format("--key: there are two for tick {}", twice->tick), "Leave out one of them");
    return out;
}

Result<picture::Look> look_of(const PictureOptions& options) {
    const auto range = parse_range(options.range);
    if (!range) return tl::unexpected<Error>(range.error());
    const auto form = parse_form(options.form);
    if (!form) return tl::unexpected<Error>(form.error());
    const auto map = render::ColourMap::named(options.map);
    if (!map)
        return fail(fmt::format("--map: there is no '{}'", options.map),
                    fmt::format("There are {}", fmt::join(render::ColourMap::names(), ", ")));
    if (const auto size = within("--catom-size", options.catom_size.value_or(1), 1e-3, 1); !size)
        return tl::unexpected<Error>(size.error());
    picture::Look out = {.colour = options.colour,
                         .only = options.only,
                         .hide = options.hide,
                         .links = options.links,
                         .arrows = options.arrows,
                         .labels = options.labels,
                         .map = *map,
                         .range = *range,
                         .form = *form,
                         .ground = options.ground};
    for (const std::string& text : options.callouts) {
        auto callout = parse_callout(text);
        if (!callout) return tl::unexpected<Error>(callout.error());
        out.callouts.push_back(std::move(*callout));
    }
    if (options.catom_size) out.size = static_cast<float>(*options.catom_size);
    return out;
}

Result<picture::SheetOptions> sheet_of(const PictureOptions& options, const world::World& world) {
    const Result<Size> size = parse_size(options.size);
    if (!size) return tl::unexpected<Error>(size.error());
    const auto background = parse_background(options.background);
    if (!background) return tl::unexpected<Error>(background.error());
    for (const auto& fits :
         {within("--zoom", options.zoom, 1e-3, 1e6), within("--azimuth", options.azimuth.value_or(0), -1e6, 1e6),
          within("--elevation", options.elevation.value_or(0), -90, 90), within("--angle", options.angle.value_or(0), 0, 120)})
        if (!fits) return tl::unexpected<Error>(fits.error());
    picture::SheetOptions out{.width = size->width, .height = size->height};
    const bool flat = !world.is_free() && world::Lattice(world.lattice).flat();
    if (flat) out.view = {.azimuth_deg = -90, .elevation_deg = 90, .angle_deg = 0};
    const auto set = [](float& value, const std::optional<double>& given) {
        if (given) value = static_cast<float>(*given);
    };
    set(out.view.azimuth_deg, options.azimuth);
    set(out.view.elevation_deg, options.elevation);
    set(out.view.angle_deg, options.angle);
    out.view.zoom = static_cast<float>(options.zoom);
    out.quality.samples = static_cast<std::size_t>(options.samples);
    out.quality.edges = options.edges;
    out.background = *background;
    out.title = options.title;
    out.scale = options.scale;
    out.words = !options.bare;
    // Positions are in diameters; an ensemble without physics has no size that matters.
    if (world.is_free()) out.catom_metres = 2 * world.radius;
    return out;
}

Result<std::int64_t> last_tick_of(const PictureOptions& options) {
    Result<std::int64_t> last = kEnd;
    if (const ShotOptions* const shot = std::get_if<ShotOptions>(&options.of)) {
        std::string form = std::filesystem::path(options.file).extension().string();
        std::ranges::transform(form, form.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
        if (options.file != "-" && !form.empty() && form != ".png")
            return fail(fmt::format("{}: a picture is a .png file", options.file),
                        "Write another name, as in picture.png; meldsim movie makes films, and meldsim export files for other programs");
        last = ticks_of(shot->ticks).map([](const auto& ticks) { return std::ranges::max(ticks); });
    } else if (const ExportOptions* const exported = std::get_if<ExportOptions>(&options.of)) {
        const Result<std::vector<std::int64_t>> ticks = ticks_of(exported->ticks);
        if (!ticks) return tl::unexpected<Error>(ticks.error());
        if (const auto fits = picture::ModelFile::check(options.file, ticks->size()); !fits) return tl::unexpected<Error>(fits.error());
        last = std::ranges::max(*ticks);
    } else {
        const MovieOptions& movie = std::get<MovieOptions>(options.of);
        last = movie_of(movie).map([](const MovieOrders& orders) { return orders.to.value_or(kEnd); });
        if (const auto fits = check(movie, options); !fits) return tl::unexpected<Error>(fits.error());
    }
    // Other programs draw what is exported.
    if (!std::holds_alternative<ExportOptions>(options.of))
        if (const auto there = show::need_view(); !there) return tl::unexpected<Error>(there.error());
    if (const auto look = look_of(options); !look) return tl::unexpected<Error>(look.error());
    if (const auto sheet = sheet_of(options, {}); !sheet) return tl::unexpected<Error>(sheet.error());
    return last;
}

}  // namespace meld::driver
