#include "runtime/ask/facts/all_facts.h"

#include <algorithm>
#include <map>
#include <memory>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include "runtime/ask/facts/fact_block.h"
#include "runtime/ask/facts/local_facts.h"
#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/comm/transport/collective_result.h"

namespace meld::inspect {

namespace {

// After so many questions for single catoms all facts of a predicate are fetched.
constexpr u32 kManyLookups = 64;

struct Request {
    enum class What : std::uint8_t { At, Heard, Each, Exists, Loss, Done } what = What::Done;
    std::uint8_t state = 0;
    bool back = false;  // Links by the catom they lead to.
    Source source = {};
    u64 catom = 0;
    u64 group = 0;  // Of a loss; of what is heard, by whom.
};

// ---- the processes that answer

class Server {
  public:
    Server(std::span<sim::Subdomain* const> states) : comm_(states[0]->comm) {
        for (sim::Subdomain* state : states) facts_.push_back(std::make_unique<LocalFacts>(*state));
    }
    void run() {
        while (true) {
            const auto all = comm_.allgather_any({});
            ByteReader in(all[0], "what a question asks for");
            const auto request = in.read<Request>();
            if (request.what == Request::What::Done) return;
            std::vector<comm::Packet> packets;
            ByteWriter out;
            answer(request, out);
            if (!out.empty()) packets.push_back({0, out.take()});
            comm_.exchange(std::move(packets));
        }
    }

  private:
    void answer(const Request& request, ByteWriter& out) {
        LocalFacts& facts = *facts_[request.state];
        const ModuleInfo& module = facts.subdomain().module;
        const auto tell = [&](u64 asked_by) {
            return [&, asked_by](const Fact& fact) { return pack(module, request.source, asked_by, fact, out), true; };
        };
        switch (request.what) {
            case Request::What::Exists:
                if (facts.exists(request.catom)) out.write(true);
                break;
            case Request::What::Loss:
                if (const auto lost = facts.loss(request.source, request.catom, request.group)) out.write(*lost);
                break;
            case Request::What::At:
                if (request.back)
                    facts.back(request.source, request.catom, tell(request.catom));
                else
                    facts.at(request.source, request.catom, tell(request.catom));
                break;
            case Request::What::Heard:
                if (facts.exists(request.group)) facts.heard(request.source, request.catom, request.group, tell(request.catom));
                break;
            case Request::What::Each:
                if (request.back)
                    facts.each_catom([&](u64 catom) { facts.back(request.source, catom, tell(catom)); });
                else
                    facts.each(request.source, [&](const Fact& fact) { return pack(module, request.source, fact.catom, fact, out), true; });
                break;
            case Request::What::Done:
                break;
        }
    }

    comm::Communicator& comm_;
    std::vector<std::unique_ptr<LocalFacts>> facts_;
};

// ---- the process that asks

class AllFacts : public Facts {
  public:
    AllFacts(sim::Subdomain& subdomain, std::uint8_t state) : here_(subdomain), state_(state) {}

    bool at(const Source& source, u64 catom, const Visit& visit) override {
        if (here_.exists(catom)) return here_.at(source, catom, visit);
        return elsewhere(source, false, catom, visit);
    }
    bool heard(const Source& source, u64 catom, u64 by, const Visit& visit) override {
        if (!here_.travels(source)) return at(source, catom, visit);
        if (here_.exists(by)) return here_.heard(source, catom, by, visit);
        std::unique_ptr<Block>& block = heard_[{source.predicate, catom, by}];
        if (block == nullptr) block = fetch({Request::What::Heard, state_, false, source, catom, by});
        return block->visit(0, source.arity, visit);
    }
    bool back(const Source& source, u64 to, const Visit& visit) override {
        if (here_.exists(to)) return here_.back(source, to, visit);
        return elsewhere(source, true, to, visit);
    }
    bool each(const Source& source, const Visit& visit) override {
        const Block& all = all_of(kept_of(source, false), source, false);
        const std::size_t arity = source.arity;
        std::size_t row = 0;
        const auto until = [&](u64 catom) {
            while (row < all.rows.size() && all.rows[row].asked_by < catom)
                if (!visit(all.fact(row++, arity))) return false;
            return true;
        };
        const auto one = [&](const Fact& fact) { return until(fact.catom) && visit(fact); };
        return here_.each(source, std::ref(one)) && until(~u64{0});
    }
    bool exists(u64 catom) override {
        if (here_.exists(catom)) return true;
        const auto [known, is_new] = exists_.emplace(catom, false);
        if (is_new) known->second = !get({Request::What::Exists, state_, false, {}, catom, 0}).empty();
        return known->second;
    }

    std::optional<Tombstone> loss(const Source& source, u64 catom, u64 group) override {
        if (here_.exists(catom)) return here_.loss(source, catom, group);
        const std::vector<comm::Packet> packets = get({Request::What::Loss, state_, false, source, catom, group});
        if (packets.empty()) return std::nullopt;
        return ByteReader(packets[0].bytes, "a loss").read<Tombstone>();
    }

  private:
    using Key = std::tuple<int, u32, int, bool>;
    struct Kept {
        std::unordered_map<u64, std::unique_ptr<Block>> at;
        std::unique_ptr<Block> all;
    };
    static Key key_of(const Source& source, bool back) {
        return {static_cast<int>(source.kind), source.predicate, static_cast<int>(source.world), back};
    }
    Kept& kept_of(const Source& source, bool back) { return kept_[key_of(source, back)]; }

    std::vector<comm::Packet> get(const Request& request) {
        ByteWriter out;
        out.write(request);
        comm::Communicator& comm = here_.subdomain().comm;
        comm.allgather_any(out.view());
        return comm.exchange({});
    }
    std::unique_ptr<Block> fetch(const Request& request) {
        auto block = std::make_unique<Block>();
        for (const comm::Packet& packet : get(request)) block->read(here_.subdomain().module, request.source, packet.bytes);
        return block;
    }
    const Block& all_of(Kept& kept, const Source& source, bool back) {
        if (kept.all == nullptr) {
            kept.all = fetch({Request::What::Each, state_, back, source, 0, 0});
            kept.all->sort(source.arity);
        }
        return *kept.all;
    }
    bool elsewhere(const Source& source, bool back, u64 catom, const Visit& visit) {
        Kept& kept = kept_of(source, back);
        if (kept.all == nullptr && kept.at.size() < kManyLookups) {
            std::unique_ptr<Block>& block = kept.at[catom];
            if (block == nullptr) block = fetch({Request::What::At, state_, back, source, catom, 0});
            return block->visit(0, source.arity, visit);
        }
        return all_of(kept, source, back).visit_catom(catom, source.arity, visit);
    }

    LocalFacts here_;
    std::uint8_t state_;
    std::map<Key, Kept> kept_;
    std::map<std::tuple<u32, u64, u64>, std::unique_ptr<Block>> heard_;  // By predicate, catom and reader.
    std::unordered_map<u64, bool> exists_;
};

}  // namespace

Result<void> ask(std::span<sim::Subdomain* const> states, const std::function<Result<void>(std::span<Facts* const>)>& question) {
    MELD_EXPECT(!states.empty(), "a question about no state");
    comm::Communicator& comm = states[0]->comm;
    if (comm.process() != 0) {
        Server(states).run();
        return comm::outcome_of_first(comm, {});
    }
    std::vector<std::unique_ptr<Facts>> own;
    std::vector<Facts*> facts;
    for (std::size_t i = 0; i < states.size(); ++i) {
        if (comm.processes() == 1)
            own.push_back(std::make_unique<LocalFacts>(*states[i]));
        else
            own.push_back(std::make_unique<AllFacts>(*states[i], static_cast<std::uint8_t>(i)));
        facts.push_back(own.back().get());
    }
    const Result<void> outcome = question(facts);
    if (comm.processes() == 1) return outcome;
    ByteWriter out;
    out.write(Request{});
    comm.allgather_any(out.view());
    return comm::outcome_of_first(comm, outcome);
}

}  // namespace meld::inspect
