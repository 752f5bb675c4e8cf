#include "runtime/ask/messages/groups.h"

#include <fmt/format.h>

#include "compiler/plan/plan.h"
#include "runtime/ask/facts/program.h"

namespace meld::inspect {

namespace {

bool is_exported(const ModuleInfo& module, u32 predicate) {
    const u16 column = module.predicates[predicate].column;
    return column != kNone16 && module.columns[column].exported;
}

}  // namespace

Result<std::vector<Group>> groups_of(const ModuleInfo& module) {
    const Result<Program> program = Program::read(module, front::Asked{});
    if (!program) return tl::unexpected<Error>(program.error());
    const plan::Plan plan = plan::make_plan(program->checked());
    std::vector<Group> groups(module.predicate_count);
    for (u32 i = 0; i < module.predicate_count; ++i) {
        if (!is_exported(module, i)) continue;
        const PredicateInfo& info = module.predicates[i];
        const check::PredicateId id(i);
        const bool known = i < plan.program.predicates.count();
        const check::Predicate* const p = known ? &plan.program.predicates[id] : nullptr;
        if (p == nullptr || p->name != info.name || p->arguments.size() != std::size_t{info.arity} + 1 || !plan.of(id).exported)
            return fail(fmt::format("the module of {} was compiled in a way of its own, so it is not known what {} tells neighbours",
                                    module.program_name, info.name),
                        "Ask the program, without a module made by meldc compile --without", ExitCode::ModuleRefused);
        groups[i].arguments = p->aggregate == check::Aggregate::None ? info.arity : static_cast<u16>(p->aggregate_at - 1);
        groups[i].has_value = p->aggregate != check::Aggregate::Since;
    }
    return groups;
}

}  // namespace meld::inspect
