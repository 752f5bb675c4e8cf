// A CodeModule with an object for each catom: it counts the moves of its catom and follows it from process to process. It also
// reads a fact of the program and writes a string and a list: who stands in the water says so, with its last position.
#include "examples.h"

namespace {

class Odometer : public meld::sim::CodeModule {
  public:
    Instances instances() const override { return Instances::PerCatom; }

    meld::Result<void> look_up(const meld::sim::Names& names) override {
        const auto moves = names.sensed("odometer", 1), log = names.sensed("log", 2), wet = names.stored("wet", 0);
        for (const auto& found : {moves, log, wet})
            if (!found) return tl::unexpected(found.error());
        moves_ = *moves;
        log_ = *log;
        wet_ = *wet;
        return {};
    }

    void run(meld::sim::CatomView& catom) override {
        const meld::world::Vec3 now = catom.position();
        if (state_.known && now != state_.last) ++state_.moves;
        state_.last = now;
        state_.known = true;
        catom.sense(moves_, {state_.moves});
        const bool wet = !catom.facts(wet_).empty();
        catom.sense(log_, {wet ? "wet" : "dry", std::vector<meld::sim::Argument>{now[0], now[1], now[2]}});
    }

    void save(meld::ByteWriter& out) const override { out.write(state_); }
    void load(meld::ByteReader& in) override { state_ = in.read<State>(); }

  private:
    struct State {
        meld::world::Vec3 last{};
        std::int64_t moves = 0;
        bool known = false;
    };
    State state_;
    meld::sim::Predicate moves_, log_, wet_;
};

}  // namespace

std::unique_ptr<meld::sim::CodeModule> make_odometer() { return std::make_unique<Odometer>(); }
