// A question about a run, asked as a Meld body: it becomes a view of the program that no rule reads and that is none of its facts, so the
// run stays as it is.
//
//     dist(A, D), D > 3      becomes      type question@(node, first int D).   question@(A, D) :- dist(A, D), D > 3.
#pragma once

#include <string>

#include "compiler/check/program.h"
#include "compiler/diagnostics/diagnostics.h"
#include "compiler/source/source.h"
#include "compiler/syntax/tree.h"
#include "runtime/base/error.h"

namespace meld::front {

// Adds the view to the tree; it holds at the catom of the first fact of the body. Mistakes within the body are reported at their place in
// it. Errors: it is something other than a body, or names no catom.
Result<void> add_question(source::FileSet& files, const std::string& body, diagnostics::Reporter& report, syntax::Tree& program);

// Once the body is checked: the view gets the values of the body's variables as arguments, one way to satisfy the body at each catom.
void add_witness(check::Program& program);

}  // namespace meld::front
