#include "runtime/ask/debug/fired.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include "runtime/ask/debug/rule_text.h"
#include "runtime/ask/facts/all_facts.h"
#include "runtime/ask/facts/program.h"
#include "runtime/ask/query/solver.h"
#include "runtime/base/bytes.h"
#include "runtime/comm/transport/gather_to_root.h"
#include "runtime/engine/tuple/value_text.h"

namespace meld::debug {

namespace {

using check::Clause;
using inspect::Program;

// What stands before the arrow of a linear rule as Meld prints it.
std::string consumed_of(std::string_view text) {
    const std::size_t arrow = find_outside_strings(text, "-o ");
    if (arrow == std::string_view::npos) return std::string(text);
    return std::string(text.substr(0, text.find_last_not_of(' ', arrow - 1) + 1));
}

// Those parts of a question that stand behind the body of the rule.
std::vector<Clause> condition_in(const check::Rule& question, std::size_t body_bytes) {
    std::vector<Clause> out;
    for (const Clause& c : question.body)
        if (c.span.begin >= body_bytes) out.push_back(c);
    return out;
}

std::string asked_by(const LinearBreak& one) { return one.body + ", " + one.condition; }

// All firings of the tick, on process 0.
std::vector<eval::Firing> gathered(sim::Subdomain& subdomain) {
    ByteWriter mine;
    for (const eval::Firing& f : subdomain.firings()) {
        mine.write(f.rule);
        mine.write(f.catom);
        mine.write_block(f.bound);
    }
    std::vector<eval::Firing> all;
    for (const auto& share : comm::gather_to_root(subdomain.comm, mine.take()))
        for (ByteReader in(share, "firings of a process"); !in.done();) {
            eval::Firing& f = all.emplace_back();
            f.rule = in.read<u32>();
            f.catom = in.read<u64>();
            const auto bound = in.read_block();
            f.bound.assign(bound.begin(), bound.end());
        }
    // One process has evaluated a catom, and one thread of it.
    std::ranges::stable_sort(all, {}, &eval::Firing::catom);
    return all;
}

struct BoundValue {
    std::string name;
    tuple::Type type;
    Value value;
};
std::vector<BoundValue> bound_by(const ModuleInfo& module, const eval::Firing& firing, tuple::Arena& arena) {
    std::vector<BoundValue> out;
    for (ByteReader in(firing.bound, "the variables of a firing"); !in.done();) {
        std::string name = in.read_string();
        const tuple::Type type(module.types, in.read<u16>());
        const Value value = tuple::unpack(type, in, arena);
        out.push_back({std::move(name), type, value});
    }
    return out;
}

std::string text_of(const std::vector<BoundValue>& values) {
    std::string out;
    for (const BoundValue& v : values)
        out += fmt::format("{}{} = {}", out.empty() ? "" : ", ", v.name, tuple::print_value(v.type, v.value));
    return out;
}

// Whether the condition of a break can be satisfied with the values of a firing.
class Condition {
  public:
    Condition(const Program& program, const LinearBreak& asked, sim::Subdomain& subdomain, inspect::Facts& facts)
        : question_(program.question()),
          parts_(condition_in(question_, asked.body.size())),
          terms_(program, subdomain.view()),
          solver_(program, facts, terms_) {}

    Result<bool> holds(const std::vector<BoundValue>& known) {
        inspect::Values values(question_.variables.count());
        inspect::Bound bound(question_.variables.count());
        for (const check::VariableId v : question_.variables.ids()) {
            const auto found = std::ranges::find(known, question_.variables[v].name, &BoundValue::name);
            if (found == known.end()) continue;
            values[v.index()] = found->value;
            bound[v.index()] = true;
        }
        bool any = false;
        const auto one = [&](const inspect::Solution&) {
            any = true;
            return false;
        };
        if (auto done = solver_.search(question_, parts_, std::move(values), std::move(bound), one); !done)
            return tl::unexpected<Error>(done.error());
        return any;
    }

  private:
    const check::Rule& question_;
    std::vector<Clause> parts_;
    inspect::Terms terms_;
    inspect::Solver solver_;
};

}  // namespace

Result<LinearBreak> linear_break(const ModuleInfo& module, const check::Rule& rule, const std::string& condition) {
    LinearBreak out{.place = fmt::format("{}:{}", rule.file, rule.line), .body = consumed_of(rule.text), .condition = condition};
    const auto is = [&](const RuleInfo& info) { return info.linear && info.name == rule.name && info.text == rule.text; };
    while (out.rule < module.rule_count && !is(module.rules[out.rule])) ++out.rule;
    if (out.rule == module.rule_count)
        return fail(fmt::format("break: the module has no rule {}", rule.name), "Compile the program again", ExitCode::ModuleRefused);
    if (condition.empty()) return out;
    const Result<Program> program = Program::read(module, asked_by(out));
    if (!program) return tl::unexpected<Error>(program.error());
    if (auto can = program->can_ask(condition_in(program->question(), out.body.size())); !can) return tl::unexpected<Error>(can.error());
    return out;
}

Result<std::vector<Fired>> fired(sim::Subdomain& subdomain, std::span<const LinearBreak> breaks) {
    std::vector<Fired> out(breaks.size());
    const std::vector<eval::Firing> all = gathered(subdomain);
    const auto look = [&](std::span<inspect::Facts* const> facts) -> Result<void> {
        tuple::Arena arena;
        for (std::size_t i = 0; i < breaks.size(); ++i) {
            std::optional<Program> program;
            std::optional<Condition> condition;
            for (const eval::Firing& firing : all) {
                if (firing.rule != breaks[i].rule) continue;
                const std::vector<BoundValue> values = bound_by(subdomain.module, firing, arena);
                if (!breaks[i].condition.empty()) {
                    if (!condition) {
                        Result<Program> read = Program::read(subdomain.module, asked_by(breaks[i]));
                        if (!read) return tl::unexpected<Error>(read.error());
                        program.emplace(std::move(*read));
                        condition.emplace(*program, breaks[i], subdomain, *facts[0]);
                    }
                    const Result<bool> holds = condition->holds(values);
                    if (!holds) return tl::unexpected<Error>(holds.error());
                    if (!*holds) continue;
                }
                out[i].at.push_back(firing.catom);
                out[i].ways.push_back(text_of(values));
            }
        }
        return {};
    };
    sim::Subdomain* const states[] = {&subdomain};
    // Only conditions ask for facts, which may be those of other processes.
    const bool asks = std::ranges::any_of(breaks, [](const LinearBreak& one) { return !one.condition.empty(); });
    if (auto done = asks ? inspect::ask(states, look) : look({}); !done) return tl::unexpected<Error>(done.error());
    return out;
}

}  // namespace meld::debug
