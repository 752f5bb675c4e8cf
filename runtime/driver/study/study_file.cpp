#include "runtime/driver/study/study_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>

#include "runtime/ask/query/measure.h"
#include "runtime/base/did_you_mean.h"
#include "runtime/base/files/input_file.h"
#include "runtime/driver/study/run_counts.h"
#include "runtime/world/file/given_facts.h"
#include "runtime/world/file/toml_reader.h"

namespace meld::driver {

namespace {

using world::Section;
using world::TomlReader;
using world::type_mismatch;

constexpr std::uint64_t kMostStudy_bytes = std::uint64_t{16} << 20;
constexpr std::uint64_t kMostSeeds = 10'000'000;

std::string not_a_count(const std::string& word) {
    const auto near = nearest_name(word, count_names());
    return near ? fmt::format("Did you mean '{}'?", *near) : fmt::format("Its counts are {}.", fmt::join(count_names(), ", "));
}

class StudyReader {
  public:
    StudyReader(TomlReader& reader, const toml::table& table, Study& study)
        : reader_(reader),
          table_(table),
          top_(reader, table, "",
               {"program", "worlds", "world", "seeds", "ticks", "until", "timeout", "threads", "events", "library", "link", "extensions",
                "set", "measure", "expect", "never"}),
          study_(study) {}

    void read() {
        read_programs();
        read_worlds();
        read_seeds();
        read_options();
        for (const auto& [name, node] : entries("set")) read_axis(name, *node, "");
        for (const auto& [name, node] : entries("measure")) read_measure(name, *node);
        for (const char* section : {"expect", "never"})
            for (const auto& [name, node] : entries(section)) read_demand(name, *node, section);
        if (study_.measures.empty())
            for (const char* count : {"ticks", "messages"}) study_.measures.push_back({.name = count, .text = count});
        check_names();
    }

  private:
    std::string beside(const std::string& name) const { return reader_.beside(name); }

    std::vector<std::pair<std::string, const toml::node*>> entries(const char* section) {
        const toml::node* node = top_.find(section);
        if (!node) return {};
        if (node->is_table()) return in_order(*node->as_table());
        reader_.wrong(node->source(), fmt::format("{} {}", section, type_mismatch(*node, fmt::format("a table [{}]", section))));
        return {};
    }

    // A string, an array of strings, or a table of them by name.
    template <class Add>
    void each_path(const char* key, const toml::node& node, const Add& add) {
        if (node.is_string()) return add(**node.as_string(), **node.as_string());
        if (node.is_array()) {
            for (const toml::node& item : *node.as_array()) {
                if (!item.is_string()) return reader_.wrong(item.source(), fmt::format("{} {}", key, type_mismatch(item, "a file name")));
                add(**item.as_string(), **item.as_string());
            }
            return;
        }
        if (!node.is_table())
            return reader_.wrong(node.source(), fmt::format("{} {}", key, type_mismatch(node, "a file name, or a table of them by name")));
        for (const auto& [name, item] : in_order(*node.as_table())) {
            if (!item->is_string()) return reader_.wrong(item->source(), fmt::format("{} {}", name, type_mismatch(*item, "a file name")));
            add(name, **item->as_string());
        }
    }

    void read_programs() {
        const toml::node* node = top_.find("program");
        if (!node)
            return reader_.wrong(Error{fmt::format("{}: the study names no program", reader_.path()), "Add program = \"FILE.meld\""});
        each_path("program", *node,
                  [&](const std::string& name, const std::string& path) { study_.programs.push_back({name, beside(path)}); });
        if (study_.programs.empty()) reader_.wrong(node->source(), "program names no file", "Write program = \"FILE.meld\"");
    }

    void read_worlds() {
        const toml::node *list = top_.find("worlds"), *own = top_.find("world");
        if (list && own) return reader_.wrong(own->source(), "there are both worlds and [world]", "Take one of the two out");
        if (list)
            each_path("worlds", *list, [&](const std::string& name, const std::string& path) {
                study_.worlds.push_back({.name = name, .path = beside(path)});
            });
        if (own && own->is_string())
            study_.worlds.push_back({.name = **own->as_string(), .path = beside(**own->as_string())});
        else if (own && own->is_table())
            study_.worlds.push_back({.name = "", .keys = own->as_table()});
        else if (own)
            reader_.wrong(own->source(), "world " + type_mismatch(*own, "a table [world], or a file name"));
        if (list && study_.worlds.empty())
            reader_.wrong(list->source(), "worlds names no file", "Take it out: then each program has its own");
        if (study_.worlds.empty()) study_.worlds.push_back({.name = ""});
    }

    void read_seeds() {
        const toml::node* node = top_.find("seeds");
        if (!node) return;
        if (!node->is_array()) {
            std::uint64_t count = 0;
            top_.read_count("seeds", count, 1, kMostSeeds);
            for (std::uint64_t seed = 1; seed <= count; ++seed) study_.seeds.push_back(seed);
            return;
        }
        for (const toml::node& item : *node->as_array()) {
            const std::optional<std::int64_t> seed = item.is_integer() ? item.value<std::int64_t>() : std::nullopt;
            if (!seed || *seed < 0) return reader_.wrong(item.source(), "a seed is a whole number that is not negative");
            study_.seeds.push_back(static_cast<std::uint64_t>(*seed));
        }
        if (study_.seeds.empty()) reader_.wrong(node->source(), "seeds is an empty list", "Take it out: then the seed is the world's");
    }

    void read_options() {
        if (top_.has("ticks")) {
            std::uint64_t ticks = 0;
            top_.read_count("ticks", ticks, 1);
            study_.ticks = static_cast<std::int64_t>(ticks);
        }
        top_.read("until", study_.until);
        top_.read_seconds("timeout", study_.timeout_seconds);
        top_.read_count("threads", study_.threads, 1);
        for (const auto& [key, files] : {std::pair{"events", &study_.events},
                                         {"library", &study_.library},
                                         {"link", &study_.link},
                                         {"extensions", &study_.extensions}})
            if (const toml::node* node = top_.find(key))
                each_path(key, *node, [&](const std::string&, const std::string& path) { files->push_back(beside(path)); });
    }

    // [set] network.loss = [0.1, 0.2] is a table in a table.
    void read_axis(const std::string& name, const toml::node& node, const std::string& before) {
        const std::string full = before + name;
        if (node.is_table()) {
            for (const auto& [key, item] : in_order(*node.as_table())) read_axis(key, *item, full + ".");
            return;
        }
        StudyAxis axis{.name = full, .values = {}, .place = reader_.place(node.source())};
        if (const toml::array* array = node.as_array())
            for (const toml::node& item : *array) axis.values.push_back(value(item, full));
        else
            axis.values.push_back(value(node, full));
        if (axis.values.empty()) reader_.wrong(node.source(), fmt::format("[set] {} has no values", full), "Take it out");
        std::set<std::string> once;
        for (const StudyValue& each : axis.values)
            if (!once.insert(each.plain).second)
                reader_.wrong(node.source(), fmt::format("[set] {} lists {} twice", full, each.plain), "Write each value once");
        study_.axes.push_back(std::move(axis));
    }

    StudyValue value(const toml::node& node, const std::string& name) {
        if (node.is_table()) {
            std::ostringstream text;
            text << toml::node_view<const toml::node>(node);
            return {"", text.str(), &node};
        }
        const std::string literal = world::literal(reader_, node, fmt::format("[set] {}", name));
        return {literal, node.is_string() ? **node.as_string() : literal, &node};
    }

    void read_measure(const std::string& name, const toml::node& node) {
        StudyMeasure measure{.name = name, .text = {}, .place = reader_.place(node.source())};
        if (const toml::table* keys = node.as_table()) {
            const Section section(reader_, *keys, fmt::format("[measure] {}", name), {"body", "ticks"});
            section.read("body", measure.text);
            if (!section.has("body")) section.wrong("body", fmt::format("[measure] {} has no body", name), "Add body = \"...\"");
            const toml::node* ticks = section.find("ticks");
            const toml::array* list = ticks ? ticks->as_array() : nullptr;
            const auto add = [&](const toml::node& item) {
                const auto tick = item.is_integer() ? item.value<std::int64_t>() : std::nullopt;
                if (!tick || *tick < 1) return reader_.wrong(item.source(), "a tick is a whole number from 1 on");
                measure.ticks.push_back(*tick);
            };
            if (list)
                for (const toml::node& item : *list) add(item);
            else if (ticks)
                add(*ticks);
        } else if (node.is_string()) {
            measure.text = **node.as_string();
        } else {
            return reader_.wrong(node.source(),
                                 fmt::format("[measure] {} {}", name, type_mismatch(node, "a count or a body, as a string")));
        }
        const bool word = std::ranges::all_of(measure.text, [](unsigned char c) { return std::isalnum(c) || c == '_'; });
        const bool count = std::ranges::find(count_names(), measure.text) != count_names().end();
        if (word && !count)
            return reader_.wrong(node.source(), fmt::format("[measure] {}: a run has no count '{}'", name, measure.text),
                                 not_a_count(measure.text) + " For facts, give a body in Meld: \"count : { leader(A) }\"");
        if (count && !measure.ticks.empty())
            return reader_.wrong(node.source(), fmt::format("[measure] {}: counts are those of the whole run", name), "Take ticks out");
        if (!count) measure.body = inspect::body_of_measure(measure.text);
        study_.measures.push_back(std::move(measure));
    }

    void read_demand(const std::string& name, const toml::node& node, const std::string& section) {
        if (!node.is_string())
            return reader_.wrong(node.source(), fmt::format("[{}] {} {}", section, name, type_mismatch(node, "a body, as a string")));
        const std::string text = **node.as_string();
        study_.demands.push_back({name, text, inspect::body_of_measure(text), section == "never", reader_.place(node.source())});
    }

    // Columns of the table.
    void check_names() {
        std::set<std::string> taken = {"row", "program", "world", "seed", "status", "reason", "digest", "seconds", "memory", "key"};
        for (const StudyAxis& axis : study_.axes)
            if (!taken.insert(axis.name).second)
                reader_.wrong(Error{fmt::format("{}: [set] {}: tables have another column of this name", axis.place, axis.name),
                                    axis.name == "seed" ? "Write seeds = N at the top" : "Give it another name"});
        for (const StudyMeasure& measure : study_.measures)
            if (!taken.insert(measure.name).second)
                reader_.wrong(Error{fmt::format("{}: [measure] {}: tables have another column of this name", measure.place, measure.name),
                                    "Give it another name"});
    }

    TomlReader& reader_;
    const toml::table& table_;
    const Section top_;
    Study& study_;
};

}  // namespace

std::vector<std::pair<std::string, const toml::node*>> in_order(const toml::table& table) {
    std::vector<std::pair<std::string, const toml::node*>> all;
    for (const auto& [key, node] : table) all.emplace_back(std::string(key.str()), &node);
    std::ranges::stable_sort(all, [](const auto& a, const auto& b) {
        const toml::source_position x = a.second->source().begin, y = b.second->source().begin;
        return std::pair(x.line, x.column) < std::pair(y.line, y.column);
    });
    return all;
}

Result<Study> read_study(const std::string& path) {
    Study study;
    study.path = path;
    const std::string folder = std::filesystem::path(path).parent_path().string();
    study.folder = folder.empty() ? "" : folder + "/";
    Result<std::string> text = read_input(path, kMostStudy_bytes);
    if (!text) return tl::unexpected<Error>(text.error());
    study.text = std::move(*text);
    if (const auto shallow = world::check_key_depth(study.text, path); !shallow) return tl::unexpected<Error>(shallow.error());
    TomlReader reader(study.text, path, nullptr);
    // The library's parser reports mistakes only by an exception.
    try {
        study.table = std::make_shared<const toml::table>(toml::parse(std::string_view(study.text), std::string_view(path)));
    } catch (const toml::parse_error& error) {
        return fail(fmt::format("{}: {}", reader.place(error.source()), error.description()),
                    "Write NAME = VALUE on each line, and texts in quotes");
    }
    StudyReader(reader, *study.table, study).read();
    if (reader.error()) return tl::unexpected<Error>(*reader.error());
    return study;
}

}  // namespace meld::driver
