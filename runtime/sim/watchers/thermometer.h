// The example of hand-written modules: three thermometers behind one interface, two CodeModules and a Component. A program
// that declares `type sensed temperature(node, first float Degrees).` and a world with `[components] thermometer =
// "plane"`, "drift" or "weather" use it.
#pragma once

#include <string>

#include "runtime/sim/core/extension.h"

namespace meld::sim {

// The temperature falls along x by half a degree a diameter, and does not change: one object serves all catoms.
class PlaneThermometer : public CodeModule {
  public:
    Result<void> look_up(const Names& names) override {
        return names.sensed("temperature", 1).map([this](Predicate found) { temperature_ = found; });
    }
    void run(CatomView& catom) override { catom.sense(temperature_, {20.0 - 0.5 * catom.position()[0]}); }

  private:
    Predicate temperature_;
};

// Each catom warms by a tenth of a degree a tick up to 30 degrees, wherever it goes: it has its own state, which migrates with it.
class DriftingThermometer : public CodeModule {
  public:
    Instances instances() const override { return Instances::PerCatom; }
    Result<void> look_up(const Names& names) override {
        return names.sensed("temperature", 1).map([this](Predicate found) { temperature_ = found; });
    }
    void run(CatomView& catom) override {
        if (tenths_ < 300) ++tenths_;
        catom.sense(temperature_, {tenths_ / 10.0});
    }
    void save(ByteWriter& out) const override { out.write(tenths_); }
    void load(ByteReader& in) override { tenths_ = in.read<int>(); }

  private:
    Predicate temperature_;
    int tenths_ = 150;
};

// The weather of the day is decided centrally, in the same way on every process because it depends only on the seed and the tick; each
// catom senses it, colder by half a degree per diameter of height.
class Weather : public Component {
  public:
    explicit Weather(std::uint64_t seed) : seed_(seed) {}
    Result<void> step(Subdomain& subdomain) override;
    // Today's weather is decided anew before anybody feels it.
    Result<void> saveable() const override { return {}; }
    Result<void> look_up(const Names& names) override {
        return names.sensed("temperature", 1).map([this](Predicate found) { temperature_ = found; });
    }
    void run(CatomView& catom) override { catom.sense(temperature_, {today_ - 0.5 * catom.position()[2]}); }
    std::string status() const override;

  private:
    Predicate temperature_;
    std::uint64_t seed_;
    double today_ = 15;
};

}  // namespace meld::sim
