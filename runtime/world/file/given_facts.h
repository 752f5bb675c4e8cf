// The sections of a world file that contain predicates or literals of the language: [facts], those of [[event]], and [set].
#pragma once

#include <map>
#include <string>
#include <vector>

#include "runtime/world/description/world.h"
#include "runtime/world/file/toml_reader.h"

namespace meld::world {

// source = "cell == (0,0,0)"                                      one region
// source = ["id == 0", "id == 9"]                                 several
// temperature = [{ where = "id < 10", args = [20.5] }, ...]       with arguments; without `where`, all catoms
// route = { args = [[1, 2], "text", "vec3(0, 0, 1)"] }            lists as arrays, all else that TOML cannot say as text
void read_facts(TomlReader& reader, const toml::table& table, std::vector<GivenFact>& facts);

// name = value
void read_settings(TomlReader& reader, const toml::table& table, std::map<std::string, std::string>& set);

// A string that says which catoms are meant.
Region read_region(TomlReader& reader, const toml::node& node);

// A TOML value as a literal of the language. A string that is itself a number, true, false, or a catom such as "@3" means that value, any
// other a string; an array means a list. Anything else is a mistake, which the message calls `what`.
std::string literal(TomlReader& reader, const toml::node& node, std::string_view what);

}  // namespace meld::world
