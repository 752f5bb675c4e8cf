// The tester itself: that it notices what is wrong, makes it small, and reads what it has written.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <set>
#include <string_view>

#include "tests/reference/answers/inquiry.h"
#include "tests/reference/evaluator/model.h"
#include "tests/reference/programs/generate.h"
#include "tests/reference/programs/shrink.h"
#include "tests/reference/trials/isolated.h"
#include "tests/reference/trials/run.h"

namespace meld::reference {
namespace {

retraction::Given source() { return {.predicate = "source", .arguments = {{0, 5}}, .per_mille = 200}; }

constexpr const char* kProgram = R"(
type source(node, int).
type dist(node, min int).
type near(node, node).
type many(node, sum int).
type far(node).
type linear walker(node, int).
type seen(node, int).
dist(A, X) :- source(A, X).
dist(B, D + 1) :- neighbor(A, B), dist(A, D).
near(A, B) :- neighbor(A, B), dist(A, D), dist(B, D).
many(A, D) :- neighbor(A, B), neighbor(B, C), dist(C, D).
far(A) :- id(A, _), not (neighbor(A, B), dist(B, D), D < 3).
walker(@0, 2).
walker(A, N), N > 0 -o seen(A, N), { B | neighbor(A, B) | walker(B, N - 1) }.
walker(A, 0) -o seen(A, 0).
)";

// What rules may do beside that.
constexpr const char* kMoreProgram = R"(
type source(node, int).
type near(node, sum int).
type late(node, int).
type slow(node, sum int).
type risen(node, int).
type linear coin(node, int).
type linear purse(node, int, list int).
type linear watch(node).
type spent(node, int).
type much(node).
type told(node, int).
type ticket(node, node).
near(A, X) :- neighbor(A, B), source(B, X).
late(A, N)@+2 :- near(A, N), C = count : { neighbor(A, _) }, C < 4.
slow(A, X)@+2 :- source(A, X), delta(N; source(A, N)) < 1, C = count : { neighbor(A, B), source(B, _) }, C >= 0.
risen(A, X) :- source(A, X), delta(N; near(A, N)) < 1.
coin(A, 1). coin(A, 2). coin(A, 3). coin(A, 4).
purse(A, 0, []).
watch(A).
watch(A), delta(N; near(A, N)) > 0 -o told(A, N), watch(A)@+1.
purse(A, S, [X | _]), S > 3, neighbor(A, B), neighbor(B, C) -o
    told(C, S * X + randint(3))@+3, [sum => T, count => K | | coin(A, T) | told(A, T * K)], exists V. (ticket(A, V)).
[desc => N | coin(A, N), source(A, X), purse(A, S, L)] -o spent(A, N), (if N > 1 then purse(A, S + N, [N | L]) otherwise much(A) end).
)";

std::string replaced(std::string text, const std::string& what, const std::string& with) {
    const std::size_t at = text.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return text.replace(at, what.size(), with);
}

// What the runtime runs differs from what the reference knows: that must show.
void expect_noticed(const char* original, const std::vector<std::pair<std::string, std::string>>& changes);

TEST(Tester, NoticesOtherPrograms) {
    expect_noticed(kProgram, {{"D + 1", "D + 2"},
                              {"dist(B, D).", "dist(B, _)."},
                              {"sum int", "max int"},
                              {"not (neighbor(A, B), dist(B, D), D < 3)", "not (neighbor(A, B), dist(B, D), D < 2)"},
                              {"N - 1", "N - 2"},
                              {"walker(A, 0) -o", "walker(A, 1) -o"},
                              {"min int", "max int"}});
    expect_noticed(kMoreProgram, {{"@+2", "@+3"},
                                  {"source(A, N)) < 1", "source(A, N)) < 0"},
                                  {"near(A, N)) < 1", "near(A, N)) < 0"},
                                  {"desc", "asc"},
                                  {"if N > 1", "if N > 2"},
                                  {"> 0 -o", "> 9 -o"},
                                  {"told(C", "told(B"},
                                  {"randint(3))@+3", "randint(3))@+6"},
                                  {"randint(3)", "0"},
                                  {"sum => T", "max => T"},
                                  {"[N | L]", "[7 | L]"},
                                  {"exists V. (ticket(A, V))", "1"}});
}

void expect_noticed(const char* original, const std::vector<std::pair<std::string, std::string>>& changes) {
    Workshop workshop(Level::Quick);
    const Result<check::Program> program = checked(original);
    ASSERT_TRUE(program) << program.error().message();
    for (const auto& [what, with] : changes) {
        // A value that holds itself up grows for ever as a maximum.
        const std::string text =
            what == "min int" ? replaced(replaced(original, what, with), "D + 1", "D - 1") : replaced(original, what, with);
        const Result<Module> module = workshop.module(text);
        ASSERT_TRUE(module) << module.error().message();
        int noticed = 0;
        for (std::uint64_t seed = 1; seed <= 5; ++seed) {
            const Trial trial{{.declarations = {}, .rules = {}, .text = text, .given = {source()}},
                              retraction::make_case(seed, {source()})};
            noticed += !run(trial, *program, info_of(*module), {}, Watch::Reference).trouble.empty();
        }
        EXPECT_GE(noticed, 3) << what << " for " << with;
    }
}

TEST(Tester, FindsNoDifferenceWhereThereIsNone) {
    Workshop workshop;
    for (const char* program : {kProgram, kMoreProgram})
        for (std::uint64_t seed = 1; seed <= 3; ++seed) {
            const Trial trial{{.declarations = {}, .rules = {}, .text = program, .given = {source()}},
                              retraction::make_case(seed, {source()})};
            EXPECT_EQ(trouble_of(trial, workshop, {{3, 1}, {2, 2}}), "");
        }
}

// A program that seems the same and is not: that must show, too.
TEST(Variants, ThatAreOtherProgramsDiffer) {
    Workshop workshop(Level::Quick);
    const std::string text =
        "type source(node, int).\ntype dist(node, min int).\ntype near(node, node).\ndist(A, X) :- source(A, X).\n"
        "dist(B, D + 1) :- neighbor(A, B), dist(A, D).\nnear(A, B) :- neighbor(A, B), dist(A, D), dist(B, D).\n";
    const Result<check::Program> program = checked(text);
    const Result<Module> module = workshop.module(text, true);
    ASSERT_TRUE(program && module);
    const Draft draft{.declarations = {}, .rules = {}, .text = text, .given = {source()}};
    int noticed = 0;
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        const Trial trial{draft, retraction::make_graph_case(seed, draft.given, 20)};
        const Outcome alone = run(trial, *program, info_of(*module), {}, Watch::Reference);
        ASSERT_EQ(alone.trouble, "");
        Tally tally;
        Varied varied{.trial = trial};
        EXPECT_EQ(trouble_of_variant(alone, *program, varied, {}, workshop, 0, tally), "");
        EXPECT_GT(tally.varied, 0u);
        varied.trial.draft.text = replaced(text, "D + 1", "D + 2");
        noticed += trouble_of_variant(alone, *program, varied, {}, workshop, 0, tally).starts_with("variant differs");
    }
    EXPECT_GE(noticed, 3);
}

TEST(Variants, KeepWhatTheySay) {
    const Draft draft{.declarations = {{"g", "type g(node, int)."}, {"p", "type p(node, int)."}, {"q", "type q(node, int)."}},
                      .rules = {{.heads = {"p(A, X1 + 1)"}, .body = {"neighbor(A, B)", "g(B, X1)", "X1 > 1"}},
                                {.heads = {"q(A, X1)"}, .body = {"p(A, X1)", "not g(A, X1)"}}},
                      .text = {},
                      .given = {{.predicate = "g", .arguments = {{0, 5}}, .per_mille = 500}}};
    const Result<check::Program> program = checked(print(draft));
    ASSERT_TRUE(program) << program.error().message();
    Trial trial{draft, {}};
    for (std::uint64_t seed = 1; trial.world.links.size() < 20; ++seed) trial.world = retraction::make_graph_case(seed, draft.given, 20);
    const Varied varied = vary(trial, *program, {true, true, true, true, true}, 3);
    EXPECT_TRUE(checked(print(varied.trial.draft))) << print(varied.trial.draft);
    const std::string text = print(varied.trial.draft);
    EXPECT_GT(varied.trial.draft.rules.size(), 2u) << text;
    EXPECT_EQ(text.find("p(A"), std::string::npos) << text;
    EXPECT_NE(text.find("% "), std::string::npos) << text;
    EXPECT_EQ(varied.trial.world.links.size(), trial.world.links.size());
    EXPECT_NE(varied.trial.world.links, trial.world.links);
    Workshop workshop(Level::Quick);
    const Result<Module> module = workshop.module(print(draft), true);
    ASSERT_TRUE(module);
    const Outcome alone = run(trial, *program, info_of(*module), {}, Watch::Reference);
    Tally tally;
    EXPECT_EQ(trouble_of_variant(alone, *program, varied, {}, workshop, 0, tally), "");
    EXPECT_GT(tally.varied, 10u);
    // Nodes that have not got their numbers.
    Varied wrong = varied;
    wrong.numbers.clear();
    EXPECT_NE(trouble_of_variant(alone, *program, wrong, {}, workshop, 0, tally), "");
}

TEST(Disturbance, GoesOnAsIfNothingHadHappened) {
    Workshop workshop(Level::Quick);
    const Result<check::Program> program = checked(kProgram);
    const Result<Module> module = workshop.module(kProgram, true);
    ASSERT_TRUE(program && module);
    Tally tally;
    const std::vector<retraction::Given> given{source()};
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        const Trial trial{{.declarations = {}, .rules = {}, .text = kProgram, .given = given},
                          retraction::make_graph_case(seed, given, 20)};
        const Outcome alone = run(trial, *program, info_of(*module), {}, Watch::Reference);
        ASSERT_EQ(alone.trouble, "");
        EXPECT_EQ(trouble_of_setting(alone, trial, *program, info_of(*module), {.disturbance = seed}, tally), "");
    }
    EXPECT_GT(tally.stopped, 6u);
}

TEST(Judge, AcceptsAnswersAndRefusesFalsifiedOnes) {
    Workshop workshop;
    for (const char* text : {kProgram, kMoreProgram}) {
        const Result<check::Program> program = checked(text);
        const Result<Module> module = workshop.module(text);
        ASSERT_TRUE(program && module);
        InquiryTally tally;
        for (const int processes : {1, 2, 3, 4}) {
            const Trial trial{{.declarations = {}, .rules = {}, .text = text, .given = {source()}},
                              retraction::make_case(static_cast<std::uint64_t>(processes), {source()})};
            EXPECT_EQ(trouble_of_inquiries(trial, *program, info_of(*module), processes, 8, tally), "");
        }
        EXPECT_GT(tally.falsified, 20u);
        EXPECT_GT(tally.judged.combined, 0u);
        EXPECT_GT(tally.judged.made, 0u);
    }
}

// Judges an answer, and refuses it if what it says beside a part that fails is another thing. Returns how many such notes it has.
std::size_t judged_notes(const Past& past, const Inquiry& inquiry, const char* body) {
    Judged judged;
    EXPECT_EQ(judge(past, inquiry, judged), "") << body << ": " << inquiry.asked.fact << "\n" << inquiry.answer.dump(1);
    if (inquiry.kind != Inquiry::Kind::WhyNot || inquiry.answer["nodes"].empty()) return 0;
    std::size_t notes = 0;
    const auto& ways = inquiry.answer["nodes"][0]["ways"];
    for (std::size_t way = 0; way < ways.size(); ++way) {
        if (ways[way]["parts"].empty() || !ways[way]["parts"].back().contains("note")) continue;
        ++notes;
        const std::string note = ways[way]["parts"].back()["note"];
        for (const std::string& other : {std::string(), note + " too", "near(@0, 99) holds, and " + note}) {
            Inquiry changed = inquiry;
            changed.answer["nodes"][0]["ways"][way]["parts"].back()["note"] = other;
            EXPECT_NE(judge(past, changed, judged), "") << body << ": " << other << " for " << note;
        }
    }
    return notes;
}

// Parts of bodies within parts: whatever of them fails, the answer says so.
TEST(Judge, AcceptsAnswersAboutPartsWithinParts) {
    constexpr const char* kBodies[] = {
        "forall neighbor(A, B) [dist(B, 1)]",
        "forall neighbor(A, B) [dist(B, D), D > 1]",
        "forall neighbor(A, B) [dist(B, D), D < 2, near(B, D)]",
        "forall neighbor(A, B) [dist(B, D), not near(B, D)]",
        "forall neighbor(A, B) [not dist(B, 2)]",
        "forall dist(A, D) [D > 2]",
        "not (neighbor(A, B), dist(B, D), E = D + 1, not dist(A, E))",
        "not (neighbor(A, B), dist(B, D), not (E = D + 1, near(A, E)))",
        "not (neighbor(A, B), not near(B, _), not dist(B, 1))",
        "forall neighbor(A, B) [forall near(B, D) [dist(B, D), D < 2]]",
        "forall neighbor(A, B) [N = count : { near(B, _) }, N > 2]",
        "not (D in [1, 2], D < 2, not dist(A, D))",
    };
    Workshop workshop;
    for (const char* body : kBodies) {
        std::string text =
            "type source(node, int).\ntype dist(node, min int).\ntype near(node, int).\ntype all(node).\n"
            "dist(A, X) :- source(A, X).\ndist(B, D + 1) :- neighbor(A, B), dist(A, D).\nnear(B, D) :- neighbor(A, B), dist(A, D).\n";
        text += fmt::format("all(A) :- id(A, _), {}.\n", body);
        const Result<check::Program> program = checked(text.c_str());
        const Result<Module> module = workshop.module(text.c_str());
        ASSERT_TRUE(program && module) << body;
        std::size_t notes = 0;
        for (std::uint64_t world = 1; world <= 20 && notes < 5; ++world) {
            const Trial trial{{.declarations = {}, .rules = {}, .text = text, .given = {source()}},
                              retraction::make_case(world, {source()})};
            const Inquiries inquiries = inquire(trial, *program, info_of(*module), 1 + static_cast<int>(world % 2), 20);
            for (const Inquiry& i : inquiries.all) notes += judged_notes(*inquiries.past, i, body);
        }
        EXPECT_GE(notes, 5u) << body;
    }
}

// One answer, falsified in many ways: whichever it is, it is noticed.
TEST(Judge, NoticesEveryWayToFalsify) {
    Workshop workshop;
    const Result<check::Program> program = checked(kProgram);
    const Result<Module> module = workshop.module(kProgram);
    ASSERT_TRUE(program && module);
    const Trial trial{{.declarations = {}, .rules = {}, .text = kProgram, .given = {source()}}, retraction::make_case(3, {source()})};
    const Inquiries inquiries = inquire(trial, *program, info_of(*module), 1, 6);
    retraction::Random random(1);
    std::set<std::string> kinds;
    for (const Inquiry& i : inquiries.all)
        for (int n = 0; n < 40; ++n) {
            Inquiry changed = i;
            const std::string how = falsify(random, changed);
            if (how.empty()) continue;
            kinds.insert(how.substr(0, how.find(' ')));
            Judged ignored;
            EXPECT_NE(judge(*inquiries.past, changed, ignored), "") << i.asked.fact << ": " << how << "\n" << changed.answer.dump(1);
        }
    for (const char* kind : {"without", "another", "line", "the", "rank"}) EXPECT_TRUE(kinds.contains(kind)) << kind;
}

TEST(Tester, SaysWhatDoesNotCompile) {
    Workshop workshop;
    const Trial trial{{.declarations = {}, .rules = {}, .text = "type p(node).\np(A) :- q(A).\n", .given = {}},
                      retraction::make_case(1, {source()})};
    EXPECT_TRUE(trouble_of(trial, workshop, {}).starts_with("refused: ")) << trouble_of(trial, workshop, {});
}

TEST(Isolated, ReturnsWhatIsSaidAndWhatGoesWrong) {
    EXPECT_EQ(isolated([] { return std::string("fine\nindeed"); }), "fine\nindeed");
    const std::string ended = isolated([]() -> std::string { std::_Exit(70); });
    EXPECT_TRUE(ended.starts_with("crash: exit code 70")) << ended;
    const std::string endless = isolated(
        []() -> std::string {
            for (;;) pause();
        },
        1);
    EXPECT_TRUE(endless.starts_with("crash: took longer than 1 s")) << endless;
}

TEST(Shrinker, KeepsWhatTheFailureNeeds) {
    const Generated made = make_program(11);
    Trial trial{made.draft, retraction::make_case(11, made.draft.given)};
    ASSERT_GT(trial.draft.rules.size(), 2u);
    const std::string rule = print(trial.draft.rules[1]);
    const auto fails = [&](const Trial& t) {
        const bool rules = std::any_of(t.draft.rules.begin(), t.draft.rules.end(), [&](const DraftRule& r) { return print(r) == rule; });
        return rules && t.world.cells.size() >= 2 && !t.world.bursts[0].empty();
    };
    const Trial small = shrink(trial, fails, 5000);
    EXPECT_EQ(small.draft.rules.size(), 1u);
    EXPECT_TRUE(small.draft.declarations.empty());
    EXPECT_EQ(small.world.cells.size(), 2u);
    EXPECT_EQ(small.world.bursts.size(), 1u);
    EXPECT_EQ(small.world.bursts[0].size(), 1u);
}

TEST(TrialFile, ReadsWhatItWrote) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        const Generated made = make_program(seed);
        const Trial trial{made.draft, seed % 2 == 0 ? retraction::make_case(seed, made.draft.given)
                                                    : retraction::make_graph_case(seed, made.draft.given, 20)};
        const Result<Trial> read = parse_trial(print(trial));
        ASSERT_TRUE(read) << read.error().message();
        // Empty lines before the changes are the only thing that grows.
        EXPECT_EQ(print(*read), replaced(print(trial), "\n//: seed", "\n\n//: seed"));
    }
    EXPECT_FALSE(parse_trial("type p(node).\n"));
    EXPECT_FALSE(parse_trial("type p(node).\n//: catom 0,0\n//: burst\n"));
    EXPECT_FALSE(parse_trial("type p(node).\n//: catom 0,0,0\n//: burst\n//: 3 jump 0,0,0\n"));
    EXPECT_FALSE(parse_trial("type p(node).\n//: lattice graph\n//: catom 0,0,0\n//: link 0 1\n//: burst\n"));
}

// Every rule has results on the sample, and the programs are not all alike.
TEST(Generator, MakesProgramsOfAllConstructs) {
    std::set<std::string_view> missing{
        "not ",      "not (neighbor",  "forall ",       "min int",        "max int",   "sum int",     "sum float",     "count int",
        "first ",    "route ",         " -o ",          "{ Y | neighbor", "$t",        "% 7",         "if ",           "float(",
        "const k0",  "neighborCount(", "position(",     "vacant(",        ", @",       "linear t",    "[desc => ",     "[random => ",
        "[sum => ",  "custom mixed",   "exists V",      "otherwise",      "@+2",       "@+3ms",       "delta(",        "proved(",
        "collect G", "randint(",       "list int",      " in L",          "folded(",   "append list", "set_union set", "[<- ",
        "[-> ",      "stable(",        "undelivered-t", "route w",        "distance(", "vec3(",       "M - D",         "lnth("};
    for (std::uint64_t seed = 1; seed <= 150 && !missing.empty(); ++seed) {
        const std::string made = print(make_program(seed).draft);
        std::erase_if(missing, [&](std::string_view what) { return made.find(what) != std::string::npos; });
    }
    EXPECT_THAT(missing, testing::IsEmpty());
}

// Most programs are asked something, by rules and without links.
TEST(Questions, AreOfManyKinds) {
    std::set<std::string_view> missing{"not ",           "not (", "forall ",   "N = count : {", "(B, V",
                                       "neighbor(A, E)", "if ",   "S = min W", "S = sum W"};
    int asked = 0, tries = 0;
    for (std::uint64_t seed = 1; seed <= 150 && !(missing.empty() && seed > 20); ++seed) {
        const Generated made = make_program(seed);
        const Result<check::Program> program = checked(print(made.draft));
        ASSERT_TRUE(program);
        for (std::uint64_t w = 0; w < 3; ++w) {
            const auto question = question_of({made.draft, retraction::make_case(seed * 1000 + w, made.draft.given)}, *program);
            ++tries;
            asked += question.has_value();
            std::erase_if(missing, [&](std::string_view what) { return question && question->find(what) != std::string::npos; });
        }
    }
    EXPECT_GT(asked * 10, tries * 7);
    EXPECT_THAT(missing, testing::IsEmpty());
}

}  // namespace
}  // namespace meld::reference
