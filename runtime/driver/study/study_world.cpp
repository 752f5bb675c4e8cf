#include "runtime/driver/study/study_world.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <sstream>
#include <string_view>

#include "runtime/base/files/input_file.h"
#include "runtime/base/files/output_file.h"
#include "runtime/base/hash.h"
#include "runtime/world/file/toml_reader.h"

namespace meld::driver {

namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMostWorldText_bytes = std::uint64_t{256} << 20;
constexpr std::uint64_t kMostNamedFile_bytes = std::uint64_t{4} << 30;

// Calls for each string in a table or array; what it returns takes the string's place.
using Change = std::function<void(toml::node& parent, std::string_view key, std::size_t index, const std::string& text)>;

void each_string(toml::node& node, const Change& change) {
    if (toml::table* table = node.as_table()) {
        std::vector<std::string> keys;
        for (const auto& [key, item] : *table) keys.emplace_back(key.str());
        for (const std::string& key : keys) {
            toml::node& item = *table->get(key);
            if (item.is_string())
                change(node, key, 0, std::string(**item.as_string()));
            else
                each_string(item, change);
        }
    } else if (toml::array* array = node.as_array()) {
        for (std::size_t i = 0; i < array->size(); ++i) {
            toml::node& item = *array->get(i);
            if (item.is_string())
                change(node, "", i, std::string(**item.as_string()));
            else
                each_string(item, change);
        }
    }
}

void put(toml::node& parent, std::string_view key, std::size_t index, const toml::node& value) {
    value.visit([&](const auto& typed) {
        if (toml::table* table = parent.as_table())
            table->insert_or_assign(key, typed);
        else
            parent.as_array()->replace(parent.as_array()->cbegin() + static_cast<std::ptrdiff_t>(index), typed);
    });
}

// The names of files in a string: all of it, or what stands in quotes in it.
std::vector<std::string> possible_files(const std::string& text) {
    std::vector<std::string> names = {text};
    for (std::size_t at = 0; (at = text.find('\'', at)) != std::string::npos;) {
        const std::size_t end = text.find('\'', at + 1);
        if (end == std::string::npos) break;
        names.push_back(text.substr(at + 1, end - at - 1));
        at = end + 1;
    }
    std::error_code error;
    std::erase_if(names, [&](const std::string& name) { return name.empty() || name.size() > 4000; });
    return names;
}

bool is_file(const std::string& path) {
    std::error_code error;
    return fs::is_regular_file(path, error);
}

// The strings of a world with each file that they name from the root, so that it can be read anywhere; and a hash of these files.
Result<std::uint64_t> make_absolute(toml::table& keys, const std::string& folder) {
    std::uint64_t hash = 0;
    Result<void> read;
    each_string(keys, [&](toml::node& parent, std::string_view key, std::size_t index, const std::string& text) {
        std::string changed = text;
        for (const std::string& name : possible_files(text)) {
            const std::string path = (fs::path(folder) / name).string();
            if (!is_file(path)) continue;
            const Result<std::string> content = read_input(path, kMostNamedFile_bytes);
            if (!content) {
                read = tl::unexpected<Error>(content.error());
                return;
            }
            hash = hash_combine(hash, hash_text(*content));
            const std::string whole = fs::absolute(path).lexically_normal().string();
            if (name == text) {
                changed = whole;
                break;
            }
            for (std::size_t at = 0; (at = changed.find("'" + name + "'", at)) != std::string::npos; at += whole.size() + 2)
                changed.replace(at + 1, name.size(), whole);
        }
        if (changed != text) put(parent, key, index, toml::value<std::string>(changed));
    });
    if (!read) return tl::unexpected<Error>(read.error());
    return hash;
}

// The value of {NAME} in a string: what is a parameter alone keeps its type.
void fill_in(toml::table& keys, const Chosen& chosen) {
    each_string(keys, [&](toml::node& parent, std::string_view key, std::size_t index, const std::string& text) {
        std::string changed = text;
        for (const auto& [axis, value] : chosen) {
            const std::string mark = "{" + axis->name + "}";
            if (text == mark) return put(parent, key, index, *value->node);
            for (std::size_t at = 0; (at = changed.find(mark, at)) != std::string::npos; at += value->plain.size())
                changed.replace(at, mark.size(), value->plain);
        }
        if (changed != text) put(parent, key, index, toml::value<std::string>(changed));
    });
}

// network.loss = 0.1
Result<void> set_key(toml::table& keys, const StudyAxis& axis, const StudyValue& value) {
    toml::table* table = &keys;
    std::string_view rest = axis.name, done;
    for (std::size_t dot = 0; (dot = rest.find('.')) != std::string_view::npos; rest.remove_prefix(dot + 1)) {
        const std::string_view part = rest.substr(0, dot);
        if (!table->contains(part)) table->insert(part, toml::table{});
        done = std::string_view(axis.name).substr(0, static_cast<std::size_t>(rest.data() - axis.name.data()) + dot);
        table = table->get(part)->as_table();
        if (!table)
            return fail(fmt::format("{}: [set] {}: {} of the world is not a table", axis.place, axis.name, done),
                        "Write {NAME} in a string of the world, and [set] NAME = [...]");
    }
    put(*table, rest, 0, *value.node);
    return {};
}

std::string text_of_world(const toml::table& keys) {
    std::ostringstream text;
    text << keys << "\n";
    return text.str();
}

Result<toml::table> read_keys(const std::string& path) {
    const Result<std::string> text = read_input(path, kMostWorldText_bytes);
    if (!text) return tl::unexpected<Error>(text.error());
    if (const auto shallow = world::check_key_depth(*text, path); !shallow) return tl::unexpected<Error>(shallow.error());
    // The library's parser reports mistakes only by an exception.
    try {
        return toml::parse(std::string_view(*text), std::string_view(path));
    } catch (const toml::parse_error& error) {
        return fail(fmt::format("{}:{}:{}: {}", path, error.source().begin.line, error.source().begin.column, error.description()));
    }
}

}  // namespace

Result<WorldTemplate> WorldTemplate::read(const std::string& path) {
    WorldTemplate made;
    made.path_ = path;
    if (path.empty()) return made;
    const std::string folder = fs::path(path).parent_path().string();
    made.folder_ = folder.empty() ? "" : folder + "/";
    Result<toml::table> keys = read_keys(path);
    if (!keys) return tl::unexpected<Error>(keys.error());
    made.keys_ = std::move(*keys);
    made.has_keys_ = true;
    return made;
}

WorldTemplate::WorldTemplate(const toml::table& keys, std::string folder) : folder_(std::move(folder)), keys_(keys), has_keys_(true) {}

bool WorldTemplate::mentions(const std::string& name) const {
    bool found = false;
    toml::table copy = keys_;
    each_string(copy, [&](toml::node&, std::string_view, std::size_t, const std::string& text) {
        found = found || text.find("{" + name + "}") != std::string::npos;
    });
    return found;
}

Result<ComposedWorld> WorldTemplate::compose(const Chosen& chosen, const std::string& folder) const {
    if (!has_keys_) {
        if (chosen.empty()) return ComposedWorld{};
        return fail(fmt::format("{}: [set] {} is of the world, and the study has no world to put it in", chosen.front().first->place,
                                chosen.front().first->name),
                    "Add worlds = [\"FILE.toml\"], or a table [world]");
    }
    toml::table keys = keys_;
    fill_in(keys, chosen);
    for (const auto& [axis, value] : chosen) {
        if (mentions(axis->name)) continue;
        if (auto set = set_key(keys, *axis, *value); !set) return tl::unexpected<Error>(set.error());
    }
    // The hash does not depend on where the world stands.
    const std::uint64_t text_hash = hash_text(text_of_world(keys));
    const Result<std::uint64_t> files = make_absolute(keys, folder_);
    if (!files) return tl::unexpected<Error>(files.error());
    const std::uint64_t hash = hash_combine(text_hash, *files);
    if (chosen.empty() && !path_.empty()) return ComposedWorld{path_, hash};
    const std::string text = text_of_world(keys);
    const std::string path = fmt::format("{}/{:016x}.toml", folder, hash_text(text));
    std::error_code error;
    fs::create_directories(folder, error);
    // Others who work on the study write the same.
    if (!fs::exists(path, error))
        if (auto written = write_file(path, text); !written && !fs::exists(path, error)) return tl::unexpected<Error>(written.error());
    return ComposedWorld{path, hash};
}

Result<toml::table> world_keys_of(const std::string& path) {
    Result<toml::table> keys = read_keys(path);
    if (!keys) return keys;
    const std::string folder = fs::path(path).parent_path().string();
    if (const auto done = make_absolute(*keys, folder.empty() ? "" : folder + "/"); !done) return tl::unexpected<Error>(done.error());
    return keys;
}

const std::vector<std::string_view>& world_keys() {
    static const std::vector<std::string_view> kKeys = {"lattice", "ports",   "acyclic", "graph",   "links", "nodes", "directed",
                                                        "radius",  "held",    "body",    "target",  "facts", "event", "set",
                                                        "motion",  "record",  "limits",  "network", "clock", "time",  "components",
                                                        "faults",  "program", "without", "assembly"};
    return kKeys;
}

bool names_world_key(const std::string& name) {
    return std::ranges::find(world_keys(), std::string_view(name).substr(0, name.find('.'))) != world_keys().end();
}

}  // namespace meld::driver
