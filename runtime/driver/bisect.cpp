#include "runtime/driver/bisect.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "runtime/abi/question.h"
#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/base/interrupt.h"
#include "runtime/base/progress.h"
#include "runtime/base/standard_streams.h"
#include "runtime/base/visible.h"
#include "runtime/driver/report.h"
#include "runtime/inspect/why.h"
#include "runtime/timeline/timeline.h"
#include "runtime/tuple/facts.h"
#include "runtime/tuple/value_text.h"

namespace meld::driver {

namespace {

using Ids = std::vector<u64>;

// The catoms at which the body holds, or has ceased to hold, in one tick.
struct Found {
    u64 least = 0;
    u64 count = 0;
    // The values of the body's variables at `least`, as Meld writes them.
    std::vector<std::pair<std::string, std::string>> witness;
};

class Asker {
  public:
    Asker(const RunOptions& options, sim::Simulation& simulation) : subdomain_(simulation.subdomain()), asks_(options.question->asks) {
        const ModuleInfo& module = subdomain_.module;
        for (predicate_ = 0; predicate_ < module.predicate_count && module.predicates[predicate_].name != kQuestion;) ++predicate_;
        MELD_CHECK(predicate_ < module.predicate_count, "a module without the body '{}'", options.question->body);
    }

    // Of the tick that has just ended; the same on all processes.
    std::optional<Found> look() {
        subdomain_.refresh();
        Ids now = holding();
        std::optional<Found> found = among_all(asks_ == Question::Asks::Until ? now : lost(now));
        held_ = std::move(now);
        if (found && asks_ == Question::Asks::Until) found->witness = witness(found->least);
        return found;
    }

  private:
    // Those of this process, in order.
    Ids holding() const {
        Ids ids;
        for (sim::Catom c = 0; c < subdomain_.ensemble.index_count(); ++c) {
            if (!subdomain_.owned(c)) continue;
            bool holds = false;
            tuple::each_fact(subdomain_.module, subdomain_.columns, subdomain_.geometry(), predicate_, c,
                             [&](const Value*) { holds = true; });
            if (holds) ids.push_back(subdomain_.ensemble.id(c));
        }
        std::sort(ids.begin(), ids.end());
        return ids;
    }

    std::vector<Ids> gather(const Ids& mine) const {
        ByteWriter out;
        out.write_bytes(mine.data(), mine.size() * sizeof(u64));
        std::vector<Ids> all;
        for (const std::vector<std::byte>& bytes : subdomain_.comm.allgather_any(out.view())) {
            Ids& ids = all.emplace_back(bytes.size() / sizeof(u64));
            ByteReader in(bytes, "catoms at which a body holds");
            for (u64& id : ids) id = in.read<u64>();
        }
        return all;
    }

    // The catoms of this process at which it held in the last tick and holds nowhere now: a catom may have gone to another process.
    Ids lost(const Ids& now) const {
        Ids missing, here, gone;
        std::ranges::set_difference(held_, now, std::back_inserter(missing));
        if (subdomain_.alone()) return missing;
        Ids elsewhere;
        const std::vector<Ids> all = gather(missing);
        for (const Ids& ids : all) std::ranges::set_intersection(ids, now, std::back_inserter(here));
        for (const Ids& ids : gather(here)) elsewhere.insert(elsewhere.end(), ids.begin(), ids.end());
        std::ranges::sort(elsewhere);
        std::ranges::set_difference(missing, elsewhere, std::back_inserter(gone));
        return gone;
    }

    std::optional<Found> among_all(const Ids& mine) const {
        ByteWriter out;
        out.write(mine.empty() ? ~u64{0} : mine.front());
        out.write(static_cast<u64>(mine.size()));
        const std::vector<std::byte> all = subdomain_.comm.allgather(out.view());
        ByteReader in(all, "what the processes found");
        Found found{.least = ~u64{0}, .count = 0, .witness = {}};
        while (!in.done()) {
            found.least = std::min(found.least, in.read<u64>());
            found.count += in.read<u64>();
        }
        return found.count > 0 ? std::optional(std::move(found)) : std::nullopt;
    }

    // Whoever owns the catom tells the others.
    std::vector<std::pair<std::string, std::string>> witness(u64 id) const {
        const PredicateInfo& p = subdomain_.module.predicates[predicate_];
        ByteWriter out;
        const auto catom = subdomain_.ensemble.find(id);
        if (catom && subdomain_.owned(*catom))
            tuple::each_fact(subdomain_.module, subdomain_.columns, subdomain_.geometry(), predicate_, *catom, [&](const Value* v) {
                for (u32 i = 0; i < p.arity; ++i) {
                    out.write_string(p.fields[i].name);
                    out.write_string(tuple::print_value(tuple::type_of(subdomain_.module, p.fields[i]), v[i]));
                }
            });
        std::vector<std::pair<std::string, std::string>> values;
        for (const std::vector<std::byte>& bytes : subdomain_.comm.allgather_any(out.view()))
            for (ByteReader in(bytes, "a witness"); !in.done();) {
                std::string name = in.read_string();
                values.emplace_back(std::move(name), in.read_string());
            }
        return values;
    }

    sim::Subdomain& subdomain_;
    Question::Asks asks_;
    u32 predicate_ = 0;
    Ids held_;  // In the last tick, on this process.
};

std::string answer_text(const Question& question, const std::optional<Found>& found, std::int64_t tick) {
    const bool until = question.asks == Question::Asks::Until;
    if (!found)
        return fmt::format("'{}' {} in {} tick{}, after which the run ended\n", question.body,
                           until ? "holds nowhere" : "goes on holding wherever it holds", tick, tick == 1 ? "" : "s");
    std::string text = fmt::format("tick {}: '{}' {} at catom @{}", tick, question.body, until ? "holds" : "no longer holds", found->least);
    for (std::size_t i = 0; i < found->witness.size(); ++i)
        text += fmt::format("{}{} = {}", i == 0 ? ", with " : ", ", found->witness[i].first, found->witness[i].second);
    if (found->count > 1) text += fmt::format("; and at {} other{}", found->count - 1, found->count == 2 ? "" : "s");
    return text + "\n";
}

std::string answer_json(const Question& question, const std::optional<Found>& found, std::int64_t tick,
                        const std::optional<inspect::Explanation>& why) {
    nlohmann::ordered_json json = {{"body", question.body},
                                   {"asked", question.asks == Question::Asks::Until ? "until" : "while"},
                                   {"found", found.has_value()},
                                   {"tick", tick}};
    if (found) {
        json["catom"] = found->least;
        json["catoms"] = found->count;
        nlohmann::ordered_json witness = nlohmann::ordered_json::object();
        for (const auto& [name, value] : found->witness) witness[name] = value;
        json["witness"] = std::move(witness);
        if (why) json["why"] = why->to_json();
    }
    return json.dump(2, ' ', true, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

// The derivation of the witness, in a second run to that tick: only that one must be able to go back.
Result<std::optional<inspect::Explanation>> explain(const RunOptions& options, const Found& found, std::int64_t tick, const Inputs& inputs,
                                                    comm::Communicator& comm) {
    const Question& question = *options.question;
    // What no longer holds has no derivation.
    if (question.asks != Question::Asks::Until || question.depth == 0) return std::nullopt;
    const auto make = [&] { return std::make_unique<sim::Simulation>(inputs.info(), inputs.world, inputs.target, comm, options.threads); };
    timeline::Timeline timeline(make, inputs.registry, {.limits = {options.ticks, options.strict}});
    // A component that cannot be saved.
    if (!timeline.start()) return std::nullopt;
    timeline.each([](sim::Simulation& simulation) {
        if (interrupt::received() != 0) simulation.subdomain().request_stop();
    });
    if (auto there = timeline.to(tick); !there) return tl::unexpected<Error>(there.error());
    auto why = inspect::why_body(timeline, {question.body, found.least, found.witness}, {.depth = question.depth});
    if (!why) return tl::unexpected<Error>(why.error());
    return std::move(*why);
}

}  // namespace

Result<int> find_tick(const RunOptions& options, const Inputs& inputs, sim::Simulation& simulation) {
    const sim::RunLimits limits{options.ticks, options.strict};
    sim::Subdomain& subdomain = simulation.subdomain();
    const bool speaks = subdomain.comm.process() == 0;
    Asker asker(options, simulation);
    std::optional<Progress> progress;
    if (speaks && !options.quiet) progress.emplace();
    Pace pace(simulation.summary());
    std::optional<Found> found;
    std::optional<sim::Ending> ended;
    while (!found && !(ended = simulation.ended(limits))) {
        if (interrupt::received() != 0) subdomain.request_stop();
        if (auto done = simulation.step(limits); !done) return tl::unexpected<Error>(done.error());
        found = asker.look();
        if (!progress) continue;
        progress->update([&] { return progress_line(simulation, pace, options.ticks); });
    }
    progress.reset();
    if (!found && ended == sim::Ending::Interrupted)
        return fail(fmt::format("interrupted after tick {}, before there was an answer", subdomain.tick()), "", ExitCode::Interrupted);
    std::optional<inspect::Explanation> why;
    if (found) {
        auto explained = explain(options, *found, subdomain.tick(), inputs, subdomain.comm);
        if (!explained) return tl::unexpected<Error>(explained.error());
        why = std::move(*explained);
    }
    if (speaks) {
        const Question& question = *options.question;
        const std::string text = options.json ? answer_json(question, found, subdomain.tick(), why)
                                              : visible(answer_text(question, found, subdomain.tick()) + (why ? why->to_text() : ""));
        if (auto printed = print(stdout, text); !printed) return tl::unexpected<Error>(printed.error());
    }
    return static_cast<int>(found ? ExitCode::Fine : ExitCode::PropertyFailed);
}

}  // namespace meld::driver
