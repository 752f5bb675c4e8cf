// Serves a run, or two side by side, to pages in browsers, until somebody ends it.
//
// Process 0 has the server and decides what is done next: a request, the next tick of a run that is played, or reading a program again
// whose files have changed. All processes do it.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/show/view/http.h"
#include "runtime/show/view/viewer.h"

namespace meld::view {

struct ServiceOptions {
    std::optional<double> seconds = {};                          // It ends by itself after so long.
    std::function<bool()> program_changed = {};                  // Asked now and then, on process 0; nothing: it does not change.
    std::function<std::string(sim::Simulation&)> progress = {};  // How far a run is, in a line.
};

class Service {
  public:
    // `server` is null on all processes but the first. All of it outlives the service.
    Service(std::vector<Viewer*> runs, Server* server, comm::Communicator& comm, ServiceOptions options);
    ~Service();
    Service(const Service&) = delete;
    Service& operator=(const Service&) = delete;

    // Returns whether it was interrupted, on all processes: otherwise its time is over.
    bool serve();

  private:
    using Clock = std::chrono::steady_clock;
    struct Play {
        std::uint64_t number = 0;  // Of the request.
        PageId page = 0;           // Whoever pressed the button. The next tick is made when this page has asked for the one before.
        double speed = 0;          // Ticks a second; 0: as fast as the page asks for them.
        std::optional<std::int64_t> to = {};
        bool seen = true;
        Clock::time_point next = {};
    };
    struct Action {
        enum class Kind : std::uint8_t { None, Request, Step, Reload, Finish, Interrupted } kind = Kind::None;
        std::uint32_t run = 0;
        std::string text = {};
        Arrived from = {};  // On process 0.
    };
    Action choose();
    std::optional<Action> next_tick() const;
    std::chrono::milliseconds patience() const;
    Action share(Action mine);
    void carry_out(Action action);
    void answer(const Action& action);
    Result<Reply> answer(const Json& request, std::uint32_t run, const Arrived& from);
    Result<Reply> play(const Json& request, std::uint32_t run, const Arrived& from);
    void step(std::uint32_t run);
    void reload();
    void stop_playing(std::uint32_t run, const char* why, Json more = Json::object());
    void tell_changes();
    void on_the_way(sim::Simulation* simulation, std::uint32_t run);
    // Whether a page, not a signal, has asked for the end of what has just been done. It is forgotten.
    bool was_interrupted();

    std::vector<Viewer*> runs_;
    Server* server_;
    comm::Communicator& comm_;
    ServiceOptions options_;
    const Clock::time_point begun_ = Clock::now();
    std::vector<std::optional<Play>> plays_;
    std::vector<std::uint64_t> told_;  // Changes of each run that pages know of.
    Clock::time_point next_look_ = {}, next_progress_ = {};
    std::uint64_t doing_ = 0;  // The request that is being carried out.
    bool raised_ = false;      // A page has asked for its end, and a signal says so to all who look.
    bool beside_ = false;      // What is being done moves no run.
};

}  // namespace meld::view
