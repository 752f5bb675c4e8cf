// What an evaluation begins with, the agenda, and the order of the actions that it leaves.
#include <algorithm>

#include "runtime/engine/eval/evaluator.h"

namespace meld::eval {

void Evaluator::resize(std::size_t catoms) {
    for (Agenda& agenda : agendas_) agenda.resize(catoms);
}

// The agenda of this tick is taken as a whole, and marks go to the other one.
void Evaluator::take_agenda(const Geometry& geometry) {
    taken().clear();
    next_agenda_ = 1 - next_agenda_;
    if (acts_ || left_out_) leave_out_or_postpone(geometry);
    groups_.clear();
    taken().each_group([&](u32 group) { groups_.push_back(group); });
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
