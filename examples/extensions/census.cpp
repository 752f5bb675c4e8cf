// A SimModule: it sees the whole ensemble and reports the greatest number of catoms there was.
#include <algorithm>
#include <cstdint>
#include <string>

#include "examples.h"
#include "runtime/sim/core/subdomain.h"

namespace {

class Census : public meld::sim::SimModule {
  public:
    meld::Result<void> after(meld::sim::Subdomain& subdomain) override {
        most_ = std::max(most_, subdomain.totals.catoms);
        return {};
    }
    // So that a run that is stopped and goes on reports the greatest number of all its ticks.
    meld::Result<void> saveable() const override { return {}; }
    void save_rest(const meld::sim::Subdomain&, meld::ByteWriter& out) const override { out.write(most_); }
    meld::Result<void> load_rest(meld::sim::Subdomain&, meld::ByteReader& in) override {
        most_ = std::max(most_, in.read<std::uint64_t>());
        return {};
    }
    std::string outcome() const override { return "at most " + std::to_string(most_) + " catoms"; }

  private:
    std::uint64_t most_ = 0;
};

}  // namespace

std::unique_ptr<meld::sim::SimModule> make_census() { return std::make_unique<Census>(); }
