// Keys that several tables of [motion] have.
#pragma once

#include <fmt/format.h>

#include <initializer_list>
#include <optional>
#include <string_view>
#include <vector>

#include "runtime/world/file/toml_reader.h"

namespace meld::world {

// The keys that only some kinds of an object have.
struct KeysOfKind {
    std::string_view kind;
    std::vector<std::string_view> keys;
    bool has(std::string_view key) const;
};
// A key of another kind would have no effect here.
void refuse_keys_of_others(const Section& section, std::string_view kind, std::initializer_list<KeysOfKind> kinds);

// Calls read(table) for each table of an array [[PREFIX.KEY]] in a table [PREFIX].
template <class Read>
void each_table(TomlReader& reader, const toml::table& in, std::string_view prefix, std::string_view key, const Read& read) {
    const toml::node* node = in.get(key);
    if (!node) return;
    if (node->is_table()) return read(*node->as_table());
    if (!node->is_array_of_tables())
        return reader.wrong(node->source(),
                            fmt::format("[{}] {} {}", prefix, key, type_mismatch(*node, fmt::format("tables [[{}.{}]]", prefix, key))));
    for (const toml::node& table : *node->as_array()) read(*table.as_table());
}

// What something carries at most, N and N m.
void read_breaking(const Section& section, std::optional<double>& force, std::optional<double>& torque);

}  // namespace meld::world
