#include "compiler/check/analysis/own_graph.h"

#include <algorithm>
#include <optional>
#include <set>

namespace meld::check {

namespace {

// The node that a term names, itself or by a constant.
std::optional<std::int64_t> named_node(const Program& program, const Term& term) {
    if (term.op == Op::Node) return term.integer;
    if (term.op != Op::Constant || program.constants[term.constant].argument) return std::nullopt;
    const Term& value = program.constants[term.constant].value;
    return value.op == Op::Node ? std::optional(value.integer) : std::nullopt;
}

bool names_several_nodes(const Program& program) {
    std::set<std::int64_t> nodes;
    const auto note = [&](const Term& whole) {
        each_subterm(whole, [&](const Term& t) {
            if (t.op == Op::Node) nodes.insert(t.integer);
        });
    };
    for (const Rule& rule : program.rules) each_term(rule, note);
    for (const Constant& c : program.constants) note(c.value);
    for (const Function& f : program.functions) note(f.body);
    return nodes.size() > 1;
}

// The catom at which a fact of the text holds: A in edge(A, @2), A = @1.
std::optional<std::int64_t> fixed_at(const Program& program, const Rule& rule, const Term& place) {
    for (const Clause& c : rule.body) {
        if (c.kind != Clause::Kind::Test || c.test.op != Op::Equal || c.test.operands.size() != 2) continue;
        for (const std::size_t side : {0u, 1u})
            if (c.test.operands[side].is_variable() && c.test.operands[side].variable == place.variable)
                if (const auto node = named_node(program, c.test.operands[1 - side])) return node;
    }
    return std::nullopt;
}

bool states_link(const Program& program) {
    return std::ranges::any_of(program.rules, [&](const Rule& rule) {
        const bool stated = std::ranges::all_of(rule.body, [](const Clause& c) { return c.kind == Clause::Kind::Test; });
        return stated && std::ranges::any_of(rule.heads, [&](const Head& h) {
                   if (h.kind != Head::Kind::Fact || h.delay.op != Op::Anonymous || !program.predicates[h.atom.predicate].route)
                       return false;
                   const auto from = fixed_at(program, rule, h.atom.arguments[0]), to = named_node(program, h.atom.arguments[1]);
                   return from && to && *from != *to;
               });
    });
}

// Whether some rule asks for the links of the world, or for its cells.
bool reads_world(const Program& program) {
    const auto of_world = [&](const Atom& a) {
        const WorldSource source = program.predicates[a.predicate].world;
        return is_link(source) || source == WorldSource::NeighborCount || info(source).has(SenseInfo::kCells);
    };
    return std::ranges::any_of(program.rules, [&](const Rule& rule) {
        bool reads = false;
        const auto look = [&](const std::vector<Clause>& body) {
            each_atom(body, [&](const Atom& a, bool) { reads = reads || of_world(a); });
        };
        look(rule.body);
        each_head(rule.heads, [&](const Head& h) { look(h.body); });
        return reads;
    });
}

bool makes_node(const std::vector<Head>& heads, Variables fresh) {
    return std::ranges::any_of(heads, [&](const Head& h) {
        if (h.kind == Head::Kind::Fact) return fresh.contains(h.atom.arguments[0].variable);
        if (h.kind == Head::Kind::Set && h.term.op == Op::Fresh) fresh.insert(h.variable);
        return makes_node(h.heads, fresh) || makes_node(h.others, fresh);
    });
}

}  // namespace

bool runs_in_own_graph(const Program& program, bool finds_ways) {
    if (std::ranges::any_of(program.rules, [](const Rule& rule) { return makes_node(rule.heads, {}); })) return true;
    const bool links = states_link(program), nodes = names_several_nodes(program);
    if (links && finds_ways) return true;
    return (links || (nodes && (finds_ways || program.kinds))) && !reads_world(program);
}

}  // namespace meld::check
