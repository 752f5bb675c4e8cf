// A run on one process: the modules that the world chose, and the process's ticks from the first to the last.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/base/error.h"
#include "runtime/sim/balance.h"
#include "runtime/sim/core/code_modules.h"
#include "runtime/sim/core/divergence_report.h"
#include "runtime/sim/core/extension.h"
#include "runtime/sim/core/failures/dead_links.h"
#include "runtime/sim/core/subdomain.h"
#include "runtime/sim/core/tick.h"
#include "runtime/sim/state/loader.h"
#include "runtime/sim/state/saver.h"
#include "runtime/sim/state/take_over.h"

namespace meld::sim {

struct RunLimits {
    std::int64_t ticks = -1;  // Stop after this many; negative: run until nothing is left to do.
    // A derivation of a view that has no value ends the run at once, not only if it is still there at quiescence or an action or a linear
    // rule would read what depends on it.
    bool strict = false;
    // Whether the function that is called after every tick looks at facts or changes any.
    bool looks = true;
};

// Why a run ended.
enum class Ending { Quiet, Ticks, Finished, Watched, Interrupted, Failed };

struct Summary {
    Ending ending = Ending::Quiet;
    std::int64_t ticks = 0;
    std::uint64_t catoms = 0;
    std::uint64_t evaluations = 0;
    std::uint64_t derivations = 0;
    std::uint64_t changes = 0;
    std::uint64_t messages = 0;
    std::uint64_t dropped = 0;
    // Linear facts to nodes that no link need lead to, and the messages by which they went.
    std::uint64_t far_facts = 0, far_hops = 0;
    std::uint64_t sent_bytes = 0;
    double bytes_per_catom = 0;
    double setup_seconds = 0;  // Wall
    double run_seconds = 0;    // Wall
    double cpu_seconds = 0;    // Of this process, from the loaded world to the end.
    // Wall-clock seconds of this process, from the first tick on; those of the modules are parts of "modules".
    std::vector<std::pair<std::string, double>> stage_seconds;
    std::vector<std::string> outcomes;
    // If the run ended before quiescence: a description of the first derivation of a view that had no value then; or empty.
    std::string undefined;
    // Facts of routes, at the end, that lead to a catom which does not touch.
    DeadRoutes dead_routes;
    // Catoms that events and faults have ended, and the times that they have made one hang or restart.
    std::uint64_t killed = 0, hung = 0, restarted = 0;
    std::uint64_t lost = 0;  // Linear facts of those that were killed or have restarted.
    std::uint64_t links_cut = 0, links_made = 0;
    std::uint64_t nodes_made = 0;  // By rules, in a graph.
    // The actions that were not carried out, by action and reason.
    std::vector<Refused> refused;
    // When the ensemble was divided anew among processes, and how uneven the work was after the last time.
    std::vector<partition::Division> divisions;
    double imbalance = 1;
};

class Simulation {
  public:
    Simulation(const ModuleInfo& module, const world::World& world, const world::Target& target, comm::Communicator& comm, int threads);

    // Makes the modules the world names, places the catoms, starts the modules in order.
    Result<void> start(const Registry& registry, std::optional<BrickCounts> counted = {});
    // The same from a snapshot of a run of this program in this world, on any number of processes: the run goes on as if it had never
    // stopped. Every process calls it. Errors: the snapshot is damaged or of another run.
    Result<void> resume(const Registry& registry, const Shares& shares);
    // A run that branches off there, with watchers of its own, which start now. Every process calls it. Returns what became of the facts,
    // with Loads::Anew. Errors: those of resume(); facts of a predicate that is declared otherwise now.
    Result<TakenOver> fork(const Registry& registry, const Shares& shares, Loads how);
    // Whether save() can: errors name the module of the world that cannot be saved. After start() or resume().
    Result<void> saveable() const;
    // What all processes have counted, for save(). Every process calls it, also one that cannot save its share.
    ByteWriter counters() const;
    // This process's share of the state between two ticks, with counters(); nothing of the run changes. The run is saveable(). Errors:
    // those of the sink. Modules that were added under names for which `leaves_out` is true are not in it, as if the run had none.
    using Names = std::function<bool(const std::string& name)>;
    Result<void> save(std::span<const std::byte> counters, ShareSink& sink, const Names& leaves_out = {}) const;
    // The same, of a lattice; chunks that are not among the changed ones the sink may take as they were.
    Result<void> save_changes(std::span<const std::byte> counters, ShareSink& sink, ChangedChunks& changed) const;
    // What the run has written is on the disk, as a checkpoint there will say. Every process calls it. Errors: those of the modules.
    Result<void> secure();
    // Adds a module that runs after those of the world (recorder, digests). A run that branches off finds by its name what it had kept. A
    // module whose name begins with a parenthesis is in no snapshot, so a run goes on with it or without.
    void add(std::unique_ptr<SimModule> module, std::string name = "") {
        extra_.push_back(std::move(module));
        extra_names_.push_back(std::move(name));
    }

    // From now on the ensemble is divided anew when that is worth it, or after each `every` ticks if that is not 0; if it can be.
    void keep_balance(int every) { balance_.emplace(every); }
    // The owners of bricks are these from the beginning of the next tick on, if the ensemble can be divided anew. Every process calls it.
    void divide_anew(partition::Partition next) { next_partition_ = std::move(next); }

    // Ticks until the end; `each` is called after every tick, on every process, and `at_end` after the last if it ended well, while all
    // that is written is still open. A failure of the program is an error whose message names rule, catom and tick.
    Result<void> run(const RunLimits& limits, const std::function<void()>& each, const std::function<void()>& at_end = {});

    // The next tick alone, for whoever goes tick by tick instead of by run(); finish() of modules is not called. Errors: those of run().
    Result<void> step(const RunLimits& limits);
    // How the run ends if the tick that it is at is its last one.
    std::optional<Ending> ended(const RunLimits& limits) const;

    Subdomain& subdomain() { return subdomain_; }
    Summary& summary() { return summary_; }
    // The modules' reports on the run right now.
    std::string status() const;

  private:
    Result<void> make_modules(const Registry& registry);
    // Those of the world alone, and with those that were added.
    Modules chosen_modules() const;
    // Those that a snapshot speaks of.
    Modules all_modules() const;
    // The others, when a run goes on.
    Result<void> resume_others();
    Result<void> make(const std::string& interface, const std::string& name, const Registry& registry);
    // The counts of all processes at a snapshot.
    Result<void> load_counters(std::span<const std::byte> counters);
    Result<void> run_tick();
    // Gives bricks to other processes, if that has been decided.
    void hand_over();
    // What this tick's events and faults do to catoms and links.
    Result<void> strike();
    // Whether the last tick was the last of the run.
    std::optional<Ending> ended_with_this_tick(bool may_be_quiet) const;
    std::int64_t last_tick(const RunLimits& limits) const;
    // Whether nobody looks at facts between the next tick and the one after it, as far as is known, and no links change.
    bool runs_unseen(const RunLimits& limits) const;
    bool may_be_quiet(const RunLimits& limits) const;
    // The error that remains at quiescence, if quiescence is reached and there is one.
    Result<void> check_defined();
    // The error that ends the run with the tick that has just been.
    Result<void> check_tick();
    Result<void> failed(const eval::Failure& failure);
    template <class Call>
    Result<void> each_module(const Call& call);
    // The world has one, and it is made first.
    bool is_motion(const SimModule& m) const { return !modules_.empty() && &m == modules_.front().get(); }

    Subdomain subdomain_;
    Tick tick_;
    std::vector<std::unique_ptr<SimModule>> modules_, extra_;
    std::vector<std::string> chosen_;  // What the world calls each of modules_: the interface and the implementation.
    std::vector<std::string> extra_names_;
    CodeModules codes_;
    std::optional<Balance> balance_;
    std::optional<partition::Partition> next_partition_;
    std::optional<Unsettled> unsettled_;  // Examines the last ticks of a run that has to become quiescent.
    Summary summary_;
    double modules_s_ = 0;
    bool goes_on_ = false;  // resume() was called, and run() not yet.
};

}  // namespace meld::sim
