#include "runtime/driver/pictures/film_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <tuple>
#include <utility>

#include "runtime/base/files/standard_streams.h"
#include "runtime/base/process/interrupt.h"
#include "runtime/base/process/parallel_for.h"
#include "runtime/base/process/processors.h"
#include "runtime/base/units.h"
#include "runtime/driver/pictures/frame_observer.h"

namespace meld::driver {

namespace {

// Frames with no more catoms than this together are painted side by side, each by a thread of its own: some 100 bytes of memory a catom.
constexpr std::uint64_t kMostTogether = 4'000'000;

}  // namespace

std::int64_t most_frames(const MovieOptions& movie, double seconds) {
    return std::max<std::int64_t>(std::llround(std::max(seconds - movie.hold, 0.0) * movie.fps), 2);
}

Reel::Reel(const RunOptions& options, const picture::Look& look, const picture::SheetOptions& sheet, const MovieOrders& orders, Show show)
    : options_(options),
      picture_(*options.debug->picture),
      movie_(std::get<MovieOptions>(picture_.of)),
      sheet_(sheet),
      show_(std::move(show)),
      film_(look, sheet,
            orders.keys.empty() ? picture::CameraPath(sheet.view, movie_.turn) : picture::CameraPath(sheet.view, orders.keys)) {}

std::size_t Reel::held() const { return static_cast<std::size_t>(std::lround(movie_.hold * movie_.fps)); }

std::size_t Reel::together() const {
    return std::clamp<std::size_t>(kMostTogether / std::max<std::uint64_t>(most_shown_, 1), 1, static_cast<std::size_t>(processors()));
}

void Reel::measure(const picture::Frame& frame) {
    ticks_.push_back(frame.tick);
    film_.measure(frame);
    if (frame.scene.places.size() >= most_shown_) std::tie(most_shown_, catoms_) = std::pair(frame.scene.places.size(), frame.catoms);
}

Result<void> Reel::open() {
    return picture::FilmFile::open(picture_.file, sheet_.width, sheet_.height, movie_.fps).map([&](auto&& file) {
        file_ = std::move(file);
    });
}

Result<void> Reel::take(picture::Frame frame, bool last) {
    film_.colour(frame);
    const std::size_t number = waiting_.empty() ? painted_ : waiting_.back().number + 1;
    waiting_.push_back({std::move(frame), number, last ? 1 + held() : 1});
    return last || waiting_.size() >= together() ? paint_waiting() : Result<void>{};
}

// Paints the frames that wait, and adds them to the film in their order.
Result<void> Reel::paint_waiting() {
    struct Job {
        const Shown* shown;
        std::size_t number, repeats;
    };
    // A frame that stays is painted again only if the camera moves.
    std::vector<Job> jobs;
    for (const Shown& shown : waiting_)
        for (std::size_t i = 0; i < (film_.camera_moves() ? shown.repeats : 1); ++i)
            jobs.push_back({&shown, shown.number + i, film_.camera_moves() ? 1 : shown.repeats});
    const std::size_t threads = static_cast<std::size_t>(processors()), side_by_side = together();
    Workers outer(static_cast<int>(side_by_side));
    std::vector<std::optional<Result<render::Image>>> images(side_by_side);
    for (std::size_t begin = 0; begin < jobs.size(); begin += side_by_side) {
        if (interrupt::received() != 0) return fail("interrupted", "", ExitCode::Interrupted);
        const std::size_t n = std::min(side_by_side, jobs.size() - begin);
        show_([&] { return fmt::format("painting frame {} of {}", painted_ + 1, count()); });
        outer.run(n, [&](int, std::size_t i) {
            Workers inner(static_cast<int>(std::max<std::size_t>(threads / side_by_side, 1)));
            const Job& job = jobs[begin + i];
            images[i] = film_.paint(job.shown->frame, job.number, count(), inner);
        });
        for (std::size_t i = 0; i < n; ++i) {
            if (!*images[i]) return tl::unexpected<Error>(images[i]->error());
            for (std::size_t again = 0; again < jobs[begin + i].repeats; ++again, ++painted_)
                if (auto added = file_->add(**images[i]); !added) return added;
        }
    }
    waiting_.clear();
    return {};
}

Result<void> Reel::end(const Result<void>& done) {
    // A film that was interrupted is one of what has been painted.
    const bool interrupted = !done && done.error().code == ExitCode::Interrupted;
    if ((!done && !interrupted) || painted_ == 0) return done;
    if (auto closed = file_->commit(); !closed || !interrupted) return closed;
    return fail(fmt::format("interrupted: {} ends with frame {} of {}", picture_.file, painted_, count()), "", ExitCode::Interrupted);
}

Result<void> Reel::report() const {
    const double seconds = static_cast<double>(painted_) / movie_.fps;
    if (options_.json)
        return print(stdout, nlohmann::ordered_json{{"file", picture_.file},
                                                    {"width", sheet_.width},
                                                    {"height", sheet_.height},
                                                    {"frames", painted_},
                                                    {"fps", movie_.fps},
                                                    {"ticks", ticks_},
                                                    {"catoms", catoms_},
                                                    {"shown", most_shown_}}
                                     .dump() +
                                 "\n");
    if (options_.quiet) return {};
    return print(stdout, fmt::format("{}: {} x {} pixels, {} frame{}, {:.1f} s, {} of {} catom{}, ticks {} to {}\n", picture_.file,
                                     sheet_.width, sheet_.height, grouped(painted_), painted_ == 1 ? "" : "s", seconds,
                                     grouped(most_shown_), grouped(catoms_), catoms_ == 1 ? "" : "s", ticks_.front(), ticks_.back()));
}

}  // namespace meld::driver
