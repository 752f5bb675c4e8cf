#include "runtime/base/process/tick_log.h"

#include <utility>

namespace meld {

const char* TickLog::name(Stage stage) {
    switch (stage) {
        case Stage::Motion:
            return "motion";
        case Stage::Components:
            return "components";
        case Stage::Events:
            return "events";
        case Stage::Code:
            return "code";
        case Stage::Evaluation:
            return "evaluation";
        case Stage::Commit:
            return "commit";
        case Stage::Exchange:
            return "exchange";
        case Stage::Agreement:
            return "agreement";
        case Stage::Recording:
            return "recording";
        case Stage::Between:
            return "between";
    }
    return "";
}

void TickLog::begin_tick(std::int64_t tick) {
    enter(Stage::Between);
    if (spans_.empty() || spans_.back().last - spans_.back().first + 1 >= ticks_of_a_span_) {
        if (spans_.size() == kMostSpans) halve();
        spans_.push_back({tick, tick, entered_ - start_, {}, std::vector<double>(busy_.size(), 0.0)});
    }
    spans_.back().last = tick;
}

void TickLog::enter(Stage stage) {
    const double at = seconds_now();
    if (!spans_.empty()) {
        spans_.back().seconds[static_cast<std::size_t>(stage_)] += at - entered_;
        for (std::size_t i = 0; i < busy_.size(); ++i) spans_.back().busy[i] += std::exchange(busy_[i].seconds, 0.0);
    }
    entered_ = at;
    stage_ = stage;
}

// Two neighbours become one, so that a run of any length has a log of bounded size.
void TickLog::halve() {
    std::vector<Span> half;
    half.reserve(kMostSpans);
    for (std::size_t i = 0; i + 1 < spans_.size(); i += 2) {
        Span both = std::move(spans_[i]);
        const Span& second = spans_[i + 1];
        both.last = second.last;
        for (std::size_t k = 0; k < kStages; ++k) both.seconds[k] += second.seconds[k];
        for (std::size_t k = 0; k < both.busy.size(); ++k) both.busy[k] += second.busy[k];
        half.push_back(std::move(both));
    }
    spans_ = std::move(half);
    ticks_of_a_span_ *= 2;
}

}  // namespace meld
