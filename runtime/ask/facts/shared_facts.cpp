#include "runtime/ask/facts/shared_facts.h"

#include <algorithm>
#include <span>

#include "runtime/base/assert.h"
#include "runtime/comm/transport/packets.h"

namespace meld::inspect {

namespace {

const Source kNoSource;

}  // namespace

// What is not here yet: nothing for now.
const Block* SharedFacts::find(const Need& need) {
    const Key key = key_of(need);
    if (const auto found = kept_.find(key); found != kept_.end()) return &found->second;
    lacked_ = true;
    needed_.emplace(key, need);
    return nullptr;
}

bool SharedFacts::at(const Source& source, u64 catom, const Visit& visit) {
    if (here_.subdomain().alone() || here_.exists(catom)) return here_.at(source, catom, visit);
    if (const auto all = kept_.find(key_of({What::Each, source, 0})); all != kept_.end())
        return all->second.visit_catom(catom, source.arity, visit);
    const Block* const block = find({What::At, source, catom});
    return block == nullptr || block->visit(0, source.arity, visit);
}

bool SharedFacts::back(const Source& source, u64 to, const Visit& visit) {
    if (here_.subdomain().alone() || here_.exists(to)) return here_.back(source, to, visit);
    const Block* const block = find({What::Back, source, to});
    return block == nullptr || block->visit(0, source.arity, visit);
}

bool SharedFacts::each(const Source& source, const Visit& visit) {
    if (here_.subdomain().alone()) return here_.each(source, visit);
    const Block* const others = find({What::Each, source, 0});
    if (others == nullptr) return true;
    std::size_t row = 0;
    const auto until = [&](u64 catom) {
        while (row < others->rows.size() && others->rows[row].asked_by < catom)
            if (!visit(others->fact(row++, source.arity))) return false;
        return true;
    };
    const auto one = [&](const Fact& fact) { return until(fact.catom) && visit(fact); };
    return here_.each(source, std::ref(one)) && until(~u64{0});
}

bool SharedFacts::has_all(const Source& source) const {
    return here_.subdomain().alone() || kept_.contains(key_of({What::Each, source, 0}));
}

bool SharedFacts::exists(u64 catom) {
    if (here_.exists(catom)) return true;
    if (here_.subdomain().alone()) return false;
    const Block* const block = find({What::Exists, kNoSource, catom});
    return block != nullptr && !block->rows.empty();
}

std::optional<Tombstone> SharedFacts::loss(const Source&, u64 catom, u64) { MELD_CHECK(false, "a watch asks what @{} has lost", catom); }

// A ghost's owner is known; of others any process may be it.
void SharedFacts::ask_for(const Need& need, std::vector<ByteWriter>& packets) const {
    const sim::Subdomain& s = here_.subdomain();
    const auto ghost = need.what == What::Each ? std::nullopt : s.ensemble.find(need.catom);
    for (int process = 0; process < s.comm.processes(); ++process) {
        if (process == s.comm.process() || (ghost && s.owner_of(*ghost) != process)) continue;
        packets[static_cast<std::size_t>(process)].write(need);
    }
}

void SharedFacts::answer(const Need& need, ByteWriter& out) {
    const ModuleInfo& module = here_.subdomain().module;
    const auto tell = [&](u64 asked_by) {
        return [&, asked_by](const Fact& fact) { return pack(module, need.source, asked_by, fact, out), true; };
    };
    if (need.what == What::Each) {
        here_.each(need.source, [&](const Fact& fact) { return pack(module, need.source, fact.catom, fact, out), true; });
    } else if (here_.exists(need.catom)) {
        if (need.what == What::At) here_.at(need.source, need.catom, tell(need.catom));
        if (need.what == What::Back) here_.back(need.source, need.catom, tell(need.catom));
        if (need.what == What::Exists) pack(module, kNoSource, need.catom, {.catom = need.catom}, out);
    }
}

bool SharedFacts::fetch() {
    const sim::Subdomain& s = here_.subdomain();
    if (s.alone()) return false;
    const std::byte mine{!needed_.empty()};
    bool any = false;
    for (const std::byte lacks : s.comm.allgather({&mine, 1})) any = any || lacks != std::byte{0};
    if (!any) return false;
    const auto processes = static_cast<std::size_t>(s.comm.processes());
    std::vector<ByteWriter> packets(processes);
    for (const auto& [key, need] : needed_) ask_for(need, packets);
    const std::vector<comm::Packet> questions = s.comm.exchange(comm::take_packets(packets));
    for (const comm::Packet& packet : questions)
        for (ByteReader in(packet.bytes, "what a watch asks for"); !in.done();) {
            const Need need = in.read<Need>();
            ByteWriter facts;
            answer(need, facts);
            ByteWriter& out = packets[static_cast<std::size_t>(packet.process)];
            out.write(need);
            out.write_block(facts.view());
        }
    for (const auto& [key, need] : needed_) kept_[key];
    for (const comm::Packet& packet : s.comm.exchange(comm::take_packets(packets)))
        for (ByteReader in(packet.bytes, "the facts that a watch asks for"); !in.done();) {
            const Need need = in.read<Need>();
            kept_[key_of(need)].read(s.module, need.source, in.read_block());
        }
    for (const auto& [key, need] : needed_) kept_[key].sort(need.source.arity);
    needed_.clear();
    return true;
}

}  // namespace meld::inspect
