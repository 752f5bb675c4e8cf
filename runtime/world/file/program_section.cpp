#include "runtime/world/file/program_section.h"

#include <algorithm>

namespace meld::world {

namespace {

void read_program(TomlReader& reader, const toml::table& table, World& world) {
    const Section section(reader, table, "[[program]]", {"where", "file"});
    std::string file;
    section.read("file", file);
    if (file.empty()) return section.wrong("file", "it does not say which program is meant", "add file = \"...\"");
    const std::optional<Region> where = section.read_region("where");
    if (!where && !section.has("where")) return section.wrong("where", "it does not say which catoms are meant", "add where = \"...\"");
    const auto found = std::ranges::find(world.programs, reader.beside(file));
    if (reader.error() || found == world.programs.end()) return;
    world.program_regions.push_back({*where, static_cast<std::uint32_t>(found - world.programs.begin()) + 1, reader.place(table.source())});
}

}  // namespace

void read_programs(TomlReader& reader, const toml::table& top, World& world) {
    const toml::node* node = top.get("program");
    if (node == nullptr) return;
    world.programs = program_files(top, [&](const std::string& file) { return reader.beside(file); });
    if (node->is_table()) return read_program(reader, *node->as_table(), world);
    if (!node->is_array_of_tables()) return reader.wrong(node->source(), "program " + type_mismatch(*node, "a table [[program]]"));
    for (const toml::node& table : *node->as_array()) read_program(reader, *table.as_table(), world);
}

}  // namespace meld::world
