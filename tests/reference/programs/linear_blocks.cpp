// Blocks of linear rules. A rule makes linear facts of later predicates than it consumes, or counts down, so that every
// catom comes to an end in every tick.
#include <fmt/format.h>

#include <utility>

#include "tests/reference/programs/blocks.h"

namespace meld::reference {

namespace {

struct Token {
    std::string name;
    bool counts = false;   // Has an int that only ever gets less,
    bool carries = false;  // and a list.
};

std::string atom(const Token& t, const std::string& at, const std::string& value, const std::string& list) {
    return fmt::format("{}({}{}{})", t.name, at, t.counts ? ", " + value : "", t.carries ? ", " + list : "");
}

class LinearRules {
  public:
    LinearRules(Random& random, const std::vector<Known>& known, int names, bool far) : random_(random), known_(known), far_(far) {
        for (std::int64_t i = 0, n = 1 + below(random, 3); i < n; ++i)
            tokens_.push_back({fmt::format("t{}", names + static_cast<int>(i)), chance(random, 70), i > 0 && chance(random, 30)});
        ticket_ = {.name = fmt::format("t{}", names + static_cast<int>(tokens_.size()) + 1), .arguments = {Kind::Node}};
        mark_ = {.name = fmt::format("t{}", names + static_cast<int>(tokens_.size())),
                 .arguments = chance(random, 60) ? std::vector{Kind::Int} : std::vector<Kind>{}};
    }

    Block make() {
        if (far_ || chance(random_, 40)) {
            // Links of the program's own, or only facts about catoms that may be anywhere or nowhere.
            road_ = fmt::format("w{}", tokens_[0].name);
            block_.declarations.push_back({road_, fmt::format("type {}{}(node, node).", far_ ? "" : "route ", road_)});
            block_.given.push_back({.predicate = road_, .arguments = {{0, 12}}, .per_mille = 400});
        }
        for (std::size_t i = 0; i < tokens_.size(); ++i) declare(i);
        block_.declarations.push_back({mark_.name, fmt::format("type {}(node{}).", mark_.name, mark_.arguments.empty() ? "" : ", int")});
        block_.known.push_back(mark_);
        block_.declarations.push_back({ticket_.name, fmt::format("type {}(node, node).", ticket_.name)});
        for (std::int64_t n = 1 + below(random_, 4); n > 0; --n) rule();
        if (far_ && chance(random_, 70)) node_rule();
        for (const Token& t : tokens_)
            if (chance(random_, road_.empty() ? 25 : 70)) undelivered(t);
        return std::move(block_);
    }

  private:
    // What no other rule consumes makes nodes.
    void node_rule() {
        Body body(random_, known_);
        body.for_linear = true;
        first_ = latest_ = 0;
        counted_ = tokens_[0].counts;
        guarded_ = false;
        lists_.clear();
        places_ = {"A"};
        body.clause(atom(tokens_[0], "A", "L", "K"));
        const std::string made = node(body, "A");
        block_.rules.push_back({.heads = {made}, .body = body.clauses(), .linear = true});
    }

    // What cannot be delivered comes back.
    void undelivered(const Token& t) {
        block_.declarations.push_back({"undelivered-" + t.name, fmt::format("type linear undelivered-{}(node, node To{}{}).", t.name,
                                                                            t.counts ? ", int" : "", t.carries ? ", list int" : "")});
        if (chance(random_, 60))
            block_.rules.push_back({.heads = {mark_with("A", t.counts ? "L" : "node2int(U) % 5")},
                                    .body = {fmt::format("undelivered-{}", atom(t, "A, U", "L", "_"))},
                                    .linear = true});
    }

    void declare(std::size_t i) {
        const Token& t = tokens_[i];
        block_.declarations.push_back(
            {t.name, fmt::format("type linear {}(node{}{}).", t.name, t.counts ? ", int" : "", t.carries ? ", list int" : "")});
        if (i == 0 || (!t.carries && chance(random_, 40))) {
            retraction::Given given{
                .predicate = t.name, .arguments = {}, .per_mille = static_cast<int>(40 + below(random_, 250)), .linear = true};
            if (t.counts) given.arguments.push_back({0, 3});
            block_.given.push_back(given);
        }
        // Nodes that rules make would begin with one for all, and make others for ever.
        if (chance(random_, 30))
            block_.rules.push_back(
                {.heads = {atom(t, chance(random_, 40) || far_ ? "@1" : "A", std::to_string(below(random_, 4)), "[3]") + delay(10)}});
    }

    void rule() {
        Body body(random_, known_);
        body.for_linear = true;
        first_ = latest_ = static_cast<std::size_t>(below(random_, static_cast<std::int64_t>(tokens_.size())));
        body.clause(atom(tokens_[first_], "A", "L", "K"));
        lists_ = tokens_[first_].carries ? std::vector<std::string>{"K"} : std::vector<std::string>{};
        counted_ = tokens_[first_].counts;
        if (chance(random_, 30)) {
            const std::size_t second = static_cast<std::size_t>(below(random_, static_cast<std::int64_t>(tokens_.size())));
            latest_ = std::max(latest_, second);
            body.clause((chance(random_, 25) ? "$" : "") +
                        atom(tokens_[second], "A", chance(random_, 50) ? "M" : "L", chance(random_, 70) ? "_" : "[_ | _]"));
        }
        places_ = {"A"};
        if (chance(random_, 40)) places_.push_back(body.link("A"));
        if (chance(random_, 55)) body.read_any(body.any_catom());
        if (chance(random_, 30)) body.test();
        if (chance(random_, 25)) body.negate();
        if (chance(random_, 12)) body.clause("not " + atom(pick(random_, tokens_), "A", "_", "_"));
        if (chance(random_, 8)) body.proved();
        if (chance(random_, 10)) body.change();
        if (chance(random_, 8)) body.aggregate();
        const std::string select = counted_ && chance(random_, 30) ? pick(random_, std::vector<std::string>{"desc", "asc", "random"}) : "";
        // Ways to satisfy a body that differ only two links away are one or many, which matters where one of them is drawn.
        if (places_.size() > 1 && select != "random" && chance(random_, 30)) places_.push_back(body.far_link());
        if (!road_.empty() && chance(random_, far_ ? 70 : 40)) {
            body.clause(fmt::format("{}(A, Far)", road_));
            places_.push_back("Far");
        }
        guarded_ = counted_ && chance(random_, 70);
        if (guarded_) body.clause("L > 0");
        DraftRule rule{.heads = {}, .body = body.clauses(), .linear = true};
        if (!select.empty()) rule.select = select + " => " + (body.has(Kind::Int) && chance(random_, 40) ? body.variable(Kind::Int) : "L");
        for (std::int64_t n = below(random_, 3) + 1; n > 0; --n) {
            const std::string text = head(body);
            if (!text.empty()) rule.heads.push_back(text);
        }
        block_.rules.push_back(std::move(rule));
    }

    std::string delay(int percent) {
        return chance(random_, percent) ? pick(random_, std::vector<std::string>{"@+1", "@+2", "@+5", "@+3ms"}) : "";
    }
    std::string small() { return chance(random_, 40) ? "randint(4)" : std::to_string(below(random_, 4)); }
    std::string list() {
        return lists_.empty()        ? "[" + small() + "]"
               : chance(random_, 50) ? lists_[0]
                                     : fmt::format("ltake([{} | {}], 3)", small(), lists_[0]);
    }

    // A token that this rule may make without running for ever, or none.
    std::string token(const std::string& at) {
        if (guarded_ && chance(random_, 60) && first_ == latest_) return atom(tokens_[first_], at, "L - 1", list()) + delay(15);
        if (latest_ + 1 >= tokens_.size()) return "";
        const Token& next =
            tokens_[latest_ + 1 + static_cast<std::size_t>(below(random_, static_cast<std::int64_t>(tokens_.size() - latest_ - 1)))];
        return atom(next, at, small(), list()) + delay(15);
    }

    std::string mark(Body& body, const std::string& at) {
        return mark_with(at, counted_ && chance(random_, 50) ? "L"
                             : chance(random_, 25)           ? small()
                                                             : body.expression(Kind::Int)) +
               delay(12);
    }
    std::string mark_with(const std::string& at, const std::string& value) {
        return fmt::format("{}({}{})", mark_.name, at, mark_.arguments.empty() ? "" : ", " + value);
    }

    std::string head(Body& body) {
        const std::string there = pick(random_, places_);
        switch (below(random_, 10)) {
            case 0:
                return token(there);
            case 1:
            case 2:
                return mark(body, there);
            case 3: {
                const std::string inner = chance(random_, 50) ? token("Y") : mark(body, "Y");
                return inner.empty() ? "" : "{ Y | neighbor(A, Y) | " + inner + " }";
            }
            case 4: {
                // Everything of one kind is consumed.
                const Token& t = pick(random_, tokens_);
                return fmt::format("{{ U | {} | {} }}", atom(t, "A", "U", "_"), mark_with("A", t.counts ? "U % 5" : "1"));
            }
            case 5:
                return mark_.arguments.empty()
                           ? ""
                           : fmt::format("{{ U | {0}(A, U){1} | {0}(A, (U + 1) % 4) }}", mark_.name, chance(random_, 50) ? ", U < 3" : "");
            case 6:
                return aggregate();
            case 7: {
                const std::string yes = mark(body, there), no = chance(random_, 60) ? mark(body, "A") : "1";
                return fmt::format("(if {} > {} then {} otherwise {} end)", counted_ ? "L" : body.expression(Kind::Int), below(random_, 3),
                                   yes, no);
            }
            case 8:
                return far_ ? node(body, there) : fmt::format("exists V, W. ({0}({1}, V), {0}({1}, W))", ticket_.name, there);
            default:
                return "setColor(A, 1, 2, 3)" + delay(30);
        }
    }

    // A node with facts, or a number of none; with a second one now and then. Others learn where they are.
    std::string node(Body& body, const std::string& there) {
        std::string facts = fmt::format("{}({}, V)", ticket_.name, there);
        // What counts down would go on there, and make ever more nodes.
        const bool guarded = std::exchange(guarded_, false);
        for (const char* at : {"V", "V", "W"}) {
            const std::string fact = chance(random_, 60) ? token(at) : mark(body, at);
            if (!fact.empty() && chance(random_, 60)) facts += ", " + fact;
        }
        guarded_ = guarded;
        if (chance(random_, 60)) facts += fmt::format(", {}(A, V)", road_);
        if (chance(random_, 40)) facts += fmt::format(", {}(V, A)", road_);
        return fmt::format("exists V, W. ({}, {}({}, W))", facts, ticket_.name, there);
    }

    // Of tokens, which are consumed, or of what neighbours have.
    std::string aggregate() {
        const Token& t = pick(random_, tokens_);
        const std::string result = mark_with("A", "S % 7"), each = chance(random_, 40) ? " | " + mark_with("A", "9") : "";
        if (!t.counts || chance(random_, 25)) return fmt::format("[count => S | | {}{} | {}]", atom(t, "A", "_", "_"), each, result);
        const std::string op = pick(random_, std::vector<std::string>{"sum", "min", "max", "custom mixed", "custom mixed 3"});
        if (chance(random_, 25))
            return fmt::format("[{} => S | | {}{} | {}]", pick(random_, std::vector<std::string>{"collect", "min_k(2)", "max_k(2)"}),
                               atom(t, "A", "S", "_"), each, mark_with("A", "lsum(S) % 7"));
        if (chance(random_, 15))
            return fmt::format("[avg => S | | {}{} | {}]", atom(t, "A", "S", "_"), each, mark_with("A", "truncate(S) % 7"));
        const std::string count = chance(random_, 30) ? ", count => N" : "";
        return fmt::format("[{} => S{} | | {}{} | {}]", op, count, atom(t, "A", "S", "_"), each,
                           count.empty() ? result : mark_with("A", "(S + N) % 7"));
    }

    Random& random_;
    const std::vector<Known>& known_;
    const bool far_;
    std::vector<Token> tokens_;
    Known mark_, ticket_;
    std::string road_;
    // Of the rule that is made.
    std::size_t first_ = 0, latest_ = 0;
    bool counted_ = false, guarded_ = false;
    std::vector<std::string> places_, lists_;
    Block block_;
};

}  // namespace

Block linear_block(Random& random, const std::vector<Known>& known, int names) { return LinearRules(random, known, names, false).make(); }
Block far_block(Random& random, const std::vector<Known>& known, int names) { return LinearRules(random, known, names, true).make(); }

}  // namespace meld::reference
