// test_random: random programs in random worlds under random changes, compiled and run, beside the reference evaluator.
// Prints a failing trial made small, and the command that runs it again. docs/reference/design.md, "Tests".
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <sys/mman.h>

#include <atomic>
#include <chrono>
#include <fstream>
#include <new>
#include <sstream>

#include "tests/reference/answers/inquiry.h"
#include "tests/reference/programs/body.h"
#include "tests/reference/programs/generate.h"
#include "tests/reference/programs/shrink.h"
#include "tests/reference/trials/isolated.h"
#include "tests/reference/trials/run.h"
#include "tests/reference/trials/worlds.h"

namespace meld::reference {
namespace {

struct Options {
    std::uint64_t first = 1, seeds = 200, worlds = 3;
    double minutes = 0;          // 0: as long as it takes.
    int jobs = 1;                // Processes that work at once.
    std::uint64_t shipped = 10;  // One program in N is compiled as it is shipped, the others as quickly as can be.
    int shrink_attempts = 3000;
    std::string out = "random_failures";
    std::string replay, show;
    bool keep_going = false;
    bool failures = false;         // Links are cut, catoms hang and restart.
    bool networks = false;         // Under networks and clocks that follow from the seeds.
    bool graphs = false;           // In graphs instead of lattices.
    bool variants = false;         // Beside other programs that say the same.
    bool disturbed = false;        // Every world is also run with kills and stops.
    std::uint64_t conditions = 0;  // For a trial that is run again.
    int why = 0;                   // Ask so many times at random ticks, instead of comparing the run.
};

// All settings a trial is run in besides the plain one; each trial of a seed takes another few of them.
const std::vector<Setting> kSettings = {{1, 2},
                                        {2, 1},
                                        {3, 1},
                                        {.unseen = true},
                                        {.processes = 3, .unseen = true},
                                        {.threads = 2, .unseen = true},
                                        {4, 1},
                                        {2, 2},
                                        {3, 2},
                                        {4, 2},
                                        {.processes = 2, .threads = 2, .unseen = true}};

// The same, and some runs that are killed and stopped, for a trial whose failure is looked for.
std::vector<Setting> all_settings() {
    std::vector<Setting> all = kSettings;
    for (std::uint64_t n = 1; n <= 6; ++n) all.push_back({.disturbance = n});
    return all;
}

Suits suits_of(std::uint64_t seed, const Options& options) {
    return !options.graphs ? Suits::Lattices : options.variants && seed % 2 == 0 ? Suits::Nameless : Suits::Graphs;
}

// What is written in another way in a world of a program.
Variation variation_of(std::uint64_t seed, const Options& options) {
    retraction::Random random(seed);
    Variation v{.reordered = chance(random, 60),
                .redundant = chance(random, 50),
                .split = chance(random, 50),
                .renamed = chance(random, 50),
                .permuted = suits_of(seed, options) == Suits::Nameless};
    v.reordered = v.reordered || !(v.redundant || v.split || v.renamed || v.permuted);
    return v;
}

// The first words of a trouble say its kind; a smaller trial must show the same.
std::string kind_of(const std::string& trouble) {
    return trouble.substr(0, trouble.find_first_of(trouble.starts_with("refused") ? "]\n" : ":\n"));
}

Generated program_of(std::uint64_t seed, const Options& options) {
    Generated made = make_program(seed, suits_of(seed, options), !options.variants);
    if (options.variants) made.draft = views_of(made.draft);
    return made;
}

Trial trial_of(const Draft& draft, std::uint64_t seed, std::uint64_t world, const Options& options) {
    const std::uint64_t number = seed * 1000 + world;
    Trial trial{draft, options.graphs ? retraction::make_graph_case(number, draft.given, max_degree(draft))
                                      : retraction::make_case(number, draft.given)};
    if (options.failures) retraction::add_failures(trial.world, draft.given);
    return trial;
}

struct Verdict {
    std::string trouble = {};
    Trial trial = {};
    Tally tally = {};
    InquiryTally asked = {};
    std::uint64_t tried = 0, kept = 0, rules = 0;
};

// Worlds of one program are asked on so many processes, one after the other.
int processes_of(std::uint64_t seed) { return 1 + static_cast<int>((seed / 1000 + seed % 1000) % 4); }

// The conditions of a world, by its seed.
std::uint64_t conditions_of(std::uint64_t seed, const Options& options) {
    if (options.conditions != 0) return options.conditions;
    return options.networks || (options.failures && seed % 2 == 1) ? seed : 0;
}

// A variant of a trial, beside it.
std::string trouble_of_variant(const Trial& trial, const Outcome& alone, const check::Program& program, Workshop& workshop,
                               const Options& options, Tally& tally) {
    const std::uint64_t seed = trial.world.seed;
    const Variation variation = variation_of(seed / 1000, options);
    return trouble_of_variant(alone, program, vary(trial, program, variation, seed), variation, workshop, conditions_of(seed, options),
                              tally);
}

// One seed: a program, and several worlds.
Verdict examine(std::uint64_t seed, const Options& options, Workshop& workshop) {
    Verdict v;
    const Generated made = program_of(seed, options);
    v.tried = made.tried;
    v.kept = made.kept;
    v.rules = made.draft.rules.size();
    v.trial = trial_of(made.draft, seed, 0, options);
    if (!made.refused.empty()) {
        v.trouble = "refused: " + made.refused;
        return v;
    }
    const std::string text = print(made.draft);
    const Result<check::Program> program = checked(text);
    const Result<Module> module = workshop.module(text, options.networks || options.failures || options.graphs);
    if (!module) {
        v.trouble = "not compiled: " + module.error().message();
        return v;
    }
    for (std::uint64_t w = 0; w < options.worlds; ++w) {
        v.trial = trial_of(made.draft, seed, w, options);
        if (options.why > 0) {
            v.trouble = trouble_of_inquiries(v.trial, *program, info_of(*module), processes_of(v.trial.world.seed), options.why, v.asked);
            if (v.trouble.empty()) continue;
            return v;
        }
        const std::uint64_t conditions = conditions_of(v.trial.world.seed, options);
        const Outcome alone = run(v.trial, *program, info_of(*module), {.conditions = conditions}, Watch::Reference);
        v.tally.add(alone.tally);
        v.trouble = alone.trouble;
        if (options.variants && w == 0 && v.trouble.empty())
            v.trouble = trouble_of_variant(v.trial, alone, *program, workshop, options, v.tally);
        std::vector<Setting> settings;
        for (std::size_t i = w % 3; i < kSettings.size(); i += 3) settings.push_back(kSettings[i]);
        if (options.disturbed || w % 3 == 2) settings.push_back({.disturbance = v.trial.world.seed});
        for (Setting setting : settings) {
            if (!v.trouble.empty()) break;
            setting.conditions = conditions;
            v.trouble = trouble_of_setting(alone, v.trial, *program, info_of(*module), setting, v.tally);
        }
        if (!v.trouble.empty()) return v;
    }
    return v;
}

Level level_of(std::uint64_t seed, const Options& options) {
    return options.shipped > 0 && seed % options.shipped == 0 ? Level::Shipped : Level::Quick;
}

// A verdict as text, out of a child process and into its parent. The trial is made again from seed and world.
std::string encode(const Verdict& v) {
    const Tally& t = v.tally;
    const InquiryTally& a = v.asked;
    const Judged& j = a.judged;
    return fmt::format("{} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {} {}\n{}", v.tried, v.kept,
                       v.rules, v.trial.world.seed % 1000, t.facts, t.tick_facts, t.lost, t.linear, t.quiet, t.ticks, t.undefined, t.errors,
                       t.questions, t.rows, t.told, t.too_large, t.stopped, t.varied, a.why, a.why_not, a.queries, a.rows, a.falsified,
                       j.nodes, j.ways, j.parts, j.unranked, j.unknown, j.combined, j.made, j.quarantines, v.trouble);
}
Verdict decode(const std::string& text, std::uint64_t seed, const Options& options) {
    Verdict v;
    std::istringstream in(text);
    std::uint64_t world = 0;
    Tally& t = v.tally;
    InquiryTally& a = v.asked;
    Judged& j = a.judged;
    if (text.starts_with("crash") || !(in >> v.tried >> v.kept >> v.rules >> world >> t.facts >> t.tick_facts >> t.lost >> t.linear >>
                                       t.quiet >> t.ticks >> t.undefined >> t.errors >> t.questions >> t.rows >> t.told >> t.too_large >>
                                       t.stopped >> t.varied >> a.why >> a.why_not >> a.queries >> a.rows >> a.falsified >> j.nodes >>
                                       j.ways >> j.parts >> j.unranked >> j.unknown >> j.combined >> j.made >> j.quarantines))
        v.trouble = text;
    else
        v.trouble = text.substr(text.find('\n') + 1);
    if (!v.trouble.empty()) v.trial = trial_of(program_of(seed, options).draft, seed, world, options);
    return v;
}

std::string trouble_of_variant(const Trial& trial, Workshop& workshop, const Options& options) {
    const std::string text = print(trial.draft);
    const Result<check::Program> program = checked(text);
    if (!program) return "refused: " + program.error().message();
    const std::uint64_t conditions = conditions_of(trial.world.seed, options);
    const Result<Module> module = workshop.module(text, by_links(trial, conditions));
    if (!module) return "not compiled: " + module.error().message();
    const Outcome alone = run(trial, *program, info_of(*module), {.conditions = conditions}, Watch::Reference);
    Tally ignored;
    return alone.trouble.empty() ? trouble_of_variant(trial, alone, *program, workshop, options, ignored) : alone.trouble;
}

// What the trial shows, in the way that the options ask for.
std::string trouble_of(const Trial& trial, Workshop& workshop, const std::vector<Setting>& settings, const Options& options) {
    if (options.variants) return trouble_of_variant(trial, workshop, options);
    if (options.why == 0) return trouble_of(trial, workshop, settings, conditions_of(trial.world.seed, options));
    const std::string text = print(trial.draft);
    const Result<check::Program> program = checked(text);
    if (!program) return "refused: " + program.error().message();
    const Result<Module> module = workshop.module(text);
    if (!module) return "not compiled: " + module.error().message();
    InquiryTally ignored;
    return trouble_of_inquiries(trial, *program, info_of(*module), processes_of(trial.world.seed), options.why, ignored);
}

Trial make_small(const Trial& trial, const std::string& trouble, const Options& options, Workshop& workshop) {
    const std::string kind = kind_of(trouble);
    std::vector<Setting> settings;
    if (kind == "states differ" || kind == "answers differ" || kind == "crash") settings = all_settings();
    return shrink(
        trial,
        [&](const Trial& less) { return kind_of(isolated([&] { return trouble_of(less, workshop, settings, options); }, 30)) == kind; },
        options.shrink_attempts);
}

void report(const Verdict& v, std::uint64_t seed, const Options& options, Workshop& workshop) {
    fmt::print("seed {}: {}\n", seed, v.trouble);
    std::fflush(stdout);
    const Trial small = make_small(v.trial, v.trouble, options, workshop);
    const std::string text = print(small), now = isolated([&] { return trouble_of(small, workshop, all_settings(), options); }, 60);
    std::filesystem::create_directories(options.out);
    const std::string path = fmt::format("{}/seed_{}.meld", options.out, seed);
    std::ofstream(path) << text;
    const std::uint64_t conditions = conditions_of(v.trial.world.seed, options);
    fmt::print("made small, with {}:\n\n{}\n{}\nRun it again: test_random --replay {}{}{}{}\n\n", describe_conditions(conditions), text,
               now, path, conditions == 0 ? "" : fmt::format(" --conditions {}", conditions), options.variants ? " --variants" : "",
               options.variants && options.graphs ? " --graphs" : "");
    std::fflush(stdout);
}

int replay(const Options& options) {
    std::ifstream in(options.replay);
    std::stringstream text;
    text << in.rdbuf();
    const Result<Trial> trial = parse_trial(text.str());
    if (!in || !trial) {
        fmt::print(stderr, "{}: {}\n", options.replay, trial ? "cannot be read" : trial.error().message());
        return 2;
    }
    std::string trouble;
    for (const Level level : {Level::Shipped, Level::Quick}) {
        Workshop workshop(level);
        if (trouble.empty()) trouble = isolated([&] { return trouble_of(*trial, workshop, all_settings(), options); });
    }
    fmt::print("{}\n", trouble.empty() ? "no difference" : trouble);
    return trouble.empty() ? 0 : 1;
}

// What all jobs together have done.
struct Sum {
    Tally tally = {};
    InquiryTally asked = {};
    std::uint64_t done = 0, failures = 0, tried = 0, kept = 0, rules = 0;
    void add(const Sum& other) {
        tally.add(other.tally);
        asked.add(other.asked);
        done += other.done;
        failures += other.failures;
        tried += other.tried;
        kept += other.kept;
        rules += other.rules;
    }
};
// Out of a job into its parent.
std::string encode(const Sum& s) {
    return fmt::format("{} {} {}", s.done, s.failures,
                       encode(Verdict{.tally = s.tally, .asked = s.asked, .tried = s.tried, .kept = s.kept, .rules = s.rules}));
}
Sum decode(const std::string& text) {
    Sum s;
    std::istringstream in(text);
    if (text.starts_with("crash") || !(in >> s.done >> s.failures)) return {.failures = 1};
    std::string rest;
    std::getline(in, rest);
    const Verdict v = decode(rest + "\n", 0, {});
    s.tally = v.tally;
    s.asked = v.asked;
    s.tried = v.tried;
    s.kept = v.kept;
    s.rules = v.rules;
    return s;
}

// Takes seeds, as long as there are some, each in a process of its own.
Sum work(const Options& options, std::atomic<std::uint64_t>& next) {
    const auto start = std::chrono::steady_clock::now();
    const auto minutes = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / 60; };
    Workshop workshop;
    // What is loaded here need not be loaded by every child.
    static_cast<void>(workshop.module("type p(node).\np(A) :- id(A, 0).\n"));
    Sum sum;
    while (options.minutes == 0 || minutes() < options.minutes) {
        const std::uint64_t number = next++;
        if (number >= options.seeds) break;
        const std::uint64_t seed = options.first + number;
        workshop.level = level_of(seed, options);
        const Verdict v = decode(isolated([&] { return encode(examine(seed, options, workshop)); }), seed, options);
        sum.add({.tally = v.tally,
                 .asked = v.asked,
                 .done = 1,
                 .failures = !v.trouble.empty(),
                 .tried = v.tried,
                 .kept = v.kept,
                 .rules = v.rules});
        if (v.trouble.empty()) continue;
        if (!options.keep_going) next = options.seeds;
        report(v, seed, options, workshop);
    }
    return sum;
}

int tell_asked(const Sum& sum, const Options& options) {
    const InquiryTally& a = sum.asked;
    const Judged& j = a.judged;
    fmt::print(
        "{} programs with {} rules, {} worlds each, on 1 to 4 processes, at random ticks: {} facts explained, and why {} others do not "
        "hold: "
        "{} facts of answers judged, {} ways and {} parts; {} combined, {} made by linear rules, {} quarantines; ranks did not say what "
        "{} rest on; {} rest on what no state tells; {} falsified answers were refused; {} queries answered with {} rows; {} failures\n",
        sum.done, sum.rules, options.worlds, a.why, a.why_not, j.nodes, j.ways, j.parts, j.combined, j.made, j.quarantines, j.unranked,
        j.unknown, a.falsified, a.queries, a.rows, sum.failures);
    // Only where a rule of a recursion asks for a value beyond a bound.
    const bool too_often = j.unranked * 100 > j.nodes;
    if (too_often) fmt::print("ranks should nearly always say what a fact rests on\n");
    return sum.failures > 0 || too_often;
}

int run_seeds(const Options& options) {
    void* const shared = mmap(nullptr, sizeof(std::atomic<std::uint64_t>), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (shared == MAP_FAILED) return 2;
    auto& next = *new (shared) std::atomic<std::uint64_t>(0);
    std::vector<Child> jobs;
    for (int j = 0; j < options.jobs; ++j) jobs.emplace_back([&] { return encode(work(options, next)); }, 0);
    Sum sum;
    for (Child& job : jobs) {
        const std::string answer = job.answer();
        if (answer.starts_with("crash")) fmt::print("{}\n", answer);
        sum.add(decode(answer));
    }
    if (options.why > 0) return tell_asked(sum, options);
    const Tally& t = sum.tally;
    fmt::print(
        "{} programs with {} rules ({} of {} blocks kept), {} worlds each: {} bursts came to rest, {} facts compared, {} of them lost "
        "later; {} ticks, {} facts compared tick by tick; {} given by linear rules; derivations had no value in {} ticks, and at the end "
        "of {} bursts, as they should; {} questions answered with {} rows, and {} lines told of them by watches; {} runs were "
        "killed or stopped and went on; {} facts of variants compared; {} were too large; {} failures\n",
        sum.done, sum.rules, sum.kept, sum.tried, options.worlds, t.quiet, t.facts, t.lost, t.ticks, t.tick_facts, t.linear, t.undefined,
        t.errors, t.questions, t.rows, t.told, t.stopped, t.varied, t.too_large, sum.failures);
    return sum.failures > 0;
}

int show(std::uint64_t seed, const Options& options) {
    fmt::print("{}", print(trial_of(program_of(seed, options).draft, seed, 0, options)));
    return 0;
}

int main(int argc, char** argv) {
    Options options;
    CLI::App app("Random programs against the reference evaluator");
    std::uint64_t shown = 0;
    app.add_option("--first", options.first, "The first seed");
    app.add_option("--seeds", options.seeds, "How many");
    app.add_option("--worlds", options.worlds, "Worlds for each program");
    app.add_option("--minutes", options.minutes, "Stop after this many");
    app.add_option("--jobs", options.jobs, "Processes that work at once")->check(CLI::Range(1, 256));
    app.add_option("--shipped", options.shipped, "Compile one program in N at the level of meldc, the others at -O0; 0: none");
    app.add_option("--out", options.out, "Where failing trials are written");
    app.add_option("--replay", options.replay, "Run a written trial again");
    app.add_option("--show", shown, "Print the trial of a seed");
    app.add_option("--shrink-attempts", options.shrink_attempts, "How long to look for a smaller trial");
    app.add_option("--why", options.why, "Ask each run N times at random ticks why facts hold and why not, and judge the answers");
    app.add_flag("--networks", options.networks, "Run under networks that take time and clocks that pause, which follow from the seeds");
    app.add_flag("--graphs", options.graphs, "Run in graphs, whose nodes are killed and whose links are cut, healed and joined");
    app.add_flag("--variants", options.variants,
                 "Only views: compare each program with one that says the same in another order, by more rules, under other names, and in "
                 "graphs every other one with nodes numbered otherwise");
    app.add_flag("--disturbed", options.disturbed, "Also kill and stop runs in every world, instead of in every third");
    app.add_flag("--failures", options.failures,
                 "Links are cut and healed, catoms hang and restart; every other world has a network or clock, and some have jams");
    app.add_option("--conditions", options.conditions, "With --replay: the network and clock of this number");
    app.add_flag("--keep-going", options.keep_going, "Do not stop at the first failure");
    CLI11_PARSE(app, argc, argv);
    if (shown != 0) return show(shown, options);
    return options.replay.empty() ? run_seeds(options) : replay(options);
}

}  // namespace
}  // namespace meld::reference

int main(int argc, char** argv) { return meld::reference::main(argc, argv); }
