// How C++ joins a simulation: SimModule acts on the whole ensemble in the central phase, CodeModule runs at each catom in addition to the
// compiled rules, Component does both and is synchronized in every tick (Ashley-Rollman et al., ICRA 2011). Motion, the recorder and the
// examples use these classes.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/base/error.h"
#include "runtime/base/version.h"
#include "runtime/engine/tuple/change_log.h"
#include "runtime/sim/core/argument.h"
#include "runtime/world/description/world.h"

namespace meld::sim {

class Subdomain;
struct Killed;

class SimModule {
  public:
    virtual ~SimModule() = default;
    // Called on every process, once, when the ensemble is complete; and at the end, after the last tick.
    virtual Result<void> start(Subdomain&) { return {}; }
    virtual void finish(Subdomain&) {}
    // A passive module has no step; other modules query it.
    virtual bool runnable() const { return true; }
    // The central phase of a tick, on every process at the same time: it may exchange through the process's communicator.
    virtual Result<void> step(Subdomain&) { return {}; }
    // Catoms that events end in this tick, of all processes and by their numbers; called after step(), on every process at the same time,
    // while they are still there. On a lattice they are taken out afterwards; motion of another kind does so itself.
    virtual Result<void> lose(Subdomain&, std::span<const Killed>) { return {}; }
    // Catoms of this process that have restarted in this tick: the facts that the module had given them are gone. Called when they have the
    // facts of the start.
    virtual void restarted(Subdomain&, std::span<const std::uint32_t> /*catoms*/) {}
    // After the events and faults of a tick, on every process at the same time: catoms and links are as this tick's rules find them.
    virtual void struck(Subdomain&) {}
    // After evaluation, before the tick is counted.
    virtual Result<void> after(Subdomain&) { return {}; }
    // Whether it neither reads nor changes facts, catoms or links in step() and after() of ticks in which no action is carried out or
    // asked for. Where all modules say so, linear facts need not be delivered before rules read them.
    virtual bool leaves_facts_alone(const Subdomain&) const { return false; }
    // Whether a snapshot can hold what it keeps between two ticks: yes for a module that keeps nothing, and for one that saves all of it
    // below. Whoever does not say so makes a checkpoint an error rather than wrong.
    virtual Result<void> saveable() const {
        return fail("it does not say how what it keeps is saved",
                    "Let it override SimModule::saveable(), and save_rest() and load_rest() if it keeps anything between two ticks");
    }
    // Whether catoms may come to belong to another process between two ticks although they have not moved: where the processes have not
    // enough or too much to do, the ensemble is divided anew. What is kept for a catom goes with it, by save_catoms() and load_catoms();
    // leave() tells the process from which catoms go, right before. It must be so, too, in a module that keeps numbers of catoms by their
    // indices. Whoever does not say so makes processes keep their catoms.
    virtual bool divides_anew() const { return false; }
    virtual void leave(Subdomain&, std::span<const std::uint32_t> /*catoms*/) {}
    // Before a checkpoint on disk, on every process at the same time: what has been written to files that save_rest() speaks of is on the
    // disk when this returns. Errors, the same on every process: there is no checkpoint then.
    virtual Result<void> secure(Subdomain&) { return {}; }
    // A run that goes on from a snapshot calls resume() where it would call start(): it finds what it needs in the program and the
    // world, and changes no facts, which come back by themselves. Then all that save_catoms and save_rest wrote is read, of all
    // processes that wrote it, on however many there are now. What is kept for catoms is written in their order, and read by their
    // places in the same order; `catoms` says where each of them is now.
    virtual Result<void> resume(Subdomain& subdomain) { return start(subdomain); }
    virtual void save_catoms(const Subdomain&, std::span<const std::uint32_t> /*catoms*/, ByteWriter&) const {}
    virtual void load_catoms(Subdomain&, std::span<const tuple::SavedCatom> /*catoms*/, ByteReader&) {}
    virtual void save_rest(const Subdomain&, ByteWriter&) const {}
    // Errors: what it wrote to is not as it was.
    virtual Result<void> load_rest(Subdomain&, ByteReader&) { return {}; }
    // When all of it is read, on every process at the same time: it may exchange.
    virtual Result<void> resumed(Subdomain&) { return {}; }
    // A few words for the progress line and the summary, e.g. "1,204 outside the target"; process 0 is asked.
    virtual std::string status() const { return ""; }
    // The result of the run, after finish(), as a line for the summary, e.g. "target reached in 400 ticks".
    virtual std::string outcome() const { return ""; }
    // Whether the module's output is complete, after finish(); an error, which must be the same on every process, makes the run fail.
    virtual Result<void> ending() const { return {}; }
    // Wall-clock seconds that the stages of its steps have taken on this process.
    using Stages = std::vector<std::pair<std::string, double>>;
    virtual Stages stages() const { return {}; }
};

// Of a module that says when what its save_catoms() writes has changed. Where checkpoints hold what has changed, others are asked for all
// catoms, and what they write counts as changed.
class SaysWhatChanges {
  public:
    virtual ~SaysWhatChanges() = default;
    // Whether it changes only with something else at the catom, or with Subdomain::touch().
    virtual bool touches_what_it_keeps() const = 0;
};

// A predicate of the running program, looked up once by name.
class Predicate {
  public:
    Predicate() = default;
    explicit Predicate(std::uint32_t number) : number_(number) {}
    std::uint32_t number() const { return number_; }

  private:
    std::uint32_t number_ = 0;
};

// The names of the running program. Errors name the nearest predicate.
class Names {
  public:
    explicit Names(const ModuleInfo& module) : module_(module) {}
    // A predicate whose facts a module may make hold, with this number of arguments after the catom.
    Result<Predicate> sensed(std::string_view name, std::size_t arguments) const;
    // A predicate whose facts a module may read, including one that rules derive.
    Result<Predicate> stored(std::string_view name, std::size_t arguments) const;
    // An action that the program uses or declares, for CatomView::act.
    Result<Predicate> action(std::string_view name, std::size_t arguments) const;
    // A linear predicate, for CatomView::send.
    Result<Predicate> linear(std::string_view name, std::size_t arguments) const;

  private:
    const ModuleInfo& module_;
};

// A CodeModule's view of its catom.
class CatomView {
  public:
    CatomView(Subdomain& subdomain, std::uint32_t catom) : subdomain_(subdomain), catom_(catom) {}
    std::uint64_t id() const;
    world::Vec3 position() const;
    std::int64_t tick() const;
    // Makes a sensed fact hold (a Single is replaced) or not hold; if that is a change, the catom is evaluated.
    void sense(Predicate predicate, const std::vector<Argument>& arguments);
    void unsense(Predicate predicate, const std::vector<Argument>& arguments);
    // The facts that a predicate has at this catom, as the last tick left them: the arguments of each after the catom.
    std::vector<std::vector<Argument>> facts(Predicate predicate) const;
    // Its neighbours, in the order of the ports.
    std::vector<CatomId> neighbors() const;
    // Requests an action as a rule of this catom does: it is carried out in the central phase of the next tick. If several catoms or
    // requests compete, those of a module come before those of its catom's rules, in the order of the calls.
    void act(Predicate action, const std::vector<Argument>& arguments);
    // Sends a linear fact to a neighbour, as a rule of this catom does: the neighbour's rules find it in the next tick. If the catoms are
    // not linked, sends nothing and returns false.
    bool send(CatomId to, Predicate linear, const std::vector<Argument>& arguments);

  private:
    Subdomain& subdomain_;
    std::uint32_t catom_;
};

class CodeModule {
  public:
    virtual ~CodeModule() = default;
    enum class Instances { Shared, PerCatom };  // One object for all catoms of a process, or one per catom with its own state.
    virtual Instances instances() const { return Instances::Shared; }
    virtual bool runnable() const { return true; }
    // Looks up the predicates that it uses. Called once for each object, before its first run; an error ends the run.
    virtual Result<void> look_up(const Names&) { return {}; }
    // Runs at every catom in every tick, before rules are evaluated. Must depend only on the catom and the tick.
    virtual void run(CatomView& catom) = 0;
    // The state of a per-catom instance, which follows its catom to another process: load() is called on a new object after look_up()
    // and must read all that save() has written. An object that is shared does not move; a snapshot asks that of process 0, and all
    // processes load it, so what it writes must be alike on all.
    virtual void save(ByteWriter&) const {}
    virtual void load(ByteReader&) {}
};

// Both sides in one object per process: in every tick step(), on every process at the same time, then run() at each catom, so the catoms
// see central decisions in the same tick.
class Component : public SimModule, public CodeModule {
  public:
    bool runnable() const override { return true; }
    Instances instances() const final { return Instances::Shared; }
};

// Implementations by interface and name: "motion" may be "none" or "lattice"; the world file chooses.
class Registry {
  public:
    using MakeSim = std::function<Result<std::unique_ptr<SimModule>>(const world::World&)>;
    using MakeCode = std::function<Result<std::unique_ptr<CodeModule>>(const world::World&)>;
    using MakeComponent = std::function<Result<std::unique_ptr<Component>>(const world::World&)>;
    void add_sim(const std::string& interface, const std::string& name, MakeSim make) { sims_[interface][name] = std::move(make); }
    void add_code(const std::string& interface, const std::string& name, MakeCode make) { codes_[interface][name] = std::move(make); }
    void add_component(const std::string& interface, const std::string& name, MakeComponent make) {
        components_[interface][name] = std::move(make);
    }

    // The implementation that a world chose for an interface: one of the three kinds, whichever has that name.
    using Choice = std::variant<MakeSim, MakeCode, MakeComponent>;
    // Errors name the nearest known interface or implementation.
    Result<Choice> choose(const std::string& interface, const std::string& name) const;
    // Whether the world has chosen a module in C++ that may give facts itself: then nobody here knows of which predicates. Code at catoms
    // only sends linear facts, and the motions that come with Claymeld give none.
    bool may_give(const world::World& world) const;

    // Everything that comes with Claymeld.
    static Registry standard();

  private:
    std::map<std::string, std::map<std::string, MakeSim>> sims_;
    std::map<std::string, std::map<std::string, MakeCode>> codes_;
    std::map<std::string, std::map<std::string, MakeComponent>> components_;
};

}  // namespace meld::sim

// Defines the function by which a shared object for `meldsim run --extension` adds its implementations; exactly one per object.
//     CLAYMELD_EXTENSION(registry) { registry.add_code("odometer", "steps", ...); }
#define CLAYMELD_EXTENSION(registry)                                                 \
    extern "C" const char* claymeld_extension_version() { return ::meld::kVersion; } \
    extern "C" void claymeld_extension(::meld::sim::Registry& registry)
