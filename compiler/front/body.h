// A body that somebody asks about a run, in Meld: `dist(A, D), D > 3`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "compiler/check/program/program.h"
#include "compiler/diagnostics/diagnostics.h"
#include "compiler/source/source.h"
#include "compiler/syntax/tree.h"
#include "runtime/base/error.h"

namespace meld::front {

// A rule with this body and no head, whose arrow is Question; its file in the set is named "the body". Nothing if there are mistakes, which
// are reported at their place in it. Errors: it is something other than a body.
Result<std::optional<syntax::Rule>> parse_body(source::FileSet& files, const std::string& body, diagnostics::Reporter& report);

// The rules of a file of watches, head :- body; nothing if there are mistakes, or something else, which are reported.
std::optional<std::vector<syntax::Rule>> parse_rules(source::FileSet& files, std::uint32_t file, diagnostics::Reporter& report);

// The variables with a name that every way to satisfy a checked body gives a value, in the order in which they occur; without the rule's
// execution site.
std::vector<check::VariableId> answers(const check::Rule& rule);

}  // namespace meld::front
