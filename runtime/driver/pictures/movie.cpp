#include "runtime/driver/pictures/movie.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "runtime/comm/transport/collective_result.h"
#include "runtime/driver/pictures/film_frames.h"
#include "runtime/driver/pictures/picture_options.h"

namespace meld::driver {

namespace {

class Movie {
  public:
    Movie(const RunOptions& options, Onlooker& onlooker, const picture::Look& look, const picture::SheetOptions& sheet,
          const MovieOrders& orders)
        : movie_(std::get<MovieOptions>(options.debug->picture->of)),
          onlooker_(onlooker),
          look_(look),
          orders_(orders),
          reel_(options, look, sheet, orders, [this](const std::function<std::string()>& text) { onlooker_.show(text); }),
          first_(onlooker.tick()) {}

    Result<int> make();

  private:
    Result<void> find_where_it_ends();
    Result<void> measure();
    Result<void> paint();
    Result<void> take(std::int64_t tick, bool last);
    // Of process 0, on every process.
    Result<void> all(const Result<void>& mine) { return comm::outcome_of_first(onlooker_.comm(), mine); }

    const MovieOptions& movie_;
    Onlooker& onlooker_;
    const picture::Look& look_;
    const MovieOrders& orders_;
    Reel reel_;           // On process 0.
    std::int64_t first_;  // Where the run begins.
    std::int64_t from_ = 0, to_ = kEnd, every_ = 0;
    std::vector<std::int64_t> ticks_;  // That are shown.
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
    const std::int64_t most = most_frames(movie_, movie_.seconds.value_or(kMovieSeconds));
    if (every_ == 0) every_ = std::max<std::int64_t>((to_ - from_ + most - 2) / (most - 1), 1);
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
        if (onlooker_.speaks()) reel_.measure(*frame);
        if (over || tick == to_) break;
        // The last tick is shown however many there are before it.
        tick = to_ == kEnd ? tick + every_ : std::min(tick + every_, to_);
    }
    return all(onlooker_.speaks() ? reel_.settle() : Result<void>{});
}

Result<void> Movie::paint() {
    if (auto opened = all(onlooker_.speaks() ? reel_.open() : Result<void>{}); !opened) return opened;
    if (auto there = onlooker_.go_to(first_); !there) return there;
    Result<void> done;
    for (const std::int64_t tick : ticks_)
        if (done = take(tick, tick == ticks_.back()); !done) break;
    if (!done && done.error().code != ExitCode::Interrupted) return done;
    return all(onlooker_.speaks() ? reel_.end(done) : done);
}

// Goes to a tick that is shown, and paints what is waiting if it is time to.
Result<void> Movie::take(std::int64_t tick, bool last) {
    if (auto there = onlooker_.reach(tick); !there) return there;
    Result<picture::Frame> frame = onlooker_.look(look_);
    if (!frame) return tl::unexpected<Error>(frame.error());
    return all(onlooker_.speaks() ? reel_.take(std::move(*frame), last) : Result<void>{});
}

Result<int> Movie::make() {
    if (auto found = find_where_it_ends(); !found) return tl::unexpected<Error>(found.error());
    if (auto measured = measure(); !measured) return tl::unexpected<Error>(measured.error());
    if (auto painted = paint(); !painted) return tl::unexpected<Error>(painted.error());
    onlooker_.show_no_more();
    if (auto told = all(onlooker_.speaks() ? reel_.report() : Result<void>{}); !told) return tl::unexpected<Error>(told.error());
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
