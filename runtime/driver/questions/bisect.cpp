#include "runtime/driver/questions/bisect.h"

#include <fmt/format.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "runtime/ask/watch/watches.h"
#include "runtime/ask/why/why.h"
#include "runtime/base/bytes.h"
#include "runtime/base/files/standard_streams.h"
#include "runtime/base/process/interrupt.h"
#include "runtime/base/terminal/progress.h"
#include "runtime/base/terminal/terminal_text.h"
#include "runtime/driver/run/report.h"
#include "runtime/driver/session/debug.h"
#include "runtime/driver/setup/print_error.h"

namespace meld::driver {

namespace {

using Where = inspect::Watches::Where;

// Snapshots for the derivation of the witness, of each process.
constexpr std::size_t kHistory_bytes = std::size_t{1} << 30;

// Where the search has ended.
struct Answer {
    std::int64_t from = 0;  // The first tick that was looked at; 0: the run was searched from its start.
    std::int64_t tick = 0;
    std::optional<Where> where = {};
    bool already = false;  // It holds in the first tick that was looked at, which is no start.
};

// What process 0 has found, on all of them.
std::optional<Where> shared(const std::optional<Where>& mine, comm::Communicator& comm) {
    ByteWriter out;
    out.write(mine.has_value());
    if (mine) {
        out.write(mine->catom.has_value());
        out.write(mine->catom.value_or(0));
        out.write(mine->catoms);
        for (const auto& [name, value] : mine->witness) {
            out.write_string(name);
            out.write_string(value);
        }
    }
    const auto all = comm.allgather_any(out.view());
    ByteReader in(all[0], "where a body holds");
    if (!in.read<bool>()) return std::nullopt;
    Where found;
    const bool somewhere = in.read<bool>();
    const u64 catom = in.read<u64>();
    if (somewhere) found.catom = catom;
    found.catoms = in.read<u64>();
    while (!in.done()) {
        std::string name = in.read_string();
        found.witness.emplace_back(std::move(name), in.read_string());
    }
    return found;
}

class Search {
  public:
    Search(const RunOptions& options, comm::Communicator& comm) : options_(options), question_(*options.question), comm_(comm) {}

    Result<Answer> run(timeline::Timeline& timeline) {
        Result<std::unique_ptr<inspect::Watches>> watches = inspect::Watches::make(
            timeline.simulation().subdomain().module,
            {{.verb = front::WatchRule::Verb::Stop, .asked = {.text = question_.body}, .body = question_.body}}, nullptr);
        if (!watches) return tl::unexpected<Error>(watches.error());
        watches_ = std::move(*watches);
        Answer answer{.from = timeline.first_tick()};
        // Before its first tick a run has no state to speak of.
        if (answer.from > 0) {
            const Result<bool> held = look(timeline.simulation());
            if (!held) return tl::unexpected<Error>(held.error());
            answer.already = *held;
        }
        if (!answer.already)
            if (auto done = go_on(timeline); !done) return tl::unexpected<Error>(done.error());
        answer.tick = timeline.tick();
        answer.where = found_;
        if (!found_ && timeline.ended() == sim::Ending::Interrupted)
            return fail(fmt::format("interrupted after tick {}, before there was an answer", answer.tick), "", ExitCode::Interrupted);
        return answer;
    }

  private:
    Result<void> go_on(timeline::Timeline& timeline) {
        std::optional<Progress> progress;
        if (comm_.process() == 0 && !options_.quiet) progress.emplace();
        Pace pace(timeline.simulation().summary());
        timeline.each([&](sim::Simulation& simulation) {
            if (interrupt::received() != 0) simulation.subdomain().request_stop();
            if (progress) progress->update([&] { return progress_line(simulation, pace, options_.ticks); });
        });
        const Result<void> done =
            timeline.forward_until(std::numeric_limits<std::int64_t>::max(), [&](sim::Simulation& simulation) { return look(simulation); });
        timeline.each({});
        return done;
    }

    // Whether the question is answered after this tick; the same on all processes.
    Result<bool> look(sim::Simulation& simulation) {
        const auto looked = watches_->look(simulation.subdomain());
        if (!looked) return tl::unexpected<Error>(looked.error());
        if (!looked->searched) return false;
        const bool until = question_.asks == Question::Asks::Until;
        found_ = shared(comm_.process() != 0 ? std::nullopt : until ? watches_->holding(0) : watches_->lost(0), comm_);
        return found_.has_value();
    }

    const RunOptions& options_;
    const Question& question_;
    comm::Communicator& comm_;
    std::unique_ptr<inspect::Watches> watches_;
    std::optional<Where> found_;
};

// The derivation of the witness, in a second run to that tick: only that one must be able to go back.
Result<std::optional<inspect::Explanation>> explain(const Question& question, const Answer& answer, const Searched& searched,
                                                    const sim::OpenCheckpoint* from, bool saveable) {
    // What no longer holds has no derivation.
    if (!answer.where || question.asks != Question::Asks::Until || question.depth == 0) return std::nullopt;
    Result<Searched::Running> running = searched.begin(from, saveable ? kHistory_bytes : 0);
    if (!running) return tl::unexpected<Error>(running.error());
    timeline::Timeline& timeline = **running;
    timeline.each([](sim::Simulation& simulation) {
        if (interrupt::received() != 0) simulation.subdomain().request_stop();
    });
    if (auto there = timeline.to(answer.tick); !there) return tl::unexpected<Error>(there.error());
    auto why =
        inspect::why_body(timeline, {question.body, answer.where->catom.value_or(0), answer.where->witness}, {.depth = question.depth});
    if (!why) return tl::unexpected<Error>(why.error());
    return std::move(*why);
}

std::string ticks_text(const Answer& answer) {
    if (answer.from == 0) return fmt::format("in {} tick{}", answer.tick, answer.tick == 1 ? "" : "s");
    if (answer.from == answer.tick) return fmt::format("in tick {}, where the checkpoint is", answer.tick);
    return fmt::format("from tick {}, where the checkpoint is, to tick {}", answer.from, answer.tick);
}

std::string answer_text(const Question& question, const Answer& answer) {
    const bool until = question.asks == Question::Asks::Until;
    if (!answer.where)
        return fmt::format("'{}' {} {}, after which the run ended\n", question.body,
                           until ? "holds nowhere" : "goes on holding wherever it holds", ticks_text(answer));
    const Where& where = *answer.where;
    std::string text = fmt::format("tick {}{}: '{}' {}", answer.tick, answer.already ? ", where the checkpoint is" : "", question.body,
                                   answer.already ? "already holds"
                                   : until        ? "holds"
                                                  : "no longer holds");
    if (where.catom) text += fmt::format(" at catom @{}", *where.catom);
    for (std::size_t i = 0; i < where.witness.size(); ++i)
        text += fmt::format("{}{} = {}", i == 0 ? ", with " : ", ", where.witness[i].first, where.witness[i].second);
    if (where.catoms > 1) text += fmt::format("; and at {} other{}", where.catoms - 1, where.catoms == 2 ? "" : "s");
    if (answer.already) text += ". The first such tick is this one or an earlier one: search the program";
    return text + "\n";
}

std::string answer_json(const Question& question, const Answer& answer, const std::optional<inspect::Explanation>& why) {
    nlohmann::ordered_json json = {{"body", question.body},
                                   {"asked", question.asks == Question::Asks::Until ? "until" : "while"},
                                   {"from", answer.from},
                                   {"found", answer.where.has_value() && !answer.already},
                                   {"tick", answer.tick}};
    if (answer.already) json["already"] = true;
    if (answer.where) {
        if (answer.where->catom) json["catom"] = *answer.where->catom;
        json["catoms"] = answer.where->catoms;
        nlohmann::ordered_json witness = nlohmann::ordered_json::object();
        for (const auto& [name, value] : answer.where->witness) witness[name] = value;
        json["witness"] = std::move(witness);
        if (why) json["why"] = why->to_json();
    }
    return json.dump(2, ' ', true, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace

int bisect_command(RunOptions options, std::string scratch, const ParseRun& parse) {
    if (!options.question || options.question->body.empty())
        return print_error({"there is nothing to look for", "Give --until 'body' or --while 'body'"});
    const Question& question = *options.question;
    Inquiry inquiry{.command = "bisect", .words = {}};
    inquiry.flags = {question.asks == Question::Asks::Until ? "--until" : "--while", question.body, "--depth",
                     std::to_string(question.depth)};
    options.debug = {.history = "0", .inquiry = std::move(inquiry)};
    return debug_command(std::move(options), std::move(scratch), parse);
}

Result<int> find_tick(const RunOptions& options, const Searched& searched, comm::Communicator& comm) {
    const Question& question = *options.question;
    std::unique_ptr<sim::OpenCheckpoint> from;
    std::optional<std::int64_t> before;
    Result<Answer> answer;
    bool saveable = false;
    do {
        Result<std::unique_ptr<sim::OpenCheckpoint>> checkpoint = searched.checkpoint(before);
        // It holds already in the oldest one.
        if (!checkpoint && before) break;
        if (!checkpoint) return tl::unexpected<Error>(checkpoint.error());
        from = std::move(*checkpoint);
        Result<Searched::Running> running = searched.begin(from.get(), 0);
        if (!running) return tl::unexpected<Error>(running.error());
        saveable = (*running)->simulation().saveable().has_value();
        answer = Search(options, comm).run(**running);
        if (!answer) return tl::unexpected<Error>(answer.error());
        before = answer->from;
    } while (answer->already);
    const auto why = explain(question, *answer, searched, from.get(), saveable);
    if (!why) return tl::unexpected<Error>(why.error());
    if (comm.process() == 0) {
        const std::string text =
            options.json ? answer_json(question, *answer, *why) : visible(answer_text(question, *answer) + (*why ? (*why)->to_text() : ""));
        if (auto printed = print(stdout, text); !printed) return tl::unexpected<Error>(printed.error());
    }
    return static_cast<int>(answer->where && !answer->already ? ExitCode::Fine : ExitCode::PropertyFailed);
}

}  // namespace meld::driver
