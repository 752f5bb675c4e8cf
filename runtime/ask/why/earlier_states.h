// Questions that look back: a state of the run for each tick that they turn out to need.
#pragma once

#include <functional>
#include <string>

#include "runtime/ask/why/explainer.h"
#include "runtime/results/timeline/timeline.h"

namespace meld::inspect {

// Process 0 runs `question` on a program with this body, with the timeline's state; and again with more states before it as long as it
// wants some that can be had. Every process calls it, and gets the outcome of process 0. Errors: those of the question, of
// Program::read() and of the timeline; a signal has asked for the end.
Result<void> ask_back(timeline::Timeline& timeline, const std::string& body, const std::function<Result<void>(Explainer&)>& question);

// So many ticks before the timeline's, at most: each is a state of all catoms in memory.
constexpr std::size_t kMostStates = 16;

}  // namespace meld::inspect
