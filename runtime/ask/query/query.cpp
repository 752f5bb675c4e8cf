#include "runtime/ask/query/query.h"

#include <optional>
#include <utility>
#include <vector>

#include "compiler/front/body.h"
#include "runtime/ask/facts/all_facts.h"
#include "runtime/ask/facts/program.h"
#include "runtime/ask/query/solver.h"
#include "runtime/ask/query/terms.h"

namespace meld::inspect {

namespace {

std::string name_of(Trap trap) {
    switch (trap) {
        case Trap::Overflow:
            return "an overflow";
        case Trap::DivisionByZero:
            return "a division by zero";
        case Trap::NotANumber:
            return "a result that is no number";
        case Trap::BadConversion:
            return "a float that does not fit an int";
        case Trap::BadIndex:
            return "an element that a list does not have";
        case Trap::TooDeep:
            return "calls that are nested too deep";
        case Trap::NotAnInt:
        case Trap::NotAFloat:
            return "a string that is no number";
        case Trap::NegativePower:
            return "a negative power of an int";
        default:
            return "a value that is too large";
    }
}

}  // namespace

std::vector<Table::Column> columns_of(const Program& program) {
    const check::Rule& question = program.question();
    std::vector<Table::Column> columns;
    for (const check::VariableId v : front::answers(question)) columns.push_back({question.variables[v].name, question.variables[v].type});
    return columns;
}

Result<Table> query_here(const sim::Subdomain& subdomain, Facts& facts, const Program& program, const std::optional<From>& from,
                         const std::function<void(std::uint64_t)>& looked) {
    const check::Rule& question = program.question();
    const std::vector<check::VariableId> variables = front::answers(question);
    Table table(columns_of(program));
    Terms terms(program, subdomain.view());
    Solver solver(program, facts, terms);
    std::vector<Value> row(variables.size());
    const auto add = [&](const Solution& found) {
        for (std::size_t i = 0; i < variables.size(); ++i) row[i] = found.values[variables[i].index()];
        table.add(row);
        return !variables.empty();
    };
    const SearchOptions options{.looked = looked};
    const Result<void> searched =
        from ? solver.search_from(
                   question, question.body, from->start, from->catoms, add, [](std::size_t) { return true; }, options)
             : solver.search(question, question.body, {}, {}, add, options);
    if (!searched) return tl::unexpected<Error>(searched.error());
    table.finish();
    table.failures = terms.scratch.failures();
    if (table.failures > 0) table.first_failure = name_of(terms.scratch.first_failure());
    return table;
}

Result<Program> read_question(const ModuleInfo& module, const std::string& body) {
    Result<Program> program = Program::read(module, body);
    if (!program) return program;
    if (auto can = program->can_ask(program->question().body); !can) return tl::unexpected<Error>(can.error());
    return program;
}

namespace {

const Program& program_of(const Program& program) { return program; }
const Program& program_of(const Program* program) { return *program; }

// Process 0 reads the body, if it has not been read, and searches; the others give it their facts.
template <class Read>
Result<Table> query_by(sim::Subdomain& subdomain, const Read& read, const std::function<void(std::uint64_t)>& looked) {
    Table table;
    sim::Subdomain* const states[] = {&subdomain};
    const Result<void> asked = ask(states, [&](std::span<Facts* const> facts) -> Result<void> {
        const auto program = read();
        if (!program) return tl::unexpected<Error>(program.error());
        Result<Table> found = query_here(subdomain, *facts[0], program_of(*program), {}, looked);
        if (!found) return tl::unexpected<Error>(found.error());
        table = std::move(*found);
        return {};
    });
    if (!asked) return tl::unexpected<Error>(asked.error());
    return table;
}

}  // namespace

Result<Table> query(sim::Subdomain& subdomain, const std::string& body, const std::function<void(std::uint64_t)>& looked) {
    return query_by(subdomain, [&] { return read_question(subdomain.module, body); }, looked);
}

Result<Table> query(sim::Subdomain& subdomain, const Program& program, const std::function<void(std::uint64_t)>& looked) {
    return query_by(subdomain, [&] { return Result<const Program*>(&program); }, looked);
}

}  // namespace meld::inspect
