// A Component: the level of the water is decided for the whole ensemble, and each catom senses its depth in the same tick.
#include "examples.h"

namespace {

class Tide : public meld::sim::Component {
  public:
    // The level depends on the number of steps alone, so all processes have the same.
    meld::Result<void> step(meld::sim::Subdomain&) override {
        ++ticks_;
        return {};
    }
    // The number of steps goes into checkpoints; all processes write the same.
    meld::Result<void> saveable() const override { return {}; }
    void save_rest(const meld::sim::Subdomain&, meld::ByteWriter& out) const override { out.write(ticks_); }
    meld::Result<void> load_rest(meld::sim::Subdomain&, meld::ByteReader& in) override {
        ticks_ = in.read<int>();
        return {};
    }
    meld::Result<void> look_up(const meld::sim::Names& names) override {
        return names.sensed("depth", 1).map([this](meld::sim::Predicate found) { depth_ = found; });
    }
    void run(meld::sim::CatomView& catom) override {
        const double level = ticks_ % 2 == 0 ? 0.5 : 1.5;
        catom.sense(depth_, {level - catom.position()[2]});
    }

  private:
    meld::sim::Predicate depth_;
    int ticks_ = 0;
};

}  // namespace

std::unique_ptr<meld::sim::Component> make_tide() { return std::make_unique<Tide>(); }
