// A session of the debugger: carries out commands on the timeline of a run. Nothing is read or printed here.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "runtime/ask/debug/answer.h"
#include "runtime/ask/debug/branches.h"
#include "runtime/ask/debug/breaks.h"
#include "runtime/ask/debug/by_hand.h"
#include "runtime/ask/debug/command.h"
#include "runtime/ask/debug/vocabulary.h"
#include "runtime/base/error.h"
#include "runtime/base/files/output_paths.h"
#include "runtime/results/timeline/timeline.h"

namespace meld::debug {

// What only whoever has started the session can do with its run.
struct Host {
    // Goes on with the program as it is now; the answer knows nothing of breaks.
    std::function<Result<Reloaded>()> reload = {};
    // Writes a checkpoint into a folder; `events` are [[event]] tables of ticks to come.
    std::function<Result<Saved>(const std::string& folder, const std::string& events)> save = {};
};

struct SessionOptions {
    std::uint64_t most_lines = 0;        // Beyond these, facts are only counted.
    std::string folder = {};             // Where paths in commands begin; empty: where the process is.
    bool recorded = false;               // What happens in the run is recorded, so nobody can change it.
    std::vector<NamedPath> inputs = {};  // What the run was read from, which no command may write over.
    Host host = {};
};

// Every process of the run has one and gives it the same commands in the same order.
class Session {
  public:
    // The timeline has been started, and it and its world outlive the session.
    Session(timeline::Timeline& timeline, world::World& world, SessionOptions options)
        : timeline_(timeline), world_(world), options_(std::move(options)), by_hand_(world), came_from_(timeline.tick()) {}

    // Process 0 has all of the answer. Nothing is to be done for Quit. Errors: it cannot be done, and the session stays where it was; the
    // program fails; a tick is not what it was before.
    Result<Answer> execute(const Command& command);

    // What can be typed now; of this process.
    Vocabulary vocabulary() const { return vocabulary_of(timeline_.simulation().subdomain(), options_.folder); }

    // Called now and then while a question is answered, with the number of facts that were looked at.
    void looked(std::function<void(std::uint64_t)> call) { looked_ = std::move(call); }

  private:
    Result<Answer> go(std::int64_t tick);
    Result<Answer> until(const std::string& body);
    Result<Answer> forward(std::int64_t tick, inspect::Watches* until, const std::string& body);
    Result<Answer> back(std::int64_t ticks);
    Result<Answer> reverse();
    Result<Answer> query(const std::string& body);
    Result<Answer> why(const Why& asked);
    Result<Answer> messages(const Messages& asked);
    Result<Answer> without(const Depends& asked);
    const ModuleInfo& module() const { return timeline_.simulation().subdomain().module; }
    // Whether something can be done by hand in the next tick.
    Result<void> changeable() const;
    Result<Answer> change(const Change& asked);
    Result<Answer> kill(const Kill& asked);
    Result<Answer> strike_links(const StrikeLinks& asked);
    Result<Answer> fork(const std::string& name);
    Result<Answer> go_to(const std::string& branch);
    Result<Answer> save_events(const std::string& path);
    Result<Answer> reload();
    Result<Answer> save(const Save& asked);
    std::string path_of(const std::string& path) const;
    Result<Answer> stand() const;
    Result<Answer> compare(std::int64_t since);

    timeline::Timeline& timeline_;
    world::World& world_;
    SessionOptions options_;
    std::function<void(std::uint64_t)> looked_;
    BreakList breaks_;
    ByHand by_hand_;
    Branches branches_;
    bool reloaded_ = false;   // The first tick is where the program was read again.
    std::int64_t came_from_;  // Where the last command that moved began.
};

}  // namespace meld::debug
