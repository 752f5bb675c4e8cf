// The facts that this process has of a run, straight from its columns and its ensemble.
#pragma once

#include <deque>
#include <utility>
#include <vector>

#include "runtime/ask/facts/facts.h"
#include "runtime/ask/facts/holders.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::inspect {

class LocalFacts : public Facts {
  public:
    // The state of the run does not change while this exists. `holders`, if there are any, are up to date and outlive it.
    explicit LocalFacts(sim::Subdomain& subdomain, Holders* holders = nullptr);

    // Of catoms that this process owns.
    bool at(const Source& source, u64 catom, const Visit& visit) override;
    // By one of them.
    bool heard(const Source& source, u64 catom, u64 by, const Visit& visit) override;
    bool each(const Source& source, const Visit& visit) override;
    bool back(const Source& source, u64 to, const Visit& visit) override;
    bool exists(u64 catom) override;
    std::optional<Tombstone> loss(const Source& source, u64 catom, u64 group) override;

    // Calls visit(number) for the catoms of this process, by their numbers.
    template <class Visitor>
    void each_catom(const Visitor& visit) {
        for (const auto& [id, catom] : by_id()) visit(id);
    }
    const sim::Subdomain& subdomain() const { return subdomain_; }

    // Whether what is heard of such facts can be something else than what is said.
    bool travels(const Source& source) const;

  private:
    bool stored(const Source& source, sim::Catom catom, u64 id, std::vector<Value>& room, const Visit& visit) const;
    bool world(const Source& source, sim::Catom catom, u64 id, const Visit& visit) const;
    bool actions(const Source& source, sim::Catom catom, u64 id, const Visit& visit) const;
    bool at(const Source& source, sim::Catom catom, u64 id, std::vector<Value>& room, const Visit& visit) const;
    const std::vector<std::pair<u64, sim::Catom>>& by_id();

    sim::Subdomain& subdomain_;
    Holders* holders_;
    std::vector<std::pair<u64, sim::Catom>> by_id_;
    bool sorted_ = false;
    // Room for the arguments of a fact, for each visit that is inside of another one.
    std::deque<std::vector<Value>> rooms_;
    std::size_t visits_ = 0;
};

}  // namespace meld::inspect
