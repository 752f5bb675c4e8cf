// Actions with `while` that are repeated although their catoms are not evaluated: nothing has changed there, so an evaluation would only
// ask for them again.
#pragma once

#include <vector>

#include "runtime/engine/eval/agenda.h"
#include "runtime/engine/eval/requests.h"
#include "runtime/engine/eval/tick_arena.h"
#include "runtime/engine/eval/timers.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::eval {

class Repeated {
  public:
    explicit Repeated(const ModuleInfo& module);

    // Before an evaluation: takes catoms off its agenda that are there only to repeat actions of the last tick, which are in `actions`, and
    // wakes them in the next tick again. Keeps those actions for add_to(). Cost: some nanoseconds for each of them.
    void rest(i64 now, Agenda& agenda, const std::vector<Action>& actions, Timers& timers);
    // An evaluation has asked for this action.
    void note(const Action& action);
    // Whether this catom repeats actions, those from an evaluation of this tick or those that are kept.
    bool asked(u32 catom) const { return has(asked_, catom); }
    // Both are in the order of the catoms' ids, before and afterwards.
    void add_to(std::vector<Action>& actions, const Geometry& geometry) const;

  private:
    static bool has(const std::vector<u64>& bits, u32 catom) {
        return catom / 64 < bits.size() && (bits[catom / 64] >> catom % 64 & 1) != 0;
    }
    static void set(std::vector<u64>& bits, u32 catom) {
        if (catom / 64 >= bits.size()) bits.resize(catom / 64 + 1, 0);
        bits[catom / 64] |= u64{1} << catom % 64;
    }

    const ModuleInfo& module_;
    bool possible_ = false;             // Some action repeats, and the last evaluation says all there is to know of it.
    std::vector<u64> asked_, resting_;  // A bit for each catom: as asked() says; not evaluated in this tick.
    std::vector<Action> kept_;          // Of this tick.
    Kept<Value> values_, last_values_;  // Their arguments, and those of the tick before.
};

}  // namespace meld::eval
