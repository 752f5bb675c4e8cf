// The pieces of a very long module: which parts are compiled together, and their objects in the cache.
#pragma once

#include <string>
#include <vector>

#include "compiler/build/build.h"
#include "compiler/build/content_hash.h"

namespace meld {

struct Piece {
    std::string text;
    CodePasses passes = CodePasses::Few;
};

// Where a piece ends is decided by the names of its parts, and by a greatest number of them, so that a new part changes few pieces.
std::vector<Piece> divide_in_pieces(const TextInParts& text);

// The objects of the pieces: from the cache, or compiled and put there. A damaged one is compiled again.
Result<std::vector<std::string>> compile_pieces(const Backend& backend, const std::string& shared, const std::vector<Piece>& pieces,
                                                const std::string& target, const BuildOptions& options);

// What decides how any text is compiled: the backend, the machine, the level and the headers.
void add_recipe(ContentHash& hash, const std::string& target, const BuildOptions& options);

}  // namespace meld
