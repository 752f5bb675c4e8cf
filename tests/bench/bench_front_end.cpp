// The front end and the planner on a program of five hundred lines, stage by stage: blocks of rules as the examples have them
// (a gradient, a tree and its sums, far parts, negation, tokens, functions), each block reading the one before.
// Usage: bench_front_end [LINES]
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "compiler/emit/emit.h"
#include "compiler/front/front_end.h"
#include "compiler/plan/plan.h"
#include "tests/bench/clock.h"

namespace {

using namespace meld;

// % after a name is the number of the block, # of the one before.
constexpr const char* kBlock = R"(// Distances, a tree over them, and what is counted along it.
const reach% = 12.
type source%(node).
type dist%(node, min int Hops).
type route parent%(node, node).
type size%(node, sum int Catoms).
type far%(node, node From, min float Length).
type mark%(node, int Kind).
type calm%(node).
type busy%(node, count int Marks).
type linear token%(node, int Left, list int Path).
type linear seen%(node, int Times).
type done%(node, first list int Path).
fun cost%(int Kind, float Length) : float = if Kind = 0 then Length else Length + 0.5 * float(Kind) end.
dist%(A, 0)            :- source%(A), calm#(A).
dist%(B, D + 1)        :- neighbor(A, B), dist%(A, D), D < reach%.
parent%(A, B)          :- neighbor(A, B), dist%(A, D), dist%(B, E), E < D.
size%(A, 1)            :- dist%(A, _).
size%(A, N)            :- parent%(B, A), size%(B, N).
far%(A, A, 0.0)        :- source%(A).
far%(B, S, cost%(K, L)) :- neighbor(A, B), far%(A, S, L), mark#(B, K), L < 20.0.
calm%(A)               :- dist%(A, D), not mark#(A, D).
busy%(A, K)            :- neighbor(A, B), neighbor(B, C), mark%(C, K), dist#(C, D), D > 2.
mark%(A, D % 3)        :- dist%(A, D), (D + 1) % 2 = 0.
token%(A, N, L), dist%(A, D), N > 0, D > 0, neighborCount(A, K) -o { B | parent%(A, B) | token%(B, N - 1, [D + K | L]) }, seen%(A, 1).
token%(A, 0, L) -o done%(A, L).
seen%(A, M), seen%(A, N) -o seen%(A, M + N).
)";

std::string program(int lines) {
    std::string text = "type mark0(node, int).\ntype calm0(node).\ntype dist0(node, int).\n";
    int have = 3;
    for (int block = 1; have < lines; ++block) {
        std::string one = kBlock;
        for (std::size_t at = 0; at < one.size(); ++at) {
            if (one[at] == '\n') ++have;
            const bool digit = at > 0 && std::isalpha(static_cast<unsigned char>(one[at - 1]));
            if (one[at] == '%' && digit) one.replace(at, 1, std::to_string(block));
            if (one[at] == '#' && digit) one.replace(at, 1, std::to_string(block - 1));
        }
        text += one;
    }
    return text;
}

}  // namespace

int main(int argc, char** argv) {
    using namespace meld::bench;
    const int lines = argc > 1 ? std::atoi(argv[1]) : 500;
    const std::string text = program(lines);
    machine_line();
    constexpr int kRepeats = 21;
    std::vector<double> parse, check, plan, emit, all;
    std::size_t rules = 0, bytes = 0;
    for (int repeat = 0; repeat < kRepeats; ++repeat) {
        const double start = cpu_now();
        source::FileSet files;
        diagnostics::Reporter report;
        const std::uint32_t prelude = front::add_prelude(files);
        const std::uint32_t file = files.add("generated.meld", text);
        front::ParsedProgram parsed = front::parse_program(files, file, prelude, report, {});
        const double read = cpu_now();
        check::Program checked = front::check_program(files, file, prelude, std::move(parsed), report);
        const double known = cpu_now();
        if (report.has_errors()) {
            std::fputs(diagnostics::render_text(files, report.sorted(), diagnostics::Colour::Never).c_str(), stderr);
            return 70;
        }
        const plan::Plan planned = plan::make_plan(std::move(checked));
        const double ready = cpu_now();
        bytes = emit::emit_module(planned).size();
        const double done = cpu_now();
        rules = planned.program.rules.count();
        parse.push_back(read - start);
        check.push_back(known - read);
        plan.push_back(ready - known);
        emit.push_back(done - ready);
        all.push_back(ready - start);
    }
    std::printf("%d lines, %zu rules planned: parse %.2f ms, check %.2f ms, plan %.2f ms: %.2f ms in all; emit %.2f ms for %zu kB of C++\n",
                lines, rules, median(parse) * 1e3, median(check) * 1e3, median(plan) * 1e3, median(all) * 1e3, median(emit) * 1e3,
                bytes / 1000);
    return 0;
}
