// Programs of all dialects: they parse without a message, and their printed form gives the same printed form again.
#include <gtest/gtest.h>

#include <algorithm>

#include "parsed.h"

namespace meld::syntax {
namespace {

void round_trip(const std::string& text) {
    const Parsed first = parsed(text);
    ASSERT_EQ(first.rendered(), "");
    const std::string printed = print(first.tree);
    const Parsed second = parsed(printed);
    ASSERT_EQ(second.rendered(), "") << printed;
    EXPECT_EQ(print(second.tree), printed);
    EXPECT_EQ(second.tree.items.size(), first.tree.items.size());
    EXPECT_EQ(static_cast<std::size_t>(std::count(printed.begin(), printed.end(), '\n')), first.tree.items.size()) << "one item a line";
}

std::string printed(const std::string& text) {
    const Parsed program = parsed(text);
    return program.report.has_errors() ? program.rendered() : print(program.tree);
}

// Each line, written as the printer writes, is printed as it stands.
void stands(const std::string& text) { EXPECT_EQ(printed(text), text); }

TEST(RoundTrip, OriginalMeld) {
    round_trip(R"(
// heads on the left, derived facts kept true, lower-case variables, ! for linear
type dist(addr, min int).
type linear doTick(addr).
extern int blockID(addr).
const RED = 0.
dist(x, 0) :- source(x).
dist(X, N+1) :-
    neighbor(X, Y, _),
    dist (Y, N).
edged(X, 0),
setColor2(X, RED) :-
    neighborCount(X, 1), RED != X, X == Y.
!doTick(N)@+1s,
!tick(N)@+250ms :-
    1 = blockID(N).
setColor2(X, BLUE).
)");
}

TEST(RoundTrip, ClassicalMeld) {
    round_trip(R"(
type route edge(node, node).
type pagerank(node, int, float).
type calcRank(node, int, sum float).
type beliefmul(node, int, sum list float [-> edge]).
type size(node, sum float [<- neighbor] S).
type linear fact(node, int set).
extern int set set_insert_int(int set, int).
const pages = @world.
pagerank(A, 0, 1.0 / float(pages)).
pagerank(A, I, V) :-
    calcRank(A, I, T), I > 0, V = damping + (1.0 - damping) * T, I <= iterations.
edge(@0,@1).
edge(@2,@1).
)");
}

TEST(RoundTrip, LinearMeld) {
    round_trip(R"(
type linear token(node, list node, list node).
const global-potential = [-0.0, -2.0, -4, 0.1].
const maxnodes = str2int(@arg1).
priority @initial 100.
fun abs(int X) : int = if X >= 0 then X else 0 - X end.
start(A) -o belief(A, initial-belief),
            {B, Side | !edge(A, B, Side) | neighbor-belief(A, B, initial-message), sent(A, B)},
            waiting(A).
waiting(A), nodepriority(A) > 0.0 -o token(A, [A], [A]).
token(A, All, [A | Next])
   -o [collect => L | Side | !edge(A, L, Side), 0 = nodelistcount(All, L), cpu-id(L) = cpu-id(A)
          | send-token(A, All, nodelistappend(Next, L))].
test-y(A, Y, [X, Y1 | RestCoords], Nodes, Coords), Y = Y1 -o 1. // fail
;; an old comment
t(A, X, Y), X < 0 || Y < 0, !coord(A, OX, OY) -o r(A, OX - 1, OY + 1).
[ :random B |
    unplugged(A), $free(A, B, Free), Free >= Total ]
    -o plugged(A, B), 1.
[:min W | start(A), !edge(A, B, W), ?tok(A)    ]
        -o state(A, found).
!coordinate(A,-1,-2,Z), Z >= 0, Z <= 1 -o !inTarget(A,b_true).
)");
}

TEST(RoundTrip, EveryDeclaration) {
    stands("type route neighbor(node, node, int Port).\n");
    stands("type linear visit(node).\n");
    stands("type dist(node, min int D, node Via).\n");
    stands("type reach(node, first node P, any list list int L, union set int).\n");
    stands("type action p(node) while.\n");
    stands("type s(node, :(int, float) S, (int, int) T).\n");
    stands("type list int vector.\n");
    stands("type (int, int) pair.\n");
    stands("type vector p(node, vector V).\n");
    stands("node kind.\n");
    stands("fun twice(int X) : int = 2 * X.\n");
    stands("fun pair(int X, list float L) : (int, int) = (X, X).\n");
    stands("extern float f(int, node).\n");
    stands("extern type handle.\n");
    stands("import p as q from \"file\".\n");
    stands("import linear p(node, int) from \"file.meld\".\n");
    stands("export p.\nmodule gossip.\n");
    stands("priority p < q.\npriority p/2 @asc.\nindex p/2.\ncompact p.\ndata p \"file\".\n");
}

TEST(RoundTrip, EveryClauseAndHead) {
    stands("p(A) :- forall q(A, B)[r(B), s(B, A)].\n");
    stands("p(A) :- not t(A), not (u(A), !v(A)), not ?w(A).\n");
    stands("p(A) :- delta(X; r(A, X)) > 0.5.\n");
    stands("p(A) :- proved(N, q), N > 1.\n");
    stands("p(A) :- S = sum X * 2 : { q(A, X) }, C = count : { q(A, _), r(A) }.\n");
    stands("p(A) :- E in [1, 2, 3].\n");
    stands("p(A) -o { | q(A) | r(A) }, { X | q(A, X) | }.\n");
    stands("p(A) -o [sum => S, count => C | X | q(A, X) | one(X) | tot(A, S, C)].\n");
    stands("p(A) -o [custom f 0 => V | | q(A) | h(A, V)].\n");
    stands("p(A) -o [custom f => V | X | q(A) | h(A, V) | ].\n");
    stands("p(A) -o exists X, Y. (q(A, X), r(A, Y)), 1.\n");
    stands("p(A) -o (if A = @1 then q(A) otherwise r(A), 1 end).\n");
    stands("p(A) -o (if A = @1 then q(A) end).\n");
    stands("[desc => X | !foo(A, X), bar(A)] -o 1.\n");
    stands("[asc => X | bar(A, X)] -o 1.\n[random => X | bar(A, X)] -o 1.\n[min => X | bar(A, X)] -o 1.\n");
    stands("p(A)@+2s, q(A)@+250ms, r(A)@+3, s(A)@+0.5s :- t(A).\n");
    stands("p(A), q(A).\n");
}

TEST(RoundTrip, WordsAreNamesWhereTheyMeanNothing) {
    stands("type linear end(node).\ntype data(node, int).\ntype type(node).\ntype in(node).\n");
    stands("data(A, 1).\ntype(A).\nend(A, min).\nnode(A).\nconst(A).\nmodule(A).\n");
    stands(
        "data(A), random(A), end(A), min(A), count(A), first(A), include(A), priority(A) :- if(A), then(A), in(A), forall(A), exists(A), "
        "delta(A, B).\n");
    stands("p(A, end, then, data) :- X = min(A, B), q(A, count), end = in, Y = if(A) + 1.\n");
    stands("p(A) :- if A = B then C else D end = 3.\n");
    EXPECT_EQ(printed("p(A) :- X = if (A = B) then (C) else (D) end."), "p(A) :- X = if A = B then C else D end.\n");
    stands("type p(node, int type, int end, int const).\n");
}

TEST(RoundTrip, DeclarationsInAnyOrder) {
    const Parsed program = parsed("p(A) :- q(A).\ntype p(node).\nconst a = 1.\nq(@1).\ntype q(node).\n");
    EXPECT_EQ(program.rendered(), "");
    EXPECT_EQ(program.tree.items.size(), 5u);
}

TEST(RoundTrip, AnEmptyFileIsAProgram) {
    EXPECT_EQ(printed(""), "");
    EXPECT_EQ(printed("  // nothing\n/* at /* all */ */\n"), "");
    EXPECT_EQ(printed("\xef\xbb\xbfp(A)."), "p(A).\n");
    EXPECT_EQ(printed("p(A)\t:-\r\n\tq(A)\t.\r\n"), "p(A) :- q(A).\n");
}

}  // namespace
}  // namespace meld::syntax
