// Goes along a run and looks at it, for those who make pictures of it.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "runtime/base/error.h"
#include "runtime/base/terminal/progress.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/driver/run/report.h"
#include "runtime/driver/setup/options.h"
#include "runtime/results/record/drawing.h"
#include "runtime/results/timeline/timeline.h"
#include "runtime/show/picture/frame.h"

namespace meld::driver {

// Every process has one, and calls the same at the same time.
class Onlooker {
  public:
    // `drawing` gives what catoms have drawn in the timeline's present run. All must outlive it.
    using Drawn = std::function<record::Drawing&()>;
    Onlooker(const RunOptions& options, comm::Communicator& comm, timeline::Timeline& timeline, Drawn drawing);
    ~Onlooker();
    Onlooker(const Onlooker&) = delete;
    Onlooker& operator=(const Onlooker&) = delete;

    // On process 0, which makes the pictures.
    bool speaks() const { return speaks_; }
    comm::Communicator& comm() { return comm_; }
    std::int64_t tick() { return timeline_.tick(); }
    // It goes no further.
    bool ended() const { return timeline_.ended().has_value(); }
    // A checkpoint is looked at, and not a run from its start.
    bool at_checkpoint() const { return !options_.resume.empty(); }

    // On to this tick, or to where the run ends before it; back only to the tick where it began. Errors: those of the run; a signal has
    // asked for the end (130).
    Result<void> go_to(std::int64_t tick);
    // The same; kEnd is where the run ends, or where the checkpoint is. Errors: also that the run ends before the tick.
    Result<void> reach(std::int64_t tick);
    // What is seen there, on process 0; nothing on the others. Errors: those of the look.
    Result<picture::Frame> look(const picture::Look& look);
    // How far the work is, where progress is shown.
    void show(const std::function<std::string()>& text);
    void show_no_more() { progress_.reset(); }

  private:
    const RunOptions& options_;
    comm::Communicator& comm_;
    timeline::Timeline& timeline_;
    Drawn drawing_;
    bool speaks_;
    std::optional<Progress> progress_;
    Pace pace_;
};

}  // namespace meld::driver
