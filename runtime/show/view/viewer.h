// Answers what pages ask of one run, and changes it as they say: the same run for all of them.
//
// Every process of the run has one and gives it the same requests in the same order. Process 0 has the answers.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "runtime/ask/debug/session.h"
#include "runtime/base/error.h"
#include "runtime/results/record/drawing.h"
#include "runtime/results/timeline/timeline.h"
#include "runtime/show/view/fields.h"
#include "runtime/show/view/frames.h"
#include "runtime/show/view/metrics.h"
#include "runtime/show/view/reply.h"
#include "runtime/show/view/series.h"

namespace meld::view {

struct ViewerOptions {
    std::string program = {}, world = {};            // As they are shown.
    std::optional<std::int64_t> last_tick = {};      // Of a recording.
    std::optional<double> catom_metres = {};         // Its diameter, where the world says so.
    debug::SessionOptions session = {};              // `folder` is also where files may be written.
    std::function<record::Drawing&()> drawing = {};  // Of the present run of the timeline.
    // Of the tab of the world, on process 0: the file as it is; what a text would be as a world; and writing it.
    std::function<Result<Reply>()> world_file = {};
    std::function<Result<Reply>(const std::string& toml)> check_world = {};
    std::function<Result<Reply>(const std::string& path, const std::string& toml)> save_world = {};
};

class Viewer {
  public:
    // The timeline has been started, and it and its world outlive the viewer.
    Viewer(timeline::Timeline& timeline, world::World& world, ViewerOptions options);
    ~Viewer();
    Viewer(const Viewer&) = delete;
    Viewer& operator=(const Viewer&) = delete;

    // Of hello, frame, image, command, metrics, series, world, world-check and world-save. Errors: what is wrong with the request, and
    // those of what it asks for; then the run is where it was. Cost: that of the command of the debugger; for a frame, as of Frames; for a
    // picture, a look at all catoms.
    Result<Reply> answer(const Json& request);
    // One tick forward, with breaks and watches.
    Result<debug::Moved> step();
    // The program, as its file is now.
    Result<debug::Reloaded> reload();

    // Where the run is: {tick, first, latest, last, ended}. `last` is null while nobody knows.
    Json where() const;
    // Counts whatever changed what pages show.
    std::uint64_t changes() const { return changes_; }

    // Called before each tick.
    void note_begin() { began_ = std::chrono::steady_clock::now(); }
    // How long it took to evaluate a catom once, of the ticks that were made for the first time; nothing if there were none. Of process 0.
    std::optional<double> seconds_per_evaluation() const;

    timeline::Timeline& timeline() { return timeline_; }
    debug::Session& session() { return session_; }

  private:
    Result<Reply> hello();
    Result<Reply> frame(const Json& request);
    Result<Reply> image(const Json& request);
    Result<Reply> command(const Json& request);
    Result<Reply> metrics(const Json& request);
    Result<Reply> series(const Json& request);
    Result<Reply> about_world(const Json& request, const std::string& verb);
    Result<void> go_to(std::optional<std::int64_t> tick);
    Result<debug::Answer> execute(const debug::Command& command);
    bool speaks() const { return timeline_.simulation().subdomain().comm.process() == 0; }

    timeline::Timeline& timeline_;
    const world::World& world_;
    ViewerOptions options_;
    debug::Session session_;
    Metrics metrics_;
    Series series_;
    Frames frames_;
    std::int64_t latest_ = 0;
    std::uint64_t changes_ = 0;
    std::chrono::steady_clock::time_point began_ = {};
    double seconds_ = 0;
    std::uint64_t evaluations_ = 0;
};

}  // namespace meld::view
