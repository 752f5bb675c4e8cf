// Which amoebots are activated in a tick (docs/amoebots.md, "Activation"), by the linear fact `activated`.
//
// In the model one amoebot acts at a time. A tick may hold many activations all the same: those of amoebots whose heads lie in cells of one
// of the 36 classes, by their coordinates modulo 6. Two of them have no neighbour in common and no empty cell that both touch, so none
// notices what another does in that tick, and the outcome is that of any order. Cost: a byte of each amoebot is read.
//
// The fact lasts for one evaluation. Workers give it just before they evaluate an amoebot, and look just afterwards whether it is left, so
// that its row comes from memory once.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::sim {

class Activation {
  public:
    explicit Activation(const world::World& world) : world_(world) {}
    // Finds the predicate, if the program reads it.
    void resume(Subdomain& subdomain);
    // Before the actions of a tick are carried out: who has not used its activation loses it.
    void end(Subdomain& subdomain);
    // Afterwards: activates those of the next evaluation. Every process calls it.
    void begin(Subdomain& subdomain);

    // What is kept for an amoebot between two ticks, as it migrates and is saved: whether it has been activated in this tick, and in this
    // round.
    static constexpr std::uint8_t kNow = 1, kInRound = 2;
    std::uint8_t turn(Catom catom) const { return catom < turn_.size() ? turn_[catom] : 0; }
    void set_turn(const Subdomain& subdomain, Catom catom, std::uint8_t turn);

    void save(ByteWriter& out) const;
    void load(ByteReader& in, bool counts);
    // The counts of all processes, at the end.
    void write_counts(ByteWriter& out);
    void add_counts(ByteReader& in);
    std::uint64_t activations() const { return activations_; }
    // Rounds that are over, in each of which each amoebot has been activated once; none where that is not known.
    std::optional<std::int64_t> rounds() const;

  private:
    static constexpr std::int32_t kClasses = world::Ensemble::kApart * world::Ensemble::kApart;

    // What a worker has done in the last evaluation; in a line of memory of its own.
    struct alignas(64) Given {
        std::vector<Catom> now;   // Amoebots of the last block that were given the fact.
        std::vector<Catom> left;  // Of all blocks those that still have it.
        std::size_t count = 0;
    };

    // Notes whose turn it is; then all of those are activated.
    void choose(Catom catom) { now_.push_back(catom); }
    void activate_chosen(Subdomain& subdomain);
    // Whether it is this amoebot's turn, by what it is evaluated for: whatever has become of it since then has taken that away.
    bool waits_for_fact(Catom catom, u64 dirty) const {
        return (dirty & dirty_) != 0 && catom < turn_.size() && (turn_[catom] & kNow) != 0;
    }
    void give_to_block(Subdomain& subdomain, int worker, std::span<const Catom> catoms, std::span<const u64> dirty);
    void look_at_block(const Subdomain& subdomain, int worker);
    // Whether all whose turn it was had the fact in the last evaluation.
    bool all_were_given() const;
    // Calls visit(worker, catom) for those whose turn it is, from all workers at once.
    template <class Visit>
    void each_now(Subdomain& subdomain, const Visit& visit) const;
    void choose_class(Subdomain& subdomain, std::int32_t which, bool once);
    void choose_one(const Subdomain& subdomain);
    std::int32_t class_of_turn(const Subdomain& subdomain) const;
    // The round ends if all have been activated in it.
    void end_pass(Subdomain& subdomain);

    const world::World& world_;
    std::optional<u32> activated_;
    u64 dirty_ = 0;                           // Of the fact.
    bool in_blocks_ = false;                  // Workers give the fact, in this tick.
    std::vector<Given> given_;                // By worker.
    std::vector<Catom> now_;                  // Who has been activated in the last tick.
    std::vector<std::vector<Catom>> chosen_;  // By each part of a search; memory for it.
    std::vector<std::uint8_t> turn_;          // By catom.
    std::int64_t step_ = 0;                   // Classes that have had their turn, in all passes. The same on all processes, as the next.
    std::int64_t rounds_ = 0;
    std::uint64_t activations_ = 0;  // Of this process; after the end, of all.
};

}  // namespace meld::sim
