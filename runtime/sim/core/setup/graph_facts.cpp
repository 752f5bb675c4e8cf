#include "runtime/sim/core/setup/graph_facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "runtime/engine/tuple/facts.h"
#include "runtime/engine/tuple/value_text.h"
#include "runtime/module/abi/senses.h"

namespace meld::sim {
namespace {

constexpr std::string_view kLink = "link";

using graph::Column;
using graph::Graph;
using graph::Node;

class GraphFacts {
  public:
    GraphFacts(Subdomain& subdomain, const std::vector<Catom>* only) : subdomain_(subdomain), graph_(*subdomain.world.graph), only_(only) {}

    Result<void> give_links(const PredicateInfo& p) {
        if (tuple::type_of(subdomain_.module, p.fields[0]).kind() != ValueType::Node)
            return fail(fmt::format("the second argument of {} is no node, and the world gives it the links of its graph", p.name),
                        fmt::format("Declare it as type {}(node, node), or give the predicate another name", p.name));
        if (p.arity > graph_.columns.size() + 1)
            return fail(fmt::format("{} has {} arguments after its two nodes, and the links of the graph have {} columns", p.name,
                                    p.arity - 1, graph_.columns.size()),
                        "Declare fewer, or add the columns to the file of links");
        return each_node([&](Catom catom, Node node) -> Result<void> {
            for (u64 at = graph_.first[node]; at < graph_.first[node + 1]; ++at) {
                if (!graph_.leads(at)) continue;
                values_.assign(1, Value{.catom = graph_.id(graph_.to[at])});
                for (u32 i = 1; i < p.arity; ++i)
                    if (auto fine = add(p, i, graph_.columns[i - 1], graph_.row[at]); !fine) return fine;
                give(p, catom);
            }
            return {};
        });
    }

    Result<void> give_column(const PredicateInfo& p, const Column& column) {
        return each_node([&](Catom catom, Node node) -> Result<void> {
            values_.clear();
            if (auto fine = add(p, 0, column, node); !fine) return fine;
            give(p, catom);
            return {};
        });
    }

  private:
    template <class Visit>
    Result<void> each_node(const Visit& visit) const {
        const std::size_t count = only_ != nullptr ? only_->size() : subdomain_.ensemble.index_count();
        for (std::size_t i = 0; i < count; ++i) {
            const Catom c = only_ != nullptr ? (*only_)[i] : static_cast<Catom>(i);
            if (!subdomain_.owned(c)) continue;
            // Files say nothing about nodes that rules have made.
            const std::optional<Node> node = graph_.find(subdomain_.ensemble.id(c));
            if (!node) continue;
            if (auto done = visit(c, *node); !done) return done;
        }
        return {};
    }

    Result<void> add(const PredicateInfo& p, u32 field, const Column& column, std::size_t row) {
        const auto value = tuple::parse_value(tuple::type_of(subdomain_.module, p.fields[field]), column.text(row), scratch_);
        if (!value)
            return fail(fmt::format("{} takes the column {} of the graph: {}", p.name, column.name, value.error().problem),
                        value.error().suggestion);
        values_.push_back(*value);
        return {};
    }

    void give(const PredicateInfo& p, Catom catom) { subdomain_.give(p.base, catom, values_.data()); }

    Subdomain& subdomain_;
    const Graph& graph_;
    const std::vector<Catom>* only_;  // Otherwise all.
    std::vector<Value> values_;
    tuple::Arena scratch_;
};

// Nodes have no cells, and there is nothing between their ports.
Result<void> check_senses(const ModuleInfo& module) {
    for (const auto& [name, arity, source] : sense_names()) {
        const std::optional<u32> p = info(source).has(SenseInfo::kCells) ? tuple::find_sensed(module, name, arity) : std::nullopt;
        if (p && module.predicates[*p].storage == Storage::World && module.predicates[*p].read)
            return fail(fmt::format("the program reads {} with {} arguments, and the nodes of a graph have no cells", name, arity + 1),
                        "Read neighbor, or give the world a lattice");
    }
    return {};
}

// A program that makes nodes may make those that events will join.
Result<void> check_joins(const ModuleInfo& module, const world::World& world) {
    if (module.makes_nodes) return {};
    for (const world::Event& event : world.events)
        for (const world::LinkChoice& choice : event.join)
            for (const u64 id : {choice.pair->first, choice.pair->second})
                if (!world.graph->find(id))
                    return fail(fmt::format("{}: the graph has no node {}", choice.place, id), "Join two of its nodes");
    return {};
}

// Aggregates that wait keep a bit for each neighbour.
constexpr u64 kMostAwaited = 32;

Result<void> check_degrees(const ModuleInfo& module, const world::World& world) {
    const Graph& graph = *world.graph;
    std::map<std::uint64_t, u64> joined;
    for (const world::Event& event : world.events)
        for (const world::LinkChoice& choice : event.join) ++joined[choice.pair->first], ++joined[choice.pair->second];
    if (module.waits && world.has_moving_nodes())
        return fail(fmt::format("the program has an aggregate that waits for all neighbours, of which there may be {}, and nodes that move "
                                "may come to have more",
                                kMostAwaited),
                    "Use an aggregate that does not wait");
    for (Node node = 0; module.waits && node < graph.nodes(); ++node) {
        const auto more = joined.find(graph.id(node));
        const u64 degree = graph.degree(node) + (more == joined.end() ? 0 : more->second);
        if (degree > kMostAwaited)
            return fail(
                fmt::format("the program has an aggregate that waits for all neighbours, of which there may be {}, and node {} has {}",
                            kMostAwaited, graph.id(node), degree),
                "Use an aggregate that does not wait, or a graph with fewer links for each node");
    }
    // A node that rules make has the links that events give it.
    for (const auto& [id, links] : joined)
        if (module.waits && !graph.find(id) && links > kMostAwaited)
            return fail(
                fmt::format("the program has an aggregate that waits for all neighbours, of which there may be {}, and events join node {} "
                            "with {}",
                            kMostAwaited, id, links),
                "Use an aggregate that does not wait, or join it with fewer");
    return {};
}

// Whether the text states facts of a predicate: then it is the program's own, whatever its name.
bool states_facts(const ModuleInfo& module, u32 predicate) {
    return std::ranges::any_of(std::span(module.rules, module.rule_count), [&](const RuleInfo& r) {
        return r.at != kEverywhere && std::find(r.heads, r.heads + r.head_count, predicate) != r.heads + r.head_count;
    });
}

bool may_be_given(const PredicateInfo& p) { return !p.auxiliary && p.base != kNone16 && p.column != kNone16; }

}  // namespace

bool graph_gives(const world::World& world, std::string_view name) {
    if (!world.is_graph()) return false;
    if (name == kLink) return !world.has_moving_nodes();
    for (const Column& column : world.graph->node_columns)
        if (column.name == name) return true;
    return false;
}

Result<void> give_graph_facts(Subdomain& subdomain, const std::vector<Catom>* only) {
    if (!subdomain.world.is_graph()) return {};
    if (auto fine = check_senses(subdomain.module); !fine) return fine;
    if (auto fine = check_degrees(subdomain.module, subdomain.world); !fine) return fine;
    if (auto fine = check_joins(subdomain.module, subdomain.world); !fine) return fine;
    GraphFacts facts(subdomain, only);
    for (u32 i = 0; i < subdomain.module.predicate_count; ++i) {
        const PredicateInfo& p = subdomain.module.predicates[i];
        if (!may_be_given(p)) continue;
        if (p.name == kLink && graph_gives(subdomain.world, kLink) && p.arity > 0 && !states_facts(subdomain.module, i))
            if (auto given = facts.give_links(p); !given) return given;
        if (p.arity != 1) continue;
        for (const Column& column : subdomain.world.graph->node_columns)
            if (column.name == p.name)
                if (auto given = facts.give_column(p, column); !given) return given;
    }
    return {};
}

}  // namespace meld::sim
