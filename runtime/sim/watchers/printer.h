// The actions `print` and `write-string`: the output of catoms, one line each, in the same order for any number of processes.
#pragma once

#include <cstdio>

#include "runtime/module/abi/module_abi.h"
#include "runtime/sim/core/extension.h"

namespace meld::sim {

class Printer : public SimModule {
  public:
    // Process 0 writes the lines; the others send it the output of their catoms.
    explicit Printer(std::FILE* to) : to_(to) {}
    Result<void> start(Subdomain& subdomain) override;
    Result<void> saveable() const override { return {}; }
    bool leaves_facts_alone(const Subdomain&) const override { return true; }
    // After each tick, ordered by the numbers of the catoms and then by text.
    Result<void> after(Subdomain& subdomain) override;

  private:
    std::FILE* to_;
    bool prints_ = false;  // The program uses one of the two.
};

}  // namespace meld::sim
