#include "runtime/sim/simulation.h"

#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>
#include <ctime>
#include <limits>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/base/process/interrupt.h"
#include "runtime/base/process/stage_clock.h"
#include "runtime/sim/choices.h"
#include "runtime/sim/core/failures/catom_failures.h"
#include "runtime/sim/core/failures/link_failures.h"
#include "runtime/sim/core/setup/world_facts.h"
#include "runtime/sim/state/hand_over.h"
#include "runtime/sim/state/reading.h"

namespace meld::sim {

namespace {

bool is_in_snapshots(const std::string& module) { return !module.starts_with('('); }

double cpu_seconds() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// Bytes that are given back to the system when a world has been set up. Less is not worth the time.
constexpr std::size_t kMuchFree = std::size_t{2} << 20;

// What files were read into and lists were sorted in lies between what stays, and would never be used as a whole again.
void give_back_memory() {
    if (mallinfo2().fordblks >= kMuchFree) malloc_trim(0);
}

// What a summary counts over a whole run, also if it was stopped in between.
struct Counted {
    std::int64_t ticks = 0;
    std::uint64_t catoms = 0, evaluations = 0, derivations = 0, changes = 0, messages = 0, dropped = 0, sent_bytes = 0;
    std::uint64_t far_facts = 0, far_hops = 0;
    std::uint64_t killed = 0, hung = 0, restarted = 0, lost = 0, links_cut = 0, links_made = 0, nodes_made = 0;

    Counted() = default;
    explicit Counted(const Summary& s)
        : ticks(s.ticks),
          catoms(s.catoms),
          evaluations(s.evaluations),
          derivations(s.derivations),
          changes(s.changes),
          messages(s.messages),
          dropped(s.dropped),
          sent_bytes(s.sent_bytes),
          far_facts(s.far_facts),
          far_hops(s.far_hops),
          killed(s.killed),
          hung(s.hung),
          restarted(s.restarted),
          lost(s.lost),
          links_cut(s.links_cut),
          links_made(s.links_made),
          nodes_made(s.nodes_made) {}
    void give_back(Summary& s) const {
        s.ticks = ticks;
        s.catoms = catoms;
        s.evaluations = evaluations;
        s.derivations = derivations;
        s.changes = changes;
        s.messages = messages;
        s.dropped = dropped;
        s.sent_bytes = sent_bytes;
        s.far_facts = far_facts;
        s.far_hops = far_hops;
        s.killed = killed;
        s.hung = hung;
        s.restarted = restarted;
        s.lost = lost;
        s.links_cut = links_cut;
        s.links_made = links_made;
        s.nodes_made = nodes_made;
    }
};

}  // namespace

Simulation::Simulation(const ModuleInfo& module, const world::World& world, const world::Target& target, comm::Communicator& comm,
                       int threads)
    : subdomain_(module, world, target, comm, threads), tick_(subdomain_) {}

template <class Call>
Result<void> Simulation::each_module(const Call& call) {
    for (auto* list : {&modules_, &extra_})
        for (auto& module : *list)
            if (Result<void> done = call(*module); !done) return done;
    return {};
}

// Makes the implementation that the world chose for an interface and adds it.
Result<void> Simulation::make(const std::string& interface, const std::string& name, const Registry& registry) {
    const auto choice = registry.choose(interface, name);
    if (!choice) return tl::unexpected<Error>(choice.error());
    if (const auto* code = std::get_if<Registry::MakeCode>(&*choice)) return codes_.add(*code, subdomain_.world);
    if (const auto* sim = std::get_if<Registry::MakeSim>(&*choice)) {
        auto module = (*sim)(subdomain_.world);
        if (!module) return tl::unexpected<Error>(module.error());
        modules_.push_back(std::move(*module));
        chosen_.push_back(fmt::format("{} \"{}\"", interface, name));
        return {};
    }
    auto component = std::get<Registry::MakeComponent>(*choice)(subdomain_.world);
    if (!component) return tl::unexpected<Error>(component.error());
    codes_.add(**component);
    modules_.push_back(std::move(*component));
    chosen_.push_back(fmt::format("{} \"{}\"", interface, name));
    return {};
}

Result<void> Simulation::make_modules(const Registry& registry) {
    const world::World& world = subdomain_.world;
    if (auto known = check_choices(registry, world); !known) return known;
    if (auto made = make("motion", world.motion.kind, registry); !made) return made;
    for (const auto& [interface, name] : world.components)
        if (auto made = make(interface, name, registry); !made)
            return fail(world.path + ": [components] " + made.error().problem, made.error().suggestion);
    return codes_.look_up(subdomain_.module);
}

Result<void> Simulation::start(const Registry& registry, std::optional<BrickCounts> counted) {
    const double before = seconds_now();
    if (auto made = make_modules(registry); !made) return made;
    if (auto done = subdomain_.populate(std::move(counted)); !done) return done;
    if (auto done = each_module([&](SimModule& m) { return m.start(subdomain_); }); !done) return done;
    subdomain_.refresh();
    subdomain_.share_routes();
    summary_.catoms = subdomain_.world.is_graph() ? subdomain_.world.graph->nodes() : subdomain_.next_id();
    give_back_memory();
    summary_.setup_seconds = seconds_now() - before;
    return {};
}

Modules Simulation::chosen_modules() const {
    Modules all;
    for (std::size_t i = 0; i < modules_.size(); ++i) all.push_back({chosen_[i], modules_[i].get()});
    return all;
}

Modules Simulation::all_modules() const {
    Modules all = chosen_modules();
    for (std::size_t i = 0; i < extra_.size(); ++i)
        if (is_in_snapshots(extra_names_[i])) all.push_back({extra_names_[i], extra_[i].get()});
    return all;
}

Result<void> Simulation::resume_others() {
    for (std::size_t i = 0; i < extra_.size(); ++i)
        if (!is_in_snapshots(extra_names_[i]))
            if (auto done = extra_[i]->resume(subdomain_); !done) return done;
    return {};
}

Result<void> Simulation::saveable() const {
    MELD_EXPECT(chosen_.size() == modules_.size(), "{} modules, {} names", modules_.size(), chosen_.size());
    for (std::size_t i = 0; i < modules_.size(); ++i)
        if (const auto can = modules_[i]->saveable(); !can)
            return fail(fmt::format("no checkpoint can be made of {}: {}", chosen_[i], can.error().problem), can.error().suggestion);
    for (const auto& module : extra_)
        if (auto can = module->saveable(); !can) return can;
    return {};
}

Result<void> Simulation::secure() {
    return each_module([&](SimModule& m) { return m.secure(subdomain_); });
}

ByteWriter Simulation::counters() const {
    ByteWriter out;
    out.write(Counted(summary_));
    write(subdomain_.refusals.of_all(subdomain_.comm), out);
    return out;
}

Result<void> Simulation::save_changes(std::span<const std::byte> counters, ShareSink& sink, ChangedChunks& changed) const {
    MELD_EXPECT(saveable().has_value(), "a snapshot of a run that cannot be saved");
    const Modules modules = all_modules();
    return Saver(subdomain_, modules, codes_, &changed).run(counters, sink);
}

Result<void> Simulation::save(std::span<const std::byte> counters, ShareSink& sink, const Names& leaves_out) const {
    MELD_EXPECT(saveable().has_value(), "a snapshot of a run that cannot be saved");
    Modules modules = all_modules();
    const auto added = modules.begin() + static_cast<std::ptrdiff_t>(modules_.size());
    if (leaves_out)
        modules.erase(std::remove_if(added, modules.end(), [&](const NamedModule& m) { return leaves_out(m.name); }), modules.end());
    return Saver(subdomain_, modules, codes_).run(counters, sink);
}

Result<void> Simulation::resume(const Registry& registry, const Shares& shares) {
    const double before = seconds_now();
    if (auto made = make_modules(registry); !made) return made;
    const Result<Block> counters = Loader(subdomain_, shares).run(all_modules(), codes_);
    if (!counters) return tl::unexpected<Error>(counters.error());
    if (auto done = resume_others(); !done) return done;
    if (auto done = load_counters(*counters); !done) return done;
    subdomain_.share_routes();
    goes_on_ = true;
    summary_.setup_seconds = seconds_now() - before;
    return {};
}

Result<void> Simulation::load_counters(std::span<const std::byte> counters) {
    ByteReader in = reader(counters, "the counters of a snapshot");
    in.read<Counted>().give_back(summary_);
    for (const Refused& each : read_refused(in)) {
        if (!known(each)) return damaged("counts refusals of no action, or for no reason");
        // What all processes have counted becomes one's.
        if (subdomain_.comm.process() == 0) subdomain_.refuse(each.action, each.why, each.count);
    }
    return read_to_its_end(in, "its counters");
}

Result<TakenOver> Simulation::fork(const Registry& registry, const Shares& shares, Loads how) {
    const double before = seconds_now();
    if (auto made = make_modules(registry); !made) return tl::unexpected<Error>(made.error());
    Loader loader(subdomain_, shares, how);
    if (auto done = loader.run(all_modules(), codes_); !done) return tl::unexpected<Error>(done.error());
    if (auto done = resume_others(); !done) return tl::unexpected<Error>(done.error());
    subdomain_.share_routes();
    // What has been counted is the other run's.
    summary_.ticks = subdomain_.tick();
    summary_.catoms = subdomain_.totals.catoms;
    goes_on_ = true;
    summary_.setup_seconds = seconds_now() - before;
    return loader.taken_over();
}

void Simulation::hand_over() {
    if (!next_partition_) return;
    const partition::Partition next = *std::exchange(next_partition_, std::nullopt);
    const Modules modules = all_modules();
    if (HandOver::possible(subdomain_, chosen_modules())) HandOver(subdomain_, modules, codes_).run(next);
}

Result<void> Simulation::run_tick() {
    tick_.begin();
    hand_over();
    const auto step = [&](SimModule& m) -> Result<void> {
        enter(subdomain_.log(), is_motion(m) ? TickLog::Stage::Motion : TickLog::Stage::Components);
        return m.runnable() ? m.step(subdomain_) : Result<void>{};
    };
    {
        const StageClock clock(modules_s_);
        if (auto done = each_module(step); !done) return done;
    }
    enter(subdomain_.log(), TickLog::Stage::Events);
    if (auto done = strike(); !done) return done;
    tick_.change_given();
    enter(subdomain_.log(), TickLog::Stage::Code);
    if (!codes_.empty()) codes_.run(subdomain_);
    if (unsettled_) unsettled_->before(subdomain_);
    const Totals& t = tick_.end();
    if (unsettled_) unsettled_->after(subdomain_);
    summary_.ticks = subdomain_.tick();
    summary_.catoms = t.catoms;
    summary_.evaluations += t.tick.awake;
    summary_.derivations += t.tick.derivations;
    summary_.changes += t.tick.changes;
    summary_.messages += t.tick.messages;
    summary_.dropped += t.tick.dropped;
    summary_.far_facts += t.tick.far_facts;
    summary_.far_hops += t.tick.far_hops;
    summary_.sent_bytes += t.sent_bytes;
    summary_.lost += t.lost;
    summary_.links_cut += t.links_cut;
    summary_.links_made += t.links_made;
    summary_.nodes_made += t.nodes_made;
    summary_.bytes_per_catom = t.catoms == 0 ? 0 : static_cast<double>(t.bytes) / static_cast<double>(t.catoms);
    // The progress of the other catoms in such a tick depends on the processes, so nobody may see it.
    if (subdomain_.status().half_way()) return {};
    // Files that are being written are written to their end.
    const interrupt::Answering patiently(interrupt::Answer::Patiently);
    const Result<void> done =
        each_module([&](SimModule& m) -> Result<void> { return m.runnable() ? m.after(subdomain_) : Result<void>{}; });
    enter(subdomain_.log(), TickLog::Stage::Between);
    if (done && balance_ && HandOver::possible(subdomain_, chosen_modules())) next_partition_ = balance_->after_tick(subdomain_);
    return done;
}

Result<void> Simulation::strike() {
    CatomFailures failures(subdomain_);
    Struck struck = failures.of_this_tick();
    const bool delayed = subdomain_.world.network.detect > 0 || !subdomain_.status().dying.empty();
    summary_.killed += delayed ? failures.let_die(struck) : struck.killed.size();
    if (!struck.killed.empty()) {
        if (auto done = each_module([&](SimModule& m) { return m.lose(subdomain_, struck.killed); }); !done) return done;
        failures.take_out(struck.killed);
    }
    if (!struck.hung.empty()) {
        failures.hang(struck.hung);
        summary_.hung += struck.hung.size();
    }
    if (!struck.restarted.empty()) {
        const std::vector<Catom> mine = failures.restart(struck.restarted);
        for (const Killed& each : struck.restarted) codes_.forget(each.id);
        GivenFacts(subdomain_).give_again(mine);
        for (auto* list : {&modules_, &extra_})
            for (auto& module : *list) module->restarted(subdomain_, mine);
        summary_.restarted += struck.restarted.size();
    }
    LinkFailures(subdomain_).strike();
    return each_module([&](SimModule& m) { return m.struck(subdomain_), Result<void>{}; });
}

Result<void> Simulation::failed(const eval::Failure& failure) {
    summary_.ending = Ending::Failed;
    return fail(eval::describe(subdomain_.module, failure), eval::cure(failure),
                is_limit(failure.trap) ? ExitCode::LimitHit : ExitCode::ProgramWrong);
}

Result<void> Simulation::check_defined() {
    const Totals& t = subdomain_.totals;
    if (t.failure.trap != Trap::None) return failed(t.failure);
    return t.undefined && t.quiescent() ? failed(tick_.first_undefined()) : Result<void>{};
}

std::optional<Ending> Simulation::ended_with_this_tick(bool may_be_quiet) const {
    const Totals& t = subdomain_.totals;
    if (t.stop) return Ending::Interrupted;
    if (subdomain_.status().ends_here) return Ending::Watched;
    if (t.finished) return Ending::Finished;
    if (!t.awake && !t.waiting && may_be_quiet) return Ending::Quiet;
    return std::nullopt;
}

Result<void> Simulation::check_tick() {
    if (auto defined = check_defined(); !defined) return defined;
    if (!subdomain_.totals.tick.cut) return {};
    summary_.ending = Ending::Interrupted;
    return fail("interrupted in tick " + std::to_string(subdomain_.tick()) + ", before it ended", "", ExitCode::Interrupted);
}

std::int64_t Simulation::last_tick(const RunLimits& limits) const {
    return limits.ticks >= 0 ? limits.ticks : static_cast<std::int64_t>(subdomain_.world.limits.max_ticks);
}

// A hand-written module may sense anything at any time: with one, only the number of ticks ends the run.
bool Simulation::may_be_quiet(const RunLimits& limits) const { return codes_.empty() || limits.ticks < 0; }

bool Simulation::runs_unseen(const RunLimits& limits) const {
    const world::World& world = subdomain_.world;
    if (limits.looks || subdomain_.tick() + 1 >= last_tick(limits) || subdomain_.totals.actions > 0) return false;
    if (!world.events.empty() || !world.faults.empty() || world.apart() || !codes_.empty() || unsettled_) return false;
    const auto alone = [&](const auto& m) { return m->leaves_facts_alone(subdomain_); };
    return std::ranges::all_of(modules_, alone) && std::ranges::all_of(extra_, alone);
}

Result<void> Simulation::step(const RunLimits& limits) {
    subdomain_.set_strict(limits.strict);
    if (auto done = run_tick(); !done) return done;
    return check_tick();
}

std::optional<Ending> Simulation::ended(const RunLimits& limits) const {
    if (subdomain_.tick() > 0)
        if (const std::optional<Ending> ending = ended_with_this_tick(may_be_quiet(limits))) return ending;
    return subdomain_.tick() >= last_tick(limits) ? std::optional(Ending::Ticks) : std::nullopt;
}

Result<void> Simulation::run(const RunLimits& limits, const std::function<void()>& each, const std::function<void()>& at_end) {
    const double wall = seconds_now(), cpu = cpu_seconds();
    Result<void> result;
    const std::int64_t most = last_tick(limits);
    const bool may_end = may_be_quiet(limits);
    summary_.ending = Ending::Ticks;
    subdomain_.set_strict(limits.strict);
    std::optional<interrupt::Answering> soon(interrupt::Answer::Soon);
    // A run that goes on from its end is over. Where facts have been given since an earlier run(), there is something left to do.
    const bool may_be_over = std::exchange(goes_on_, false) && subdomain_.tick() > 0;
    std::optional<Ending> ended = may_be_over ? ended_with_this_tick(may_end) : std::nullopt;
    while (!ended && subdomain_.tick() < most) {
        if (limits.ticks < 0 && !unsettled_ && subdomain_.tick() >= most - Unsettled::kTicks) unsettled_.emplace(subdomain_.module);
        subdomain_.leave_broadcasts(runs_unseen(limits));
        if (auto done = run_tick(); !done) {
            result = done;
            break;
        }
        if (next_partition_ || subdomain_.totals.actions > 0) subdomain_.deliver_broadcasts();
        each();
        if (result = check_tick(); !result) break;
        ended = ended_with_this_tick(may_end);
    }
    subdomain_.leave_broadcasts(false);
    subdomain_.deliver_broadcasts();
    if (ended) summary_.ending = *ended;
    soon.reset();
    if (result && at_end) at_end();
    if (summary_.ending == Ending::Ticks && limits.ticks < 0 && result)
        result = fail("the run was not quiescent after " + std::to_string(most) + " ticks",
                      "Give --ticks N, or raise [limits] max_ticks in the world, if it should go on.\n" + unsettled_->describe(subdomain_),
                      ExitCode::LimitHit);
    if (!result)
        tick_.end_early();
    else if (subdomain_.totals.undefined)
        summary_.undefined = eval::describe(subdomain_.module, tick_.first_undefined());
    if (result) {
        DeadLinks dead(subdomain_);
        dead.look_at_all();
        summary_.dead_routes = dead.of_all_processes();
        summary_.refused = subdomain_.refusals.of_all(subdomain_.comm);
    }
    for (auto* list : {&modules_, &extra_})
        for (auto& module : *list) {
            module->finish(subdomain_);
            if (std::string outcome = module->outcome(); !outcome.empty()) summary_.outcomes.push_back(std::move(outcome));
            if (Result<void> ending = module->ending(); !ending && result) result = std::move(ending);
        }
    if (balance_) {
        summary_.divisions = balance_->rule().divisions();
        summary_.imbalance = balance_->rule().imbalance();
    }
    summary_.stage_seconds = {{"modules", modules_s_}};
    for (const auto* list : {&modules_, &extra_})
        for (const auto& module : *list)
            for (auto& stage : module->stages()) summary_.stage_seconds.push_back(std::move(stage));
    summary_.stage_seconds.emplace_back("evaluation", tick_.evaluation_s());
    summary_.stage_seconds.emplace_back("exchange", tick_.exchange_s());
    summary_.run_seconds = seconds_now() - wall;
    summary_.cpu_seconds = cpu_seconds() - cpu;
    return result;
}

std::string Simulation::status() const {
    std::string text;
    for (const auto& module : modules_)
        if (std::string s = module->status(); !s.empty()) text += (text.empty() ? "" : ", ") + s;
    return text;
}

}  // namespace meld::sim
