// Runs a trial on the runtime, beside the reference, and says where they part.
#pragma once

#include <optional>

#include "runtime/base/hash.h"
#include "tests/reference/evaluator/value.h"
#include "tests/reference/programs/compiled.h"
#include "tests/reference/programs/draft.h"
#include "tests/reference/programs/variants.h"

namespace meld::reference {

struct Setting {
    int processes = 1;
    int threads = 1;
    std::uint64_t conditions = 0;  // Of network and clock (worlds.h). The module must have been compiled in the links form.
    // The run is killed and stopped some times, and goes on from its last snapshot on another number of processes, as this number says; 0:
    // nothing disturbs it. Then `processes` means nothing.
    std::uint64_t disturbance = 0;
    // After most ticks nobody looks at facts, so that what catoms tell all their neighbours need not be delivered.
    bool unseen = false;
};

struct Tally {
    std::uint64_t facts = 0;       // Compared at quiescence,
    std::uint64_t tick_facts = 0;  // and tick by tick.
    std::uint64_t lost = 0;        // Facts of one quiescence that were gone at the next.
    std::uint64_t linear = 0;      // Facts that linear rules gave.
    std::uint64_t quiet = 0;       // Bursts that came to rest.
    std::uint64_t ticks = 0;
    std::uint64_t undefined = 0;  // Ticks in which derivations had no value,
    std::uint64_t errors = 0;     // and bursts that ended so, or with a linear rule that met it, as they should.
    std::uint64_t questions = 0;  // Answered at quiescence,
    std::uint64_t rows = 0;       // with so many rows.
    std::uint64_t told = 0;       // Lines of watches.
    std::uint64_t too_large = 0;  // Bursts that were more than the reference can do, or a run may.
    std::uint64_t stopped = 0;    // Runs that were killed or stopped, and went on from a snapshot.
    std::uint64_t varied = 0;     // Facts of variants of programs, compared with those of the program.
    void add(const Tally& other);
};

// After a tick. How many derivations it took must not depend on how the ensemble is divided either.
struct State {
    Digest digest;
    std::uint64_t derivations = 0;
    std::string error = {};  // Of what has no value: at quiescence.
    bool seen = true;        // Else there is no digest.
    bool operator==(const State& other) const {
        return derivations == other.derivations && error == other.error && (!seen || !other.seen || digest == other.digest);
    }
};

struct Outcome {
    std::string trouble = {};        // Empty: all is as it should be. Its first words say what kind it is.
    std::vector<State> states = {};  // After every tick.
    std::string answers = {};        // To questions at quiescence.
    std::string told = {};           // By the watch of the same, in all ticks.
    std::vector<Facts> views = {};   // After every burst that came to rest, not with Watch::States.
    Tally tally = {};
};

enum class Watch { Reference, Views, States };

// Watch::States runs without the reference, for the states alone, Watch::Views also for the views where all has come to rest. Only one
// process and thread can be watched otherwise than by States. Under conditions that are not ideal the reference compares views where all
// has come to rest; what linear rules make is not for it to say, because they may fire in another order.
Outcome run(const Trial& trial, const check::Program& program, const ModuleInfo& module, const Setting& setting, Watch watch);

// Compiles the trial's program and runs it in all of these settings; the trouble, or nothing.
std::string trouble_of(const Trial& trial, Workshop& workshop, const std::vector<Setting>& settings, std::uint64_t conditions = 0);

// Whether its program must be compiled in the links form.
bool by_links(const Trial& trial, std::uint64_t conditions);

// A run in another setting, beside `alone`, which is the plain one; what differs, or nothing.
std::string trouble_of_setting(const Outcome& alone, const Trial& trial, const check::Program& program, const ModuleInfo& module,
                               const Setting& setting, Tally& tally);

// A variant of a trial, beside the outcome of the trial and its program; what differs, or nothing.
std::string trouble_of_variant(const Outcome& base, const check::Program& program, const Varied& varied, const Variation& variation,
                               Workshop& workshop, std::uint64_t conditions, Tally& tally);

// What is asked in the end of a trial.
std::optional<std::string> question_of(const Trial& trial, const check::Program& program);

// Facts that a case has given, as values.
Facts given_facts(const check::Program& program, const retraction::Mirror& mirror);
Row row_of(const check::Program& program, PredicateId predicate, const retraction::Row& row);
PredicateId predicate_of(const check::Program& program, const retraction::Given& given);

}  // namespace meld::reference
