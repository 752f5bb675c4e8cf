#include "runtime/driver/shrink/trials.h"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "runtime/base/files/output_file.h"
#include "runtime/base/hash.h"
#include "runtime/base/process/interrupt.h"
#include "runtime/base/units.h"

namespace meld::driver {

namespace {

namespace fs = std::filesystem;

constexpr int kWaitForTry_ms = 200;

}  // namespace

Trials::Trials(StudyPlan& plan, RunOptions options, std::size_t program, Failure wanted, Limits limits, bool quiet)
    : plan_(plan), options_(std::move(options)), program_(program), wanted_(std::move(wanted)), limits_(limits) {
    if (!quiet) progress_.emplace();
}

// Signals are answered already, so nothing holds them as for other folders of this kind.
Result<void> Trials::open() {
    std::error_code error;
    std::string path = (fs::temp_directory_path(error) / "claymeld-shrink-XXXXXX").lexically_normal().string();
    if (error || ::mkdtemp(path.data()) == nullptr) return fail(fmt::format("cannot make a folder {}", path));
    folder_ = path;
    leftover_ = Leftover(path);
    return {};
}

Trials::~Trials() {
    std::error_code error;
    if (!folder_.empty()) fs::remove_all(folder_, error);
}

RunOptions Trials::options_for(const SmallWorld& world, const std::string& path) const {
    RunOptions options = options_;
    options.world = path;
    if (world.ticks >= 0) options.ticks = world.ticks;
    return options;
}

bool Trials::fails(const RowResult& result, const std::string& path) const {
    if (result.exit == static_cast<int>(ExitCode::Interrupted)) return false;
    if (!result.demands.value(std::string(kStillName), "").empty()) return false;
    const std::optional<Failure> failure = failure_in(result, plan_.study(), path);
    return failure && same_failure(wanted_, *failure);
}

Result<std::optional<bool>> Trials::start(std::size_t number, const SmallWorld& world, std::vector<Running>& running) {
    const std::string name = fmt::format("try-{}", started_);
    // A graph that cannot be written as files is not smaller.
    const Result<WorldTexts> texts = texts_of(world, "try");
    if (!texts) return std::optional(false);
    std::uint64_t hash = hash_combine(hash_text(texts->world), static_cast<std::uint64_t>(world.ticks));
    for (const auto& [ending, text] : texts->beside) hash = hash_combine(hash, hash_text(text));
    if (const auto found = tried_.find(hash); found != tried_.end()) return std::optional(found->second);
    ++started_;
    const fs::path folder = fs::path(folder_) / name;
    const std::string path = (folder / "try.toml").string();
    std::vector<Leftover> leftovers;
    leftovers.emplace_back(folder.string());
    std::error_code error;
    fs::create_directory(folder, error);
    if (error) return fail(fmt::format("cannot make the folder {}: {}", folder.string(), error.message()), "", ExitCode::LimitHit);
    const auto put = [&](const fs::path& file, const std::string& text) {
        leftovers.emplace_back(file.string());
        return write_file(file.string(), text);
    };
    if (auto written = put(path, texts->world); !written) return tl::unexpected<Error>(written.error());
    for (const auto& [ending, text] : texts->beside)
        if (auto written = put(folder / ("try" + ending), text); !written) return tl::unexpected<Error>(written.error());
    const Result<std::size_t> module = plan_.module_for(program_, path);
    if (!module) {
        tried_[hash] = false;
        return std::optional(false);
    }
    RunOptions options = options_for(world, path);
    if (options.ticks < 0) options.ticks = limits_.ticks;
    Result<RowRun> run = RowRun::start(plan_, options, plan_.module(*module), number);
    if (!run) return tl::unexpected<Error>(run.error());
    running.push_back({number, hash, path, std::move(leftovers), std::move(*run)});
    return std::optional<bool>();
}

Result<void> Trials::wait(std::vector<Running>& running, std::map<std::size_t, Outcome>& known) {
    std::vector<pollfd> ends;
    for (const Running& each : running) ends.push_back({each.run.descriptor(), POLLIN, 0});
    poll(ends.data(), ends.size(), kWaitForTry_ms);
    for (std::size_t i = ends.size(); i-- > 0;) {
        std::optional<RowResult> result;
        if (ends[i].revents != 0) result = running[i].run.take();
        if (!result) result = running[i].run.end_if_late(limits_.seconds);
        if (!result) continue;
        const Running& ended = running[i];
        known[ended.number] = {fails(*result, ended.path), ended.hash};
        std::error_code error;
        fs::remove_all(fs::path(ended.path).parent_path(), error);
        running.erase(running.begin() + static_cast<std::ptrdiff_t>(i));
    }
    return {};
}

Result<std::optional<std::size_t>> Trials::first(std::size_t count, const Make& make) {
    std::vector<Running> running;
    std::map<std::size_t, Outcome> known;  // By number of a candidate, those that ended.
    std::size_t next = 0, decided = 0;     // All before these are started; are known not to fail.
    while (decided < count && !over_) {
        if (interrupt::received() != 0) {
            interrupted_ = over_ = true;
            break;
        }
        // A candidate after one that fails does not matter.
        bool found = std::ranges::any_of(known, [](const auto& each) { return each.second.failed; });
        while (!found && next < count && running.size() < static_cast<std::size_t>(limits_.jobs)) {
            const Result<std::optional<bool>> failed = start(next, make(next), running);
            if (!failed) return tl::unexpected<Error>(failed.error());
            if (*failed) known[next] = {**failed};
            found = *failed && **failed;
            ++next;
        }
        if (!running.empty() && !known.contains(decided))
            if (auto done = wait(running, known); !done) return tl::unexpected<Error>(done.error());
        for (auto each = known.find(decided); each != known.end() && !over_; each = known.find(decided)) {
            // Those that did not count are forgotten, so that it does not matter how many ran at a time.
            if (each->second.hash) tried_[*each->second.hash] = each->second.failed;
            if (each->second.hash && ++tries_ >= limits_.tries) over_ = true;
            if (each->second.failed) return std::optional(decided);
            ++decided;
        }
        if (progress_)
            progress_->update([&] { return fmt::format("{} of {} tries: {}", grouped(tries_), grouped(limits_.tries), about_); });
    }
    return std::optional<std::size_t>();
}

}  // namespace meld::driver
