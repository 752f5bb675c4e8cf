// Runs a case on the runtime and says where it differs from what should hold.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "reference.h"
#include "runtime/base/hash.h"
#include "runtime/module/abi/module_abi.h"

namespace meld::retraction {

struct Setting {
    int processes = 1;
    int threads = 1;
    // Faults planted to see that the test notices them: the network is taken for faster than it is, so that nothing waits
    // in quarantine; the last change of the last burst that means anything is not told to the runtime.
    bool no_quarantine = false;
    bool lose_last_change = false;
    // What holds is not compared with the expectations, but what groups remember of their losses and all ranks join the states.
    bool deep = false;
};

struct Outcome {
    std::string trouble;              // Empty: all is as it should be.
    std::vector<Digest> states = {};  // After every tick.
    std::uint64_t retractions = 0;    // Facts that held at the end of a burst and not at the end of the next.
    std::uint64_t tombstones = 0;     // The most catoms that remembered losses at a time.
    std::uint64_t quarantines = 0;    // Ticks that ended with nothing left but waiting.
    std::uint64_t exchanges = 0;      // Ticks in which processes told each other something.
    std::uint64_t compared = 0;       // Facts.
    std::uint64_t derivations = 0;
};

// What should hold after each burst.
std::vector<Facts> expectations(const Case& c, const Program& program);

Outcome run(const Case& c, const Program& program, const ModuleInfo& module, const std::vector<Facts>& expected, const Setting& setting);

// The smallest case found, by leaving out changes and catoms, that still is in trouble.
Case shrink(Case c, const std::function<bool(const Case&)>& in_trouble);

}  // namespace meld::retraction
