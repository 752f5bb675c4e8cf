#include "runtime/driver/pictures/frame_observer.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "runtime/base/process/interrupt.h"
#include "runtime/driver/pictures/picture_options.h"

namespace meld::driver {

Onlooker::Onlooker(const RunOptions& options, comm::Communicator& comm, timeline::Timeline& timeline, Drawn drawing)
    : options_(options),
      comm_(comm),
      timeline_(timeline),
      drawing_(std::move(drawing)),
      speaks_(comm.process() == 0),
      pace_(timeline.simulation().summary()) {
    if (speaks_ && !options_.quiet) progress_.emplace();
    timeline_.each([this](sim::Simulation& simulation) {
        if (interrupt::received() != 0) simulation.subdomain().request_stop();
        show([&] { return progress_line(simulation, pace_, options_.ticks); });
    });
}

Onlooker::~Onlooker() { timeline_.each({}); }

void Onlooker::show(const std::function<std::string()>& text) {
    if (progress_) progress_->update(text);
}

Result<void> Onlooker::go_to(std::int64_t tick) {
    if (auto there = timeline_.to(tick); !there) return there;
    if (timeline_.ended() == sim::Ending::Interrupted)
        return fail(fmt::format("interrupted after tick {}", timeline_.tick()), "", ExitCode::Interrupted);
    return {};
}

Result<void> Onlooker::reach(std::int64_t tick) {
    if (tick == kEnd && at_checkpoint()) return {};
    if (auto there = go_to(tick == kEnd ? std::numeric_limits<std::int64_t>::max() : tick); !there) return there;
    if (tick != kEnd && this->tick() != tick) return fail(fmt::format("the run ends with tick {}, before tick {}", this->tick(), tick));
    return {};
}

Result<picture::Frame> Onlooker::look(const picture::Look& look) {
    return picture::look_at(timeline_.simulation().subdomain(), drawing_(), look);
}

}  // namespace meld::driver
