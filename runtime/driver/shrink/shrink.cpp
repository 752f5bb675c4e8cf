#include "runtime/driver/shrink/shrink.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "runtime/ask/query/query.h"
#include "runtime/base/files/output_file.h"
#include "runtime/base/files/standard_streams.h"
#include "runtime/base/process/interrupt.h"
#include "runtime/base/process/processors.h"
#include "runtime/base/terminal/log.h"
#include "runtime/base/terminal/terminal_text.h"
#include "runtime/base/units.h"
#include "runtime/driver/setup/default_world.h"
#include "runtime/driver/setup/run_words.h"
#include "runtime/driver/shrink/failure.h"
#include "runtime/driver/shrink/reduce.h"
#include "runtime/driver/shrink/trials.h"
#include "runtime/driver/study/first_line.h"
#include "runtime/driver/study/shell_words.h"
#include "runtime/driver/study/study_table.h"
#include "runtime/driver/study/study_world.h"

namespace meld::driver {

namespace {

constexpr std::size_t kRowsNamed = 10;
constexpr int kWaitForRow_ms = 200;
// A smaller run is not expected to take longer than the row; one that takes this much longer fails otherwise.
constexpr double kLonger = 20, kLeast_s = 10;
constexpr std::int64_t kMoreTicks = 4, kLeastTicks = 1000;

std::string visible_line(const std::string& text) { return visible(first_line(text)); }

// The rows that can be shrunk, for those who have named another.
std::string failed_rows(const StudyPlan& plan, const RowStore& store) {
    std::vector<std::size_t> rows;
    for (std::size_t i = 0; i < plan.rows().size(); ++i)
        if (const RowResult* result = store.any(plan.rows()[i]); result != nullptr && !failure_of(*result, plan.study()).empty())
            rows.push_back(i + 1);
    if (rows.empty()) return "No row that has been made has failed";
    const std::size_t shown = std::min(rows.size(), kRowsNamed);
    const std::string more = rows.size() > shown ? fmt::format(" and {} more", grouped(rows.size() - shown)) : "";
    return fmt::format("Those that have failed are {}{}", fmt::join(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(shown), ", "),
                       more);
}

class Shrinking {
  public:
    Shrinking(const SweepOptions& options, StudyPlan& plan, const RowStore& store, std::size_t row)
        : options_(options), plan_(plan), store_(store), number_(row), row_(plan.rows()[row]), run_(plan.options(row_)) {}

    Result<int> run();

  private:
    const Study& study() const { return plan_.study(); }
    Result<RowResult> make_again() const;
    // How the row fails, as it was kept and as it is now.
    Result<Failure> look();
    Result<toml::table> keys() const;
    Result<std::string> write(const SmallWorld& world, const RunOptions& run) const;

    const SweepOptions& options_;
    StudyPlan& plan_;
    const RowStore& store_;
    const std::size_t number_;
    const StudyRow row_;
    RunOptions run_;
    RowResult result_;
};

Result<RowResult> Shrinking::make_again() const {
    RunOptions options = run_;
    if (!options_.still.empty()) options.expect.push_back(fmt::format("{}: {}", kStillName, options_.still));
    Result<RowRun> run = RowRun::start(plan_, options, plan_.module_of(row_), number_);
    if (!run) return tl::unexpected<Error>(run.error());
    for (;;) {
        if (interrupt::received() != 0) return fail("interrupted", "", ExitCode::Interrupted);
        pollfd end{run->descriptor(), POLLIN, 0};
        poll(&end, 1, kWaitForRow_ms);
        std::optional<RowResult> result;
        if (end.revents != 0) result = run->take();
        if (!result) result = run->end_if_late(study().timeout_seconds);
        if (result) return std::move(*result);
    }
}

Result<Failure> Shrinking::look() {
    const RowResult* const kept = store_.any(row_);
    const std::optional<Failure> before = kept != nullptr ? failure_in(*kept, study(), run_.world) : std::nullopt;
    const auto fine = [&] {
        return fail(fmt::format("row {} has not failed, so there is nothing to shrink", number_ + 1), failed_rows(plan_, store_));
    };
    if (kept != nullptr && !before) return fine();
    if (!options_.still.empty())
        if (const auto body = inspect::read_question(plan_.module_of(row_).info(), options_.still); !body)
            return fail("--still: " + body.error().problem, body.error().suggestion);
    Result<RowResult> now = make_again();
    if (!now) return tl::unexpected<Error>(now.error());
    result_ = std::move(*now);
    const std::optional<Failure> failure = failure_in(result_, study(), run_.world);
    if (!before && !failure) return fine();
    if (!failure || (before && !same_failure(*before, *failure)))
        return fail(
            fmt::format("row {} does not fail any more as it did: {}; now: {}", number_ + 1, visible_line(failure_of(*kept, study())),
                        failure ? visible_line(failure_of(result_, study())) : "it is fine"),
            "What depends on the time or the memory that there is cannot be shrunk. Make the failed rows anew with --again");
    if (failure->kind == Failure::Kind::Measure)
        return fail(
            fmt::format("row {} has failed by a measure, and its run is fine: {}", number_ + 1, visible_line(failure_of(result_, study()))),
            "Correct the measure");
    if (!result_.demands.value(std::string(kStillName), "").empty())
        return fail(fmt::format("--still: the body does not hold at the end of row {} itself", number_ + 1),
                    "Give one that holds there: meldsim query on the command of --show tells");
    return *failure;
}

// The world as it is to be reduced, with the events of other files.
Result<toml::table> Shrinking::keys() const {
    Result<toml::table> keys = toml::table{};
    if (!run_.world.empty()) {
        keys = world_keys_of(run_.world);
    } else {
        const Result<world::World> world = default_world(plan_.module_of(row_).info());
        if (!world) return tl::unexpected<Error>(world.error());
        keys = toml::parse(std::string_view(world->text));
        if (world->network.reach == world::Reach::Any) keys->insert("network", toml::table{{"reach", "any"}});
    }
    if (!keys) return keys;
    for (const std::string& file : run_.events) {
        const Result<toml::table> more = world_keys_of(file);
        if (!more) return tl::unexpected<Error>(more.error());
        const toml::array* events = (*more)["event"].as_array();
        if (events == nullptr) continue;
        if (!keys->contains("event")) keys->insert("event", toml::array{});
        if (const toml::table* one = (*keys)["event"].as_table()) {
            toml::array all;
            all.push_back(*one);
            keys->insert_or_assign("event", all);
        }
        for (const toml::node& each : *events) (*keys)["event"].as_array()->push_back(each);
    }
    return keys;
}

// Returns the path of the world.
Result<std::string> Shrinking::write(const SmallWorld& world, const RunOptions& run) const {
    namespace fs = std::filesystem;
    const fs::path path = run.world;
    const Result<WorldTexts> texts = texts_of(world, path.stem().string());
    if (!texts) return tl::unexpected<Error>(texts.error());
    std::error_code error;
    fs::create_directories(path.parent_path(), error);
    if (error)
        return fail(fmt::format("cannot make the folder {}: {}", path.parent_path().string(), error.message()), "Choose another with -o");
    const std::string head = fmt::format("# Row {} of {} fails here as in its own world: {}\n# {}\n\n", number_ + 1, options_.study,
                                         visible_line(failure_of(result_, study())), visible_line(shell_words(run_words(run, "."))));
    if (auto written = write_file(path.string(), head + texts->world); !written) return tl::unexpected<Error>(written.error());
    for (const auto& [ending, text] : texts->beside)
        if (auto written = write_file((path.parent_path() / (path.stem().string() + ending)).string(), text); !written)
            return tl::unexpected<Error>(written.error());
    return path.string();
}

Result<int> Shrinking::run() {
    const interrupt::Answering patiently(interrupt::Answer::Patiently);
    const Result<Failure> failure = look();
    if (!failure) return tl::unexpected<Error>(failure.error());
    const Result<toml::table> keys = this->keys();
    if (!keys) return tl::unexpected<Error>(keys.error());
    RunOptions options = run_;
    options.events.clear();
    const bool late = failure->kind == Failure::Kind::TimeLimit;
    const double longest = std::max(kLeast_s, kLonger * result_.seconds);
    const Trials::Limits limits{.tries = options_.tries,
                                .jobs = options_.jobs > 0 ? options_.jobs : std::max(1, processors() / study().threads),
                                .seconds = late                          ? study().timeout_seconds
                                           : study().timeout_seconds > 0 ? std::min(study().timeout_seconds, longest)
                                                                         : longest,
                                .ticks = late ? -1 : kMoreTicks * failure->ticks + kLeastTicks};
    RunOptions tried = options;
    if (!options_.still.empty()) tried.expect.push_back(fmt::format("{}: {}", kStillName, options_.still));
    const std::uint64_t seed = row_.seed ? *row_.seed : static_cast<std::uint64_t>((*keys)["seed"].value_or(std::int64_t{1}));
    const bool makes_nodes = plan_.module_of(row_).info().makes_nodes;
    Trials trials(plan_, std::move(tried), row_.program, *failure, limits, options_.quiet);
    if (auto opened = trials.open(); !opened) return tl::unexpected<Error>(opened.error());
    const Result<Reduced> reduced = reduce(*keys, seed, *failure, makes_nodes, trials);
    if (!reduced) return tl::unexpected<Error>(reduced.error());

    options.world = fmt::format("{}/shrunk/row-{}.toml", store_.folder(), number_ + 1);
    if (reduced->world.ticks >= 0) options.ticks = reduced->world.ticks;
    const Result<std::string> path = write(reduced->world, options);
    if (!path) return tl::unexpected<Error>(path.error());
    std::string text = fmt::format("row {} fails: {}\n", number_ + 1, visible_line(failure_of(result_, study())));
    for (const std::string& line : reduced->became) text += fmt::format("  {}\n", line);
    text += fmt::format("  {} {}\n", grouped(trials.tries()), trials.tries() == 1 ? "try" : "tries");
    text += fmt::format("{}\n", shell_words(run_words(options, ".")));
    if (auto printed = print(stdout, text); !printed) return tl::unexpected<Error>(printed.error());
    if (trials.interrupted()) {
        log::warning("interrupted: the world can perhaps be made smaller");
        return interrupt::exit_code();
    }
    if (!reduced->least) log::warning("the world can perhaps be made smaller, and so many tries were not enough: give more with --tries");
    return 0;
}

}  // namespace

Result<int> shrink_row(const SweepOptions& options, StudyPlan& plan, const RowStore& store, std::size_t row) {
    return Shrinking(options, plan, store, row).run();
}

}  // namespace meld::driver
