// Judges why a fact does not hold although a rule's body is met: what an answer says of it.
#pragma once

#include <set>
#include <string>

#include "tests/reference/answers/judge.h"

namespace meld::reference {

class YetJudge {
  public:
    // All outlive it.
    YetJudge(const Past& past, std::int64_t tick, Judged& judged)
        : past_(past), program_(past.program()), bodies_(past), tick_(tick), judged_(judged) {}

    // Whether the body is met, and the note says why there is no such fact.
    bool so(const Answer::Way& way, const HeadOf& head, const Pattern& fact);
    // Why not.
    const std::string& why() const { return why_; }

    // Whether some way to satisfy the body gives the fact.
    bool met(const HeadOf& head, const Pattern& fact, const When& when) const;

  private:
    const Moment& now() const { return past_.at(tick_); }
    bool fails(std::string why);
    bool consumes_of_several(const HeadOf& h) const;
    bool too_short(const HeadOf& h, const Pattern& fact);
    bool others_hold(const Answer::Way& w, const HeadOf& h, const Pattern& fact);
    bool waits(const Answer::Way& w, const HeadOf& h, const Pattern& fact);
    std::set<std::int64_t> silent(const Pattern& fact, const std::set<std::int64_t>& heard) const;
    bool keeps_apart(const Answer::Way& w, const HeadOf& h, const Pattern& fact);
    bool loses(const Pattern& fact, std::int64_t when);
    bool quarantine(const Answer::Way& w, const Pattern& fact, std::int64_t until);

    const Past& past_;
    const check::Program& program_;
    const Bodies bodies_;
    const std::int64_t tick_;
    Judged& judged_;
    std::string why_;
};

}  // namespace meld::reference
