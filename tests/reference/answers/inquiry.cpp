#include "tests/reference/answers/inquiry.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "runtime/ask/query/query.h"
#include "runtime/ask/why/why.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/results/timeline/timeline.h"
#include "runtime/world/ensemble/target.h"
#include "tests/reference/answers/questions.h"
#include "tests/reference/programs/body.h"
#include "tests/reference/trials/schedule.h"
#include "tests/reference/trials/worlds.h"

namespace meld::reference {

namespace {

using Json = nlohmann::ordered_json;

// An answer that goes on for longer says nothing new, and takes long to judge.
constexpr std::size_t kWhyNotDepth = 6;

// ---- what is asked

// Whether a fact can be written as a question: not with sets, and not with values that `exists` has made.
bool writable(const check::Type& type, const Value& value) {
    if (type.kind == check::Type::Kind::Set) return false;
    if (value.has_items()) {
        for (std::size_t i = 0; i < value.items().size(); ++i)
            if (!writable(type.parts.empty() ? check::Type::Float : type.parts[std::min(i, type.parts.size() - 1)], value.items()[i]))
                return false;
        return true;
    }
    if (value.is_real()) return print(type, value).find('e') == std::string::npos;
    return value.is_text() || type != check::Type::Node || (value.integer() >= 0 && value.integer() < 1'000'000);
}

class Chooser {
  public:
    Chooser(const Past& past, Random& random) : past_(past), program_(past.program()), random_(random) {}

    struct Chosen {
        PredicateId predicate;
        Row row;
    };
    // A fact of a tick that a program knows by its name.
    std::optional<Chosen> fact(std::int64_t tick) {
        std::vector<PredicateId> known;
        for (const PredicateId id : program_.predicates.ids()) {
            const check::Predicate& p = program_.predicates[id];
            const bool own = p.world == check::WorldSource::None && p.kind != check::PredicateKind::Action && !p.prelude;
            if (own && p.name.find('@') == std::string::npos && !past_.at(tick).facts[id.index()].empty()) known.push_back(id);
        }
        if (known.empty()) return std::nullopt;
        const PredicateId id = pick(random_, known);
        const Rows& rows = past_.at(tick).facts[id.index()];
        const Row& row = *std::next(rows.begin(), below(random_, static_cast<std::int64_t>(rows.size())));
        for (std::size_t i = 0; i < row.size(); ++i)
            if (!writable(program_.predicates[id].arguments[i].type, row[i])) return std::nullopt;
        return Chosen{id, row};
    }
    // One that nearly holds: with another value in one place.
    std::optional<Chosen> near_miss(std::int64_t tick) {
        std::optional<Chosen> out = fact(tick);
        if (!out) return out;
        Values& row = out->row;
        const std::size_t at = static_cast<std::size_t>(below(random_, static_cast<std::int64_t>(row.size())));
        const check::Type& type = program_.predicates[out->predicate].arguments[at].type;
        constexpr std::int64_t kSteps[] = {-2, -1, 1, 3};
        if (type == check::Type::Int)
            row[at] = value_of(row[at].integer() + kSteps[below(random_, 4)]);
        else if (type == check::Type::Float)
            row[at] = value_of(row[at].real() + 0.25 * static_cast<double>(kSteps[below(random_, 4)]));
        else if (type == check::Type::Bool)
            row[at] = value_of(!row[at].truth());
        else if (type == check::Type::Node && !past_.at(tick).scene.links.empty())
            row[at] = value_of(
                std::next(past_.at(tick).scene.links.begin(), below(random_, static_cast<std::int64_t>(past_.at(tick).scene.links.size())))
                    ->first);
        else
            return std::nullopt;
        const bool absurd = type == check::Type::Int && (row[at].integer() < -1'000'000'000 || row[at].integer() > 1'000'000'000);
        if (absurd || past_.holds(tick, out->predicate, row)) return std::nullopt;
        return out;
    }

  private:
    const Past& past_;
    const check::Program& program_;
    Random& random_;
};

std::vector<Inquiry> choose(const Past& past, Random& random, int count) {
    std::vector<Inquiry> out;
    for (int n = 0; n < count; ++n) {
        const std::int64_t tick = chance(random, 20) ? past.last() : below(random, past.last() + 1);
        Chooser chooser(past, random);
        if (const auto fact = chooser.fact(tick))
            out.push_back({.asked = {.fact = print(past.program(), fact->predicate, fact->row), .tick = tick, .all = chance(random, 30)}});
        if (const auto fact = chooser.near_miss(tick))
            out.push_back({.asked = {.fact = print(past.program(), fact->predicate, fact->row), .tick = tick, .depth = kWhyNotDepth},
                           .kind = Inquiry::Kind::WhyNot});
        if (n % 3 == 0) out.push_back({.asked = {.tick = tick}, .kind = Inquiry::Kind::Query});
    }
    std::ranges::stable_sort(out, {}, [](const Inquiry& i) { return i.asked.tick; });
    return out;
}

// ---- the runs

struct Run {
    Trial trial;  // On one clock.
    const ModuleInfo& module;
    world::World world;
    std::int64_t last;

    Run(const Trial& the_trial, const ModuleInfo& the_module)
        : trial(the_trial), module(the_module), last(last_tick(on_one_clock(the_trial.world))) {
        trial.world = on_one_clock(the_trial.world);
        world = make_world(trial.world);
    }
    std::unique_ptr<sim::Simulation> make(const world::Target& target, comm::Communicator& comm) const {
        auto out = std::make_unique<sim::Simulation>(module, world, target, comm, 1);
        out->add(std::make_unique<Schedule>(trial.world, trial.draft.given));
        return out;
    }
};

template <class T>
T or_throw(Result<T> result) {
    if (!result) throw std::runtime_error(result.error().message());
    if constexpr (!std::is_void_v<T>) return std::move(*result);
}

// The reference's answer to a query.
std::string compare(const Moment& moment, const ModuleInfo& module, const std::string& body, const inspect::Table& table) {
    const Result<inspect::Program> asked = inspect::Program::read(module, body);
    if (!asked) return asked.error().message();
    Scene scene = moment.scene;
    scene.program = &asked->checked();
    if (asked->checked().predicates.count() != moment.facts.size()) return "the question has predicates of its own";
    const Rows expected = answer(*asked, scene, moment.facts, moment.linear), rows = rows_of(table);
    if (rows == expected && rows.size() == table.rows()) return "";
    return fmt::format("{} rows instead of {}", table.rows(), expected.size());
}

void ask(timeline::Timeline& timeline, const Run& run, Inquiries& out, std::size_t i, bool speaks) {
    Inquiry& inquiry = out.all[i];
    const AskedFor& asked = inquiry.asked;
    or_throw(timeline.to(asked.tick));
    if (inquiry.kind == Inquiry::Kind::Query) {
        const Result<inspect::Table> table = inspect::query(timeline.simulation().subdomain(), asked.fact);
        if (!speaks) return;
        inquiry.trouble = table ? compare(out.past->at(asked.tick), run.module, asked.fact, *table) : table.error().message();
        if (table) out.rows += table->rows();
        return;
    }
    const bool why = inquiry.kind == Inquiry::Kind::Why;
    const inspect::WhyOptions options{.depth = asked.depth, .all = asked.all};
    const auto found = why ? inspect::why(timeline, asked.fact, options) : inspect::why_not(timeline, asked.fact, options);
    if (!speaks) return;
    if (found)
        inquiry.answer = found->to_json();
    else
        inquiry.error = found.error().message();
}

}  // namespace

Inquiries inquire(const Trial& trial, const check::Program& program, const ModuleInfo& module, int processes, int count) {
    const Run run(trial, module);
    const world::Target target = or_throw(world::Target::make(run.world, world::Lattice(run.world.lattice)));
    const sim::Registry registry = sim::Registry::standard();
    Inquiries out;
    const auto alone = comm::make_single();
    const auto simulation = run.make(target, *alone);
    or_throw(simulation->start(registry));
    out.past = std::make_unique<Past>(run.trial, program, *simulation, run.last);
    Random random(trial.world.seed);
    out.all = choose(*out.past, random, count);
    const std::optional<std::string> question = question_of(trial, program);
    if (!question) std::erase_if(out.all, [](const Inquiry& i) { return i.kind == Inquiry::Kind::Query; });
    for (Inquiry& i : out.all)
        if (i.kind == Inquiry::Kind::Query) i.asked.fact = *question;
    comm::run_threads_as_processes(processes, [&](comm::Communicator& comm) {
        // Without snapshots: what makes the changes of a trial begins at the start.
        timeline::Timeline timeline([&] { return run.make(target, comm); }, registry, {.limits = {run.last}, .history_bytes = 0});
        or_throw(timeline.start());
        for (std::size_t i = 0; i < out.all.size(); ++i) ask(timeline, run, out, i, comm.process() == 0);
    });
    return out;
}

std::string judge(const Past& past, const Inquiry& inquiry, Judged& judged) {
    if (!inquiry.error.empty()) return inquiry.error;
    if (inquiry.kind == Inquiry::Kind::Query) return inquiry.trouble;
    const Answer answer = read_answer(inquiry.answer);
    return inquiry.kind == Inquiry::Kind::Why ? judge_why(past, answer, inquiry.asked, judged)
                                              : judge_why_not(past, answer, inquiry.asked, judged);
}

void InquiryTally::add(const InquiryTally& other) {
    why += other.why;
    why_not += other.why_not;
    queries += other.queries;
    rows += other.rows;
    falsified += other.falsified;
    judged.add(other.judged);
}

std::string trouble_of_inquiries(const Trial& trial, const check::Program& program, const ModuleInfo& module, int processes, int count,
                                 InquiryTally& tally) {
    constexpr const char* kCommands[] = {"why", "why-not", "query"};
    const Inquiries inquiries = inquire(trial, program, module, processes, count);
    Random random(trial.world.seed);
    tally.rows += inquiries.rows;
    for (const Inquiry& i : inquiries.all) {
        const auto number = static_cast<std::size_t>(i.kind);
        ++*std::array{&tally.why, &tally.why_not, &tally.queries}[number];
        const std::string command = fmt::format("{} `{}` in tick {}{}, {} processes", kCommands[number], i.asked.fact, i.asked.tick,
                                                i.asked.all ? " with all" : "", processes);
        if (const std::string trouble = judge(*inquiries.past, i, tally.judged); !trouble.empty())
            return fmt::format("{}: {}: {}\n{}", kCommands[number], command, trouble, i.answer.dump(1));
        Inquiry false_one = i;
        const std::string how = falsify(random, false_one);
        if (how.empty()) continue;
        ++tally.falsified;
        Judged ignored;
        if (judge(*inquiries.past, false_one, ignored).empty())
            return fmt::format("not refused: {}: {}\n{}", command, how, false_one.answer.dump(1));
    }
    return "";
}

}  // namespace meld::reference
