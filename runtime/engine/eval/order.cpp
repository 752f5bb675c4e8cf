// What an evaluation begins with, the agenda, and the order of the actions that it leaves.
#include <algorithm>

#include "runtime/engine/eval/evaluator.h"

namespace meld::eval {

namespace {

// So many groups are taken by all workers, so many blocks of them at once.
constexpr std::size_t kManyGroups = 4096, kBlocksAtOnce = 16;

}  // namespace

void Evaluator::resize(std::size_t catoms) {
    for (Agenda& agenda : agendas_) agenda.resize(catoms);
}

// The agenda of this tick is taken as a whole, and marks go to the other one.
void Evaluator::take_agenda(const Geometry& geometry) {
    Agenda& last = taken();
    next_agenda_ = 1 - next_agenda_;
    const bool some_wait = acts_ || left_out_;
    if (some_wait) {
        last.clear();
        leave_out_or_postpone(geometry);
    }
    const std::size_t blocks = taken().blocks(), parts = (blocks + kBlocksAtOnce - 1) / kBlocksAtOnce, before = groups_.size();
    const auto end_of = [&](std::size_t part) { return std::min(blocks, (part + 1) * kBlocksAtOnce); };
    groups_before_.assign(parts + 1, 0);
    for (std::size_t part = 0; part < parts; ++part)
        groups_before_[part + 1] = groups_before_[part] + taken().group_count(part * kBlocksAtOnce, end_of(part));
    groups_.resize(groups_before_[parts]);
    const auto take = [&](int, std::size_t part) {
        if (!some_wait) last.clear(part * kBlocksAtOnce, end_of(part));
        taken().copy_groups(part * kBlocksAtOnce, end_of(part), groups_.data() + groups_before_[part]);
    };
    if (std::max(before, groups_.size()) >= kManyGroups) return workers_.run(parts, take);
    for (std::size_t part = 0; part < parts; ++part) take(0, part);
}

void Evaluator::leave_out_or_postpone(const Geometry& geometry) {
    taken().each([&](u32 catom, u64 dirty) {
        const bool out = geometry.catom_state[catom] != kCatomOwned || (left_out_ && left_out_(catom));
        if (!out && (!acts_ || acts_(catom))) return;
        taken().forget(catom);
        if (!out) agenda().mark(catom, dirty);
    });
}

void Evaluator::order_actions(const Geometry& geometry) {
    std::ranges::stable_sort(actions_, {}, [&](const Action& action) { return id_of(geometry, action.catom); });
}

}  // namespace meld::eval
