// Facts and actions that evaluated catoms send and request, and those that C++ code outside the program requests for them.
#pragma once

#include <vector>

#include "runtime/engine/eval/tick_arena.h"
#include "runtime/engine/tuple/columns.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::eval {

// A linear or given fact on its way to a catom of this process or to a ghost.
struct Message {
    u32 to = 0;  // Index on this process.
    u16 predicate = 0;
    u64 from = 0;  // Id of the sender, and the number of the message among those it sent in this tick: the order of delivery.
    u32 sequence = 0;
    const Value* arguments = nullptr;  // Valid until the next evaluation.
};

// The same for a node that may be anywhere.
struct FarMessage {
    u64 to = 0;  // Id
    u16 predicate = 0;
    u64 from = 0;
    u32 sequence = 0;
    const Value* arguments = nullptr;  // Valid until the next evaluation.
};

struct Action {
    u32 catom = 0;
    u16 predicate = 0;
    const Value* arguments = nullptr;  // Valid until the next evaluation.
};

// Requests made between two evaluations. The next evaluation treats them as if each catom's rules had made them first.
class Requests {
  public:
    Requests(const ModuleInfo& module, tuple::Columns& columns) : module_(module), columns_(columns) {}
    ~Requests();
    Requests(const Requests&) = delete;
    Requests& operator=(const Requests&) = delete;

    // The arguments are copied. Catoms keep their indices until the evaluation. One thread at a time.
    void act(u32 catom, u16 predicate, const Value* arguments);
    void send(u32 to, u16 predicate, u64 from, const Value* arguments);

    // Nothing is asked for yet: so it is between two ticks, for whoever asks acts before the evaluation of a tick.
    bool empty() const { return next_.messages.empty() && next_.actions.empty(); }
    // From now on the lists below hold the requests since the last call.
    void begin_evaluation();
    const std::vector<Message>& messages() const { return current_.messages; }
    const std::vector<Action>& actions() const { return current_.actions; }

  private:
    struct Batch {
        std::vector<Message> messages;
        std::vector<Action> actions;
        Kept<Value> values;
        std::vector<const List*> owned;
    };
    const Value* keep(u16 predicate, const Value* arguments);
    void clear(Batch& batch);

    const ModuleInfo& module_;
    tuple::Columns& columns_;
    Batch next_, current_;
};

}  // namespace meld::eval
