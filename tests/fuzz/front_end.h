// Runs the front end over a text as meldc does, for the fuzz targets.
#pragma once

#include <optional>
#include <string>

#include "compiler/check/program/program.h"

namespace meld::fuzz {

// The checked program, if the text is accepted. Diagnostics are rendered both ways, the printed program and tree are made:
// whatever a text is, that must end.
std::optional<check::Program> front_end(std::string text);

}  // namespace meld::fuzz
