// Tells the processes of an ensemble, in the central phase, what a case changes. Every process has its own, runs the same
// schedule, and does what concerns the catoms it knows.
#pragma once

#include <optional>

#include "case.h"
#include "runtime/sim/core/extension.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::retraction {

class Changes : public sim::SimModule {
  public:
    Changes(const Case& c, const std::vector<Given>& given) : case_(c), mirror_(c, given) {}

    void begin_burst(std::size_t burst, std::int64_t tick) {
        burst_ = burst;
        start_ = tick;
        next_ = 0;
    }
    bool done() const { return next_ == case_.bursts[burst_].size() && mirror_.hung.empty(); }
    // Goes on where another one of the same case is.
    void go_on(const Changes& other) {
        mirror_.become(other.mirror_);
        burst_ = other.burst_;
        start_ = other.start_;
        next_ = other.next_;
    }
    // This change happens in the book alone.
    void lose(const Change* change) { lost_ = change; }

    Result<void> step(sim::Subdomain& subdomain) override;

  private:
    void apply(sim::Subdomain& subdomain, const Change& change, std::uint64_t id);
    void give_or_take(sim::Subdomain& subdomain, const Given& given, const Change& change) const;
    void change_link(sim::Subdomain& subdomain, const Change& change) const;
    std::optional<sim::Catom> find(const sim::Subdomain& subdomain, Cell cell) const;
    void restart(sim::Subdomain& subdomain, std::uint64_t id) const;
    static bool sees(const sim::Subdomain& subdomain, Cell cell);
    static void add(sim::Subdomain& subdomain, std::uint64_t id, Cell cell);
    static void move(sim::Subdomain& subdomain, std::uint64_t id, Cell from, Cell to);

    const Case& case_;
    Mirror mirror_;
    std::size_t burst_ = 0, next_ = 0;
    std::int64_t start_ = 0;
    const Change* lost_ = nullptr;
};

}  // namespace meld::retraction
