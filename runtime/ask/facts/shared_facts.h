// The facts of a run for searches that go on on all processes at once: what a search needs of another process is noted, and comes to all
// in one round; then it begins again.
#pragma once

#include <map>
#include <memory>
#include <set>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include "runtime/ask/facts/fact_block.h"
#include "runtime/ask/facts/facts.h"
#include "runtime/ask/facts/local_facts.h"

namespace meld::inspect {

class SharedFacts : public Facts {
  public:
    // The state of the run does not change while this exists. Every process makes it.
    explicit SharedFacts(sim::Subdomain& subdomain, Holders* holders = nullptr) : here_(subdomain, holders) {}

    bool at(const Source& source, u64 catom, const Visit& visit) override;
    bool each(const Source& source, const Visit& visit) override;
    bool has_all(const Source& source) const override;
    bool back(const Source& source, u64 to, const Visit& visit) override;
    bool exists(u64 catom) override;
    // No watch asks for losses.
    std::optional<Tombstone> loss(const Source& source, u64 catom, u64 group) override;

    // Whether the search has lacked a fact since this was last asked, so that what it found is not what holds.
    bool lacked() { return std::exchange(lacked_, false); }
    // Gets what is lacking on any process. Every process calls it; returns whether any lacked something.
    bool fetch();

  private:
    enum class What : u8 { At, Back, Each, Exists };
    struct Need {
        What what = What::At;
        Source source = {};
        u64 catom = 0;
    };
    using Key = std::tuple<What, int, u32, int, u64>;
    static Key key_of(const Need& need) {
        return {need.what, static_cast<int>(need.source.kind), need.source.predicate, static_cast<int>(need.source.world), need.catom};
    }
    const Block* find(const Need& need);
    void ask_for(const Need& need, std::vector<ByteWriter>& packets) const;
    void answer(const Need& need, ByteWriter& out);

    LocalFacts here_;
    std::map<Key, Block> kept_;
    std::map<Key, Need> needed_;
    bool lacked_ = false;
};

}  // namespace meld::inspect
