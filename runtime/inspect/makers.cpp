#include "runtime/inspect/makers.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "runtime/base/bytes.h"
#include "runtime/inspect/all_facts.h"
#include "runtime/inspect/explainer.h"

namespace meld::inspect {

namespace {

using check::Clause;
using check::Head;
using check::Rule;
using Node = Explanation::Node;
using Part = Explanation::Part;

// So many facts of one answer are looked for, and so many ways for each are shown.
constexpr std::size_t kMostMade = 16, kMostWays = 3;

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

// How a linear rule may have made a fact, by the state before and the present one.
class Makers {
  public:
    Makers(Explainer& explainer, const Known& fact, Node& node) : e_(explainer), fact_(fact), node_(node) {}

    Result<void> find() {
        for (const Rule* rule : e_.makers(fact_.predicate)) {
            names_ += (names_.empty() ? "" : ", ") + fmt::format("{}:{}", rule->file, rule->line);
            if (auto done = heads(*rule, rule->heads, {}); !done) return done;
        }
        if (count_ == 0) node_.note += fmt::format(", by a rule among {}; what it took came within that tick", names_);
        if (count_ > 1) node_.note += fmt::format(", in one of {} ways", count_);
        if (count_ > node_.ways.size()) node_.more = count_ - node_.ways.size();
        return {};
    }

  private:
    Result<void> heads(const Rule& rule, const std::vector<Head>& all, const std::vector<Clause>& around) {
        for (const Head& h : all) {
            std::vector<Clause> more = around;
            more.insert(more.end(), h.body.begin(), h.body.end());
            if (h.kind == Head::Kind::If) more.push_back({.kind = Clause::Kind::Test, .test = h.term, .span = h.span});
            if (h.kind == Head::Kind::Fact && h.atom.predicate == fact_.predicate)
                if (auto done = by(rule, h.atom, more); !done) return done;
            if (auto done = heads(rule, h.heads, more); !done) return done;
            if (auto done = heads(rule, h.others, around); !done) return done;
        }
        return {};
    }
    Result<void> by(const Rule& rule, const check::Atom& head, const std::vector<Clause>& more) {
        const std::optional<Fitted> fitted = e_.fit(rule, head, fact_, false, more);
        if (!fitted || !e_.cannot(fitted->body).empty()) return {};
        const Result<bool> done = e_.search(*fitted, {.age = 1}, [&](const Solution& solution) {
            if (++count_ > kMostWays) return true;
            Explanation::Way way = e_.way_of(rule);
            for (std::size_t c = 0; c < fitted->own; ++c)
                if (solution.facts[c] != nullptr)
                    way.parts.push_back({.is = Part::Is::Fact,
                                         .text = e_.text(e_.keep(fitted->body[c].atom.predicate, *solution.facts[c], 1)),
                                         .tick = e_.states().tick - 1});
            node_.ways.push_back(std::move(way));
            return true;
        });
        if (!done) return tl::unexpected<Error>(done.error());
        return {};
    }

    Explainer& e_;
    const Known& fact_;
    Node& node_;
    std::string names_;
    std::size_t count_ = 0;
};

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
        return Makers(explainer, *known, *node).find();
    });
}

}  // namespace

Result<void> find_makers(timeline::Timeline& timeline, Explanation& explanation) {
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

Result<Comings> history(timeline::Timeline& timeline, const std::string& fact) {
    Comings out{.asked = fact, .first_tick = timeline.first_tick(), .last_tick = timeline.tick()};
    std::set<std::string> last;
    const Result<void> walked = timeline.walk(out.first_tick, out.last_tick, [&](sim::Simulation& simulation) -> Result<bool> {
        auto found = matches(simulation.subdomain(), fact);
        if (!found) return tl::unexpected<Error>(found.error());
        Comings::Tick tick{.tick = simulation.subdomain().tick()};
        std::ranges::set_difference(*found, last, std::back_inserter(tick.came));
        std::ranges::set_difference(last, *found, std::back_inserter(tick.went));
        if (tick.tick == out.first_tick)
            out.at_first = std::move(tick.came);
        else if (!tick.came.empty() || !tick.went.empty())
            out.ticks.push_back(std::move(tick));
        last = std::move(*found);
        return true;
    });
    if (!walked) return tl::unexpected<Error>(walked.error());
    return out;
}

}  // namespace meld::inspect
