#include "runtime/show/view/series.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <span>
#include <utility>

#include "runtime/ask/query/measure.h"
#include "runtime/ask/query/query.h"
#include "runtime/comm/transport/collective_result.h"

namespace meld::view {

namespace {

using Clock = std::chrono::steady_clock;
using Kind = check::Type::Kind;

// An answer takes so long, or so many times what it took to get to its first tick.
constexpr std::chrono::milliseconds kWork{250};
constexpr int kTimesTheWay = 3;
constexpr std::size_t kMostBodies = 64;

// On process 0.
Result<std::optional<double>> number_of(const inspect::Table& table) {
    const auto& columns = table.columns();
    if (columns.empty()) return table.rows() > 0 ? 1.0 : 0.0;
    const Kind kind = columns.front().type.kind;
    if (columns.size() > 1 || (kind != Kind::Int && kind != Kind::Float)) return static_cast<double>(table.rows());
    if (table.rows() == 0) return std::optional<double>();
    if (table.rows() > 1)
        return fail(fmt::format("it gives {} numbers after one tick, and a plot has one", table.rows()),
                    "Aggregate them: max D : { dist(A, D) }");
    const Value value = table.cell(0, 0);
    return kind == Kind::Int ? static_cast<double>(value.integer) : value.real;
}

// Collective; the number is on process 0.
Result<std::optional<double>> measured(sim::Subdomain& subdomain, const inspect::Program& question) {
    const Result<inspect::Table> table = inspect::query(subdomain, question);
    if (!table) return tl::unexpected<Error>(table.error());
    const bool speaks = subdomain.comm.process() == 0;
    Result<std::optional<double>> number = speaks ? number_of(*table) : std::optional<double>();
    if (auto all = comm::outcome_of_first(subdomain.comm, number.map([](const auto&) {})); !all) return tl::unexpected<Error>(all.error());
    return number;
}

// Whether it is late, by the clock of process 0. Collective.
bool is_late(comm::Communicator& comm, Clock::time_point until) { return comm::value_of_first(comm, Clock::now() >= until); }

}  // namespace

Result<Json> Series::ask(timeline::Timeline& timeline, const std::string& body, std::int64_t last, std::int64_t most_points) {
    const auto begun = Clock::now();
    sim::Subdomain& present = timeline.simulation().subdomain();
    const Result<inspect::Program> question = inspect::read_question(present.module, inspect::body_of_measure(body));
    if (!question) return tl::unexpected<Error>(question.error());
    if (!bodies_.contains(body) && bodies_.size() >= kMostBodies) bodies_.clear();
    Numbers& numbers = bodies_[body];

    // A power of two, so that a longer run wants no others than it has wanted before.
    const std::int64_t first = timeline.first_tick();
    std::int64_t every = 1;
    while ((last - first) / every >= most_points) every *= 2;
    const auto next_missing = [&](std::int64_t tick) {
        while (tick < last && numbers.contains(tick)) tick = std::min(last, tick + every);
        return numbers.contains(tick) ? last + 1 : tick;
    };
    const auto note = [&](sim::Subdomain& subdomain) -> Result<void> {
        const std::int64_t tick = subdomain.tick();
        if (((tick - first) % every != 0 && tick != last) || numbers.contains(tick)) return {};
        const Result<std::optional<double>> number = measured(subdomain, *question);
        if (!number) return tl::unexpected<Error>(number.error());
        numbers[tick] = *number;
        return {};
    };
    // Where the run is, nothing is run again.
    if (auto noted = note(present); !noted) return tl::unexpected<Error>(noted.error());
    bool done = true;
    if (const std::int64_t missing = next_missing(first); missing <= last) {
        std::optional<Clock::time_point> until;
        const auto walked = timeline.walk(missing, last, [&](sim::Simulation& simulation) -> Result<bool> {
            if (!until) until = Clock::now() + std::max<Clock::duration>(kWork, kTimesTheWay * (Clock::now() - begun));
            if (auto noted = note(simulation.subdomain()); !noted) return tl::unexpected<Error>(noted.error());
            done = next_missing(missing) > last;
            return !done && !is_late(present.comm, *until);
        });
        if (!walked) return tl::unexpected<Error>(walked.error());
    }
    Json ticks = Json::array(), values = Json::array();
    for (const auto& [tick, number] : numbers) {
        if (tick > last || ((tick - first) % every != 0 && tick != last)) continue;
        ticks.push_back(tick);
        values.push_back(number ? Json(*number) : Json());
    }
    return Json{{"every", every}, {"ticks", std::move(ticks)}, {"values", std::move(values)}, {"done", done}};
}

void Series::forget_from(std::int64_t tick) {
    for (auto& [body, numbers] : bodies_) numbers.erase(numbers.lower_bound(tick), numbers.end());
}

}  // namespace meld::view
