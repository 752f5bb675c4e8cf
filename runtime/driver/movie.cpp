#include "runtime/driver/movie.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "runtime/base/interrupt.h"
#include "runtime/base/parallel_for.h"
#include "runtime/base/standard_streams.h"
#include "runtime/base/units.h"
#include "runtime/comm/outcome.h"
#include "runtime/driver/picture_options.h"
#include "runtime/picture/film.h"
#include "runtime/picture/film_file.h"

namespace meld::driver {

namespace {

// Frames with no more catoms than this together are painted side by side, each by a thread of its own: some 100 bytes of memory a catom.
constexpr std::uint64_t kMostTogether = 4'000'000;

class Movie {
  public:
    Movie(const RunOptions& options, Onlooker& onlooker, const picture::Look& look, const picture::SheetOptions& sheet,
          const MovieOrders& orders)
        : options_(options),
          picture_(*options.debug->picture),
          movie_(std::get<MovieOptions>(picture_.of)),
          onlooker_(onlooker),
          look_(look),
          sheet_(sheet),
          orders_(orders),
          film_(look_, sheet_,
                orders.keys.empty() ? picture::CameraPath(sheet_.view, movie_.turn) : picture::CameraPath(sheet_.view, orders.keys)),
          first_(onlooker.tick()) {}

    Result<int> make();

  private:
    // A picture that is to be painted.
    struct Shown {
        picture::Frame frame;
        std::size_t number = 0, repeats = 1;  // The first of its pictures, and how many show this frame.
    };

    Result<void> find_where_it_ends();
    Result<void> measure();
    Result<void> paint();
    Result<void> take(std::int64_t tick, bool last);
    Result<void> paint_waiting();
    Result<void> report() const;
    // Of process 0, on every process.
    Result<void> all(const Result<void>& mine) { return comm::outcome_of_first(onlooker_.comm(), mine); }
    std::size_t held() const { return static_cast<std::size_t>(std::lround(movie_.hold * movie_.fps)); }
    // How many frames of the run there are room for.
    std::int64_t most_frames() const {
        const double seconds = std::max(movie_.seconds - movie_.hold, 0.0);
        return std::max<std::int64_t>(std::llround(seconds * movie_.fps), 2);
    }

    const RunOptions& options_;
    const PictureOptions& picture_;
    const MovieOptions& movie_;
    Onlooker& onlooker_;
    const picture::Look& look_;
    const picture::SheetOptions& sheet_;
    const MovieOrders& orders_;
    picture::Film film_;
    std::int64_t first_;  // Where the run begins.
    std::int64_t from_ = 0, to_ = kEnd, every_ = 0;
    std::vector<std::int64_t> ticks_;            // That are shown.
    std::uint64_t most_shown_ = 0, catoms_ = 0;  // In a frame.
    // On process 0.
    std::unique_ptr<picture::FilmFile> file_;
    std::vector<Shown> waiting_;
    std::size_t painted_ = 0;
};

// Sets from_, every_ and, unless the first pass is to find it, to_.
Result<void> Movie::find_where_it_ends() {
    from_ = orders_.from.value_or(first_);
    to_ = orders_.to.value_or(kEnd);
    every_ = movie_.every.value_or(0);
    if (to_ == kEnd && (every_ == 0 || from_ == kEnd)) {
        if (auto there = onlooker_.go_to(std::numeric_limits<std::int64_t>::max()); !there) return there;
        to_ = onlooker_.tick();
        if (from_ == kEnd) from_ = to_;
    }
    if (to_ != kEnd && to_ < from_) return fail(fmt::format("the run ends with tick {}, before tick {}", to_, from_));
    if (from_ < first_) return fail(fmt::format("--from: the checkpoint is after tick {}, and what was before is not known", first_));
    if (every_ == 0) every_ = std::max<std::int64_t>((to_ - from_ + most_frames() - 2) / (most_frames() - 1), 1);
    return {};
}

// Looks at all frames, and finds out which there are.
Result<void> Movie::measure() {
    if (auto there = onlooker_.go_to(first_); !there) return there;
    for (std::int64_t tick = from_;;) {
        if (auto there = onlooker_.go_to(tick); !there) return there;
        const bool over = onlooker_.tick() < tick;
        if (over && (ticks_.empty() || to_ != kEnd))
            return fail(fmt::format("the run ends with tick {}, before tick {}", onlooker_.tick(), std::max(tick, to_)));
        if (over && onlooker_.tick() == ticks_.back()) break;
        ticks_.push_back(onlooker_.tick());
        const Result<picture::Frame> frame = onlooker_.look(look_);
        if (!frame) return tl::unexpected<Error>(frame.error());
        if (onlooker_.speaks()) {
            film_.measure(*frame);
            if (frame->scene.places.size() >= most_shown_)
                std::tie(most_shown_, catoms_) = std::pair(frame->scene.places.size(), frame->catoms);
        }
        if (over || tick == to_) break;
        // The last tick is shown however many there are before it.
        tick = to_ == kEnd ? tick + every_ : std::min(tick + every_, to_);
    }
    return all(onlooker_.speaks() ? film_.settle() : Result<void>{});
}

Result<void> Movie::paint() {
    Result<void> opened;
    if (onlooker_.speaks())
        opened = picture::FilmFile::open(picture_.file, sheet_.width, sheet_.height, movie_.fps).map([&](auto&& file) {
            file_ = std::move(file);
        });
    if (auto fine = all(opened); !fine) return fine;
    if (auto there = onlooker_.go_to(first_); !there) return there;
    Result<void> done;
    for (const std::int64_t tick : ticks_)
        if (done = take(tick, tick == ticks_.back()); !done) break;
    // A film that was interrupted is one of what has been painted.
    const bool interrupted = !done && done.error().code == ExitCode::Interrupted;
    if (!done && !interrupted) return done;
    const Result<void> closed = [&]() -> Result<void> {
        if (!onlooker_.speaks() || painted_ == 0) return {};
        return file_->commit();
    }();
    if (auto fine = all(closed); !fine || !interrupted) return fine;
    if (!onlooker_.speaks() || painted_ == 0) return done;
    return fail(fmt::format("interrupted: {} ends with frame {} of {}", picture_.file, painted_, ticks_.size() + held()), "",
                ExitCode::Interrupted);
}

// Goes to a tick that is shown, and paints what is waiting if it is time to.
Result<void> Movie::take(std::int64_t tick, bool last) {
    if (auto there = onlooker_.reach(tick); !there) return there;
    Result<picture::Frame> frame = onlooker_.look(look_);
    if (!frame) return tl::unexpected<Error>(frame.error());
    const Result<void> painted = [&]() -> Result<void> {
        if (!onlooker_.speaks()) return {};
        film_.colour(*frame);
        const std::size_t number = waiting_.empty() ? painted_ : waiting_.back().number + 1;
        waiting_.push_back({std::move(*frame), number, last ? 1 + held() : 1});
        const auto threads = static_cast<std::uint64_t>(processors());
        const std::uint64_t together = std::clamp<std::uint64_t>(kMostTogether / std::max<std::uint64_t>(most_shown_, 1), 1, threads);
        return last || waiting_.size() >= together ? paint_waiting() : Result<void>{};
    }();
    return all(painted);
}

// Paints the frames that wait, and adds them to the film in their order.
Result<void> Movie::paint_waiting() {
    struct Job {
        const Shown* shown;
        std::size_t number, repeats;
    };
    // A frame that stays is painted again only if the camera moves.
    std::vector<Job> jobs;
    for (const Shown& shown : waiting_)
        for (std::size_t i = 0; i < (film_.camera_moves() ? shown.repeats : 1); ++i)
            jobs.push_back({&shown, shown.number + i, film_.camera_moves() ? 1 : shown.repeats});
    const std::size_t count = ticks_.size() + held(), threads = static_cast<std::size_t>(processors());
    const std::size_t together = std::clamp<std::size_t>(kMostTogether / std::max<std::size_t>(most_shown_, 1), 1, threads);
    Workers outer(static_cast<int>(together));
    std::vector<std::optional<Result<render::Image>>> images(together);
    for (std::size_t begin = 0; begin < jobs.size(); begin += together) {
        if (interrupt::received() != 0) return fail("interrupted", "", ExitCode::Interrupted);
        const std::size_t n = std::min(together, jobs.size() - begin);
        onlooker_.show([&] { return fmt::format("painting frame {} of {}", painted_ + 1, count); });
        outer.run(n, [&](int, std::size_t i) {
            Workers inner(static_cast<int>(std::max<std::size_t>(threads / together, 1)));
            const Job& job = jobs[begin + i];
            images[i] = film_.paint(job.shown->frame, job.number, count, inner);
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

Result<void> Movie::report() const {
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

Result<int> Movie::make() {
    if (auto found = find_where_it_ends(); !found) return tl::unexpected<Error>(found.error());
    if (auto measured = measure(); !measured) return tl::unexpected<Error>(measured.error());
    if (auto painted = paint(); !painted) return tl::unexpected<Error>(painted.error());
    onlooker_.show_no_more();
    if (auto told = all(onlooker_.speaks() ? report() : Result<void>{}); !told) return tl::unexpected<Error>(told.error());
    return static_cast<int>(ExitCode::Fine);
}

}  // namespace

Result<int> make_movie(const RunOptions& options, const world::World& world, Onlooker& onlooker) {
    const PictureOptions& picture = *options.debug->picture;
    const Result<picture::Look> look = look_of(picture);
    if (!look) return tl::unexpected<Error>(look.error());
    const Result<picture::SheetOptions> sheet = sheet_of(picture, world);
    if (!sheet) return tl::unexpected<Error>(sheet.error());
    const Result<MovieOrders> orders = movie_of(std::get<MovieOptions>(picture.of));
    if (!orders) return tl::unexpected<Error>(orders.error());
    return Movie(options, onlooker, *look, *sheet, *orders).make();
}

}  // namespace meld::driver
