#include "runtime/ask/why/firings.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "runtime/ask/why/heads.h"

namespace meld::inspect {

namespace {

using check::Clause;
using check::Head;
using check::Rule;
using Part = Explanation::Part;

// So many ways are described.
constexpr std::size_t kMostWays = 3;

// Looks for the firings of one rule after the other in which an atom, of a head or of a body, is the fact.
class Finder {
  public:
    Finder(Explainer& explainer, const Known& fact) : e_(explainer), fact_(fact) {}

    Result<Firings> made() {
        const auto look = [&](const Rule& rule) { return by_heads(rule); };
        return find(e_.linear_rules(fact_.predicate), look, [&](const Rule& rule) { return makes_here(rule); });
    }
    Result<Firings> took() {
        std::vector<const Rule*> rules;
        for (const Rule& rule : e_.checked().rules)
            if (rule.linear && consumes(rule)) rules.push_back(&rule);
        const auto look = [&](const Rule& rule) -> Result<void> {
            if (auto done = by_body(rule, rule.body, {}); !done) return done;
            return by_matches(rule);
        };
        // A linear rule consumes what is at its catom.
        return find(rules, look, [](const Rule&) { return true; });
    }

  private:
    // First all facts as they were before the tick; then, if nothing is found, what else has changed in it, as by an event.
    template <class Look, class Here>
    Result<Firings> find(const std::vector<const Rule*>& rules, const Look& look, const Here& here) {
        for (const Explainer::Search& how : {Explainer::Search{.age = 1}, Explainer::Search{.spread = true, .linear_before = true}}) {
            how_ = how;
            for (const Rule* rule : rules)
                if (auto done = look(*rule); !done) return tl::unexpected<Error>(done.error());
            if (found_.count > 0) break;
        }
        // One rule alone can have done it, and what is sensed as linear facts has come in the tick: it took that.
        if (found_.count == 0 && fits_.size() == 1 && senses(*fits_[0])) {
            sensed_in_tick_ = true;
            if (auto done = look(*fits_[0]); !done) return tl::unexpected<Error>(done.error());
        }
        for (const Rule* rule : fits_) found_.rules += (found_.rules.empty() ? "" : ", ") + fmt::format("{}:{}", rule->file, rule->line);
        if (found_.count == 0 && fits_.size() == 1) {
            found_.ways.push_back(e_.way_of(*fits_[0]));
            if (here(*fits_[0])) found_.ways.back().catom = fact_.catom;
        }
        return std::move(found_);
    }
    // A linear fact that comes from outside and goes when a rule takes it, such as that a joint broke.
    bool comes_in_tick(const Clause& c) const {
        if (c.kind != Clause::Kind::Atom || c.atom.read_only) return false;
        const check::Predicate& p = e_.predicate(c.atom.predicate);
        return p.sensed && p.linear();
    }
    bool senses(const Rule& rule) const {
        return std::ranges::any_of(rule.body, [&](const Clause& c) { return comes_in_tick(c); });
    }
    // Takes such atoms out of a body that is to be looked up.
    std::vector<Clause> take_out_sensed(PartialMatch& match) const {
        std::vector<Clause> out, left;
        std::size_t own = 0;
        for (std::size_t c = 0; c < match.body.size(); ++c) {
            const bool goes = c < match.own && comes_in_tick(match.body[c]);
            own += c < match.own && !goes ? 1 : 0;
            (goes ? out : left).push_back(match.body[c]);
        }
        // It is no longer the body of a rule, whose atoms must match different facts.
        match.body = std::move(left), match.own = own, match.of = nullptr;
        return out;
    }
    // Whether the fact is one of the catom at which the rule fires.
    bool makes_here(const Rule& rule) const {
        bool here = true;
        check::each_head(rule.heads, [&](const Head& h) {
            if (h.kind != Head::Kind::Fact || h.atom.predicate != fact_.predicate) return;
            const check::Term& at = h.atom.arguments[0];
            here = here && at.is_variable() && at.variable == rule.site;
        });
        return here;
    }
    bool is_it(const Clause& c) const { return c.kind == Clause::Kind::Atom && c.atom.predicate == fact_.predicate && !c.atom.read_only; }
    bool consumes(const std::vector<Clause>& body) const {
        return std::ranges::any_of(body, [&](const Clause& c) { return is_it(c); });
    }
    // Comprehensions consume as well what they match.
    bool consumes(const Rule& rule) const {
        bool any = consumes(rule.body);
        each_head_within(rule, [&](const HeadWithin& h) { any = any || consumes(h.head.body); });
        return any;
    }
    Result<void> by_heads(const Rule& rule) {
        Result<void> done;
        each_head_within(rule, [&](const HeadWithin& h) {
            if (done && h.head.kind == Head::Kind::Fact && h.head.atom.predicate == fact_.predicate) done = by(rule, h.head.atom, h.around);
        });
        return done;
    }
    Result<void> by_body(const Rule& rule, const std::vector<Clause>& body, const std::vector<Clause>& more) {
        for (const Clause& c : body)
            if (is_it(c))
                if (auto done = by(rule, c.atom, more); !done) return done;
        return {};
    }
    Result<void> by_matches(const Rule& rule) {
        Result<void> done;
        each_head_within(rule, [&](const HeadWithin& h) {
            if (done) done = by_body(rule, h.head.body, h.around);
        });
        return done;
    }
    Result<void> by(const Rule& rule, const check::Atom& atom, const std::vector<Clause>& more) {
        std::optional<PartialMatch> match = e_.match_head(rule, atom, fact_, false, more);
        if (!match) return {};
        if (std::ranges::find(fits_, &rule) == fits_.end()) fits_.push_back(&rule);
        if (!e_.cannot(match->body).empty()) return {};
        const std::vector<Clause> sensed = sensed_in_tick_ ? take_out_sensed(*match) : std::vector<Clause>();
        const Bound bound = bound_by(*match);
        const Result<bool> done = e_.search(*match, how_, [&](const Solution& solution) {
            Explanation::Way way = e_.way_of(rule);
            if (rule.site.valid() && bound[rule.site.index()]) way.catom = solution.values[rule.site.index()].catom;
            for (std::size_t c = 0; c < match->own; ++c)
                if (solution.facts[c] != nullptr) {
                    const Clause& clause = match->body[c];
                    const std::size_t linear = how_.linear_before ? e_.linear_age(clause) : 0;
                    const std::size_t age = how_.age + std::max(linear, e_.age_of(*match, clause, how_.spread));
                    way.parts.push_back({.is = Part::Is::Fact,
                                         .text = e_.text(e_.keep(clause.atom.predicate, *solution.facts[c], age)),
                                         .tick = e_.states().tick - static_cast<i64>(age)});
                }
            for (const Clause& clause : sensed)
                way.parts.push_back({.is = Part::Is::Fact,
                                     .text = e_.print(e_.named(*match, solution.values, bound), clause),
                                     .tick = e_.states().tick,
                                     .note = "sensed"});
            // Several heads of a rule may give the same fact: that is one firing.
            std::string key = fmt::format("{}:{}: {} @{}", way.file, way.line, way.text, way.catom.value_or(0));
            for (const Part& part : way.parts) key += fmt::format(", {} in {}", part.text, part.tick.value_or(0));
            if (!seen_.insert(std::move(key)).second || ++found_.count > kMostWays) return true;
            found_.ways.push_back(std::move(way));
            return true;
        });
        if (!done) return tl::unexpected<Error>(done.error());
        return {};
    }

    Explainer& e_;
    const Known& fact_;
    bool sensed_in_tick_ = false;
    Explainer::Search how_ = {};
    std::vector<const Rule*> fits_;  // Those of which some atom can be the fact.
    std::set<std::string> seen_;     // The firings that were found.
    Firings found_;
};

}  // namespace

Result<Firings> that_made(Explainer& explainer, const Known& fact) { return Finder(explainer, fact).made(); }
Result<Firings> that_took(Explainer& explainer, const Known& fact) { return Finder(explainer, fact).took(); }

}  // namespace meld::inspect
