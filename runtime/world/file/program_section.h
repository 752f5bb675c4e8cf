// [[program]] of a world file: regions whose catoms run another program than the others.
#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "runtime/world/file/toml_reader.h"

namespace meld::world {

// [[program]] where = REGION, file = PATH
void read_programs(TomlReader& reader, const toml::table& top, World& world);

// The files that the sections name, each once, in order; whatever has a mistake is left out. `beside` gives the path of a file.
template <class Beside>
std::vector<std::string> program_files(const toml::table& top, const Beside& beside) {
    std::vector<std::string> files;
    const auto add = [&](const toml::node& node) {
        const toml::table* one = node.as_table();
        const auto file = one == nullptr ? std::nullopt : (*one)["file"].value<std::string>();
        if (!file || file->empty()) return;
        if (std::string path = beside(*file); std::ranges::find(files, path) == files.end()) files.push_back(std::move(path));
    };
    const toml::node* node = top.get("program");
    if (node == nullptr) return files;
    if (const toml::array* all = node->as_array())
        for (const toml::node& each : *all) add(each);
    else
        add(*node);
    return files;
}

}  // namespace meld::world
