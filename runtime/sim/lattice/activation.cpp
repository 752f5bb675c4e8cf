#include "runtime/sim/lattice/activation.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <numeric>
#include <span>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/hash.h"
#include "runtime/engine/tuple/facts.h"

namespace meld::sim {

namespace {

using Activating = world::AmoebotOptions::Activation;
// Draws of activations are not those of anything else.
constexpr std::uint64_t kDraw = 0x6163746976617465ull;
// Amoebots of a class are far apart in memory: what is written for one is asked for while this many before it have their turn.
constexpr std::size_t kAhead = 12;
// Amoebots that a worker gives the fact or takes it from in one piece of its work.
constexpr std::size_t kAtOnce = 1024;
// Amoebots among which a worker searches for those whose turn it is in one piece of its work: whole blocks of the agenda, which workers
// mark at the same time.
constexpr std::size_t kGroup = eval::Agenda::kGroup, kSearched = 16 * eval::Agenda::kBlock;

// A bit for each of eight bytes that is this one, the first lowest.
constexpr u64 equal_among_eight(u64 bytes, std::uint8_t byte) {
    constexpr u64 kEach = 0x0101010101010101, kLow = 0x7f * kEach;
    const u64 different = bytes ^ (byte * kEach);
    const u64 same = ~(((different & kLow) + kLow) | different | kLow);  // The highest bit of each byte that is 0.
    return same == 0 ? 0 : ((same >> 7) * 0x0102040810204080) >> 56;
}
static_assert(equal_among_eight(0x0503050505050305, 3) == 0b01000010 && equal_among_eight(0x83'00'03'02'7f'80'ff'03, 3) == 0b00100001);

// The same of so many bytes, at most 64.
u64 equal_bytes(const std::uint8_t* bytes, std::size_t count, std::uint8_t byte) {
    u64 found = 0;
    if (count == kGroup && std::endian::native == std::endian::little) {
        for (std::size_t i = 0; i < kGroup; i += 8) {
            u64 eight = 0;
            std::memcpy(&eight, bytes + i, sizeof eight);
            found |= equal_among_eight(eight, byte) << i;
        }
        return found;
    }
    for (std::size_t i = 0; i < count; ++i) found |= u64{bytes[i] == byte} << i;
    return found;
}

void ask_for_facts(const Subdomain& subdomain, u32 predicate, Catom catom) {
    __builtin_prefetch(subdomain.columns.entry(subdomain.module.predicates[predicate].column, catom), 1);
}

// Facts of linear predicates are rows.
bool holds(const Subdomain& subdomain, u32 predicate, Catom catom) {
    return subdomain.columns.rows(subdomain.module.predicates[predicate].column, catom).count > 0;
}

}  // namespace

void Activation::resume(Subdomain& subdomain) {
    activated_.reset();
    if (!world_.has_amoebots()) return;
    const std::optional<u32> found = tuple::find_predicate(subdomain.module, "activated", 0);
    // A predicate of the program's own with the same name has another kind.
    if (!found || subdomain.module.predicates[*found].kind != PredicateKind::Linear) return;
    const u32 base = subdomain.module.predicates[*found].base;
    if (base == kNone16 || subdomain.module.predicates[base].column == kNone16) return;
    activated_ = base;
    // Modules that users have added may read the fact before it is evaluated.
    by_turn_ = subdomain.module.predicates[base].by_turn && world_.components.empty();
    of_worker_.clear();
    of_worker_.resize(static_cast<std::size_t>(subdomain.workers.threads()));
    subdomain.tell_still_activated([this](int worker, std::span<const Catom> catoms) {
        std::vector<Catom>& left = of_worker_[static_cast<std::size_t>(worker)].left;
        left.insert(left.end(), catoms.begin(), catoms.end());
        for (const Catom catom : catoms) turn_[catom] |= kNow;
    });
}

void Activation::set_turn(const Subdomain& subdomain, Catom catom, std::uint8_t turn) {
    turn_.resize(subdomain.ensemble.index_count());
    turn_[catom] = turn;
    if ((turn & kNow) != 0 && subdomain.owned(catom)) now_.push_back(catom);
}

void Activation::end(Subdomain& subdomain) {
    if (!activated_) return;
    // Those that still have the fact: rules of most have used it up.
    std::vector<std::vector<Catom>> taken(static_cast<std::size_t>(subdomain.workers.threads()));
    const auto take = [&](int worker, Catom catom) {
        turn_[catom] &= static_cast<std::uint8_t>(~kNow);
        // It may have been killed since.
        if (subdomain.owned(catom) && holds(subdomain, *activated_, catom) && subdomain.take_shared(*activated_, catom, nullptr, worker))
            taken[static_cast<std::size_t>(worker)].push_back(catom);
    };
    each_now(subdomain, take);
    now_.clear();
    for (OfWorker& w : of_worker_) {
        for (const Catom catom : w.left) take(0, catom);
        w.left.clear();
    }
    for (const std::vector<Catom>& catoms : taken) subdomain.mark_given(*activated_, catoms);
}

void Activation::begin(Subdomain& subdomain) {
    if (!activated_) return;
    subdomain.refresh();
    // A tick in which nobody is activated is not the last one.
    subdomain.set_moving(true);
    turn_.resize(subdomain.ensemble.index_count());
    const Activating way = world_.motion.amoebots.activation;
    if (way == Activating::All)
        activate(subdomain, [](std::size_t, std::size_t count) { return ~u64{0} >> (kGroup - count); });
    else if (way == Activating::One)
        activate_one(subdomain);
    else
        activate(subdomain,
                 [classes = subdomain.ensemble.head_classes(), which = class_of_turn(subdomain)](std::size_t first, std::size_t count) {
                     return equal_bytes(&classes[first], count, static_cast<std::uint8_t>(which));
                 });
    if (!by_turn_) give_now(subdomain);
    if (way == Activating::All) ++rounds_;
    if (way == Activating::Fair && ++step_ % kClasses == 0) end_pass(subdomain);
}

template <class Among>
void Activation::activate(Subdomain& subdomain, const Among& among) {
    const std::size_t all = subdomain.ensemble.index_count();
    parts_.resize((all + kSearched - 1) / kSearched);
    subdomain.workers.run(parts_.size(), [&](int, std::size_t number) {
        Part part{0, std::move(parts_[number].catoms)};
        part.catoms.clear();
        const std::size_t end = std::min(all, (number + 1) * kSearched);
        for (std::size_t first = number * kSearched; first < end; first += kGroup)
            if (const u64 some = among(first, std::min(kGroup, end - first)); some != 0)
                activate_group(subdomain, static_cast<Catom>(first), some, part);
        parts_[number] = std::move(part);
    });
    for (const Part& part : parts_) {
        activations_ += part.count;
        now_.insert(now_.end(), part.catoms.begin(), part.catoms.end());
    }
}

void Activation::activate_group(Subdomain& subdomain, Catom first, u64 some, Part& part) {
    const bool fair = world_.motion.amoebots.activation == Activating::Fair;
    u64 turns = 0;
    for (u64 left = some; left != 0; left &= left - 1) {
        const Catom catom = first + static_cast<Catom>(std::countr_zero(left));
        if (!subdomain.owned(catom) || (fair && (turn_[catom] & kInRound) != 0)) continue;
        turns |= left & -left;
        ++part.count;
        if (fair) turn_[catom] |= kInRound;
        if (!by_turn_) part.catoms.push_back(catom);
    }
    if (by_turn_ && turns != 0) subdomain.give_turn(first / kGroup, turns);
}

// Whoever has been killed is drawn in vain, and the next tick draws another.
void Activation::activate_one(Subdomain& subdomain) {
    const std::uint64_t drawn = hash_combine(hash_combine(world_.seed, kDraw), static_cast<std::uint64_t>(subdomain.tick()));
    if (subdomain.next_id() == 0) return;
    const std::optional<Catom> catom = subdomain.ensemble.find(drawn % subdomain.next_id());
    if (!catom) return;
    Part part;
    activate_group(subdomain, *catom - *catom % eval::Agenda::kGroup, u64{1} << (*catom % kGroup), part);
    activations_ += part.count;
    now_.insert(now_.end(), part.catoms.begin(), part.catoms.end());
}

void Activation::give_now(Subdomain& subdomain) {
    for (const Catom catom : now_) turn_[catom] |= kNow;
    each_now(subdomain, [&](int worker, Catom catom) { subdomain.give_shared(*activated_, catom, nullptr, worker); });
    subdomain.mark_given(*activated_, now_);
}

template <class Visit>
void Activation::each_now(Subdomain& subdomain, const Visit& visit) const {
    subdomain.workers.run((now_.size() + kAtOnce - 1) / kAtOnce, [&](int worker, std::size_t part) {
        const std::size_t from = part * kAtOnce, end = std::min(now_.size(), from + kAtOnce);
        for (std::size_t i = from; i < std::min(from + kAhead, end); ++i) ask_for_facts(subdomain, *activated_, now_[i]);
        for (std::size_t i = from; i < end; ++i) {
            if (i + kAhead < end) ask_for_facts(subdomain, *activated_, now_[i + kAhead]);
            visit(worker, now_[i]);
        }
    });
}

// Random: any of the classes. Fair: each pass over the classes has an order of its own.
std::int32_t Activation::class_of_turn(const Subdomain& subdomain) const {
    const std::uint64_t seed = hash_combine(world_.seed, kDraw);
    if (world_.motion.amoebots.activation == Activating::Random)
        return static_cast<std::int32_t>(hash_combine(seed, static_cast<std::uint64_t>(subdomain.tick())) % kClasses);
    std::array<std::int32_t, kClasses> order{};
    std::iota(order.begin(), order.end(), 0);
    std::uint64_t drawn = hash_combine(seed, static_cast<std::uint64_t>(step_ / kClasses));
    for (std::size_t left = order.size(); left > 1; --left) {
        drawn = mix64(drawn + left);
        std::swap(order[left - 1], order[drawn % left]);
    }
    return order[static_cast<std::size_t>(step_ % kClasses)];
}

void Activation::end_pass(Subdomain& subdomain) {
    bool missing = false;
    for (Catom c = 0; c < subdomain.ensemble.index_count() && !missing; ++c) missing = subdomain.owned(c) && (turn_[c] & kInRound) == 0;
    if (!subdomain.alone()) {
        ByteWriter mine;
        mine.write(missing);
        for (const auto& theirs : subdomain.comm.allgather_any(mine.view()))
            missing = ByteReader(theirs, "a round").read<bool>() || missing;
    }
    if (missing) return;
    ++rounds_;
    for (std::uint8_t& turn : turn_) turn &= static_cast<std::uint8_t>(~kInRound);
}

std::optional<std::int64_t> Activation::rounds() const {
    const Activating way = world_.motion.amoebots.activation;
    return activated_ && (way == Activating::All || way == Activating::Fair) ? std::optional(rounds_) : std::nullopt;
}

void Activation::save(ByteWriter& out) const {
    out.write(step_);
    out.write(rounds_);
    out.write(activations_);
}

void Activation::load(ByteReader& in, bool counts) {
    step_ = std::max(step_, in.read<std::int64_t>());
    rounds_ = std::max(rounds_, in.read<std::int64_t>());
    const auto activations = in.read<std::uint64_t>();
    if (counts) activations_ += activations;
}

void Activation::write_counts(ByteWriter& out) { out.write(std::exchange(activations_, 0)); }
void Activation::add_counts(ByteReader& in) { activations_ += in.read<std::uint64_t>(); }

}  // namespace meld::sim
