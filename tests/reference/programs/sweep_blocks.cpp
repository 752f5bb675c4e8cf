// Blocks of linear rules that update one fact by each of many others, which the compiler takes in one pass where it can
// (compiler/plan/passes/sweep.cpp), and rules that only look like these. Every firing consumes a message, and nothing makes new ones
// without end.
#include <fmt/format.h>

#include "tests/reference/programs/blocks.h"

namespace meld::reference {

namespace {

class SweepRules {
  public:
    SweepRules(Random& random, int names)
        : random_(random),
          state_(fmt::format("t{}", names)),
          message_(fmt::format("t{}", names + 1)),
          mark_(fmt::format("t{}", names + 2)),
          start_(fmt::format("t{}", names + 3)),
          real_(chance(random, 40)),
          lists_(chance(random, 20)) {}

    Block make() {
        block_.declarations.push_back({state_, fmt::format("type linear {}(node, int, {}).", state_, real_ ? "float" : "int")});
        block_.declarations.push_back({message_, fmt::format("type linear {}(node, int, int{}).", message_, lists_ ? ", list int" : "")});
        block_.declarations.push_back({mark_, fmt::format("type {}(node, int).", mark_)});
        block_.declarations.push_back({start_, fmt::format("type linear {}(node, int).", start_)});
        block_.known.push_back({.name = mark_, .arguments = {Kind::Int}});
        if (!lists_)
            block_.given.push_back({.predicate = message_,
                                    .arguments = {{0, 2}, {-3, 9}},
                                    .per_mille = static_cast<int>(100 + below(random_, 500)),
                                    .linear = true});
        block_.given.push_back(
            {.predicate = start_, .arguments = {{0, 2}}, .per_mille = static_cast<int>(100 + below(random_, 300)), .linear = true});
        if (chance(random_, 30)) seen_before();
        sends();
        if (chance(random_, 20)) updates();
        updates();
        if (chance(random_, 50)) ends();
        if (chance(random_, 20)) reader();
        return std::move(block_);
    }

  private:
    void rule(std::vector<std::string> heads, std::vector<std::string> body) {
        block_.rules.push_back({.heads = std::move(heads), .body = std::move(body), .linear = true});
    }
    std::string state(const std::string& key, const std::string& value) const { return fmt::format("{}(A, {}, {})", state_, key, value); }
    std::string message(const std::string& at, const std::string& key, const std::string& value, const std::string& list) const {
        return fmt::format("{}({}, {}, {}{})", message_, at, key, value, lists_ ? ", " + list : "");
    }
    std::string small() { return std::to_string(below(random_, 4)); }

    // A catom begins anew and tells its neighbours.
    void sends() {
        const std::string value = pick(random_, std::vector<std::string>{"K + 1", "C", "C * (K - 1) % 5", "randint(6)"});
        rule({fmt::format("{{ B | neighbor(A, B) | {} }}", message("B", chance(random_, 70) ? "K" : small(), value, "[C, K]")),
              state("K", real_ ? "0.0" : "0")},
             {fmt::format("{}(A, K)", start_), "neighborCount(A, C)"});
        if (chance(random_, 25)) rule({message("B", "K", "K", "[]")}, {fmt::format("{}(A, K)", start_), "K = 1", "neighbor(A, B)"});
    }

    // The state and a message, in either order, with conditions on one or both of them, some of which keep the rule from sweeping.
    void updates() {
        const std::string next = real_ ? pick(random_, std::vector<std::string>{"S + 0.1 * float(V)", "S * 0.7 + float(V)", "S - 0.3"})
                                       : pick(random_, std::vector<std::string>{"S + V", "(S * 3 + V) % 11", "S - 1", "V"});
        const std::string key = pick(random_, std::vector<std::string>{"K", "K", "K", "J", "_", small()});
        const std::string held = chance(random_, 85) ? state("K", "S") : state(small(), "S");
        const bool known_key = held.find("K") != std::string::npos;
        const std::string taken = message("A", known_key || key != "K" ? key : "J", "V", chance(random_, 70) ? "_" : "[X | _]");
        std::vector<std::string> body = {held, taken};
        if (chance(random_, 40)) std::swap(body[0], body[1]);
        const std::string limit = real_ ? "2.0" : "4";
        for (const std::string& condition :
             {fmt::format("V > {}", small()), fmt::format("S < {}", limit), std::string(real_ ? "float(V) > S" : "V > S"),
              std::string(known_key ? "V != K" : "V != 3"), std::string(known_key ? "V + K < 6" : "V < 6")})
            if (chance(random_, 14)) body.push_back(condition);
        if (chance(random_, 8)) body.push_back("neighborCount(A, C)");
        if (chance(random_, 6)) body.push_back(fmt::format("not {}(A, _)", start_));
        std::vector<std::string> heads = {state(!known_key ? "1" : chance(random_, 85) ? "K" : "(K + 1) % 3", next)};
        if (chance(random_, 15)) heads.push_back(fmt::format("{}(A, V % 5)", mark_));
        if (chance(random_, 8)) heads.push_back("setColor(A, V, 2, 3)");
        if (chance(random_, 8)) heads.push_back(state("2", real_ ? "1.5" : "1"));
        if (chance(random_, 8)) heads.push_back(fmt::format("{{ B | neighbor(A, B) | {}(B, 7) }}", mark_));
        DraftRule made{.heads = heads, .body = body, .linear = true};
        if (chance(random_, 8)) made.select = pick(random_, std::vector<std::string>{"desc => V", "asc => V", "random => V"});
        block_.rules.push_back(std::move(made));
    }

    // A rule before the update, which its result may enable.
    void seen_before() {
        if (chance(random_, 50))
            rule({fmt::format("{}(A, K)", mark_)}, {state("K", "S"), real_ ? "S > 1.0" : "S = 5"});
        else
            rule({fmt::format("{}(A, K + 10)", mark_)}, {fmt::format("{}(A, K)", start_), "not " + state("_", "_")});
    }
    void ends() {
        rule({fmt::format("{}(A, {})", mark_, real_ ? "truncate(S * 100.0) % 17" : "S % 7")},
             {state("K", "S"), real_ ? "S > 1.5" : "S > 6"});
    }
    // A view that changes while the rule fires.
    void reader() {
        const std::string name = mark_ + "v";
        block_.declarations.push_back({name, fmt::format("type {}(node, count int).", name)});
        block_.rules.push_back({.heads = {fmt::format("{}(A, X)", name)}, .body = {fmt::format("{}(A, X)", mark_)}});
    }

    Random& random_;
    std::string state_, message_, mark_, start_;
    bool real_, lists_;
    Block block_;
};

}  // namespace

Block sweep_block(Random& random, const std::vector<Known>&, int names) { return SweepRules(random, names).make(); }

}  // namespace meld::reference
