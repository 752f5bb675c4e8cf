// Keys that several tables of [motion] have.
#pragma once

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

// What something carries at most, N and N m.
void read_breaking(const Section& section, std::optional<double>& force, std::optional<double>& torque);

}  // namespace meld::world
