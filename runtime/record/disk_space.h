// Finding a full disk before a write does. Private to runtime/record.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace meld::record {

// Makes sure that the file at `path` can grow by so many bytes: takes the blocks from the disk, if the file system can do
// that, without changing the file's size; else looks at what is free. Nothing when it can, else the reason in words.
std::optional<std::string> reserve_growth(const std::string& path, std::uint64_t bytes);

}  // namespace meld::record
