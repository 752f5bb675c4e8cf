#include "runtime/driver/grade/exercise_file.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string_view>
#include <utility>

#include "runtime/ask/query/measure.h"
#include "runtime/base/files/input_file.h"
#include "runtime/base/hash.h"
#include "runtime/driver/study/study_file.h"
#include "runtime/world/file/toml_reader.h"
#include "runtime/world/file/world_file.h"

namespace meld::driver {

namespace {

namespace fs = std::filesystem;
using world::Section;
using world::TomlReader;
using world::type_mismatch;

constexpr std::uint64_t kMostExercise_bytes = std::uint64_t{1} << 20;
constexpr std::uint64_t kMostInput_bytes = std::uint64_t{1} << 30;
constexpr std::uint64_t kMostPoints = 1'000'000;
// What results do not depend on.
constexpr std::string_view kOnlyForPeople[] = {"README.md", "solution", "wrong"};

// Its page is called so, beside index.html.
bool is_name(const std::string& text) {
    return !text.empty() && text != "index" && text.size() <= 60 && text.front() != '-' &&
           std::ranges::all_of(text, [](unsigned char c) { return std::isalnum(c) || c == '-' || c == '_'; });
}

// Both files; a world lies in the folder of the exercise, so that a copy of this is the whole exercise.
class ExerciseReader {
  public:
    ExerciseReader(TomlReader& reader, Exercise& exercise) : reader_(reader), exercise_(exercise) {}

    void read_exercise(const toml::table& table) {
        const Section top(reader_, table, "", {"title", "program", "library", "limits", "expect", "never", "world"});
        exercise_.title = fs::path(exercise_.folder).filename().string();
        top.read("title", exercise_.title);
        std::string program = "start.meld";
        top.read("program", program);
        exercise_.program = within(program, "program", top);
        std::vector<std::string> library;
        top.read("library", library);
        for (const std::string& each : library) exercise_.library.push_back(within(each, "library", top));
        read_limits(top);
        read_checks(top, common_);
        read_worlds(top, false);
    }

    void read_hidden(const toml::table& table, const std::vector<ExerciseCheck>& common) {
        common_ = common;
        const Section top(reader_, table, "", {"world"});
        read_worlds(top, true);
        if (!top.has("world"))
            reader_.wrong(Error{fmt::format("{}: it lists no world", reader_.path()), "Add [[world]] with file = \"WORLD.toml\""});
    }

    const std::vector<ExerciseCheck>& common() const { return common_; }

  private:
    // The absolute path of a file or folder that this file names.
    std::string within(const std::string& name, std::string_view key, const Section& section) {
        std::error_code error;
        const fs::path path = fs::weakly_canonical(reader_.beside(name), error);
        const fs::path root = fs::weakly_canonical(exercise_.folder, error);
        const std::string from_root = path.lexically_relative(root).string();
        if (error || from_root.empty() || from_root.starts_with(".."))
            section.wrong(key, fmt::format("'{}' is not in the folder of the exercise", name), "Copy it there, and name the copy");
        else if (!fs::exists(path, error))
            section.wrong(key, fmt::format("there is no '{}'", name), "A path is relative to this file");
        return path.string();
    }

    void read_limits(const Section& top) {
        const toml::node* node = top.find("limits");
        if (!node) return;
        if (!node->is_table()) return reader_.wrong(node->source(), "limits " + type_mismatch(*node, "a table [limits]"));
        const Section limits(reader_, *node->as_table(), "[limits]", {"seconds", "compile", "memory", "output", "ticks"});
        limits.read_seconds("seconds", exercise_.limits.seconds);
        limits.read_seconds("compile", exercise_.limits.compile_seconds);
        limits.read_bytes("memory", exercise_.limits.memory);
        limits.read_bytes("output", exercise_.limits.output);
        limits.read_count("ticks", exercise_.limits.ticks, 1);
    }

    void read_checks(const Section& section, std::vector<ExerciseCheck>& checks) {
        for (const std::string_view kind : {"expect", "never"}) {
            const toml::node* node = section.find(kind);
            if (!node) continue;
            if (!node->is_table()) {
                reader_.wrong(node->source(), fmt::format("{} {}", kind, type_mismatch(*node, "a table of bodies by name")));
                continue;
            }
            for (const auto& [name, item] : in_order(*node->as_table())) read_check(name, *item, kind, checks);
        }
    }

    void read_check(const std::string& name, const toml::node& node, std::string_view kind, std::vector<ExerciseCheck>& checks) {
        ExerciseCheck check{.name = name, .text = {}, .body = {}, .never = kind == "never"};
        const std::string what = fmt::format("[{}] {}", kind, name);
        if (node.is_string()) {
            check.text = **node.as_string();
        } else if (const toml::table* keys = node.as_table(); keys && !check.never) {
            const Section section(reader_, *keys, what, {"body", "ticks"});
            section.read("body", check.text);
            const toml::node* ticks = section.find("ticks");
            const auto add = [&](const toml::node& item) {
                const auto tick = item.is_integer() ? item.value<std::int64_t>() : std::nullopt;
                if (!tick || *tick < 1) return reader_.wrong(item.source(), "a tick is a whole number from 1 on");
                check.ticks.push_back(*tick);
            };
            if (ticks != nullptr && ticks->is_array())
                for (const toml::node& item : *ticks->as_array()) add(item);
            else if (ticks != nullptr)
                add(*ticks);
        } else {
            return reader_.wrong(node.source(), fmt::format("{} {}", what, type_mismatch(node, "a body, as a string")));
        }
        if (check.text.empty()) return reader_.wrong(node.source(), fmt::format("{} says nothing", what), "Write a body in Meld");
        check.body = inspect::body_of_measure(check.text);
        const auto same = [&](const ExerciseCheck& other) { return other.name == check.name; };
        if (std::ranges::any_of(checks, same))
            return reader_.wrong(node.source(), fmt::format("{}: another one has this name", what), "Give it another name");
        checks.push_back(std::move(check));
    }

    void read_worlds(const Section& top, bool hidden) {
        const toml::node* node = top.find("world");
        if (!node) return;
        const toml::array* list = node->as_array();
        if (!list) return reader_.wrong(node->source(), "world " + type_mismatch(*node, "a list of tables [[world]]"));
        for (const toml::node& item : *list) {
            if (!item.is_table()) return reader_.wrong(item.source(), "world " + type_mismatch(item, "a table [[world]]"));
            const Section keys(reader_, *item.as_table(), "[[world]]", {"name", "file", "points", "ticks", "seed", "expect", "never"});
            ExerciseWorld world{.name = {}, .path = {}, .hidden = hidden, .checks = common_};
            std::string file;
            keys.read("file", file);
            if (file.empty()) return reader_.wrong(item.source(), "a [[world]] names no file", "Add file = \"WORLD.toml\"");
            world.path = within(file, "file", keys);
            world.name = fs::path(file).stem().string();
            keys.read("name", world.name);
            if (!is_name(world.name))
                return keys.wrong(keys.has("name") ? "name" : "file", fmt::format("'{}' is not the name of a world", world.name),
                                  "Add name = \"NAME\", of letters, digits, - and _");
            for (const ExerciseWorld& other : exercise_.worlds)
                if (other.name == world.name)
                    return reader_.wrong(item.source(), fmt::format("two worlds are called '{}'", world.name), "Add name = \"NAME\"");
            keys.read_count("points", world.points, 0, kMostPoints);
            std::uint64_t number = 0;
            if (keys.has("ticks")) {
                keys.read_count("ticks", number, 1);
                world.ticks = static_cast<std::int64_t>(number);
            }
            if (keys.has("seed")) {
                keys.read_count("seed", number);
                world.seed = static_cast<std::int64_t>(number);
            }
            read_checks(keys, world.checks);
            if (world.checks.empty())
                return reader_.wrong(item.source(), fmt::format("nothing is expected in the world '{}'", world.name),
                                     "Add [expect] to the exercise, or [world.expect] below this [[world]]");
            exercise_.worlds.push_back(std::move(world));
        }
    }

    TomlReader& reader_;
    Exercise& exercise_;
    std::vector<ExerciseCheck> common_;  // Of all worlds.
};

// Reads a file of TOML and hands its table on. Errors: it is none; those that the reader has stored.
template <class Read>
Result<void> read_toml(const std::string& path, const Read& read) {
    const Result<std::string> text = read_input(path, kMostExercise_bytes);
    if (!text) return tl::unexpected<Error>(text.error());
    if (const auto shallow = world::check_key_depth(*text, path); !shallow) return shallow;
    TomlReader reader(*text, path, nullptr);
    // The library's parser reports mistakes only by an exception.
    try {
        const toml::table table = toml::parse(std::string_view(*text), std::string_view(path));
        read(reader, table);
    } catch (const toml::parse_error& error) {
        return fail(fmt::format("{}: {}", reader.place(error.source()), error.description()),
                    "Write NAME = VALUE on each line, and texts in quotes");
    }
    if (reader.error()) return tl::unexpected<Error>(*reader.error());
    return {};
}

Result<std::uint64_t> hash_of_files(const std::string& folder) {
    std::vector<std::string> names;
    std::error_code error;
    for (fs::recursive_directory_iterator each(folder, error), end; !error && each != end; each.increment(error)) {
        const std::string name = each->path().lexically_relative(folder).string();
        const std::string first = name.substr(0, name.find('/'));
        if (std::ranges::find(kOnlyForPeople, first) == std::end(kOnlyForPeople) && each->is_regular_file()) names.push_back(name);
    }
    if (error) return fail(fmt::format("{} cannot be read: {}", folder, error.message()));
    std::ranges::sort(names);
    std::uint64_t hash = 0;
    for (const std::string& name : names) {
        const Result<std::string> text = read_input(folder + "/" + name, kMostInput_bytes);
        if (!text) return tl::unexpected<Error>(text.error());
        hash = hash_combine(hash_combine(hash, hash_text(name)), hash_text(*text));
    }
    return hash;
}

}  // namespace

std::uint64_t Exercise::points() const {
    std::uint64_t sum = 0;
    for (const ExerciseWorld& each : worlds) sum += each.points;
    return sum;
}

Result<Exercise> read_exercise(const std::string& folder) {
    Exercise exercise;
    std::error_code error;
    if (!fs::is_directory(folder, error))
        return fail(fmt::format("{} is not a folder", folder), "Give the folder of an exercise, with exercise.toml in it");
    exercise.folder = fs::canonical(folder, error).string();
    std::vector<ExerciseCheck> common;
    const std::string path = (fs::path(folder) / "exercise.toml").string();
    auto done = read_toml(path, [&](TomlReader& reader, const toml::table& table) {
        ExerciseReader read(reader, exercise);
        read.read_exercise(table);
        common = read.common();
    });
    if (!done) return tl::unexpected<Error>(done.error());
    const std::string hidden = (fs::path(folder) / "hidden" / "hidden.toml").string();
    if (fs::exists(hidden, error)) {
        done = read_toml(
            hidden, [&](TomlReader& reader, const toml::table& table) { ExerciseReader(reader, exercise).read_hidden(table, common); });
        if (!done) return tl::unexpected<Error>(done.error());
    }
    if (exercise.worlds.empty())
        return fail(fmt::format("{}: the exercise has no world", path), "Add [[world]] with file = \"WORLD.toml\"");
    // A mistake in a world is the teacher's, and no student's.
    for (const ExerciseWorld& each : exercise.worlds)
        if (const auto world = world::read_world(each.path); !world) return tl::unexpected<Error>(world.error());
    const Result<std::uint64_t> hash = hash_of_files(exercise.folder);
    if (!hash) return tl::unexpected<Error>(hash.error());
    exercise.hash = *hash;
    return exercise;
}

}  // namespace meld::driver
