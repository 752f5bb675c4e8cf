// [network] links = "links.csv": what single links are like.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "runtime/world/description/network.h"
#include "runtime/world/file/toml_reader.h"

namespace meld::world {

// Reads the file into NetworkOptions::singles: a line for each link and direction, from, to and terms, which the first line names. Terms
// that it does not name are those of the network, which have been read before. `keys`: the terms that the network's kind has. Stores the
// first mistake in the reader, with its line.
void read_link_terms(TomlReader& reader, const Section& section, const std::string& name, const std::vector<std::string_view>& keys,
                     NetworkOptions& network);

}  // namespace meld::world
