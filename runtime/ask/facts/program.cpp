#include "runtime/ask/facts/program.h"

#include <fmt/format.h>

#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "compiler/check/program/library.h"
#include "compiler/front/carried.h"
#include "compiler/syntax/stable_name.h"
#include "runtime/base/assert.h"

namespace meld::inspect {

namespace {

using check::Op;

tl::unexpected<Error> another_program(const ModuleInfo& module, const std::string& why) {
    return fail(fmt::format("the sources in the module of {} are not those of its facts: {}", module.program_name, why),
                "Compile the program again with this version of meldc", ExitCode::ModuleRefused);
}

bool kinds_agree(check::PredicateKind a, PredicateKind b) { return static_cast<int>(a) == static_cast<int>(b); }
static_assert(static_cast<int>(check::PredicateKind::Sensed) == static_cast<int>(PredicateKind::Sensed) &&
              static_cast<int>(check::PredicateKind::Linear) == static_cast<int>(PredicateKind::Linear) &&
              static_cast<int>(check::PredicateKind::Action) == static_cast<int>(PredicateKind::Action));

// By name and number of arguments. The planner only adds predicates, so a predicate usually has the number that it has in the module; what
// a question has added itself, for stable facts, may have another one.
std::optional<u32> find(const ModuleInfo& module, check::PredicateId id, const check::Predicate& p) {
    const auto is = [&](u32 i) {
        return module.predicates[i].name == p.name && std::size_t{module.predicates[i].arity} + 1 == p.arguments.size();
    };
    const auto own = static_cast<u32>(id.index());
    if (own < module.predicate_count && is(own)) return own;
    for (u32 i = 0; i < module.predicate_count; ++i)
        if (is(i)) return i;
    return std::nullopt;
}

}  // namespace

Result<Program> Program::read(const ModuleInfo& module, const front::Asked& asked) {
    Program program;
    program.module_ = &module;
    if (module.source_count == 0) return another_program(module, "there are none");
    front::Carried carried;
    for (u32 i = 0; i < module.source_count; ++i) carried.sources.push_back({module.sources[i].path, module.sources[i].text});
    for (u32 i = 0; i < module.include_count; ++i) {
        const u32 source = module.includes[i];
        carried.includes.push_back(source < module.source_count ? std::optional(source) : std::nullopt);
    }
    if (module.program_count == 0 || module.program_count > module.source_count) return another_program(module, "it has too few");
    carried.programs = module.program_count;
    if (module.for_graphs) carried.worlds = check::Worlds::Graphs;
    diagnostics::Reporter report;
    Result<check::Program> checked = front::check_carried(program.files_, carried, asked, report);
    if (!checked) return tl::unexpected<Error>(checked.error());
    if (report.has_errors()) return fail(diagnostics::render_errors(program.files_, report));
    program.checked_ = std::move(*checked);
    if (auto found = program.find_sources(); !found) return tl::unexpected<Error>(found.error());
    if (auto found = program.find_parameters(); !found) return tl::unexpected<Error>(found.error());
    return program;
}

Result<void> Program::find_sources() {
    for (const check::PredicateId id : checked_.predicates.ids()) {
        const check::Predicate& p = checked_.predicates[id];
        Source source{.arity = static_cast<u16>(p.arguments.size() - 1)};
        const std::optional<u32> found = find(*module_, id, p);
        if (found) source.predicate = *found;
        const PredicateInfo* const known = found ? &module_->predicates[*found] : nullptr;
        if (known != nullptr && !kinds_agree(p.kind, known->kind)) return another_program(*module_, p.signature() + " is of another kind");
        if (p.world != WorldSource::None) {
            source.kind = Source::Kind::World;
            source.world = p.world;
        } else if (p.kind == check::PredicateKind::Action) {
            source.kind = Source::Kind::Actions;
        } else if (known != nullptr && known->column != kNone16) {
            source.kind = Source::Kind::Stored;
        }
        sources_.push_back(source);
    }
    return {};
}

// The planner leaves constants as they are, so they have the numbers of the module's; a question may bring new ones behind them.
Result<void> Program::find_parameters() {
    for (const check::ConstantId id : checked_.constants.ids()) {
        const check::Constant& c = checked_.constants[id];
        const bool in_module = !c.prelude && !c.computed.valid();
        const bool found = id.index() < module_->parameter_count && module_->parameters[id.index()].name == c.name;
        if (in_module && !found && c.argument)
            return fail(fmt::format("the program takes no @{}, so it has no value", c.name), "Write the value itself");
        if (in_module && !found) return another_program(*module_, fmt::format("the constant {}", c.name));
        parameters_.push_back(in_module ? std::optional(static_cast<u32>(id.index())) : std::nullopt);
    }
    return {};
}

Result<void> Program::can_compute(const check::Term& term) const {
    std::set<check::FunctionId> seen;
    std::optional<std::string> external, random;
    const auto look = [&](const auto& self, const check::Term& t) -> void {
        check::each_subterm(t, [&](const check::Term& part) {
            if (part.op == Op::Library && check::library_function(part.text, part.operands.size())->random) random = part.text;
            check::FunctionId f = part.op == Op::Call ? part.function : check::FunctionId{};
            if (part.op == Op::Constant) f = checked_.constants[part.constant].computed;
            if (!f.valid() || !seen.insert(f).second) return;
            if (checked_.functions[f].external)
                external = checked_.functions[f].name;
            else
                self(self, checked_.functions[f].body);
        });
    };
    look(look, term);
    if (random) return fail(fmt::format("this calls '{}', whose value is not kept", *random), "Ask for the fact that was made of it");
    if (!external) return {};
    return fail(fmt::format("this calls '{}', a function in C, and only the program's rules can call it", *external),
                "Let a rule of the program compute the value, and ask for its fact");
}

namespace {

std::string written(const check::Predicate& p) {
    const auto stable = syntax::read_stable_name(p.name);
    return stable ? fmt::format("stable({}/{}, {})", stable->predicate, p.arguments.size(), stable->ticks) : p.signature();
}

}  // namespace

Result<void> Program::can_ask(const std::vector<check::Clause>& body) const {
    for (const check::Clause& c : body) {
        if (c.kind == check::Clause::Kind::Atom && source(c.atom.predicate).kind == Source::Kind::Nowhere)
            return fail(fmt::format("the run has no facts of '{}', because no rule of the program reads it",
                                    written(checked_.predicates[c.atom.predicate])),
                        "Let a rule of the program read it, and run it again");
        if (c.kind == check::Clause::Kind::Delta)
            return fail("this looks at a change in the tick, and only one moment is known", "Let a rule of the program record the change");
        for (const check::Term& t : c.atom.arguments)
            if (auto can = can_compute(t); !can) return can;
        for (const check::Term* t : {&c.test, &c.parameter})
            if (auto can = can_compute(*t); !can) return can;
        if (c.fold.valid())
            if (auto can = can_compute({.op = Op::Call, .function = c.fold}); !can) return can;
        if (auto can = can_ask(c.inner); !can) return can;
    }
    return {};
}

}  // namespace meld::inspect
