// Which amoebots are activated in a tick (docs/amoebots.md, "Activation"), by the linear fact `activated`.
//
// In the model one amoebot acts at a time. A tick may hold many activations all the same: those of amoebots whose heads lie in cells of one
// of the 36 classes, by their coordinates modulo 6. Two of them have no neighbour in common and no empty cell that both touch, so none
// notices what another does in that tick, and the outcome is that of any order. Cost: a byte of each amoebot is read.
//
// The fact lasts for one evaluation. Mostly it is only a bit of the agenda that says so, and the compiled program makes the fact of it
// (PredicateInfo::by_turn), so that no row is read or written.
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

    // What is kept for an amoebot between two ticks, as it migrates and is saved: whether it has been activated in this tick and may still
    // have the fact; if the activation is fair, whether it has been in this round.
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

    // In a line of memory of its own.
    struct alignas(64) OfWorker {
        std::vector<Catom> left;  // Amoebots that still had the fact when they had been evaluated.
    };
    struct Part {
        std::size_t count = 0;      // How many it has found whose turn it is,
        std::vector<Catom> catoms;  // and which, if the fact is not given by turns.
    };

    // Activates those of this process among some, all workers at once: among(first, count) has a bit for each of so many amoebots from
    // `first` on, at most 64.
    template <class Among>
    void activate(Subdomain& subdomain, const Among& among);
    void activate_group(Subdomain& subdomain, Catom first, u64 some, Part& part);
    void activate_one(Subdomain& subdomain);
    // Those whose turn it is, where the fact is not given by turns.
    void give_now(Subdomain& subdomain);
    // Calls visit(worker, catom) for those of now_, from all workers at once.
    template <class Visit>
    void each_now(Subdomain& subdomain, const Visit& visit) const;
    std::int32_t class_of_turn(const Subdomain& subdomain) const;
    // The round ends if all have been activated in it.
    void end_pass(Subdomain& subdomain);

    const world::World& world_;
    std::optional<u32> activated_;
    bool by_turn_ = false;             // It is given as a bit of the agenda,
    std::vector<OfWorker> of_worker_;  // and workers learn who does not use it up.
    std::vector<Catom> now_;           // Who else may still have it.
    std::vector<Part> parts_;          // Of a search for those whose turn it is; memory for it.
    std::vector<std::uint8_t> turn_;   // By catom.
    std::int64_t step_ = 0;            // Classes that have had their turn, in all passes. The same on all processes, as the next.
    std::int64_t rounds_ = 0;
    std::uint64_t activations_ = 0;  // Of this process; after the end, of all.
};

}  // namespace meld::sim
