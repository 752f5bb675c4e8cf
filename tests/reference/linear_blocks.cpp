// Blocks of linear rules. A rule makes linear facts of later predicates than it consumes, or counts down, so that every
// catom comes to an end in every tick.
#include <fmt/format.h>

#include "blocks.h"

namespace meld::reference {

namespace {

struct Token {
    std::string name;
    bool counts = false;  // Carries an int that only ever gets less.
};

std::string atom(const Token& t, const std::string& at, const std::string& value) { return t.counts ? fmt::format("{}({}, {})", t.name, at, value) : fmt::format("{}({})", t.name, at); }

class LinearRules {
  public:
    LinearRules(Random& random, const std::vector<Known>& known, int names) : random_(random), known_(known) {
        for (std::int64_t i = 0, n = 1 + below(random, 3); i < n; ++i) tokens_.push_back({fmt::format("t{}", names + static_cast<int>(i)), chance(random, 70)});
        mark_ = {.name = fmt::format("t{}", names + static_cast<int>(tokens_.size())), .arguments = chance(random, 60) ? std::vector{Kind::Int} : std::vector<Kind>{}};
    }

    Block make() {
        for (std::size_t i = 0; i < tokens_.size(); ++i) declare(i);
        block_.declarations.push_back({mark_.name, fmt::format("type {}(node{}).", mark_.name, mark_.arguments.empty() ? "" : ", int")});
        block_.known.push_back(mark_);
        for (std::int64_t n = 1 + below(random_, 4); n > 0; --n) rule();
        return std::move(block_);
    }

  private:
    void declare(std::size_t i) {
        const Token& t = tokens_[i];
        block_.declarations.push_back({t.name, fmt::format("type linear {}(node{}).", t.name, t.counts ? ", int" : "")});
        if (i == 0 || chance(random_, 40)) {
            retraction::Given given{.predicate = t.name, .arguments = {}, .per_mille = static_cast<int>(40 + below(random_, 250)), .linear = true};
            if (t.counts) given.arguments.push_back({0, 3});
            block_.given.push_back(given);
        }
        if (chance(random_, 30)) block_.rules.push_back({.heads = {atom(t, chance(random_, 40) ? "@1" : "A", std::to_string(below(random_, 4)))}});
    }

    void rule() {
        Body body(random_, known_);
        body.for_linear = true;
        const std::size_t first = static_cast<std::size_t>(below(random_, static_cast<std::int64_t>(tokens_.size())));
        std::size_t latest = first;
        body.clause(atom(tokens_[first], "A", "L"));
        bool counted = tokens_[first].counts;
        if (chance(random_, 30)) {
            const std::size_t second = static_cast<std::size_t>(below(random_, static_cast<std::int64_t>(tokens_.size())));
            latest = std::max(latest, second);
            body.clause((chance(random_, 25) ? "$" : "") + atom(tokens_[second], "A", chance(random_, 50) ? "M" : "L"));
        }
        const bool links = chance(random_, 40);
        if (links) body.link("A");
        if (chance(random_, 55)) body.read_any(body.any_catom());
        if (chance(random_, 30)) body.test();
        if (chance(random_, 25)) body.negate();
        if (chance(random_, 12)) body.clause("not " + atom(pick(random_, tokens_), "A", "_"));
        const bool guarded = counted && chance(random_, 70);
        if (guarded) body.clause("L > 0");
        DraftRule rule{.heads = {}, .body = body.clauses(), .linear = true};
        for (std::int64_t n = below(random_, 3) + 1; n > 0; --n) head(body, first, latest, counted, guarded, links, rule.heads);
        block_.rules.push_back(std::move(rule));
    }

    // A token that this rule may make without running for ever, or none.
    std::string token(const std::string& at, std::size_t latest, std::size_t first, bool guarded) {
        if (guarded && tokens_[first].counts && chance(random_, 60) && first == latest) return atom(tokens_[first], at, "L - 1");
        if (latest + 1 >= tokens_.size()) return "";
        const Token& next = tokens_[latest + 1 + static_cast<std::size_t>(below(random_, static_cast<std::int64_t>(tokens_.size() - latest - 1)))];
        return atom(next, at, std::to_string(below(random_, 4)));
    }

    std::string mark(Body& body, const std::string& at, bool counted) {
        if (mark_.arguments.empty()) return fmt::format("{}({})", mark_.name, at);
        return fmt::format("{}({}, {})", mark_.name, at, counted && chance(random_, 50) ? "L" : body.expression(Kind::Int));
    }

    void head(Body& body, std::size_t first, std::size_t latest, bool counted, bool guarded, bool links, std::vector<std::string>& heads) {
        const std::string there = links && chance(random_, 60) ? body.catoms().back() : "A";
        std::string text;
        switch (below(random_, 7)) {
            case 0: text = token(there, latest, first, guarded); break;
            case 1:
            case 2: text = mark(body, there, counted); break;
            case 3: {
                const std::string inner = chance(random_, 50) ? token("Y", latest, first, guarded) : mark(body, "Y", counted);
                if (!inner.empty()) text = "{ Y | neighbor(A, Y) | " + inner + " }";
                break;
            }
            case 4: {
                // Everything of one kind is consumed.
                const Token& t = pick(random_, tokens_);
                text = t.counts ? fmt::format("{{ U | {} | {}(A{}) }}", atom(t, "A", "U"), mark_.name, mark_.arguments.empty() ? "" : ", U % 5") : fmt::format("{{ | {} | {} }}", atom(t, "A", ""), mark(body, "A", counted));
                break;
            }
            case 5: {
                if (mark_.arguments.empty()) break;
                text = fmt::format("{{ U | {0}(A, U){1} | {0}(A, (U + 1) % 4) }}", mark_.name, chance(random_, 50) ? ", U < 3" : "");
                break;
            }
            default: text = "setColor(A, 1, 2, 3)";
        }
        if (!text.empty()) heads.push_back(text);
    }

    Random& random_;
    const std::vector<Known>& known_;
    std::vector<Token> tokens_;
    Known mark_;
    Block block_;
};

}  // namespace

Block linear_block(Random& random, const std::vector<Known>& known, int names) { return LinearRules(random, known, names).make(); }

}  // namespace meld::reference
