// Judges one way in which an answer says that a fact was derived.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tests/reference/answers/judge.h"
#include "tests/reference/evaluator/apart.h"

namespace meld::reference {

// Whether an answer says of a fact in recursion that it has found it on no facts of lower rank.
inline bool unranked(const Answer::Node& node) {
    return node.note.find("ranks do not say here what rests on what") != std::string::npos ||
           node.note == "it rests on itself among the values that hold: one that has been replaced began it";
}
// Whether it says of a group, which stands with _, that it has a value before the value itself is there.
inline bool without_value(const Answer::Node& node, const Pattern& fact) {
    return !fact.whole() && node.note == "it has a value, and which one still waits for a quarantine";
}
// Ways of a combined fact and matches of an aggregate that are shown if not all are asked for.
constexpr std::size_t kShown = 10;

class WayJudge {
  public:
    // All outlive it. `facts` are those of the answer's nodes.
    WayJudge(const Past& past, const Answer& answer, const AskedFor& asked, Judged& judged, const std::vector<Pattern>& facts)
        : past_(past), program_(past.program()), bodies_(past), answer_(answer), asked_(asked), judged_(judged), facts_(facts) {}

    // Whether the rule that is named gives the fact from the facts, absences and conditions that are named, in the tick of the node, or
    // where they were read; and from nothing else.
    bool so(std::size_t node, const Answer::Way& way, const Pattern& fact);
    // The rule that is named, if it gives such facts.
    std::optional<HeadOf> head_of(const Answer::Way& way, PredicateId p);
    // Why not.
    const std::string& why() const { return why_; }

    // Every way in which a rule derives something at a catom.
    void each_derivation(const HeadOf& head, std::int64_t catom, const When& when,
                         const std::function<void(const Row&, const Environment&)>& visit) const;
    // The same where each derivation counts for itself: of a head with a delay, only those that have waited.
    void each_counted(const HeadOf& head, std::int64_t catom, const When& when,
                      const std::function<void(const Row&, const Environment&)>& visit) const;

  private:
    // Which parts are facts of which atoms, and what stands for the other clauses.
    struct Assigned {
        std::map<const check::Atom*, Rows> named;
        std::map<const check::Clause*, const Answer::Part*> absent;
        struct Matches {
            std::size_t count = 0;
            std::vector<const Answer::Part*> facts;  // Of some of them.
        };
        std::map<const check::Clause*, Matches> matches;  // Of aggregates.
        std::vector<std::string> conditions;
    };
    bool fails(std::string why);
    bool assign(std::size_t i, const Answer::Way& w, const HeadOf& head, const When& when, Assigned& out);
    bool fact_part(std::size_t i, const Answer::Part& part, const HeadOf& head, const check::Atom& atom, std::int64_t tick, Rows& out);
    bool asks_only_existence(const HeadOf& head, const Pattern& made, const check::Atom& atom) const;
    std::optional<Row> some_row(const Pattern& group) const;
    bool lower(std::size_t head, std::size_t body);
    bool body(std::size_t i, const Answer::Way& w, const HeadOf& head, const Pattern& fact, const Environment& with, const When& when);
    bool gives(const HeadOf& head, const Environment& env, const Pattern& fact);
    bool printed(const HeadOf& head, const Environment& env, const Assigned& parts);
    bool matched(std::size_t i, const HeadOf& head, const Environment& env, const Assigned& parts, const When& when);
    bool held_long_enough(const HeadOf& head, const Pattern& fact, const When& when);
    bool given_by(const HeadOf& head, const Pattern& fact, const When& when) const;
    bool waited(const Apart& apart, const Environment& env, std::int64_t now) const;

    const Past& past_;
    const check::Program& program_;
    const Bodies bodies_;
    const Answer& answer_;
    const AskedFor& asked_;
    Judged& judged_;
    const std::vector<Pattern>& facts_;
    std::string why_;
};

}  // namespace meld::reference
