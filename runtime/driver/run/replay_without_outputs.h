// A run that is made again, without what it writes: its snapshots have something of the modules that do.
#pragma once

#include <string>
#include <vector>

#include "runtime/driver/setup/options.h"
#include "runtime/sim/core/extension.h"

namespace meld::driver {

// The modules of a run that write, as simulate() adds and names them.
std::vector<std::string> writing_modules(const RunOptions& options);

// In place of a module of the run that writes: what that has kept in a checkpoint is read and forgotten.
class Silent : public sim::SimModule {
  public:
    bool runnable() const override { return false; }
    Result<void> saveable() const override { return {}; }
    void load_catoms(sim::Subdomain&, std::span<const tuple::SavedCatom>, ByteReader& in) override { in.read_bytes(in.left()); }
    Result<void> load_rest(sim::Subdomain&, ByteReader& in) override {
        in.read_bytes(in.left());
        return {};
    }
};

}  // namespace meld::driver
