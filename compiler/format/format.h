// The formatter: a program laid out in one way, with every token and every comment of it kept.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "compiler/diagnostics/diagnostics.h"
#include "compiler/source/source.h"
#include "runtime/base/error.h"

namespace meld::format {

// Lines are broken where they would be longer than this, in columns.
constexpr std::size_t kMaxColumns = 120;

// The text of a file of the set, laid out. Nothing if the file has mistakes of text or grammar, which are reported: it is better left
// alone then. What it includes is neither read nor looked at. Formatting the result again changes nothing. The tokens and comments of
// the result are compared with the file's; a difference, which would be our bug, is an error. Cost: linear in the text.
Result<std::optional<std::string>> format(source::FileSet& files, std::uint32_t file, diagnostics::Reporter& report);

}  // namespace meld::format
