// Programs of linear rules alone: catoms that mostly hold one fact of each predicate, which the compiler then keeps in variables
// (compiler/plan/passes/singles.cpp), and that sometimes come to hold several. Every firing consumes a message, joins two facts or takes
// one of the steps that a fact has left, so each program comes to an end.
#include <fmt/format.h>

#include "tests/reference/programs/blocks.h"

namespace meld::reference {

namespace {

class StateRules {
  public:
    explicit StateRules(Random& random)
        : random_(random),
          states_(static_cast<int>(2 + below(random, 3))),
          messages_(static_cast<int>(1 + below(random, 2))),
          real_(chance(random, 50)) {}

    Block make() {
        const std::string value = real_ ? "float" : "int";
        for (int i = 0; i < states_; ++i) declare(fmt::format("s{}", i), value, i == 0 ? 100 : 15);
        for (int i = 0; i < messages_; ++i) declare(fmt::format("m{}", i), value, 15);
        send("s0");
        sweep();
        for (std::int64_t n = below(random_, 5); n > 0; --n) another();
        return std::move(block_);
    }

  private:
    void another() {
        switch (below(random_, 6)) {
            case 0:
                return send(state());
            case 1:
                return sweep();
            case 2:
                return drop();
            case 3:
                return join();
            default:
                return step();
        }
    }
    void declare(const std::string& name, const std::string& value, int given) {
        block_.declarations.push_back({name, fmt::format("type linear {}(node, int, {}).", name, value)});
        // Floats that cases give are not of different sizes, so they come from rules.
        if (chance(random_, given)) start(name);
    }
    void start(const std::string& name) {
        const std::string from = name + "g";
        block_.declarations.push_back({from, fmt::format("type linear {}(node, int, int).", from)});
        block_.given.push_back(
            {.predicate = from, .arguments = {{0, 4}, {-3, 9}}, .per_mille = static_cast<int>(150 + below(random_, 500)), .linear = true});
        rule({atom(name, "A", "L", real_ ? "float(V) * 0.37" : "V")}, {fmt::format("{}(A, L, V)", from)});
    }
    void rule(std::vector<std::string> heads, std::vector<std::string> body) {
        block_.rules.push_back({.heads = std::move(heads), .body = std::move(body), .linear = true});
    }
    static std::string atom(const std::string& name, const std::string& at, const std::string& left, const std::string& value) {
        return fmt::format("{}({}, {}, {})", name, at, left, value);
    }
    std::string state() { return fmt::format("s{}", below(random_, states_)); }
    std::string message() { return fmt::format("m{}", below(random_, messages_)); }
    std::string small() { return std::to_string(below(random_, 4)); }
    std::string next(const std::string& v, const std::string& w) {
        return fmt::format(
            fmt::runtime(pick(random_, real_ ? std::vector<std::string>{"{0} + {1}", "{0} * 0.7 + {1}", "{0} - 0.3 * {1}", "{1}"}
                                             : std::vector<std::string>{"({0} + {1}) % 23", "({0} * 3 + {1}) % 11", "{1}"})),
            v, w);
    }
    std::string condition(const std::string& v) {
        return fmt::format("{} {} {}", v, pick(random_, std::vector<std::string>{">", "<", "<="}), real_ ? small() + ".5" : small());
    }
    void sometimes(std::vector<std::string>& body, int percent, const std::string& clause) {
        if (chance(random_, percent)) body.push_back(clause);
    }

    // A state tells its neighbours, and becomes another one.
    void send(const std::string& from) {
        std::vector<std::string> body = {atom(from, "A", "L", "V"), "L > 0"};
        const bool counted = chance(random_, 50);
        if (counted) body.push_back("neighborCount(A, N)");
        sometimes(body, 20, condition("V"));
        sometimes(body, 20, fmt::format("not {}", atom(state(), "A", "_", "_")));
        const std::string told =
            pick(random_, std::vector<std::string>{"V", real_ ? "V / 2.0" : "V + 1", counted && !real_ ? "V * N % 7" : "V"});
        const std::string all =
            fmt::format("{{ B | neighbor(A, B) | {} }}", atom(message(), "B", chance(random_, 70) ? "L" : "L - 1", told));
        rule({all, after("L - 1", "V")}, std::move(body));
    }
    // What follows: a state, or one of two, or an action besides.
    std::string after(const std::string& left, const std::string& value) {
        const std::string one = atom(state(), "A", left, value);
        if (chance(random_, 90)) return one;
        if (chance(random_, 70)) return one + fmt::format(", (if {} then setColor(A, L, 1, 2) otherwise 1 end)", condition("V"));
        return fmt::format("(if {} then {} otherwise {} end)", condition("V"), one, atom(state(), "A", left, value));
    }
    // A state takes messages: all, those of its round, or some.
    void sweep() {
        const std::string to = state();
        const std::string key = pick(random_, std::vector<std::string>{"L", "L", "K", "_", small()});
        std::vector<std::string> body = {atom(to, "A", "L", "V"), atom(message(), "A", key, "W")};
        if (chance(random_, 30)) std::swap(body[0], body[1]);
        sometimes(body, 15, condition("W"));
        sometimes(body, 10, condition("V"));
        sometimes(body, 10, "W > V");
        if (key == "K") sometimes(body, 40, "K >= L");
        rule({atom(to, "A", chance(random_, 80) ? "L" : "max(L - 1, 0)", next("V", "W"))}, std::move(body));
    }
    void step() {
        std::vector<std::string> body = {atom(state(), "A", "L", "V"), "L > 0"};
        sometimes(body, 30, condition("V"));
        sometimes(body, 30,
                  fmt::format("not {}", atom(chance(random_, 70) ? state() : message(), "A", chance(random_, 50) ? "L" : "_", "_")));
        rule({after("L - 1", next("V", "V"))}, std::move(body));
    }
    void join() {
        const std::string one = state(), other = chance(random_, 80) ? state() : message();
        rule({atom(state(), "A", "min(L, K)", next("V", "W"))}, {atom(one, "A", "L", "V"), atom(other, "A", "K", "W")});
    }
    void drop() {
        std::vector<std::string> body = {atom(message(), "A", "L", "V")};
        sometimes(body, 50, condition("V"));
        rule({chance(random_, 50) ? "1" : "setColor(A, L, 2, 3)"}, std::move(body));
    }

    Random& random_;
    int states_, messages_;
    bool real_;
    Block block_;
};

}  // namespace

Block state_block(Random& random, const std::vector<Known>&, int) { return StateRules(random).make(); }

}  // namespace meld::reference
