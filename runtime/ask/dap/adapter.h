// The requests of the Debug Adapter Protocol: what each means for a run, and the answer.
//
// One thing is done at a time. A request that makes the run move is answered at once, and the move is made when nothing else waits; a
// request that comes on the way ends the move between two ticks, is answered, and the move goes on.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/ask/dap/breakpoints.h"
#include "runtime/ask/dap/launch.h"
#include "runtime/ask/dap/message.h"
#include "runtime/ask/dap/place.h"
#include "runtime/ask/dap/rules.h"
#include "runtime/ask/dap/run.h"

namespace meld::dap {

class Adapter {
  public:
    // Both outlive this.
    Adapter(Run& run, Writer& client) : run_(run), client_(client) {}

    // A request while nothing is done.
    void take(const Request& request);
    // One that comes while the run is asked. False: it has to wait.
    bool take_meanwhile(const Request& request);
    // A move waits to be made or to go on.
    bool has_work() const { return move_.has_value(); }
    // Makes the move, or as much of it as there is until a request waits, which `someone_waits` says then.
    void work(const std::function<bool()>& someone_waits);
    // The run has ended by itself.
    void ended();
    // The client wants no more.
    bool over() const { return over_; }

    // What is done may be ended between two ticks, and goes on later.
    bool moving() const { return moving_; }

  private:
    struct Move {
        std::string command = {};
        const char* reason = "step";  // Of the stop behind it.
        bool shown = false;           // Somebody has typed it and sees its answer.
        bool last = false;            // The session ends with it.
        bool begun = false;
    };
    using Body = Result<Json>;  // Of a response; null: none.
    using Answers = Body (Adapter::*)(const Json& arguments);
    struct Entry {
        const char* name;
        Answers answer;
        bool of_run;  // It needs a run.
    };
    static std::span<const Entry> entries();

    Body initialize(const Json& arguments);
    Body launch(const Json& arguments);
    Body attach(const Json& arguments);
    Body set_breakpoints(const Json& arguments);
    Body set_function_breakpoints(const Json& arguments);
    Body set_exception_breakpoints(const Json& arguments);
    Body breakpoint_locations(const Json& arguments);
    Body configuration_done(const Json& arguments);
    Body threads(const Json& arguments);
    Body next(const Json& arguments);
    Body step_back(const Json& arguments);
    Body go_on(const Json& arguments);
    Body reverse(const Json& arguments);
    Body pause(const Json& arguments);
    Body stack_trace(const Json& arguments);
    Body scopes(const Json& arguments);
    Body variables(const Json& arguments);
    Body set_variable(const Json& arguments);
    Body evaluate(const Json& arguments);
    Body completions(const Json& arguments);
    Body catom(const Json& arguments);
    Body terminate(const Json& arguments);
    Body disconnect(const Json& arguments);

    Body move(Move move);
    Body typed(const std::string& line);
    Body watched(const std::string& expression);
    Body pointed_at(const std::string& word);
    Body choose(std::string_view digits);
    void stopped(const Result<Json>& answer, const Move& move);
    void tell_stop(const char* reason, const std::string& description, const Json& breakpoints = Json::array());
    void show_anew();
    Result<void> know_program();
    Result<void> know_words();

    Run& run_;
    Writer& client_;
    Launch launch_;
    Rules rules_;
    std::optional<Breakpoints> breakpoints_;
    std::optional<Place> place_;
    std::optional<Move> move_;
    std::vector<std::string> commands_, predicates_;  // For completions; once they were asked for.
    std::int64_t first_line_ = 1, first_column_ = 1;  // As the client counts.
    bool initialized_ = false, launched_ = false, configured_ = false, invalidates_ = false;
    bool moving_ = false, pause_wanted_ = false, end_told_ = false, over_ = false;
    std::vector<std::function<void()>> after_;  // To be done behind the response.
};

}  // namespace meld::dap
