#include "runtime/driver/session/view_world.h"

#include <fmt/format.h>

#include <charconv>
#include <filesystem>
#include <optional>
#include <utility>

#include "runtime/base/files/input_file.h"
#include "runtime/base/files/output_file.h"
#include "runtime/driver/setup/memory_check.h"
#include "runtime/driver/setup/memory_need.h"
#include "runtime/show/picture/frame.h"
#include "runtime/show/picture/lamps.h"
#include "runtime/show/picture/obstacles.h"
#include "runtime/show/picture/stage.h"
#include "runtime/show/view/scene/block.h"
#include "runtime/sim/bodies/physics_scene.h"
#include "runtime/sim/choices.h"
#include "runtime/world/description/measure.h"
#include "runtime/world/description/populate.h"
#include "runtime/world/ensemble/target.h"
#include "runtime/world/file/world_file.h"
#include "runtime/world/shapes/nearest_cell.h"

namespace meld::driver {

namespace {

using Json = WorldTab::Json;

constexpr std::uint64_t kMostWorld_bytes = std::uint64_t{1} << 20;
// Counting is exact, and takes no more than some tenths of a second up to here.
constexpr double kMostCounted = 2e7;

Json cell(const world::Cell& at) { return {at.x, at.y, at.z}; }

// More are counted and not shown, while somebody types.
constexpr double kMostShown = 2e5;

// The catoms of a world as they would be placed, without a run.
picture::Frame preview(const world::World& world, const world::Lattice& lattice, std::uint64_t catoms) {
    picture::Frame out;
    std::vector<std::uint32_t> numbers;
    // Catoms have the numbers of a run.
    const sim::BodyMaker bodies(world, catoms);
    out.scene.compounds = picture::compounds_of(world);
    const auto put = [&](world::Cell cell, const world::Vec3& at) {
        const std::uint64_t id = out.ids.size();
        out.ids.push_back(id);
        out.scene.places.push_back(picture::vec_of(at));
        if (!world.is_free()) return;
        const render::RoundedBody body = picture::rounded_of(bodies.looks(id, cell, at));
        if (world.physics.has_forms()) out.scene.rounded.push_back(body);
        out.scene.diameters.push_back(2 * body.least());
    };
    for (const auto& [key, count] : world::count_bricks(world, lattice, 0, 1)) {
        world::cells_of_brick(world, lattice, key, numbers);
        for (const std::uint32_t number : numbers) {
            const world::Cell cell = lattice.cell_in_brick(lattice.brick_at(key), number);
            world::Vec3 at = lattice.position(cell);
            if (world.is_free())
                for (double& x : at) x *= world.physics.spacing;
            put(cell, at);
        }
    }
    for (const world::PlacedCatom& placed : world.placed) put(world::nearest_cell(placed.position), placed.position);
    if (world.is_free()) picture::add_obstacles(world, 0, out.scene);
    picture::add_lamps(world, out.scene);
    out.catoms = out.ids.size();
    out.scene.colours.resize(out.ids.size());
    out.scene.form = world.is_free() ? render::Form::Sphere : picture::form_of(world.lattice);
    return out;
}

// A message about a world begins with "path:line:column: ".
Json mistake(const Error& error, const std::string& path) {
    Json out = {{"message", error.problem}, {"hint", error.suggestion}};
    if (!error.problem.starts_with(path + ":")) return out;
    const char* at = error.problem.data() + path.size() + 1;
    const char* const end = error.problem.data() + error.problem.size();
    for (const char* key : {"line", "column"}) {
        std::uint64_t number = 0;
        const auto [rest, wrong] = std::from_chars(at, end, number);
        if (wrong != std::errc{} || rest == end || *rest != ':') return out;
        out[key] = number;
        at = rest + 1;
    }
    out["message"] = std::string(at + (at != end && *at == ' ' ? 1 : 0), end);
    return out;
}

}  // namespace

Result<view::Reply> WorldTab::file() const {
    const std::string& path = inputs_.world.path;
    std::string toml = inputs_.world.text;
    const std::string named = world_path(options_);
    if (options_.replay.empty() && !named.empty()) {
        Result<std::string> now = read_input(named, kMostWorld_bytes, InputKind::FileOrPipe);
        if (!now) return tl::unexpected<Error>(now.error());
        toml = std::move(*now);
    }
    Json out = {{"path", path}, {"toml", toml}, {"writable", options_.replay.empty() && !options_.world.empty()}};
    Result<view::Reply> checked = check(toml);
    if (!checked) return checked;
    out.update(checked->words);
    checked->words = std::move(out);
    return checked;
}

Result<view::Reply> WorldTab::check(const std::string& toml) const {
    const std::string named = world_path(options_);
    const std::string path = named.empty() ? "world.toml" : named;
    const auto invalid = [&](const Error& error) { return view::Reply{.words = {{"valid", false}, {"error", mistake(error, path)}}}; };
    Result<world::World> world = world::parse_world(toml, path);
    if (!world) return invalid(world.error());
    const Result<world::WorldSize> size = world::measure(*world);
    if (!size) return invalid(size.error());
    const world::Lattice lattice(world->lattice);
    const Result<world::Target> target = world::Target::make(*world, lattice);
    if (!target) return invalid(target.error());
    if (const auto known = sim::check_choices(inputs_.registry, *world); !known) return invalid(known.error());
    const bool exact = size->cells_estimate < kMostCounted;
    const double catoms = exact ? static_cast<double>(world::count_catoms(*world, lattice)) : size->cells_estimate;
    // Without counts it is what a run says of a world that may be too large to be counted.
    const MemoryNeed need = memory_need(*world, inputs_.info(), options_, options_.processes, {});
    const ByteRange memory = need.peak();
    Json out = {{"valid", true},
                {"lattice", world->is_free() ? "free" : std::string(world->lattice_name())},
                {"catoms", catoms},
                {"exact", exact},
                {"first", cell(size->first)},
                {"last", cell(size->last)},
                {"target", world->target ? Json(target->text()) : Json()},
                {"components", world->components},
                {"memory", {{"least", memory.least}, {"most", memory.most}, {"fits", true}, {"message", ""}}},
                {"seconds", nullptr}};
    if (const auto fits = check_memory(*world, need, options_.processes); !fits)
        out["memory"].update({{"fits", false}, {"message", fits.error().message()}});
    else
        out["memory"]["message"] = warning_of_memory(*world, need, options_.processes);
    // Of a tick in which all catoms are evaluated.
    if (const std::optional<double> each = evaluation_()) out["seconds"] = *each * catoms;
    if (world->is_graph() || !exact || catoms > kMostShown) return view::Reply{.words = std::move(out)};
    const picture::Frame seen = preview(*world, lattice, static_cast<std::uint64_t>(catoms));
    view::Reply checked{.words = view::frame_words(seen, std::nullopt), .binary = view::frame_block(seen)};
    checked.words.erase("tick");
    checked.words.update(out);
    return checked;
}

Result<view::Reply> WorldTab::save(const std::string& path, const std::string& toml) const {
    if (!options_.replay.empty()) return fail("a recording says itself what its world is", "Show the program of the run");
    if (options_.world.empty()) return fail("no world was named when the viewer was started", "Start it with --world FILE");
    if (!path.empty() && path != options_.world)
        return fail(fmt::format("'{}' is not the world that was named when the viewer was started", path),
                    fmt::format("That is {}", options_.world));
    Result<view::Reply> checked = check(toml);
    if (!checked) return checked;
    if (!checked->words.at("valid").get<bool>()) {
        const Json& error = checked->words.at("error");
        return fail(fmt::format("this is no world, and is not written: {}", error["message"].get<std::string>()),
                    error["hint"].get<std::string>());
    }
    if (auto written = write_file(options_.world, toml); !written) return tl::unexpected<Error>(written.error());
    Json out = {{"path", options_.world}, {"written", toml.size()}};
    out.update(checked->words);
    checked->words = std::move(out);
    return checked;
}

}  // namespace meld::driver
