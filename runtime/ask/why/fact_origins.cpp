#include "runtime/ask/why/fact_origins.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "runtime/ask/facts/all_facts.h"
#include "runtime/ask/why/explainer.h"
#include "runtime/ask/why/firings.h"
#include "runtime/base/bytes.h"

namespace meld::inspect {

namespace {

using Node = Explanation::Node;

// So many facts of one answer are looked for.
constexpr std::size_t kMostMade = 16;

// What is on process 0, on all.
std::vector<std::string> shared(const std::vector<std::string>& mine, comm::Communicator& comm) {
    ByteWriter out;
    for (const std::string& text : mine) out.write_string(text);
    const auto all = comm.allgather_any(comm.process() == 0 ? out.view() : std::span<const std::byte>{});
    std::vector<std::string> texts;
    for (ByteReader in(all[0], "facts that are asked about"); !in.done();) texts.push_back(in.read_string());
    return texts;
}

Result<std::set<std::string>> matches(sim::Subdomain& subdomain, const std::string& body) {
    std::set<std::string> out;
    sim::Subdomain* const states[] = {&subdomain};
    const Result<void> asked = ask(states, [&](std::span<Facts* const> facts) -> Result<void> {
        const Result<Program> program = Program::read(subdomain.module, body);
        if (!program) return tl::unexpected<Error>(program.error());
        if (auto can = program->can_ask(program->question().body); !can) return can;
        Terms terms(*program, subdomain.view());
        Explainer explainer(*program, {.facts = facts, .tick = subdomain.tick()}, terms);
        if (auto one = explainer.asked(); !one) return tl::unexpected<Error>(one.error());
        return explainer.each_match([&](const Known& fact) {
            out.insert(explainer.text(fact));
            return true;
        });
    });
    if (!asked) return tl::unexpected<Error>(asked.error());
    return out;
}

// The firings that may have made a fact, as its ways.
Result<void> tell(Explainer& explainer, const Known& fact, Node& node) {
    Result<Firings> found = that_made(explainer, fact);
    if (!found) return tl::unexpected<Error>(found.error());
    if (found->count == 0 && !found->rules.empty()) {
        const bool one = !found->ways.empty();
        const std::string at = one && found->ways[0].catom ? fmt::format(" at @{}", *found->ways[0].catom) : "";
        node.note += fmt::format(", by {}{}{}; what it took came within that tick", one ? "" : "a rule among ", found->rules, at);
    }
    if (found->count > 1) node.note += fmt::format(", in one of {} ways", found->count);
    if (found->count > found->ways.size()) node.more = found->count - found->ways.size();
    if (found->count > 0) node.ways = std::move(found->ways);
    return {};
}

Result<void> explain_made(timeline::Timeline& timeline, const std::string& fact, std::int64_t tick, Node* node) {
    auto before = timeline.beside(tick - 1), then = timeline.beside(tick);
    for (const auto* made : {&before, &then})
        if (!*made) return tl::unexpected<Error>(made->error());
    sim::Subdomain* const states[] = {&(*then)->subdomain(), &(*before)->subdomain()};
    return ask(states, [&](std::span<Facts* const> facts) -> Result<void> {
        const Result<Program> program = Program::read(states[0]->module, fact);
        if (!program) return tl::unexpected<Error>(program.error());
        Terms terms(*program, states[0]->view());
        Explainer explainer(*program, {.facts = facts, .tick = tick, .first_tick = timeline.first_tick()}, terms);
        const Result<Known> known = explainer.asked();
        if (!known) return tl::unexpected<Error>(known.error());
        return tell(explainer, *known, *node);
    });
}

}  // namespace

Result<void> find_origins(timeline::Timeline& timeline, Explanation& explanation) {
    comm::Communicator& comm = timeline.simulation().subdomain().comm;
    const std::int64_t now = timeline.tick(), first = timeline.first_tick();
    std::vector<std::string> mine;
    std::vector<std::size_t> nodes;
    for (std::size_t i = 0; i < explanation.nodes.size(); ++i) {
        const Node& n = explanation.nodes[i];
        if (n.is != Node::Is::Made || n.tick != now || mine.size() == kMostMade) continue;
        mine.push_back(n.fact);
        nodes.push_back(i);
    }
    const std::vector<std::string> facts = shared(mine, comm);
    if (facts.empty()) return {};
    // The last tick before which each was not there; on process 0.
    std::vector<std::optional<std::int64_t>> came(facts.size());
    std::vector<bool> there(facts.size(), false);
    const Result<void> walked = timeline.walk(first, now, [&](sim::Simulation& simulation) -> Result<bool> {
        for (std::size_t i = 0; i < facts.size(); ++i) {
            const auto found = matches(simulation.subdomain(), facts[i]);
            if (!found) return tl::unexpected<Error>(found.error());
            const bool is = !found->empty();
            if (is && !there[i] && simulation.subdomain().tick() > first) came[i] = simulation.subdomain().tick();
            there[i] = is;
        }
        return true;
    });
    if (!walked) return walked;
    std::vector<std::string> ticks;
    for (const auto& tick : came) ticks.push_back(tick ? std::to_string(*tick) : "");
    ticks = shared(ticks, comm);
    for (std::size_t i = 0; i < facts.size(); ++i) {
        Node none;
        Node& node = comm.process() == 0 ? explanation.nodes[nodes[i]] : none;
        if (ticks[i].empty()) {
            node.note = first == 0 ? "there from the start" : fmt::format("there already in tick {}, before which nothing is known", first);
            continue;
        }
        const std::int64_t tick = std::stoll(ticks[i]);
        node.note = fmt::format("made in tick {}", tick);
        if (auto done = explain_made(timeline, facts[i], tick, &node); !done) return done;
    }
    return {};
}

}  // namespace meld::inspect
