#include "runtime/driver/session/debug.h"
#include "runtime/driver/run/replay_without_outputs.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <limits>
#include <memory>
#include <utility>

#include "runtime/ask/debug/input.h"
#include "runtime/ask/debug/session.h"
#include "runtime/base/bytes.h"
#include "runtime/base/files/standard_streams.h"
#include "runtime/base/process/interrupt.h"
#include "runtime/base/terminal/log.h"
#include "runtime/base/terminal/progress.h"
#include "runtime/base/terminal/terminal_text.h"
#include "runtime/base/units.h"
#include "runtime/comm/transport/collective_result.h"
#include "runtime/driver/pictures/export.h"
#include "runtime/driver/pictures/frame_observer.h"
#include "runtime/driver/pictures/movie.h"
#include "runtime/driver/pictures/picture_options.h"
#include "runtime/driver/pictures/recorded_steps.h"
#include "runtime/driver/pictures/shot.h"
#include "runtime/driver/pictures/whole_recording.h"
#include "runtime/driver/questions/bisect.h"
#include "runtime/driver/run/checkpoints.h"
#include "runtime/driver/run/replay.h"
#include "runtime/driver/run/report.h"
#include "runtime/driver/run/run.h"
#include "runtime/driver/session/debug_state.h"
#include "runtime/driver/session/session_run.h"
#include "runtime/driver/session/session_target.h"
#include "runtime/driver/session/view.h"
#include "runtime/driver/setup/outputs.h"
#include "runtime/driver/setup/print_error.h"
#include "runtime/driver/setup/scratch_folder.h"
#include "runtime/results/timeline/timeline.h"
#include "runtime/sim/state/checkpoint_folder.h"
#include "runtime/sim/watchers/watcher.h"

namespace meld::driver {

namespace {

// So many lines of facts are shown on a terminal, and in an editor.
constexpr std::uint64_t kLinesOnTerminal = 40, kLinesServed = 1000;
// What another program says instead of a signal: what is being done is to end.
constexpr std::string_view kPause = "pause";

// Shows how far the run is while a command is carried out, and asks it to stop when a signal has come.
class OnTheWay {
  public:
    // Whoever serves says on its input that it is to stop.
    OnTheWay(timeline::Timeline& timeline, debug::Session& session, bool shows, std::int64_t last_tick, debug::Input* served)
        : timeline_(timeline), session_(session), pace_(timeline.simulation().summary()) {
        if (shows) progress_.emplace();
        const auto listen = [served] {
            if (served != nullptr && interrupt::received() == 0 && served->says(kPause)) static_cast<void>(::raise(SIGINT));
        };
        if (progress_ || served != nullptr)
            session_.looked([this, listen](std::uint64_t facts) {
                listen();
                if (!progress_) return;
                progress_->update([&] { return fmt::format("{:.1f} million facts looked at", 1e-6 * static_cast<double>(facts)); });
            });
        timeline_.each([this, listen, last_tick](sim::Simulation& simulation) {
            listen();
            if (interrupt::received() != 0) simulation.subdomain().request_stop();
            if (progress_) progress_->update([&] { return progress_line(simulation, pace_, last_tick); });
        });
    }
    ~OnTheWay() {
        timeline_.each({});
        session_.looked({});
    }
    OnTheWay(const OnTheWay&) = delete;
    OnTheWay& operator=(const OnTheWay&) = delete;

  private:
    timeline::Timeline& timeline_;
    debug::Session& session_;
    std::optional<Progress> progress_;
    Pace pace_;
};

// Process 0 reads commands and prints answers, all carry them out.
class Conversation {
  public:
    Conversation(const RunOptions& options, comm::Communicator& comm, timeline::Timeline& timeline, world::World& world,
                 std::optional<debug::Input> input, debug::Host host)
        : options_(options),
          comm_(comm),
          timeline_(timeline),
          input_(std::move(input)),
          session_(timeline, world,
                   {.most_lines = most_lines(options),
                    .folder = options.debug->folder,
                    .recorded = !options.replay.empty(),
                    .inputs = inputs_of(options, world_path(options)),
                    .host = std::move(host)}) {
        if (input_) input_->complete_by([this](std::string_view line) { return debug::complete(line, session_.vocabulary()); });
    }
    Conversation(const Conversation&) = delete;
    Conversation& operator=(const Conversation&) = delete;

    // One command instead of those that somebody gives. Returns the exit code.
    Result<int> inquire(const Inquiry& inquiry) {
        int code = 0;
        const auto asked = [&]() -> Result<void> {
            if (auto there = go_to(inquiry.tick); !there) return there;
            std::string line = inquiry.command;
            for (const auto* words : {&inquiry.flags, &inquiry.words})
                for (const std::string& word : *words) line += " " + word;
            const Result<debug::Command> command = debug::parse_command(line);
            if (!command) return tl::unexpected<Error>(command.error());
            const Result<debug::Answer> answer = execute(*command);
            if (!answer) return tl::unexpected<Error>(answer.error());
            const auto* rows = std::get_if<debug::RowsFound>(&*answer);
            const auto* why = std::get_if<debug::WhyFound>(&*answer);
            const bool none = (rows != nullptr && rows->table.rows() == 0) || (why != nullptr && why->explanation.roots.empty());
            // As grep and diff say it.
            if (none) code = static_cast<int>(ExitCode::ProgramWrong);
            if (!input_) return {};
            if (const auto* sent = std::get_if<inspect::Messages>(&*answer); sent != nullptr && (inquiry.csv || inquiry.dot))
                return print(stdout, inquiry.csv ? sent->to_csv() : sent->to_dot());
            if (rows != nullptr && inquiry.csv) return print(stdout, rows->table.to_csv(rows->most_rows));
            if (why != nullptr && inquiry.dot) return print(stdout, why->explanation.to_dot());
            return print(stdout, shown(*answer));
        }();
        if (auto all = comm::outcome_of_first(comm_, asked); !all) return tl::unexpected<Error>(all.error());
        return comm::value_of_first(comm_, code);
    }

    Result<void> hold() {
        while (true) {
            const Result<std::optional<std::string>> line = next_line();
            if (!line) return tl::unexpected<Error>(line.error());
            // A request that came before it was answered at the prompt, of which only process 0 knows.
            if (!input_) static_cast<void>(interrupt::forget_request());
            if (!*line) return {};
            const Result<debug::Command> command = debug::parse_command(line->value());
            if (command && std::holds_alternative<debug::Quit>(*command)) return {};
            const Result<debug::Answer> answer = command ? execute(*command) : tl::unexpected<Error>(command.error());
            const Result<void> told = input_ ? tell_answer(answer) : Result<void>{};
            if (auto all = comm::outcome_of_first(comm_, told); !all) return all;
        }
    }

  private:
    static std::uint64_t most_lines(const RunOptions& options) {
        if (const auto& inquiry = options.debug->inquiry; inquiry && inquiry->limit) return *inquiry->limit;
        if (options.debug->served) return kLinesServed;
        const bool on_terminal = !options.json && options.debug->shown && !options.debug->inquiry;
        return on_terminal ? kLinesOnTerminal : std::numeric_limits<std::uint64_t>::max();
    }

    // To the end of this tick; if none is asked for, to the end of the run, or to where the checkpoint is.
    Result<void> go_to(std::int64_t tick) {
        if (tick < 0 && !options_.resume.empty()) return {};
        const Result<debug::Answer> moved = execute(tick < 0 ? debug::Command{debug::Run{}} : debug::Command{debug::To{tick}});
        if (!moved) return tl::unexpected<Error>(moved.error());
        if (std::get<debug::Moved>(*moved).ended == sim::Ending::Interrupted)
            return fail(fmt::format("interrupted after tick {}", timeline_.tick()), "", ExitCode::Interrupted);
        if (tick >= 0 && timeline_.tick() != tick)
            return fail(fmt::format("the run ends with tick {}, before tick {}", timeline_.tick(), tick));
        return {};
    }

    // The same on all processes; nothing at the end.
    Result<std::optional<std::string>> next_line() {
        Result<std::optional<std::string>> mine = std::nullopt;
        if (input_) {
            const bool served = options_.debug->served;
            do mine = input_->next(fmt::format("tick {}> ", timeline_.tick()));
            // What it was to end had ended by itself.
            while (served && mine && *mine && **mine == kPause);
        }
        if (auto all = comm::outcome_of_first(comm_, mine.map([](const auto&) {})); !all) return tl::unexpected<Error>(all.error());
        ByteWriter out;
        if (input_) {
            out.write(mine->has_value());
            // Enter repeats a step.
            out.write_string(!*mine ? "" : (*mine)->empty() ? "step" : **mine);
        }
        const auto all = comm_.allgather_any(out.view());
        ByteReader in(all[0], "a command");
        if (!in.read<bool>()) return std::nullopt;
        return in.read_string();
    }

    Result<debug::Answer> execute(const debug::Command& command) {
        // At a terminal Ctrl-C ends the command and not the session, so a tick that has begun is made to its end.
        std::optional<interrupt::Answering> soon;
        if (!options_.debug->typed && !options_.debug->served) soon.emplace(interrupt::Answer::Soon);
        const OnTheWay watched(timeline_, session_, input_ && !options_.quiet, options_.ticks,
                               input_ && options_.debug->served ? &*input_ : nullptr);
        return session_.execute(command);
    }

    std::string shown(const debug::Answer& answer) const {
        if (options_.debug->served) return debug::to_json_with_text(answer);
        return options_.json ? debug::to_json(answer) : visible(debug::to_text(answer));
    }

    // Errors: the session ends.
    Result<void> tell_answer(const Result<debug::Answer>& answer) {
        const auto* moved = answer ? std::get_if<debug::Moved>(&*answer) : nullptr;
        const bool interrupted = interrupt::received() != 0 || (moved != nullptr && moved->ended == sim::Ending::Interrupted);
        const bool goes_on = input_->forgives() && (interrupt::received() == 0 || interrupt::forget_request());
        if (answer)
            if (auto printed = print(stdout, shown(*answer)); !printed) return printed;
        if (interrupted && !goes_on) return fail(fmt::format("interrupted after tick {}", timeline_.tick()), "", ExitCode::Interrupted);
        if (answer) return {};
        const Error& error = answer.error();
        if (options_.json)
            if (auto printed = print(stdout, debug::to_json(error)); !printed) return printed;
        if (!goes_on) return fail(input_->place() + error.problem, error.suggestion, error.code);
        // At a terminal it stands among the answers: what goes through mpirun by two ways comes in any order.
        return options_.json ? Result<void>{} : print(stdout, visible(error.message()) + "\n");
    }

    const RunOptions& options_;
    comm::Communicator& comm_;
    timeline::Timeline& timeline_;
    std::optional<debug::Input> input_;  // On process 0.
    debug::Session session_;
};

}  // namespace

int debug_command(RunOptions options, std::string scratch, const ParseRun& parse) {
    if (options.debug->picture) {
        const bool copies =
            std::holds_alternative<ExportOptions>(options.debug->picture->of) && is_recording_name(options.debug->picture->file);
        if (const auto right = last_tick_of(*options.debug->picture); !copies && !right) return print_error(right.error());
        if (const auto distinct = check_output(options, world_path(options), "--output", options.debug->picture->file); !distinct)
            return print_error(distinct.error());
        if (options.debug->picture->steps) return paint_steps(options);
        if (copies) return export_recording(options);
    }
    if (options.debug->view && !options.debug->view->share.file.empty()) {
        if (const auto distinct = check_output(options, world_path(options), "--share", options.debug->view->share.file); !distinct)
            return print_error(distinct.error());
        const std::string& target = options.replay.empty() ? options.program : options.replay;
        if (const auto fits = check_name(
                {"--share", options.debug->view->share.file, "a run is shared as HTML", ".html", target.empty() ? "TARGET" : target});
            !fits)
            return print_error(fits.error());
        if (!options.debug->view->other.empty())
            return print_error({"--share: a page shows one run", fmt::format("Leave out {}", options.debug->view->other)});
    }
    if (const auto bytes = parse_bytes(options.debug->history); !bytes) return print_error({"--history: " + bytes.error().problem});
    // The processes that are started here have pipes.
    const auto note = [&](bool& flag, bool is, const char* word) {
        if (!is || flag) return;
        flag = true;
        options.arguments.emplace_back(word);
    };
    const bool from_input = options.debug->commands.empty() || options.debug->commands == "-";
    if (options.debug->served) options.json = options.quiet = true;
    if (!options.debug->inquiry) {
        if (options.debug->folder.empty()) {
            std::error_code error;
            options.debug->folder = std::filesystem::current_path(error).string();
            options.arguments.insert(options.arguments.end(), {"--folder", options.debug->folder});
        }
    }
    if (!options.debug->inquiry && !options.debug->view) {
        note(options.debug->typed, !options.debug->served && from_input && ::isatty(STDIN_FILENO) != 0, "--typed");
        note(options.debug->shown, !options.debug->served && ::isatty(STDOUT_FILENO) != 0, "--shown");
    }
    Scratch own, beside;
    std::shared_ptr<const RunOptions> other_run;
    if (options.debug->view && !options.debug->view->other.empty()) {
        Result<RunOptions> other = looked_at_beside(options, beside);
        if (!other) return print_error(other.error());
        other_run = std::make_shared<const RunOptions>(std::move(*other));
    }
    Result<RunOptions> run = looked_at(std::move(options), scratch, own, parse);
    if (run && run->debug->view) run->debug->view->beside = other_run;
    return run ? run_command(std::move(*run)) : print_error(run.error());
}

Result<int> debug_run(const RunOptions& options, Inputs& inputs, const std::vector<Claim>& claims, comm::Communicator& comm) {
    if (options.debug->view) return view_run(options, inputs, claims, comm);
    Drawings drawings;
    const bool draws = options.debug->picture.has_value();
    const Result<timeline::Timeline::Make> made = make_simulations(options, inputs, comm, draws ? &drawings : nullptr);
    if (!made) return tl::unexpected<Error>(made.error());
    timeline::Timeline::Make make = *made;
    if (options.question) {
        const auto begin = [&](const sim::OpenCheckpoint* from, std::size_t history_bytes) {
            return start_timeline(options, inputs, make, from, history_bytes);
        };
        const auto checkpoint = [&](std::optional<std::int64_t> before) {
            return open_beginning(options, claims, inputs.world, comm, before);
        };
        return find_tick(options, {begin, checkpoint}, comm);
    }
    const Result<std::unique_ptr<sim::OpenCheckpoint>> beginning = open_beginning(options, claims, inputs.world, comm);
    if (!beginning) return tl::unexpected<Error>(beginning.error());
    std::optional<debug::Input> input;
    if (comm.process() == 0) {
        using From = debug::Input::From;
        const From from = options.debug->served ? From::Program : options.debug->typed ? From::Terminal : From::Script;
        Result<debug::Input> opened = debug::Input::open(options.debug->commands, from);
        if (const auto all = comm::outcome_of_first(comm, opened.map([](const auto&) {})); !all) return tl::unexpected<Error>(all.error());
        input = std::move(*opened);
    } else if (const auto all = comm::outcome_of_first(comm, {}); !all) {
        return tl::unexpected<Error>(all.error());
    }

    Result<std::unique_ptr<timeline::Timeline>> started =
        start_timeline(options, inputs, make, beginning->get(), parse_bytes(options.debug->history).value_or(0));
    if (!started) return tl::unexpected<Error>(started.error());
    timeline::Timeline& timeline = **started;
    // What is done is ended between two ticks, and the session by whoever reads its commands.
    const interrupt::Answering patiently(interrupt::Answer::Patiently);
    // Whoever sees a prompt may answer it with Ctrl-C, which would end a process that is not so far yet.
    comm.barrier();
    if (draws) {
        Result<timeline::Timeline::Make> with = begin_drawing(options, inputs, comm, timeline, std::move(make), drawings);
        if (!with) return tl::unexpected<Error>(with.error());
        Onlooker onlooker(options, comm, timeline, [&]() -> record::Drawing& { return drawings.of(timeline); });
        const auto& of = options.debug->picture->of;
        if (std::holds_alternative<ShotOptions>(of)) return take_shot(options, inputs.world, onlooker);
        if (std::holds_alternative<ExportOptions>(of)) return export_run(options, onlooker);
        return make_movie(options, inputs.world, onlooker);
    }
    DebuggedRun run(options, inputs, claims, comm);
    debug::Host host{
        .reload = [&] { return run.reload(timeline, make); },
        .save = [&](const std::string& folder, const std::string& events) { return run.save(timeline.simulation(), folder, events); }};
    Conversation conversation(options, comm, timeline, inputs.world, std::move(input), std::move(host));
    if (options.debug->inquiry) return conversation.inquire(*options.debug->inquiry);
    const Result<void> held = conversation.hold();
    if (!held) return tl::unexpected<Error>(held.error());
    return static_cast<int>(ExitCode::Fine);
}

}  // namespace meld::driver
