#include "runtime/driver/study/row_run.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <functional>
#include <utility>

#include "runtime/ask/query/query.h"
#include "runtime/base/process/available_memory.h"
#include "runtime/base/process/stage_clock.h"
#include "runtime/base/terminal/terminal_text.h"
#include "runtime/driver/run/simulate.h"
#include "runtime/driver/setup/made_by.h"
#include "runtime/driver/study/run_counts.h"
#include "runtime/results/record/state_digest.h"
#include "runtime/sim/ending_name.h"

namespace meld::driver {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kMostSaid_bytes = 2000;
// Sums of some of them are numbers still.
constexpr double kMostMemory_bytes = 1e15;

// The value of a body: the only one that it gives; 1 and 0 for one that only holds or does not; nothing for none.
Result<Json> value_of(const inspect::Table& table) {
    if (table.columns().empty()) return Json(table.rows() > 0 ? 1 : 0);
    if (table.rows() == 0) return Json();
    if (table.columns().size() > 1 || table.rows() > 1)
        return fail(fmt::format("it gives {} values in {} way{}, and a measure is one value", table.columns().size(), table.rows(),
                                table.rows() == 1 ? "" : "s"),
                    "Aggregate them: \"max D : { dist(A, D) }\"");
    return table.rows_json(1)[0][0];
}

// Takes the measures of a run, and its digest.
class Measuring : public RunObserver {
  public:
    // `ask` is told what memory the run takes, and returns when it may.
    using Ask = std::function<Result<void>(const MemoryNeed&)>;
    Measuring(const StudyPlan& plan, const StudyModule& module, RowResult& result, Ask ask)
        : plan_(plan), module_(module), result_(result), ask_(std::move(ask)) {}

    Result<void> need(const MemoryNeed& need) override { return ask_ ? ask_(need) : Result<void>(); }
    void begin(sim::Simulation& simulation) override;
    Result<void> end(sim::Simulation& simulation, const inspect::Watches* watches, bool failed) override;
    Result<void> after_tick(sim::Subdomain& subdomain);

  private:
    Result<void> measure(sim::Subdomain& subdomain, std::size_t number, std::int64_t tick);
    const StudyPlan& plan_;
    const StudyModule& module_;
    RowResult& result_;
    const Ask ask_;
};

// Of those that are taken after certain ticks.
class TickMeasures : public sim::SimModule {
  public:
    explicit TickMeasures(Measuring& of) : of_(of) {}
    Result<void> after(sim::Subdomain& subdomain) override { return of_.after_tick(subdomain); }

  private:
    Measuring& of_;
};

void Measuring::begin(sim::Simulation& simulation) {
    const auto& measures = plan_.study().measures;
    if (std::ranges::any_of(measures, [](const StudyMeasure& m) { return !m.ticks.empty(); }))
        simulation.add(std::make_unique<TickMeasures>(*this), "(measures)");
}

Result<void> Measuring::measure(sim::Subdomain& subdomain, std::size_t number, std::int64_t tick) {
    const StudyMeasure& measure = plan_.study().measures[number];
    const Result<inspect::Table> table = inspect::query(subdomain, *module_.measures[number]);
    const Result<Json> value = table ? value_of(*table) : tl::unexpected<Error>(table.error());
    if (!value && value.error().code == ExitCode::Interrupted) return tl::unexpected<Error>(value.error());
    // A measure without a value is a failure of the row; the others are taken all the same.
    result_.measures[measure_key(measure, tick)] = value ? *value : Json::object({{"error", value.error().message()}});
    return {};
}

Result<void> Measuring::after_tick(sim::Subdomain& subdomain) {
    const auto& measures = plan_.study().measures;
    for (std::size_t i = 0; i < measures.size(); ++i)
        if (std::ranges::find(measures[i].ticks, subdomain.tick()) != measures[i].ticks.end())
            if (auto done = measure(subdomain, i, subdomain.tick()); !done) return done;
    return {};
}

Result<void> Measuring::end(sim::Simulation& simulation, const inspect::Watches* watches, bool failed) {
    const sim::Summary& summary = simulation.summary();
    result_.seconds = summary.setup_seconds + summary.run_seconds;
    result_.memory = resident_memory().peak;
    result_.counts = counts_of(summary);
    if (failed) return {};
    result_.ended = sim::name_of(summary.ending);
    result_.digest = record::state_digest(simulation.subdomain()).to_string();
    if (watches != nullptr) {
        const auto& demands = plan_.study().demands;
        for (const inspect::Watches::Outcome& outcome : watches->outcomes())
            for (const StudyDemand& demand : demands) {
                if (outcome.name != demand.name || std::string_view(outcome.verb) != (demand.never ? "never" : "expect")) continue;
                result_.demands[demand_key(demand)] = outcome.wrong ? outcome.found.substr(0, outcome.found.find('\n')) : "";
            }
        for (const inspect::Watches::Outcome& outcome : watches->outcomes())
            if (outcome.name == kStillName) result_.demands[std::string(kStillName)] = outcome.wrong ? outcome.found : "";
    }
    const auto& measures = plan_.study().measures;
    for (std::size_t i = 0; i < measures.size(); ++i) {
        if (measures[i].body.empty()) {
            result_.measures[measure_key(measures[i])] = result_.counts[measures[i].text];
        } else if (measures[i].ticks.empty()) {
            if (auto done = measure(simulation.subdomain(), i, 0); !done) return done;
        } else {
            // A run that ended before has no value there.
            for (const std::int64_t tick : measures[i].ticks) result_.measures.emplace(measure_key(measures[i], tick), nullptr);
        }
    }
    return {};
}

RowResult make_run(const StudyPlan& plan, RunOptions options, const StudyModule& module, Measuring::Ask ask) {
    RowResult result;
    // The process that has started this one looks at the clock, since timers are not inherited.
    options.timeout_seconds = 0;
    result.made_by = made_by();
    Measuring observer(plan, module, result, std::move(ask));
    const auto comm = comm::make_single();
    const Result<int> done = simulate(options, *comm, module.path, &observer);
    result.exit = done ? *done : static_cast<int>(done.error().code);
    if (!done) result.reason = done.error().message();
    // It has ended well; whether that is as wanted depends on what the study demands, which may change.
    result.fine = done && result.exit != static_cast<int>(ExitCode::Interrupted);
    return result;
}

// In a process of its own.
void answer(const StudyPlan& plan, const RunOptions& options, const StudyModule& module, const std::optional<Gate>& gate, int pipe,
            int said) {
    dup2(said, STDOUT_FILENO);
    dup2(said, STDERR_FILENO);
    const std::uint64_t start = own_memory(0);
    const auto ask = [&](const MemoryNeed& need) -> Result<void> {
        const std::uint64_t own = own_memory(0);
        const RowMemory memory{.peak = static_cast<std::uint64_t>(std::clamp(need.peak().most, 0.0, kMostMemory_bytes)),
                               .resident = resident_memory().now,
                               .own = own > start ? own - start : 0,
                               .start = start};
        write_all(pipe, to_line(memory));
        return gate->wait();
    };
    const RowResult result = make_run(plan, options, module, gate ? Measuring::Ask(ask) : Measuring::Ask());
    std::fflush(stdout);
    std::fflush(stderr);
    write_all(pipe, to_json(result).dump(-1, ' ', true, Json::error_handler_t::replace));
}

}  // namespace

std::string measure_key(const StudyMeasure& measure, std::int64_t tick) {
    return (tick > 0 ? fmt::format("@{} ", tick) : std::string()) + (measure.body.empty() ? measure.text : measure.body);
}

std::string demand_key(const StudyDemand& demand) { return (demand.never ? "never " : "expect ") + demand.body; }

nlohmann::ordered_json to_json(const RowResult& r) {
    return {{"fine", r.fine},       {"exit", r.exit},         {"reason", r.reason},   {"ended", r.ended},
            {"counts", r.counts},   {"measures", r.measures}, {"demands", r.demands}, {"digest", r.digest},
            {"seconds", r.seconds}, {"memory", r.memory},     {"made_by", r.made_by}};
}

std::optional<RowResult> row_result(const nlohmann::ordered_json& json) {
    try {
        return RowResult{.fine = json.at("fine"),
                         .exit = json.at("exit"),
                         .reason = json.at("reason"),
                         .ended = json.at("ended"),
                         .counts = json.at("counts"),
                         .measures = json.at("measures"),
                         .demands = json.at("demands"),
                         .digest = json.at("digest"),
                         .seconds = json.at("seconds"),
                         .memory = json.at("memory"),
                         .made_by = json.value("made_by", Json())};
    } catch (const Json::exception&) {
        return std::nullopt;
    }
}

Result<RowRun> RowRun::start(const StudyPlan& plan, std::size_t row) {
    Result<Gate> gate = Gate::make();
    if (!gate) return fail(gate.error().problem, "Give a smaller --jobs", gate.error().code);
    return start(plan, plan.options(plan.rows()[row]), plan.module_of(plan.rows()[row]), row, std::move(*gate));
}

Result<RowRun> RowRun::start(const StudyPlan& plan, const RunOptions& options, const StudyModule& module, std::size_t number) {
    return start(plan, options, module, number, std::nullopt);
}

Result<RowRun> RowRun::start(const StudyPlan& plan, const RunOptions& options, const StudyModule& module, std::size_t number,
                             std::optional<Gate> gate) {
    auto process =
        CopiedProcess::start([&](int pipe, int said) { answer(plan, options, module, gate, pipe, said); }, CopiedProcess::Signals::Shared);
    if (!process) return fail(process.error().problem, "Give a smaller --jobs", process.error().code);
    return RowRun(std::move(*process), number, std::move(gate));
}

RowRun::RowRun(CopiedProcess process, std::size_t number, std::optional<Gate> gate)
    : begun_(seconds_now()), row_(number), process_(std::move(process)), gate_(std::move(gate)) {}

// What it says first is a line, if it has come so far.
void RowRun::note_memory() {
    const std::size_t end = text_.find('\n');
    if (!gate_ || memory_ || end == std::string::npos) return;
    memory_ = row_memory(std::string_view(text_).substr(0, end));
    text_.erase(0, end + 1);
    asked_ = seconds_now();
}

std::uint64_t RowRun::own_now() const {
    const std::uint64_t now = own_memory(process_.id());
    return memory_ && now > memory_->start ? now - memory_->start : 0;
}

void RowRun::let_go_on() {
    may_go_on_ = true;
    begun_ += seconds_now() - asked_;
    gate_->open();
}

std::optional<RowResult> RowRun::take() {
    char buffer[65536];
    const ssize_t n = read(process_.pipe(), buffer, sizeof buffer);
    if (n < 0 && errno == EINTR) return std::nullopt;
    if (n > 0) {
        text_.append(buffer, static_cast<std::size_t>(n));
        note_memory();
        return std::nullopt;
    }
    return finish();
}

std::optional<RowResult> RowRun::end_if_late(double most_seconds) {
    if (most_seconds <= 0 || waits() || seconds_now() - begun_ < most_seconds) return std::nullopt;
    process_.kill();
    RowResult result = finish();
    if (!result.fine) {
        result.exit = static_cast<int>(ExitCode::LimitHit);
        result.reason = fmt::format("the time limit of {} s has passed. Raise timeout", most_seconds);
        result.seconds = seconds_now() - begun_;
    }
    return result;
}

RowResult RowRun::finish() {
    const int status = process_.end().status;
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0)
        if (const Json json = Json::parse(text_, nullptr, false); !json.is_discarded())
            if (const auto result = row_result(json)) return *result;
    // It has crashed, or was ended: what it said last is all there is.
    std::string said(kMostSaid_bytes, '\0');
    const off_t size = lseek(process_.file(), 0, SEEK_END);
    const ssize_t n = pread(process_.file(), said.data(), said.size(), std::max<off_t>(0, size - static_cast<off_t>(said.size())));
    said.resize(static_cast<std::size_t>(std::max<ssize_t>(0, n)));
    RowResult result;
    result.exit = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    result.reason = (WIFSIGNALED(status) ? fmt::format("ended by signal {}", WTERMSIG(status)) : std::string("ended early")) +
                    (said.empty() ? "" : ": " + said);
    return result;
}

}  // namespace meld::driver
