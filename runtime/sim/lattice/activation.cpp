#include "runtime/sim/lattice/activation.h"

#include <algorithm>
#include <array>
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
// Amoebots that a worker activates, or whose activation it ends, in one piece of its work.
constexpr std::size_t kAtOnce = 1024;
// Amoebots among which a worker searches for a class in one piece of its work.
constexpr std::size_t kSearched = 1 << 16;

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
    dirty_ = subdomain.module.columns[subdomain.module.predicates[base].column].own_dirty;
    given_.resize(static_cast<std::size_t>(subdomain.workers.threads()));
    subdomain.around_evaluation(
        [this, &subdomain](int worker, std::span<const Catom> catoms, std::span<const u64> dirty) {
            if (in_blocks_) give_to_block(subdomain, worker, catoms, dirty);
        },
        [this, &subdomain](int worker, std::span<const Catom>, std::span<const u64>) {
            if (in_blocks_) look_at_block(subdomain, worker);
        });
}

void Activation::give_to_block(Subdomain& subdomain, int worker, std::span<const Catom> catoms, std::span<const u64> dirty) {
    Given& given = given_[static_cast<std::size_t>(worker)];
    given.now.clear();
    for (std::size_t i = 0; i < catoms.size(); ++i)
        if (waits_for_fact(catoms[i], dirty[i])) given.now.push_back(catoms[i]);
    const std::size_t count = given.now.size();
    for (std::size_t i = 0; i < std::min(kAhead, count); ++i) ask_for_facts(subdomain, *activated_, given.now[i]);
    for (std::size_t i = 0; i < count; ++i) {
        if (i + kAhead < count) ask_for_facts(subdomain, *activated_, given.now[i + kAhead]);
        subdomain.give_shared(*activated_, given.now[i], nullptr, worker);
    }
    given.count += given.now.size();
}

void Activation::look_at_block(const Subdomain& subdomain, int worker) {
    Given& given = given_[static_cast<std::size_t>(worker)];
    for (const Catom catom : given.now)
        if (holds(subdomain, *activated_, catom)) given.left.push_back(catom);
}

bool Activation::all_were_given() const {
    std::size_t count = 0;
    for (const Given& given : given_) count += given.count;
    return in_blocks_ && count == now_.size();
}

void Activation::set_turn(const Subdomain& subdomain, Catom catom, std::uint8_t turn) {
    turn_.resize(subdomain.ensemble.index_count());
    turn_[catom] = turn;
    if ((turn & kNow) != 0 && subdomain.owned(catom)) now_.push_back(catom);
}

void Activation::end(Subdomain& subdomain) {
    if (!activated_) return;
    const bool known = all_were_given();
    for (const Catom catom : now_) turn_[catom] &= static_cast<std::uint8_t>(~kNow);
    // Those that still have the fact: rules of most have used it up.
    std::vector<std::vector<Catom>> left(static_cast<std::size_t>(subdomain.workers.threads()));
    const auto take = [&](int worker, Catom catom) {
        // It may have been killed since.
        if (subdomain.owned(catom) && holds(subdomain, *activated_, catom) && subdomain.take_shared(*activated_, catom, nullptr, worker))
            left[static_cast<std::size_t>(worker)].push_back(catom);
    };
    if (known) {
        for (const Given& given : given_)
            for (const Catom catom : given.left) take(0, catom);
    } else {
        each_now(subdomain, take);
    }
    for (const std::vector<Catom>& catoms : left) subdomain.mark_given(*activated_, catoms);
    now_.clear();
}

void Activation::begin(Subdomain& subdomain) {
    if (!activated_) return;
    subdomain.refresh();
    // A tick in which nobody is activated is not the last one.
    subdomain.set_moving(true);
    turn_.resize(subdomain.ensemble.index_count());
    const Activating way = world_.motion.amoebots.activation;
    switch (way) {
        case Activating::All:
            for (Catom c = 0; c < subdomain.ensemble.index_count(); ++c)
                if (subdomain.owned(c)) choose(c);
            break;
        case Activating::One:
            choose_one(subdomain);
            break;
        case Activating::Random:
        case Activating::Fair:
            choose_class(subdomain, class_of_turn(subdomain), way == Activating::Fair);
    }
    activate_chosen(subdomain);
    if (way == Activating::All) ++rounds_;
    if (way == Activating::Fair && ++step_ % kClasses == 0) end_pass(subdomain);
}

void Activation::activate_chosen(Subdomain& subdomain) {
    // Modules that users have added may read the fact before it is evaluated.
    in_blocks_ = world_.components.empty();
    for (Given& given : given_) given.left.clear(), given.count = 0;
    for (const Catom catom : now_) turn_[catom] = kNow | kInRound;
    if (!in_blocks_) each_now(subdomain, [&](int worker, Catom catom) { subdomain.give_shared(*activated_, catom, nullptr, worker); });
    subdomain.mark_given(*activated_, now_);
    activations_ += now_.size();
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

void Activation::choose_class(Subdomain& subdomain, std::int32_t which, bool once) {
    const std::span<const std::uint8_t> classes = subdomain.ensemble.head_classes();
    chosen_.resize((classes.size() + kSearched - 1) / kSearched);
    subdomain.workers.run(chosen_.size(), [&](int, std::size_t part) {
        const std::size_t end = std::min(classes.size(), (part + 1) * kSearched);
        chosen_[part].clear();
        for (std::size_t from = part * kSearched; from < end; ++from) {
            const void* const found = std::memchr(&classes[from], which, end - from);
            if (found == nullptr) return;
            from = static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - classes.data());
            const auto catom = static_cast<Catom>(from);
            if (subdomain.owned(catom) && !(once && (turn_[catom] & kInRound) != 0)) chosen_[part].push_back(catom);
        }
    });
    for (const std::vector<Catom>& catoms : chosen_) now_.insert(now_.end(), catoms.begin(), catoms.end());
}

// Whoever has been killed is drawn in vain, and the next tick draws another.
void Activation::choose_one(const Subdomain& subdomain) {
    const std::uint64_t drawn = hash_combine(hash_combine(world_.seed, kDraw), static_cast<std::uint64_t>(subdomain.tick()));
    if (subdomain.next_id() == 0) return;
    const std::optional<Catom> catom = subdomain.ensemble.find(drawn % subdomain.next_id());
    if (catom && subdomain.owned(*catom)) choose(*catom);
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
