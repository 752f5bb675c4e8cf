// The life of a session and its moves; what is asked while it stands is in questions.cpp.
#include "runtime/ask/dap/adapter.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <utility>

#include "runtime/ask/dap/text.h"

namespace meld::dap {

namespace {

// There is one, in which the whole ensemble moves.
constexpr int kThread = 1;

// As the protocol names what there is.
Json capabilities() {
    Json out = Json::object();
    for (const char* const each : {"supportsConfigurationDoneRequest", "supportsFunctionBreakpoints", "supportsConditionalBreakpoints",
                                   "supportsEvaluateForHovers", "supportsStepBack", "supportsSetVariable", "supportsCompletionsRequest",
                                   "supportsTerminateRequest", "supportsBreakpointLocationsRequest", "supportsDelayedStackTraceLoading"})
        out[each] = true;
    return out;
}

// How the run ends at this tick, after "tick 59: ".
std::string ending_in(const Json& moved) {
    const auto text = moved.value("text", "");
    const std::string line = text.substr(0, text.find('\n'));
    const std::size_t colon = line.find(": ");
    return colon == std::string::npos ? "" : line.substr(colon + 2);
}

}  // namespace

std::span<const Adapter::Entry> Adapter::entries() {
    static constexpr std::array<Entry, 24> kEntries = {{
        {"initialize", &Adapter::initialize, false},
        {"launch", &Adapter::launch, false},
        {"attach", &Adapter::attach, false},
        {"setBreakpoints", &Adapter::set_breakpoints, true},
        {"setFunctionBreakpoints", &Adapter::set_function_breakpoints, true},
        {"setExceptionBreakpoints", &Adapter::set_exception_breakpoints, false},
        {"breakpointLocations", &Adapter::breakpoint_locations, true},
        {"configurationDone", &Adapter::configuration_done, true},
        {"threads", &Adapter::threads, false},
        {"next", &Adapter::next, true},
        {"stepIn", &Adapter::next, true},
        {"stepOut", &Adapter::next, true},
        {"stepBack", &Adapter::step_back, true},
        {"continue", &Adapter::go_on, true},
        {"reverseContinue", &Adapter::reverse, true},
        {"pause", &Adapter::pause, true},
        {"stackTrace", &Adapter::stack_trace, true},
        {"scopes", &Adapter::scopes, true},
        {"variables", &Adapter::variables, true},
        {"setVariable", &Adapter::set_variable, true},
        {"evaluate", &Adapter::evaluate, true},
        {"completions", &Adapter::completions, true},
        {"claymeld/catom", &Adapter::catom, true},
        {"terminate", &Adapter::terminate, false},
    }};
    return kEntries;
}

void Adapter::take(const Request& request) {
    const auto answer = [&]() -> Body {
        // A client may leave whatever has come before.
        if (request.command == "disconnect") return disconnect(request.arguments);
        const auto entry = std::ranges::find_if(entries(), [&](const Entry& e) { return e.name == request.command; });
        if (entry == entries().end()) return fail(fmt::format("there is no request {}", request.command));
        if (!initialized_ && request.command != "initialize") return fail(request.command + ": initialize comes first");
        if (entry->of_run && !launched_) return fail(request.command + ": launch comes first");
        if (entry->of_run && !run_.alive()) return fail(request.command + ": the run has ended");
        try {
            return (this->*entry->answer)(request.arguments);
        } catch (const Json::exception& error) {
            return fail(fmt::format("{}: the request is not as the protocol has it: {}", request.command, error.what()));
        }
    };
    const Body body = answer();
    if (body)
        client_.respond(request, *body);
    else
        client_.refuse(request, body.error().message());
    for (const auto& each : std::exchange(after_, {})) each();
    if (launched_ && !run_.alive()) ended();
}

bool Adapter::take_meanwhile(const Request& request) {
    if (request.command != "threads" && request.command != "pause" && request.command != "terminate" && request.command != "disconnect")
        return false;
    take(request);
    return true;
}

// ---- the session

Adapter::Body Adapter::initialize(const Json& arguments) {
    if (initialized_) return fail("initialize: it has come before");
    if (arguments.value("pathFormat", "path") != "path") return fail("initialize: files are named by their paths here, not by addresses");
    first_line_ = arguments.value("linesStartAt1", true) ? 1 : 0;
    first_column_ = arguments.value("columnsStartAt1", true) ? 1 : 0;
    invalidates_ = arguments.value("supportsInvalidatedEvent", false);
    initialized_ = true;
    return capabilities();
}

Adapter::Body Adapter::attach(const Json&) { return fail("attach: there is no run to join; launch starts one"); }

Adapter::Body Adapter::launch(const Json& arguments) {
    if (launched_) return fail("launch: it has come before");
    const Result<Launch> launch = read_launch(arguments);
    if (!launch) return tl::unexpected<Error>(launch.error());
    launch_ = *launch;
    if (auto started = run_.start(launch_); !started) return tl::unexpected<Error>(started.error());
    place_.emplace(run_, rules_, launch_.program.ends_with(".meld") ? launch_.program : "");
    place_->choose(launch_.catom);
    // It is ready when it answers.
    if (auto known = know_program(); !known) return fail(fmt::format("the run cannot be started: {}", known.error().message()));
    breakpoints_.emplace(run_, rules_);
    launched_ = true;
    after_.push_back([this] { client_.event("initialized"); });
    return Json();
}

// Where the run is, and by which rules.
Result<void> Adapter::know_program() {
    const Body at = run_.ask("where");
    const Body rules = at ? run_.ask("rules") : at;
    if (!rules) return tl::unexpected<Error>(rules.error());
    // The files of a recording are where the client knows them to be.
    const bool program = launch_.program.ends_with(".meld");
    rules_ = Rules(*rules, program ? std::filesystem::path(launch_.program).parent_path().string() : "");
    commands_.clear();
    predicates_.clear();
    place_->arrive(*at);
    return {};
}

Adapter::Body Adapter::configuration_done(const Json&) {
    if (configured_) return fail("configurationDone: it has come before");
    configured_ = true;
    if (!launch_.debug)
        move_ = Move{.command = "run", .shown = true, .last = true};
    else if (launch_.stop_on_entry)
        after_.push_back([this] { tell_stop("entry", fmt::format("tick {}", place_->tick())); });
    else
        move_ = Move{.command = "run"};
    return Json();
}

void Adapter::ended() {
    move_.reset();
    if (std::exchange(end_told_, true)) return;
    client_.event("exited", {{"exitCode", run_.end()}});
    client_.event("terminated");
}

Adapter::Body Adapter::terminate(const Json&) {
    run_.end();
    after_.push_back([this] { ended(); });
    return Json();
}

Adapter::Body Adapter::disconnect(const Json&) {
    run_.end();
    move_.reset();
    // Nobody waits for events any more.
    over_ = end_told_ = true;
    return Json();
}

Adapter::Body Adapter::threads(const Json&) {
    const std::string name = launch_.program.empty() ? "run" : std::filesystem::path(launch_.program).filename().string();
    return Json{{"threads", Json::array({{{"id", kThread}, {"name", name}}})}};
}

// ---- moves

Adapter::Body Adapter::move(Move move) {
    if (move_) return fail("the run is on its way; pause it first");
    if (!configured_) return fail("configurationDone comes first");
    move_ = std::move(move);
    return Json();
}

Adapter::Body Adapter::next(const Json&) { return move({.command = "step"}); }
Adapter::Body Adapter::step_back(const Json&) { return move({.command = "back"}); }

Adapter::Body Adapter::go_on(const Json&) {
    Body moves = move({.command = "run"});
    if (moves) *moves = {{"allThreadsContinued", true}};
    return moves;
}

Adapter::Body Adapter::reverse(const Json&) { return move({.command = "reverse"}); }

Adapter::Body Adapter::pause(const Json&) {
    pause_wanted_ = move_.has_value();
    run_.pause();
    return Json();
}

void Adapter::work(const std::function<bool()>& someone_waits) {
    if (!std::exchange(move_->begun, true)) place_->leave();
    moving_ = true;
    const Body answer = pause_wanted_ ? run_.ask("where") : ask_line(run_, move_->command);
    moving_ = false;
    // The client may have left meanwhile.
    if (over_ || !move_) return;
    if (!run_.alive()) return ended();
    const bool interrupted = answer && answer->contains("from") && answer->at("ended") == "interrupted";
    if (interrupted && !pause_wanted_ && someone_waits()) return place_->arrive(*answer);
    const Move move = *std::exchange(move_, std::nullopt);
    stopped(answer, move);
    pause_wanted_ = false;
}

void Adapter::stopped(const Result<Json>& answer, const Move& move) {
    if (!answer) {
        client_.output("stderr", answer.error().message() + "\n");
        tell_stop(answer.error().code == ExitCode::ProgramWrong ? "exception" : move.reason, answer.error().problem);
        return;
    }
    place_->arrive(*answer);
    if (move.shown) client_.output("console", answer->value("text", ""));
    if (move.last) {
        run_.end();
        return ended();
    }
    const Json stops = answer->value("stops", Json::array());
    if (!stops.empty()) return tell_stop("breakpoint", stops[0].at("what").get<std::string>(), breakpoints_->numbers_of(stops));
    const std::string ending = ending_in(*answer);
    if (pause_wanted_ || !ending.empty()) return tell_stop("pause", ending.empty() ? "paused" : ending);
    tell_stop(move.reason, fmt::format("tick {}", place_->tick()));
}

void Adapter::tell_stop(const char* reason, const std::string& description, const Json& breakpoints) {
    Json body = {{"reason", reason}, {"description", description}, {"threadId", kThread}, {"allThreadsStopped", true}};
    if (std::string_view(reason) == "exception") body["text"] = description;
    if (!breakpoints.empty()) body["hitBreakpointIds"] = breakpoints;
    client_.event("stopped", body);
}

// What the client has of the stack and its values is no longer so.
void Adapter::show_anew() {
    if (invalidates_)
        client_.event("invalidated", {{"areas", Json::array({"all"})}});
    else
        tell_stop("step", fmt::format("tick {}", place_->tick()));
}

}  // namespace meld::dap
