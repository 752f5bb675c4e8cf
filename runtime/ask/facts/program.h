// The checked program of a run beside its module: where the run keeps the facts of each predicate, and the values of constants.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "compiler/check/program/program.h"
#include "compiler/diagnostics/diagnostics.h"
#include "compiler/front/carried.h"
#include "compiler/source/source.h"
#include "runtime/base/assert.h"
#include "runtime/base/error.h"
#include "runtime/module/abi/module_abi.h"
#include "runtime/module/abi/senses.h"

namespace meld::inspect {

// Where a run has the facts of a predicate.
struct Source {
    enum class Kind {
        Stored,   // In a column of the module.
        World,    // Read from the ensemble.
        Actions,  // What catoms have asked for in this tick.
        Nowhere,  // Nothing in the program reads it, so the run does not have it.
    } kind = Kind::Nowhere;
    u32 predicate = kNone32;  // Of the module; kNone32: it has none of this name.
    WorldSource world = WorldSource::None;
    u16 arity = 0;  // Without the catom.
    bool operator==(const Source&) const = default;
};

class Program {
  public:
    // From the sources that the module carries, with a body that is asked; an empty one asks nothing. Errors: the body has mistakes, which
    // the message shows at their places; the module was made from other sources than it carries, or by another compiler (5).
    static Result<Program> read(const ModuleInfo& module, const front::Asked& asked);
    static Result<Program> read(const ModuleInfo& module, const std::string& body) { return read(module, front::Asked{.text = body}); }

    const check::Program& checked() const { return checked_; }
    const source::FileSet& files() const { return files_; }
    const ModuleInfo& module() const { return *module_; }
    // The body that is asked.
    const check::Rule& question() const {
        MELD_EXPECT(!checked_.questions.empty(), "nothing is asked");
        return checked_.questions.front();
    }

    const Source& source(check::PredicateId id) const { return sources_[id.index()]; }
    // The number of a constant's value among SubdomainView::parameters; nothing: the program's text alone says it.
    std::optional<u32> parameter(check::ConstantId id) const { return parameters_[id.index()]; }

    // Errors: a body of a rule, also within its parts, reads what the run does not have, looks at a change, or calls what only a module
    // can.
    Result<void> can_ask(const std::vector<check::Clause>& body) const;

  private:
    Program() = default;
    Result<void> find_sources();
    Result<void> find_parameters();
    Result<void> can_compute(const check::Term& term) const;

    source::FileSet files_;
    check::Program checked_;
    const ModuleInfo* module_ = nullptr;
    std::vector<Source> sources_;
    std::vector<std::optional<u32>> parameters_;
};

}  // namespace meld::inspect
