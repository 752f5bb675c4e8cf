#include "tests/reference/trials/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "runtime/ask/query/query.h"
#include "runtime/comm/transport/cluster.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/results/record/state_digest.h"
#include "runtime/sim/core/tick.h"
#include "runtime/sim/state/hand_over.h"
#include "runtime/world/ensemble/target.h"
#include "tests/reference/answers/questions.h"
#include "tests/reference/evaluator/model.h"
#include "tests/reference/evaluator/ticks.h"
#include "tests/reference/trials/disturbance.h"
#include "tests/reference/trials/found.h"
#include "tests/reference/trials/watched.h"
#include "tests/reference/trials/worlds.h"
#include "tests/retraction/changes.h"
#include "tests/state/random_division.h"

namespace meld::reference {

using retraction::Change;
using retraction::Mirror;

namespace {

// Derivations in one tick: as many as the reference makes in a round before it gives up.
constexpr std::size_t kMostInATick = 1'000'000;

// More than any trial needs to quiesce. With linear rules some never do.
constexpr int kPatience = 2000, kLinearPatience = 50;

// At most this many of each kind are reported.
constexpr int kMaxShown = 12;

template <class Container>
void list_missing(const check::Program& program, PredicateId p, const Container& from, const Container& in, const char* what,
                  std::string& text) {
    std::vector<Row> rows;
    std::set_difference(from.begin(), from.end(), in.begin(), in.end(), std::back_inserter(rows));
    int shown = 0;
    for (const Row& row : rows) text += ++shown <= kMaxShown ? fmt::format("  {} {}\n", what, print(program, p, row)) : "";
}

template <class Container>
void tell_difference(const check::Program& program, PredicateId p, const Container& expected, const Container& found, std::string& text) {
    list_missing(program, p, expected, found, "missing:", text);
    list_missing(program, p, found, expected, "should not hold:", text);
}

// Whether the runtime stores the predicate under its name. What is stable it need not: rules read what waits.
bool stored(const check::Predicate& p) {
    return p.name.find("@stable") == std::string::npos && p.world == check::WorldSource::None && p.kind != check::PredicateKind::Action &&
           !p.prelude;
}

class Watcher {
  public:
    Watcher(const Trial& trial, const check::Program& program)
        : trial_(trial), program_(program), ticks_(program, trial.world.seed), mirror_(trial.world, trial.draft.given) {
        for (const check::Rule& rule : program.rules) linear_ = linear_ || rule.linear;
        for (const auto& [cell, id] : mirror_.at) ticks_.know(static_cast<std::int64_t>(id));
        if (linear_) ticks_.know(scene(0).links);
        if (trial.draft.reach == Reach::Routes) ticks_.find_ways(Ticks::Ways::Routes);
    }

    bool linear() const { return linear_; }
    Tally tally;

    void begin_burst(std::size_t burst, std::int64_t tick) {
        burst_ = burst;
        start_ = tick;
        next_ = 0;
    }

    // Records the changes that the runtime gets before this tick.
    void change(std::int64_t now) {
        const std::vector<Change>& burst = trial_.world.bursts[burst_];
        mirror_.wake(now);
        for (; next_ < burst.size() && start_ + burst[next_].tick < now; ++next_) {
            const Change& c = burst[next_];
            const auto here = mirror_.at.find(c.cell);
            const std::int64_t id = here == mirror_.at.end() ? 0 : static_cast<std::int64_t>(here->second);
            const bool applied = mirror_.apply(c);
            scene_is_old_ = scene_is_old_ || (applied && c.kind > Change::Kind::Take);
            if (applied && c.kind == Change::Kind::Hang) mirror_.hang(static_cast<std::uint64_t>(id), now + c.arguments.at(0));
            if (!applied || !linear_) continue;
            if (c.kind != Change::Kind::Give && c.kind != Change::Kind::Take) continue;
            const PredicateId p = predicate_of(program_, trial_.draft.given[c.given]);
            retraction::Row raw{id};
            raw.insert(raw.end(), c.arguments.begin(), c.arguments.end());
            if (c.kind == Change::Kind::Give)
                ticks_.give(p, row_of(program_, p, raw));
            else
                ticks_.take(p, row_of(program_, p, raw));
        }
    }

    // Linear rules and what is certain in every tick. Returns the trouble.
    std::string compare_tick(std::int64_t now, sim::Subdomain& subdomain, bool trapped) {
        if (!linear_) return "";
        ticks_.step(scene(now));
        for (const auto& [node, maker] : ticks_.born()) add_node(static_cast<std::uint64_t>(node), static_cast<std::uint64_t>(maker));
        if (ticks_.ran_away()) return "";
        if (ticks_.failed()) return trapped ? "" : fmt::format("no trap: in tick {} the reference met an error", now);
        if (trapped) return "";
        Found found = collect(subdomain, program_);
        const Facts views = ticks_.views(), arriving = ticks_.arriving();
        const std::vector<Bag> linear = ticks_.linear();
        std::string text;
        for (const PredicateId p : program_.predicates.ids()) {
            if (!stored(program_.predicates[p])) continue;
            for (const Row& row : arriving[p.index()])
                if (!views[p.index()].contains(row)) found.facts[p.index()].erase(row);
            if (program_.predicates[p].linear())
                tell_difference(program_, p, linear[p.index()], found.linear[p.index()], text);
            else if (ticks_.certain(p))
                tell_difference(program_, p, views[p.index()], found.facts[p.index()], text);
            tally.tick_facts += linear[p.index()].size() + views[p.index()].size();
        }
        return text.empty() ? "" : fmt::format("tick by tick: at the end of tick {}\n{}", now, text);
    }

    // All views, where nothing changes any more.
    std::string compare_model(std::int64_t now, sim::Subdomain& subdomain, const std::string& error, std::vector<Facts>& views) {
        const Found found = collect(subdomain, program_);
        views.push_back(found.facts);
        const Facts given = linear_ ? ticks_.given() : given_facts(program_, mirror_);
        const Model model = make_model(scene(now), given, found.facts);
        if (model.too_large) {
            ++tally.too_large;
            return "";
        }
        if (!model.settled) return fmt::format("no model: the reference does not come to an end in tick {}", now);
        if (model.failed && error.empty()) return fmt::format("no error: something has no value in tick {}", now);
        if (!model.failed && !error.empty()) return fmt::format("error: all has a value in tick {}, but {}", now, error);
        tally.errors += model.failed;
        std::string text;
        for (const PredicateId p : program_.predicates.ids()) {
            if (!stored(program_.predicates[p]) || program_.predicates[p].linear()) continue;
            tell_difference(program_, p, model.facts[p.index()], found.facts[p.index()], text);
            tally.facts += model.facts[p.index()].size();
        }
        count_losses(found.facts);
        ++tally.quiet;
        if (linear_)
            for (const Rows& rows : given) tally.linear += rows.size();
        return text.empty() ? "" : fmt::format("model: after burst {}, tick {}\n{}", burst_, now, text);
    }

    // The answer to a question about a run at rest. Returns the trouble.
    std::string compare_answer(std::int64_t now, sim::Subdomain& subdomain, const std::string& body, const inspect::Table& table) {
        const Result<inspect::Program> asked = inspect::Program::read(subdomain.module, body);
        if (!asked) return "question: " + asked.error().message();
        const Found found = collect(subdomain, asked->checked());
        const Scene there = make_scene(asked->checked(), trial_.world, mirror_, now);
        const Rows expected = answer(*asked, there, found.facts, found.linear), rows = rows_of(table);
        ++tally.questions;
        tally.rows += rows.size();
        if (rows == expected && rows.size() == table.rows()) return "";
        std::string text;
        const auto list = [&](const Rows& from, const Rows& in, const char* what) {
            int shown = 0;
            for (const Row& row : from) {
                if (in.contains(row) || ++shown > kMaxShown) continue;
                text += fmt::format("  {}", what);
                for (std::size_t i = 0; i < row.size(); ++i)
                    text += fmt::format(" {} = {}", table.columns()[i].name, print(table.columns()[i].type, row[i]));
                text += "\n";
            }
        };
        list(expected, rows, "missing:");
        list(rows, expected, "no answer:");
        return fmt::format("answer: `{}` in tick {}: {} rows instead of {}\n{}", body, now, table.rows(), expected.size(), text);
    }

    // Whether the reference has left the comparison: it met an error, or a catom made facts without end.
    bool lost_track() const { return ticks_.ran_away() || ticks_.failed(); }

  private:
    const Scene& scene(std::int64_t now) {
        if (scene_is_old_)
            scene_ = make_scene(program_, trial_.world, mirror_, now);
        else
            set_tick(scene_, now);
        scene_is_old_ = false;
        return scene_;
    }
    // As the runtime places nodes: on a spiral around their makers.
    void add_node(std::uint64_t node, std::uint64_t maker) {
        const auto known = mirror_.made.find(maker);
        const auto graph = make_graph(trial_.world);
        const graph::Point& at = known == mirror_.made.end() ? graph->places[*graph->find(maker)] : known->second;
        const double k = ++children_[maker], turn = std::numbers::pi * (3 - std::sqrt(5.0)), r = 1.5 * std::sqrt(k);
        mirror_.made[node] = {at[0] + r * std::cos(k * turn), at[1] + r * std::sin(k * turn), at[2]};
        mirror_.at[retraction::node(node)] = node;
        scene_is_old_ = true;
    }
    void count_losses(const Facts& now) {
        for (std::size_t p = 0; p < before_.size(); ++p)
            for (const Row& row : before_[p]) tally.lost += !now[p].contains(row);
        before_ = now;
    }

    const Trial& trial_;
    const check::Program& program_;
    Ticks ticks_;
    Mirror mirror_;
    Scene scene_ = {};
    std::map<std::uint64_t, int> children_;  // How many nodes each has made.
    bool scene_is_old_ = true;
    bool linear_ = false;
    std::size_t burst_ = 0, next_ = 0;
    std::int64_t start_ = 0;
    Facts before_ = {};
};

// What the processes of a run share. Process 0 writes.
struct Shared {
    const Trial& trial;
    const ModuleInfo& module;
    const Setting& setting;
    const world::World& world;
    const world::Target& target;
    Watcher* watcher;  // Null: nobody watches.
    bool linear;
    bool beyond;  // Networks, clocks and failures, under which the reference knows only where all comes to rest.
    Outcome outcome = {};
    std::optional<std::string> question;     // Watched in every tick, and asked in the end.
    std::string undefined_at_end = {};       // The error of the last burst, where the reference watches.
    Disturbance* disturbance = nullptr;      // Null: nothing disturbs the run.
    const check::Program* viewed = nullptr;  // With Watch::Views.
};

// Every process asks.
void ask(sim::Subdomain& subdomain, Shared& s) {
    const Result<inspect::Table> table = inspect::query(subdomain, *s.question);
    if (subdomain.comm.process() != 0) return;
    s.outcome.answers += table ? table->to_text(~std::uint64_t{0}) : table.error().message() + "\n";
    if (s.watcher == nullptr) return;
    s.outcome.trouble = table ? s.watcher->compare_answer(subdomain.tick(), subdomain, *s.question, *table)
                              : fmt::format("answer: `{}`: {}", *s.question, table.error().message());
}

// On several processes catoms go to others now and then, in half of the trials.
void divide_anew(sim::Subdomain& subdomain, std::uint64_t seed) {
    const std::uint64_t division = random_bits(seed, 0x64697669, static_cast<std::uint64_t>(subdomain.tick()), 0);
    if (seed % 2 == 0 || division % 3 != 0 || !sim::HandOver::possible(subdomain, {})) return;
    sim::CodeModules none;
    sim::HandOver(subdomain, {}, none).run(random_division(subdomain.lattice, subdomain.comm.processes(), division));
}

bool is_unseen(std::uint64_t seed, std::int64_t tick) {
    return random_bits(seed, 0x756e7365, static_cast<std::uint64_t>(tick), 0) % 4 != 0;
}

enum class End { Quiet, Restless, Failed, Stopped };

// One burst, from its begin or from where it was stopped.
End settle(sim::Subdomain& subdomain, sim::Tick& tick, Place& place, Shared& s, std::optional<Watched>& watched,
           record::RunningDigest& digest) {
    const bool speaks = subdomain.comm.process() == 0;
    retraction::Changes& changes = place.changes;
    const std::size_t burst = place.burst;
    if (place.patience == 0) {
        changes.begin_burst(burst, subdomain.tick());
        if (s.watcher) s.watcher->begin_burst(burst, subdomain.tick());
        const int longer = static_cast<int>(s.world.latency());
        place.patience = s.linear ? kLinearPatience : kPatience * longer;
    }
    for (; place.patience > 0; place.patience -= changes.done()) {
        if (s.disturbance && s.disturbance->before_tick(subdomain, place)) return End::Stopped;
        tick.begin();
        if (!s.setting.unseen) divide_anew(subdomain, s.trial.world.seed);
        static_cast<void>(changes.step(subdomain));
        if (s.watcher) s.watcher->change(subdomain.tick());
        const bool unseen = s.setting.unseen && changes.done() && is_unseen(s.trial.world.seed, subdomain.tick());
        subdomain.leave_broadcasts(unseen);
        const sim::Totals& totals = tick.end();
        const bool trapped = totals.failure.trap != Trap::None;
        State state{unseen ? Digest{} : digest.of(subdomain), totals.tick.derivations, {}, !unseen};
        if (const Result<void> same = unseen ? Result<void>{} : digest.check(subdomain); !same) {
            if (speaks) s.outcome.trouble = same.error().message();
            return End::Failed;
        }
        const bool quiet = changes.done() && !totals.awake && !totals.waiting;
        if (totals.undefined && quiet) state.error = eval::describe(subdomain.module, tick.first_undefined());
        if (s.watcher) s.undefined_at_end = state.error;
        if (s.watcher) s.watcher->tally.undefined += totals.undefined;
        // After an error some catoms have been evaluated and others not.
        if (speaks && !trapped) s.outcome.states.push_back(state);
        const bool limited = totals.failure.trap == Trap::TooManyDerivations || totals.failure.trap == Trap::TooManyFacts;
        if (limited || totals.tick.derivations > kMostInATick) {
            // The limit of a run, which the reference does not have; or a dozen runs with such ticks would take minutes.
            if (s.watcher) ++s.watcher->tally.too_large;
            return End::Failed;
        }
        if (s.watcher && !s.beyond) {
            s.outcome.trouble = s.watcher->compare_tick(subdomain.tick(), subdomain, trapped);
            if (s.outcome.trouble.empty() && trapped && !s.watcher->lost_track()) s.outcome.trouble = "trap";
            if (!s.outcome.trouble.empty() && trapped) s.outcome.trouble += ": " + eval::describe(subdomain.module, totals.failure);
            if (!s.outcome.trouble.empty()) return End::Failed;
            if (s.watcher->lost_track() && !trapped) return End::Failed;
        }
        if (trapped) {
            if (s.watcher) ++s.watcher->tally.errors;
            return End::Failed;
        }
        if (watched) {
            const std::string trouble = watched->after(subdomain);
            if (speaks && !trouble.empty()) {
                s.outcome.trouble = trouble;
                return End::Failed;
            }
        }
        if (quiet) return End::Quiet;
    }
    if (speaks && !s.linear) s.outcome.trouble = fmt::format("never quiet after burst {}", burst);
    return s.linear ? End::Restless : End::Failed;
}

void run_process(comm::Communicator& comm, Shared& s) {
    sim::Subdomain subdomain(s.module, s.world, s.target, comm, s.setting.threads);
    Place place{.burst = 0, .patience = 0, .changes = retraction::Changes(s.trial.world, s.trial.draft.given)};
    if (s.disturbance && s.disturbance->goes_on())
        s.disturbance->load(subdomain, place);
    else if (const auto done = subdomain.populate(); !done)
        throw std::runtime_error(done.error().message());
    subdomain.share_routes();
    sim::Tick tick(subdomain);
    if (s.disturbance && comm.process() == 0) s.outcome.states.resize(static_cast<std::size_t>(subdomain.tick()));
    record::RunningDigest digest;
    std::optional<Watched> watched;
    if (s.question) watched.emplace(s.module, *s.question, s.watcher != nullptr);
    for (; place.burst < s.trial.world.bursts.size(); ++place.burst, place.patience = 0) {
        const End end = settle(subdomain, tick, place, s, watched, digest);
        subdomain.deliver_broadcasts();
        if (watched && comm.process() == 0) {
            s.outcome.told = watched->told();
            if (s.watcher) s.watcher->tally.told = watched->lines();
        }
        if (end == End::Failed || end == End::Stopped) return;
        if (s.question && place.burst + 1 == s.trial.world.bursts.size()) ask(subdomain, s);
        if (subdomain.comm.process() == 0 && !s.outcome.trouble.empty()) return;
        if (end == End::Quiet && s.viewed && !(s.linear && s.beyond)) s.outcome.views.push_back(collect(subdomain, *s.viewed).facts);
        if (end == End::Restless || s.watcher == nullptr || (s.linear && s.beyond)) continue;
        s.outcome.trouble = s.watcher->compare_model(subdomain.tick(), subdomain, s.undefined_at_end, s.outcome.views);
        if (!s.outcome.trouble.empty()) return;
    }
}

// What two runs of a trial differ in.
std::string compare(const Outcome& alone, const Outcome& other, const std::string& setting) {
    const std::size_t known = std::min(alone.states.size(), other.states.size());
    std::size_t same = 0;
    while (same < known && alone.states[same] == other.states[same]) ++same;
    if (same < known) {
        const State &a = alone.states[same], &b = other.states[same];
        return fmt::format("states differ: {}, after tick {}: {} facts, {} derivations instead of {}, `{}` and `{}`", setting, same + 1,
                           a.digest == b.digest ? "equal" : "other", b.derivations, a.derivations, b.error, a.error);
    }
    if (alone.states.size() != other.states.size())
        return fmt::format("states differ: {}: {} ticks instead of {}", setting, other.states.size(), alone.states.size());
    if (other.told != alone.told) return fmt::format("watches differ: {}\n{}instead of\n{}", setting, other.told, alone.told);
    if (other.answers != alone.answers) return fmt::format("answers differ: {}\n{}instead of\n{}", setting, other.answers, alone.answers);
    return "";
}

}  // namespace

std::optional<std::string> question_of(const Trial& trial, const check::Program& program) {
    Random random(trial.world.seed);
    return make_question(random, trial.draft, program);
}

void Tally::add(const Tally& other) {
    facts += other.facts;
    tick_facts += other.tick_facts;
    lost += other.lost;
    linear += other.linear;
    quiet += other.quiet;
    undefined += other.undefined;
    errors += other.errors;
    ticks += other.ticks;
    questions += other.questions;
    told += other.told;
    rows += other.rows;
    too_large += other.too_large;
    stopped += other.stopped;
    varied += other.varied;
}

PredicateId predicate_of(const check::Program& program, const retraction::Given& given) {
    for (const PredicateId p : program.predicates.ids())
        if (program.predicates[p].name == given.predicate && program.predicates[p].arguments.size() == given.arguments.size() + 1) return p;
    throw std::runtime_error("the program does not declare " + given.predicate);
}

Row row_of(const check::Program& program, PredicateId predicate, const retraction::Row& raw) {
    Row row;
    for (std::size_t i = 0; i < raw.size(); ++i)
        row.push_back(is_real(program.predicates[predicate].arguments[i].type) ? value_of(retraction::quarters(raw[i])) : value_of(raw[i]));
    return row;
}

Facts given_facts(const check::Program& program, const Mirror& mirror) {
    Facts facts(program.predicates.count());
    for (const retraction::Given& given : mirror.given) {
        const auto rows = mirror.facts.find(given.predicate);
        if (given.linear || rows == mirror.facts.end()) continue;
        const PredicateId p = predicate_of(program, given);
        for (const retraction::Row& raw : rows->second) facts[p.index()].insert(row_of(program, p, raw));
    }
    return facts;
}

Outcome run(const Trial& trial, const check::Program& program, const ModuleInfo& module, const Setting& setting, Watch watch) {
    world::World world = make_world(trial.world);
    if (trial.draft.reach == Reach::OneHop) world.network.reach = world::Reach::Any;
    if (trial.draft.reach == Reach::Routes) world.network.reach = world::Reach::Links;
    set_conditions(world, setting.conditions);
    const bool fails = retraction::has_failures(trial.world);
    if (fails) set_jams(world, trial.world.seed);
    const Result<world::Target> target = world::Target::make(world, world::Lattice(world.lattice));
    if (!target) throw std::runtime_error(target.error().message());
    Watcher watcher(trial, program);
    Shared shared{
        .trial = trial,
        .module = module,
        .setting = setting,
        .world = world,
        .target = *target,
        .watcher = watch == Watch::Reference ? &watcher : nullptr,
        .linear = watcher.linear(),
        .beyond = world.apart() || retraction::has_catom_failures(trial.world),
        .question = setting.conditions == 0 && !retraction::has_catom_failures(trial.world) && setting.disturbance == 0 && !setting.unseen
                        ? question_of(trial, program)
                        : std::nullopt};
    if (watch == Watch::Views) shared.viewed = &program;
    if (setting.disturbance != 0) {
        Disturbance disturbance(setting.disturbance);
        shared.disturbance = &disturbance;
        while (disturbance.attempt([&](comm::Communicator& comm) { run_process(comm, shared); })) {
        }
        watcher.tally.stopped = disturbance.stopped();
    } else if (setting.processes == 1) {
        const auto comm = comm::make_single();
        run_process(*comm, shared);
    } else if (setting.threads == 1) {
        // So that what differs once in many orders of turns differs again when the seed is run again.
        comm::run_cluster({.processes = setting.processes, .seed = trial.world.seed},
                          [&](comm::Communicator& comm) { run_process(comm, shared); });
    } else {
        comm::run_threads_as_processes(setting.processes, [&](comm::Communicator& comm) { run_process(comm, shared); });
    }
    shared.outcome.tally = watcher.tally;
    shared.outcome.tally.ticks = shared.outcome.states.size();
    return std::move(shared.outcome);
}

std::string trouble_of_setting(const Outcome& alone, const Trial& trial, const check::Program& program, const ModuleInfo& module,
                               const Setting& setting, Tally& tally) {
    Outcome other = run(trial, program, module, setting, Watch::States);
    tally.stopped += other.tally.stopped;
    if (setting.disturbance != 0 || setting.unseen) {
        other.told = alone.told;
        other.answers = alone.answers;
    }
    if (setting.disturbance != 0) {
        // A catom that has not acted for a while is evaluated as a whole after it was restored, instead of row by row.
        const bool waits = setting.conditions != 0 || retraction::has_catom_failures(trial.world);
        for (std::size_t i = 0; waits && i < std::min(alone.states.size(), other.states.size()); ++i)
            other.states[i].derivations = alone.states[i].derivations;
    }
    return compare(alone, other,
                   setting.disturbance != 0
                       ? fmt::format("disturbance {}", setting.disturbance)
                       : fmt::format("{} processes, {} threads{}", setting.processes, setting.threads, setting.unseen ? ", unseen" : ""));
}

std::string trouble_of(const Trial& trial, Workshop& workshop, const std::vector<Setting>& settings, std::uint64_t conditions) {
    const std::string text = print(trial.draft);
    const Result<check::Program> program = checked(text);
    if (!program) return "refused: " + program.error().message();
    const Result<Module> module = workshop.module(text, by_links(trial, conditions));
    if (!module) return "not compiled: " + module.error().message();
    const Outcome alone = run(trial, *program, info_of(*module), {.conditions = conditions}, Watch::Reference);
    std::string trouble = alone.trouble;
    Tally ignored;
    for (Setting setting : settings) {
        if (!trouble.empty()) break;
        setting.conditions = conditions;
        trouble = trouble_of_setting(alone, trial, *program, info_of(*module), setting, ignored);
    }
    return trouble;
}

bool by_links(const Trial& trial, std::uint64_t conditions) {
    return conditions != 0 || trial.world.graph || retraction::has_failures(trial.world);
}

std::string trouble_of_variant(const Outcome& base, const check::Program& program, const Varied& varied, const Variation& variation,
                               Workshop& workshop, std::uint64_t conditions, Tally& tally) {
    const std::string text = print(varied.trial.draft), how = describe(variation);
    const Result<check::Program> other = checked(text);
    if (!other) return fmt::format("variant refused: {}: {}\n{}", how, other.error().message(), text);
    const Result<Module> module = workshop.module(text, by_links(varied.trial, conditions));
    if (!module) return fmt::format("variant not compiled: {}: {}\n{}", how, module.error().message(), text);
    const bool comparable = reference::comparable(program, variation);
    // In another order of its atoms a body may take the reference too long.
    if (!comparable && variation.reordered) return "";
    const Outcome out =
        run(varied.trial, *other, info_of(*module), {.conditions = conditions}, comparable ? Watch::Views : Watch::Reference);
    tally.add(out.tally);
    if (!out.trouble.empty()) return fmt::format("variant: {}: {}\n{}", how, out.trouble, text);
    if (!comparable) return "";
    if (out.views.size() != base.views.size())
        return fmt::format("variant at rest: {}: {} bursts came to rest instead of {}\n{}", how, out.views.size(), base.views.size(), text);
    for (std::size_t burst = 0; burst < base.views.size(); ++burst) {
        const Facts expected = translate(program, base.views[burst], *other, varied);
        std::string difference;
        for (const PredicateId p : other->predicates.ids()) {
            if (!stored(other->predicates[p]) || other->predicates[p].linear()) continue;
            tell_difference(*other, p, expected[p.index()], out.views[burst][p.index()], difference);
            tally.varied += expected[p.index()].size();
        }
        if (!difference.empty()) return fmt::format("variant differs: {}: after burst {}\n{}\n{}", how, burst, difference, text);
    }
    return "";
}

}  // namespace meld::reference
