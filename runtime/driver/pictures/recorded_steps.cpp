#include "runtime/driver/pictures/recorded_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "runtime/base/files/output_file.h"
#include "runtime/base/process/interrupt.h"
#include "runtime/base/terminal/progress.h"
#include "runtime/driver/pictures/film_frames.h"
#include "runtime/driver/pictures/picture_options.h"
#include "runtime/driver/pictures/shot.h"
#include "runtime/driver/session/session_target.h"
#include "runtime/driver/setup/print_error.h"
#include "runtime/results/compare/compare.h"
#include "runtime/results/record/drawn_steps.h"
#include "runtime/results/record/provenance.h"
#include "runtime/show/picture/frame.h"
#include "runtime/world/file/world_file.h"

namespace meld::driver {

namespace {

// Options that ask for facts, which a recording does not have for every body.
Result<void> asks_nothing(const PictureOptions& picture) {
    const std::pair<const char*, const std::string*> bodies[] = {{"--colour", &picture.colour}, {"--only", &picture.only},
                                                                 {"--hide", &picture.hide},     {"--links", &picture.links},
                                                                 {"--arrows", &picture.arrows}, {"--labels", &picture.labels}};
    const auto refused = [](const char* option, const std::string& body) {
        return fail(fmt::format("{}: `{}` asks for facts, and with --steps no run is made that has them", option, body),
                    fmt::format("Leave out --steps, and the run is made again; or leave out {}", option));
    };
    for (const auto& [option, body] : bodies)
        if (!body->empty()) return refused(option, *body);
    for (const std::string& callout : picture.callouts)
        if (!callout.starts_with('@')) return refused("--callout", callout);
    return {};
}

Result<record::RecordingReader> open_recording(const std::string& path) {
    std::error_code error;
    if (std::filesystem::exists(path, error) && !compare::begins_as_hdf5(path))
        return fail(fmt::format("--steps: {} is not a recording", path),
                    "Leave out --steps, or give a file that `meldsim run --record` has written");
    return record::RecordingReader::open(path);
}

// Without what else it takes to make the run again.
Result<world::World> world_of(const record::RecordingReader& recording) {
    const auto from_file = [&](const Error& error) {
        return fail(fmt::format("{}: {}", recording.path(), error.problem), error.suggestion, ExitCode::RecordingRefused);
    };
    const Result<record::Provenance> from = record::provenance_from_json(recording.about("provenance"));
    if (!from) return from_file(from.error());
    Result<world::World> world = world::parse_world(from->world, from->world_path, &from->world_files);
    if (!world) return from_file(world.error());
    if (world->is_graph())
        return fail(fmt::format("--steps: {} is of a graph, and the links of a graph are not recorded", recording.path()),
                    "Leave out --steps, and the run is made again");
    return world;
}

class Steps {
  public:
    static Result<Steps> of(const RunOptions& options);
    Result<void> shoot();
    Result<void> film();

  private:
    Steps(const RunOptions& options, record::DrawnSteps steps, world::World world, picture::Look look, picture::SheetOptions sheet)
        : options_(options),
          picture_(*options.debug->picture),
          steps_(std::move(steps)),
          world_(std::move(world)),
          look_(std::move(look)),
          sheet_(std::move(sheet)) {}

    // Those of a film.
    Result<std::vector<std::size_t>> chosen(const MovieOrders& orders) const;
    // The step of this tick. Errors: there is none.
    Result<std::size_t> step_of(std::int64_t tick) const;
    Result<picture::Frame> look(std::size_t step);
    std::int64_t last() const { return steps_.ticks().back(); }

    const RunOptions& options_;
    const PictureOptions& picture_;
    record::DrawnSteps steps_;
    world::World world_;
    picture::Look look_;
    picture::SheetOptions sheet_;
};

Result<Steps> Steps::of(const RunOptions& options) {
    const PictureOptions& picture = *options.debug->picture;
    if (auto fits = asks_nothing(picture); !fits) return tl::unexpected<Error>(fits.error());
    if (options.processes > 1)
        return fail("-n: with --steps there is no run for several processes", "Leave out -n; pictures are painted by all processors");
    Result<record::RecordingReader> recording = open_recording(options.program);
    if (!recording) return tl::unexpected<Error>(recording.error());
    if (auto fits = carries_its_own(options, options.program, true); !fits) return tl::unexpected<Error>(fits.error());
    Result<world::World> world = world_of(*recording);
    if (!world) return tl::unexpected<Error>(world.error());
    Result<record::DrawnSteps> steps = record::DrawnSteps::of(std::move(*recording));
    if (!steps) return tl::unexpected<Error>(steps.error());
    Result<picture::Look> look = look_of(picture);
    if (!look) return tl::unexpected<Error>(look.error());
    Result<picture::SheetOptions> sheet = sheet_of(picture, *world);
    if (!sheet) return tl::unexpected<Error>(sheet.error());
    return Steps(options, std::move(*steps), std::move(*world), std::move(*look), std::move(*sheet));
}

Result<std::size_t> Steps::step_of(std::int64_t tick) const {
    const std::vector<std::int64_t>& ticks = steps_.ticks();
    if (tick == kEnd) return ticks.size() - 1;
    const auto after = std::ranges::lower_bound(ticks, tick);
    if (after != ticks.end() && *after == tick) return static_cast<std::size_t>(after - ticks.begin());
    const std::string nearest = after == ticks.begin() ? fmt::format("the first is {}", *after)
                                : after == ticks.end() ? fmt::format("the last is {}", ticks.back())
                                                       : fmt::format("the nearest are {} and {}", *(after - 1), *after);
    return fail(fmt::format("--tick: tick {} is not recorded in {}: {}", tick, options_.program, nearest),
                "Choose a tick that is recorded; or leave out --steps, and the run is made again");
}

Result<picture::Frame> Steps::look(std::size_t step) {
    if (interrupt::received() != 0) return fail("interrupted", "", ExitCode::Interrupted);
    return steps_.drawn(step).map([&](const record::Drawn& drawn) { return picture::look_at(drawn, world_, steps_.ticks()[step], look_); });
}

Result<void> Steps::shoot() {
    const ShotOptions& shot = std::get<ShotOptions>(picture_.of);
    sheet_.columns = static_cast<std::size_t>(shot.columns);
    const Result<std::vector<std::int64_t>> ticks = ticks_of(shot.ticks);
    if (!ticks) return tl::unexpected<Error>(ticks.error());
    std::vector<std::size_t> steps;
    for (const std::int64_t tick : *ticks) {
        const Result<std::size_t> step = step_of(tick);
        if (!step) return tl::unexpected<Error>(step.error());
        steps.push_back(*step);
    }
    Result<OutputFile> file = OutputFile::open(picture_.file, Appears::Whole);
    if (!file) return tl::unexpected<Error>(file.error());
    std::vector<picture::Frame> frames;
    for (const std::size_t step : steps) {
        Result<picture::Frame> frame = look(step);
        if (!frame) return tl::unexpected<Error>(frame.error());
        frames.push_back(std::move(*frame));
    }
    return finish_shot(options_, frames, look_, sheet_, *file);
}

Result<std::vector<std::size_t>> Steps::chosen(const MovieOrders& orders) const {
    const MovieOptions& movie = std::get<MovieOptions>(picture_.of);
    const std::vector<std::int64_t>& ticks = steps_.ticks();
    const auto meant = [&](std::int64_t tick) { return tick == kEnd ? last() : tick; };
    const std::int64_t from = meant(orders.from.value_or(ticks.front())), to = meant(orders.to.value_or(kEnd));
    for (const std::int64_t tick : {from, to})
        if (tick > last()) return fail(fmt::format("{} ends with tick {}, before tick {}", options_.program, last(), tick));
    std::vector<std::size_t> all;
    for (std::size_t step = 0; step < ticks.size(); ++step)
        if (ticks[step] >= from && ticks[step] <= to) all.push_back(step);
    if (all.empty())
        return fail(fmt::format("no tick from {} to {} is recorded in {}", from, to, options_.program),
                    "Write other ticks after --from and --to; or leave out --steps, and the run is made again");
    std::size_t apart = 1;
    if (movie.seconds) {
        const auto most = static_cast<std::size_t>(most_frames(movie, *movie.seconds));
        apart = std::max<std::size_t>((all.size() + most - 3) / (most - 1), 1);
    }
    // The last tick is shown however many there are before it.
    std::vector<std::size_t> out;
    for (std::size_t i = 0; i < all.size(); ++i)
        if (out.empty() || i + 1 == all.size() || (i % apart == 0 && ticks[all[i]] - ticks[out.back()] >= movie.every.value_or(0)))
            out.push_back(all[i]);
    return out;
}

Result<void> Steps::film() {
    const Result<MovieOrders> orders = movie_of(std::get<MovieOptions>(picture_.of));
    if (!orders) return tl::unexpected<Error>(orders.error());
    const Result<std::vector<std::size_t>> steps = chosen(*orders);
    if (!steps) return tl::unexpected<Error>(steps.error());
    std::optional<Progress> progress;
    if (!options_.quiet) progress.emplace();
    const auto show = [&](const std::function<std::string()>& text) {
        if (progress) progress->update(text);
    };
    Reel reel(options_, look_, sheet_, *orders, show);
    for (std::size_t i = 0; i < steps->size(); ++i) {
        show([&] { return fmt::format("reading step {} of {}", i + 1, steps->size()); });
        const Result<picture::Frame> frame = look((*steps)[i]);
        if (!frame) return tl::unexpected<Error>(frame.error());
        reel.measure(*frame);
    }
    if (auto settled = reel.settle(); !settled) return settled;
    if (auto opened = reel.open(); !opened) return opened;
    Result<void> done;
    for (const std::size_t step : *steps) {
        Result<picture::Frame> frame = look(step);
        done = frame ? reel.take(std::move(*frame), step == steps->back()) : tl::unexpected<Error>(frame.error());
        if (!done) break;
    }
    if (auto ended = reel.end(done); !ended) return ended;
    progress.reset();
    return reel.report();
}

}  // namespace

int paint_steps(const RunOptions& options) {
    interrupt::handle({SIGINT, SIGTERM, SIGHUP});
    interrupt::set_last_words("meldsim: interrupted before its end\n");
    const interrupt::Answering patiently(interrupt::Answer::Patiently);
    Result<Steps> steps = Steps::of(options);
    if (!steps) return print_error(steps.error());
    const bool one = std::holds_alternative<ShotOptions>(options.debug->picture->of);
    const Result<void> done = one ? steps->shoot() : steps->film();
    if (done) return static_cast<int>(ExitCode::Fine);
    const int code = print_error(done.error());
    return done.error().code == ExitCode::Interrupted ? interrupt::exit_code() : code;
}

}  // namespace meld::driver
