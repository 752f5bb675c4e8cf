// Finding a full disk before a write does. Private to runtime/record.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace meld::record {

// Makes the file at `path` longer by so many bytes: takes the blocks from the disk, if the file system can do that; else looks at
// what is free. Nothing when it could, else the reason in words.
std::optional<std::string> reserve_growth(const std::string& path, std::uint64_t bytes);

}  // namespace meld::record
