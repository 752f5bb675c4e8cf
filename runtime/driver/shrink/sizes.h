// Whole numbers in what a world says of its catoms: graph = "ring(1000)", shape = "box(20, 20, 1)".
#pragma once

#include <toml++/toml.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace meld::driver {

struct SizePlace {
    std::optional<std::size_t> body;  // Its number among [[body]]; nothing: that of the graph.
    std::size_t number = 0;           // Among the numbers of the text.
};

// Those of at least 2.
std::vector<SizePlace> sizes_in(const toml::table& keys);
std::int64_t size_at(const toml::table& keys, const SizePlace& place);
void set_size(toml::table& keys, const SizePlace& place, std::int64_t value);

}  // namespace meld::driver
