// Blocks of rules over tables of facts at a catom: joins by any of their arguments, and linear rules that keep the best of a group, replace
// a fact by a better one, or fold all of a group, which the compiler finds with indexes and in one search where it can
// (compiler/plan/passes/indexes.cpp, one_search.cpp). Every firing takes a fact away, or changes one that is counted down.
#include <fmt/format.h>

#include <algorithm>

#include "tests/reference/programs/blocks.h"

namespace meld::reference {

namespace {

class TableRules {
  public:
    TableRules(Random& random, int names)
        : random_(random),
          row_(fmt::format("t{}", names)),
          best_(fmt::format("t{}", names + 1)),
          mark_(fmt::format("t{}", names + 2)),
          fact_(fmt::format("t{}", names + 3)),
          real_(chance(random, 30)) {}

    Block make() {
        block_.declarations.push_back({row_, fmt::format("type linear {}(node, int, {}, int).", row_, real_ ? "float" : "int")});
        block_.declarations.push_back({best_, fmt::format("type linear {}(node, int, int).", best_)});
        block_.declarations.push_back({mark_, fmt::format("type {}(node, int, int).", mark_)});
        block_.declarations.push_back({fact_, fmt::format("type {}(node, int, int, int).", fact_)});
        block_.known.push_back({.name = mark_, .arguments = {Kind::Int, Kind::Int}});
        block_.known.push_back({.name = fact_, .arguments = {Kind::Int, Kind::Int, Kind::Int}});
        block_.given.push_back(
            {.predicate = fact_, .arguments = {{0, 4}, {0, 4}, {0, 2}}, .per_mille = static_cast<int>(50 + below(random_, 500))});
        block_.given.push_back(
            {.predicate = best_, .arguments = {{0, 3}, {0, 5}}, .per_mille = static_cast<int>(below(random_, 500)), .linear = true});
        if (!real_)
            block_.given.push_back({.predicate = row_,
                                    .arguments = {{0, 3}, {0, 3}, {0, 3}},
                                    .per_mille = static_cast<int>(50 + below(random_, 500)),
                                    .linear = true});
        else
            rule({atom(row_, {"X", "float(Y) * 0.5", "Z"})}, {atom(best_, {"X", "Y"}), atom("$" + best_, {"Z", "Y"})});
        for (std::int64_t n = 1 + below(random_, 3); n > 0; --n) linear();
        for (std::int64_t n = below(random_, 3); n > 0; --n) view();
        return std::move(block_);
    }

  private:
    void rule(std::vector<std::string> heads, std::vector<std::string> body) {
        block_.rules.push_back({.heads = std::move(heads), .body = std::move(body), .linear = true});
    }
    static std::string atom(const std::string& name, const std::vector<std::string>& arguments) {
        return fmt::format("{}(A, {})", name, fmt::join(arguments, ", "));
    }
    std::string small() { return std::to_string(below(random_, 4)); }
    std::string one_of(std::vector<std::string> texts) { return pick(random_, texts); }

    void linear() {
        switch (below(random_, 6)) {
            case 0:
                return keeps();
            case 1:
                return replaces();
            case 2:
                return folds();
            case 3:
                return meets();
            case 4:
                return counts_down();
            default:
                return joins();
        }
    }
    void test(std::vector<std::string>& body, const std::vector<std::string>& conditions, int percent) {
        for (const std::string& c : conditions)
            if (chance(random_, percent)) body.push_back(c);
    }
    // Of two facts of a group, by any of its arguments, one stays.
    void keeps() {
        std::vector<std::string> first = {"X", "Y", "Z"}, second = {"U", "V", "W"};
        for (std::size_t i = 0; i < 3; ++i)
            if (chance(random_, 45)) second[i] = chance(random_, 80) ? first[i] : small();
        if (real_) second[1] = chance(random_, 50) ? "Y" : "V";
        std::vector<std::string> body = {atom(row_, first), atom(row_, second)};
        test(body, {second[0] == "U" ? "X < U" : "X < 3", second[1] == "V" ? "Y <= V" : "X != 9", second[2] == "W" ? "Z != W" : "Z < 3"},
             40);
        if (chance(random_, 20)) body.push_back(atom(fact_, {"X", "_", "Z"}));
        if (chance(random_, 10)) body.push_back(fmt::format("not {}(A, X, _)", best_));
        if (chance(random_, 8)) body.push_back(fmt::format("not {}(A, 9, _, _)", row_));
        std::vector<std::string> heads = {atom(row_, chance(random_, 60) ? first : second)};
        if (chance(random_, 30)) heads.push_back(atom(mark_, {"X", "Z"}));
        if (chance(random_, 10)) heads.push_back(fmt::format("{{ B | neighbor(A, B) | {}(B, X, 7) }}", mark_));
        rule(heads, body);
    }
    void replaces() {
        const std::string key = chance(random_, 70) ? "X" : "Z";
        std::vector<std::string> body = {atom(best_, {key, "D"}), real_ ? atom(row_, {"X", "R", "Z"}) : atom(row_, {"X", "Y", "Z"})};
        if (chance(random_, 30)) std::swap(body[0], body[1]);
        const std::string offer = real_ ? "truncate(R * 2.0)" : "Y";
        if (chance(random_, 70)) body.push_back(fmt::format("{} {} D", offer, one_of({"<", ">", "<="})));
        if (chance(random_, 15)) body.push_back("D < 4");
        rule({atom(best_, {chance(random_, 85) ? key : "(" + key + " + 1) % 4", offer})}, body);
    }
    void folds() {
        const std::string value = one_of({"(D + Z) % 9", "D + Z", "(D * 3 + Z) % 7"});
        std::vector<std::string> body = {atom(best_, {"X", "D"}), atom(row_, {chance(random_, 60) ? "X" : "_", "_", "Z"})};
        test(body, {"Z < 3", "D < 8", atom("$" + best_, {"Z", "_"})}, 15);
        rule({atom(best_, {"X", value})}, body);
    }
    // Two facts that fit take each other away.
    void meets() {
        std::vector<std::string> body = {atom(best_, {"X", "D"}),
                                         atom(row_, {chance(random_, 50) ? "X" : "U", "_", chance(random_, 50) ? "D" : "W"})};
        if (chance(random_, 40)) body.push_back(atom(best_, {"D", chance(random_, 50) ? "X" : "E"}));
        if (chance(random_, 30)) body.insert(body.begin() + 1, "neighbor(A, B)");
        rule({atom(mark_, {"X", "D"})}, body);
    }
    void counts_down() {
        rule({atom(best_, {"X", "D - 1"}), atom(mark_, {"X", "D % 4"})},
             {atom(best_, {"X", "D"}), fmt::format("D > {}", below(random_, 3))});
    }
    void joins() {
        std::vector<std::string> body = {atom(best_, {"X", "D"}),
                                         atom(fact_, {chance(random_, 50) ? "_" : "X", chance(random_, 60) ? "D" : "Y", "Z"})};
        test(body, {"Z > 0", atom(fact_, {"Z", "_", "X"}), fmt::format("not {}", atom(fact_, {"_", "X", "Z"}))}, 30);
        rule({atom(mark_, {"X", "Z"})}, body);
    }
    // A join of the facts on some of their arguments, here or at a neighbour.
    void view() {
        const std::string name = fmt::format("{}v{}", mark_, block_.rules.size());
        block_.declarations.push_back({name, fmt::format("type {}(node, int, int).", name)});
        std::vector<std::string> first = {"X", "Y", "Z"}, second = {"U", "V", "W"};
        second[static_cast<std::size_t>(below(random_, 3))] = first[static_cast<std::size_t>(below(random_, 3))];
        if (chance(random_, 40)) second[static_cast<std::size_t>(below(random_, 3))] = small();
        std::string result = "W";
        for (const char* v : {"U", "V", "W"})
            if (std::ranges::find(second, v) != second.end()) result = v;
        if (std::ranges::find(second, result) == second.end()) result = "X";
        std::vector<std::string> body = {atom(fact_, first), atom(fact_, second)};
        const bool there = chance(random_, 25);
        if (there) body = {"neighbor(A, B)", atom(fact_, first), fmt::format("{}(B, {})", fact_, fmt::join(second, ", "))};
        if (chance(random_, 20)) body.push_back("X != Z");
        if (!there && chance(random_, 20)) body.push_back(fmt::format("not {}", atom(fact_, {"Z", "_", "X"})));
        if (!there && chance(random_, 15)) body.push_back(fmt::format("N = count : {{ {} }}, N < 9", atom(fact_, {"_", "X", "_"})));
        block_.rules.push_back({.heads = {atom(name, {"X", result})}, .body = body});
        if (!there && chance(random_, 40))
            block_.rules.push_back(
                {.heads = {atom(name, {"X", "Z"})},
                 .body = {atom(name, {"X", "Y"}), chance(random_, 50) ? atom(name, {"Y", "Z"}) : atom(fact_, {"_", "Y", "Z"})}});
        block_.known.push_back({.name = name, .arguments = {Kind::Int, Kind::Int}});
    }

    Random& random_;
    std::string row_, best_, mark_, fact_;
    bool real_;
    Block block_;
};

}  // namespace

Block table_block(Random& random, const std::vector<Known>&, int names) { return TableRules(random, names).make(); }

}  // namespace meld::reference
