#include "runtime/ask/query/catom_question.h"

#include <algorithm>
#include <utility>

#include "compiler/front/body.h"
#include "runtime/ask/facts/local_facts.h"
#include "runtime/ask/query/query.h"

namespace meld::inspect {

using check::Clause;
using check::Op;
using check::VariableId;

namespace {

// What changes only where catoms are told of it: not the tick, and not the target, which an event may change.
bool is_of_catom(WorldSource source) {
    switch (source) {
        case WorldSource::Neighbor:
        case WorldSource::NeighborPort:
        case WorldSource::NeighborCount:
        case WorldSource::Vacant:
        case WorldSource::Cell:
        case WorldSource::Id:
            return true;
        default:
            return false;
    }
}

bool reads_run(const check::Term& term) {
    return check::any_subterm(term, [](const check::Term& t) {
        return t.op == Op::Now || t.op == Op::Ticks || t.op == Op::Due || t.op == Op::Fresh || t.op == Op::NewNode;
    });
}

// All atoms are at this catom.
bool is_about(const Program& program, const std::vector<Clause>& body, VariableId catom) {
    bool about = true;
    check::each_clause(body, [&](const Clause& c) {
        if (c.kind == Clause::Kind::Delta) about = false;
        if (c.kind != Clause::Kind::Atom) return;
        const check::Term& where = c.atom.arguments[0];
        const Source& source = program.source(c.atom.predicate);
        about = about && where.is_variable() && where.variable == catom &&
                (source.kind == Source::Kind::Stored || (source.kind == Source::Kind::World && is_of_catom(source.world)));
    });
    check::each_term(body, [&](const check::Term& t) { about = about && !reads_run(t); });
    return about;
}

}  // namespace

std::optional<CatomQuestion> CatomQuestion::read(const ModuleInfo& module, const std::string& body) {
    Result<Program> program = read_question(module, body);
    if (!program) return std::nullopt;
    const check::Rule& question = program->question();
    const std::vector<VariableId> variables = front::answers(question);
    const auto catom = std::ranges::find(variables, check::Type::Kind::Node, [&](VariableId v) { return question.variables[v].type.kind; });
    if (catom == variables.end() || !is_about(*program, question.body, *catom)) return std::nullopt;
    // Some atom says which catoms there are.
    if (std::ranges::find(question.body, Clause::Kind::Atom, &Clause::kind) == question.body.end()) return std::nullopt;
    return CatomQuestion(std::move(*program), *catom);
}

std::vector<Table::Column> CatomQuestion::columns() const { return columns_of(program_); }

Result<Table> CatomQuestion::at_all(sim::Subdomain& subdomain) const {
    LocalFacts facts(subdomain);
    return query_here(subdomain, facts, program_);
}

Result<Table> CatomQuestion::at(sim::Subdomain& subdomain, std::span<const u64> catoms) const {
    LocalFacts facts(subdomain);
    return query_here(subdomain, facts, program_, From{.start = catom_, .catoms = catoms});
}

}  // namespace meld::inspect
