// A question to a run on any number of processes: process 0 asks, and the others look up what it needs of them.
#pragma once

#include <functional>
#include <span>

#include "runtime/ask/facts/facts.h"
#include "runtime/base/error.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::inspect {

// Process 0 runs `question` with the facts of these states of one run, such as this tick and the one before; all others serve it until it
// ends. What has come from them is kept until then. Every process calls it with its share of the same states, which do not change
// meanwhile, and gets the outcome of process 0. On one process the facts come straight from the columns.
// Cost on several: two small messages to and from each for every fact that is looked up, and after some of them all facts of the predicate.
Result<void> ask(std::span<sim::Subdomain* const> states, const std::function<Result<void>(std::span<Facts* const>)>& question);

}  // namespace meld::inspect
