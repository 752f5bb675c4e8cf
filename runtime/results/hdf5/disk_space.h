// Finding a full disk before a write does. Private to runtime/results.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace meld::record {

// Makes the file at `path` longer by this many bytes: allocates the blocks on the disk if the file system can; otherwise checks the free
// space. Returns nothing on success, otherwise the reason in words.
std::optional<std::string> reserve_growth(const std::string& path, std::uint64_t bytes);

}  // namespace meld::record
