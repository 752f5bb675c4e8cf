// The formatter: lays out a program in one way and keeps every token and every comment.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "compiler/diagnostics/diagnostics.h"
#include "compiler/source/source.h"
#include "runtime/base/error.h"

namespace meld::format {

// Lines that would be longer than this number of columns are broken.
constexpr std::size_t kMaxColumns = 120;

// The formatted text of a file of the set. Nothing if the file has lexical or syntax errors, which are reported. Included files are not
// read. Formatting the result again changes nothing. The tokens and comments of the result are compared with the file's; a difference,
// which would be our bug, is an error. Cost: linear in the text.
Result<std::optional<std::string>> format(source::FileSet& files, std::uint32_t file, diagnostics::Reporter& report);

}  // namespace meld::format
