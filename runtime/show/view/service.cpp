#include "runtime/show/view/service.h"

#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <utility>

#include "runtime/base/bytes.h"
#include "runtime/base/process/interrupt.h"

namespace meld::view {

namespace {

using std::chrono::duration;
using std::chrono::duration_cast;
using std::chrono::milliseconds;

// A signal is noticed after so long.
constexpr milliseconds kLook{100};
// Files of the program are looked at so often,
constexpr milliseconds kBetweenLooks{400};
// and how far a run is, is told so often.
constexpr milliseconds kBetweenProgress{100};

std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

}  // namespace

Service::Service(std::vector<Viewer*> runs, Server* server, comm::Communicator& comm, ServiceOptions options)
    : runs_(std::move(runs)), server_(server), comm_(comm), options_(std::move(options)), plays_(runs_.size()), told_(runs_.size(), 0) {
    for (std::uint32_t run = 0; run < runs_.size(); ++run) {
        runs_[run]->timeline().each([this, run](sim::Simulation& simulation) {
            on_the_way(&simulation, run);
            runs_[run]->note_begin();
        });
        runs_[run]->session().looked([this, run](std::uint64_t) { on_the_way(nullptr, run); });
    }
}

Service::~Service() {
    for (Viewer* const run : runs_) {
        run->timeline().each({});
        run->session().looked({});
    }
}

// Between two ticks, and now and then while a question is answered.
void Service::on_the_way(sim::Simulation* simulation, std::uint32_t run) {
    if (server_ != nullptr && !raised_ && interrupt::received() == 0 && doing_ > 0 && server_->interrupted(doing_)) {
        raised_ = true;
        static_cast<void>(::raise(SIGINT));
    }
    if (simulation == nullptr) return;
    if (interrupt::received() != 0) simulation->subdomain().request_stop();
    if (server_ == nullptr || !options_.progress || beside_ || Clock::now() < next_progress_) return;
    next_progress_ = Clock::now() + kBetweenProgress;
    server_->push(
        "progress",
        text_of({{"event", "progress"}, {"run", run}, {"tick", simulation->subdomain().tick()}, {"text", options_.progress(*simulation)}}));
}

bool Service::was_interrupted() { return std::exchange(raised_, false) && interrupt::forget_request(); }

bool Service::serve() {
    while (true) {
        Action action = share(server_ != nullptr ? choose() : Action{});
        if (action.kind == Action::Kind::Finish || action.kind == Action::Kind::Interrupted)
            return action.kind == Action::Kind::Interrupted;
        carry_out(std::move(action));
    }
}

// The tick of a run that is played, if it is time for it and the page has seen the one before.
std::optional<Service::Action> Service::next_tick() const {
    for (std::uint32_t run = 0; run < plays_.size(); ++run)
        if (plays_[run] && plays_[run]->seen && Clock::now() >= plays_[run]->next) return Action{.kind = Action::Kind::Step, .run = run};
    return std::nullopt;
}

milliseconds Service::patience() const {
    Clock::time_point until = Clock::now() + kLook;
    for (const std::optional<Play>& play : plays_)
        if (play && play->seen) until = std::min(until, play->next);
    return std::max(milliseconds(0), std::chrono::ceil<milliseconds>(until - Clock::now()));
}

Service::Action Service::choose() {
    while (true) {
        if (interrupt::received() != 0) return {.kind = Action::Kind::Interrupted};
        if (options_.seconds && duration<double>(Clock::now() - begun_).count() >= *options_.seconds) return {.kind = Action::Kind::Finish};
        for (std::uint32_t run = 0; run < plays_.size(); ++run)
            if (plays_[run] && server_->interrupted(plays_[run]->number))
                stop_playing(run, "interrupted");
            else if (plays_[run] && !server_->is_open(plays_[run]->page))
                stop_playing(run, "paused");
        if (options_.program_changed && Clock::now() >= next_look_) {
            next_look_ = Clock::now() + kBetweenLooks;
            if (options_.program_changed()) return {.kind = Action::Kind::Reload};
        }
        if (std::optional<Arrived> arrived = server_->next(patience())) {
            std::string text = std::move(arrived->text);
            return {.kind = Action::Kind::Request, .text = std::move(text), .from = std::move(*arrived)};
        }
        if (auto tick = next_tick()) return *tick;
    }
}

// What process 0 has chosen, on all.
Service::Action Service::share(Action mine) {
    if (comm_.processes() == 1) return mine;
    ByteWriter out;
    if (comm_.process() == 0) {
        out.write(mine.kind);
        out.write(mine.run);
        out.write_string(mine.text);
    }
    const auto all = comm_.allgather_any(out.view());
    if (comm_.process() == 0) return mine;
    ByteReader in(all[0], "what is to be done");
    Action action;
    action.kind = in.read<Action::Kind>();
    action.run = in.read<std::uint32_t>();
    action.text = in.read_string();
    return action;
}

void Service::carry_out(Action action) {
    doing_ = action.kind == Action::Kind::Step && plays_[action.run] ? plays_[action.run]->number : action.from.number;
    next_progress_ = Clock::now() + kBetweenProgress;
    if (action.kind == Action::Kind::Request) answer(action);
    if (action.kind == Action::Kind::Step) step(action.run);
    if (action.kind == Action::Kind::Reload) reload();
    static_cast<void>(was_interrupted());
    doing_ = 0;
    tell_changes();
}

void Service::answer(const Action& action) {
    const Json request = Json::parse(action.text, nullptr, false);
    Json words = Json::object();
    // Whatever else it is, it may be nested deeply.
    if (request.is_object() && request.contains("id") && (request["id"].is_number() || request["id"].is_string()))
        words["id"] = request["id"];
    std::uint32_t run = 0;
    const Result<Reply> reply = [&]() -> Result<Reply> {
        if (request.is_discarded()) return fail("the request is no JSON");
        Fields fields(request, "the request");
        std::int64_t number = 0;
        fields.read("run", number, 0, static_cast<std::int64_t>(runs_.size()) - 1);
        for (const auto& [key, value] : request.items()) fields.known(key.c_str());
        if (auto right = fields.done(); !right) return tl::unexpected<Error>(right.error());
        run = static_cast<std::uint32_t>(number);
        return answer(request, run, action.from);
    }();
    if (server_ == nullptr) return;
    words["ok"] = reply.has_value();
    if (request.is_object() && request.contains("run")) words["run"] = run;
    words["tick"] = runs_[run]->timeline().tick();
    if (reply)
        words.update(reply->words);
    else
        words["error"] = as_json(reply.error());
    if (reply && !reply->binary.empty()) words["binary"] = true;
    server_->answer(action.from.page, text_of(words), reply ? reply->binary : "");
}

Result<Reply> Service::answer(const Json& request, std::uint32_t run, const Arrived& from) {
    const auto verb = request.find("do");
    if (verb != request.end() && (*verb == "play" || *verb == "pause")) return play(request, run, from);
    // The run stays where it is while ticks of it are run again for a plot.
    beside_ = verb != request.end() && *verb == "series";
    Result<Reply> reply = runs_[run]->answer(request);
    beside_ = false;
    if (plays_[run] && plays_[run]->page == from.page && verb != request.end() && (*verb == "frame" || *verb == "image"))
        plays_[run]->seen = true;
    return reply;
}

Result<Reply> Service::play(const Json& request, std::uint32_t run, const Arrived& from) {
    Play asked{.number = from.number, .page = from.page, .next = Clock::now()};
    Fields fields(request, "the request");
    for (const char* key : {"id", "do", "run"}) fields.known(key);
    fields.read("speed", asked.speed, 0, 1e6);
    fields.read("to", asked.to, 0, INT64_MAX - 1);
    if (auto right = fields.done(); !right) return tl::unexpected<Error>(right.error());
    // The others are told of each tick.
    if (server_ == nullptr) return Reply{};
    if (request["do"] == "pause")
        stop_playing(run, "paused");
    else
        plays_[run] = asked;
    return Reply{};
}

void Service::stop_playing(std::uint32_t run, const char* why, Json more) {
    if (!plays_[run]) return;
    plays_[run].reset();
    Json words = {{"event", "stopped"}, {"run", run}, {"why", why}, {"tick", runs_[run]->timeline().tick()}};
    words.update(more);
    server_->push(fmt::format("stopped {}", run), text_of(words));
}

void Service::step(std::uint32_t run) {
    Viewer& viewer = *runs_[run];
    const std::int64_t before = viewer.timeline().tick();
    const Result<debug::Moved> moved = viewer.step();
    if (server_ == nullptr || !plays_[run]) return;
    Play& play = *plays_[run];
    play.seen = false;
    // Late is late: a run that is too slow does not hurry afterwards.
    const auto now = Clock::now();
    const auto between = play.speed > 0 ? duration_cast<Clock::duration>(duration<double>(1 / play.speed)) : Clock::duration(0);
    play.next = std::max(play.next + between, now);
    const std::int64_t tick = viewer.timeline().tick();
    if (!moved) return stop_playing(run, "error", {{"error", as_json(moved.error())}});
    if (!moved->stops.empty()) {
        Json stops = Json::array();
        for (const debug::Stop& stop : moved->stops) stops.push_back(stop.what);
        return stop_playing(run, "stop", {{"stops", std::move(stops)}});
    }
    if (interrupt::received() != 0) return stop_playing(run, "interrupted");
    if (tick == before || moved->ended || (play.to && tick >= *play.to)) stop_playing(run, "end");
}

void Service::reload() {
    const Result<debug::Reloaded> done = runs_.front()->reload();
    if (server_ == nullptr) return;
    Json words = {{"event", "reloaded"}, {"run", 0}, {"ok", done.has_value()}, {"tick", runs_.front()->timeline().tick()}};
    if (done) {
        Json answer = Json::parse(debug::to_json_with_text(*done));
        words["text"] = std::move(answer["text"]);
        answer.erase("text");
        words["answer"] = std::move(answer);
    } else {
        words["error"] = as_json(done.error());
    }
    server_->push("reloaded", text_of(words));
}

// All pages learn where runs are, also the one that has moved them.
void Service::tell_changes() {
    for (std::uint32_t run = 0; run < runs_.size(); ++run) {
        if (std::exchange(told_[run], runs_[run]->changes()) == runs_[run]->changes() || server_ == nullptr) continue;
        Json words = {{"event", "moved"}, {"run", run}};
        words.update(runs_[run]->where());
        server_->push(fmt::format("moved {}", run), text_of(words));
    }
}

}  // namespace meld::view
