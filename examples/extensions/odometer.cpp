// A CodeModule with an object for each catom: it counts the moves of its catom and follows it from process to process.
#include <cstring>

#include "examples.h"

namespace {

class Odometer : public meld::sim::CodeModule {
  public:
    Instances instances() const override { return Instances::PerCatom; }

    void run(meld::sim::CatomView& catom) override {
        const meld::world::Vec3 now = catom.position();
        if (state_.known && now != state_.last) ++state_.moves;
        state_.last = now;
        state_.known = true;
        catom.sense("odometer", {static_cast<double>(state_.moves)});
    }

    std::vector<std::byte> save() const override {
        std::vector<std::byte> bytes(sizeof state_);
        std::memcpy(bytes.data(), &state_, sizeof state_);
        return bytes;
    }
    void load(const std::vector<std::byte>& bytes) override {
        if (bytes.size() == sizeof state_) std::memcpy(&state_, bytes.data(), sizeof state_);
    }

  private:
    struct State {
        meld::world::Vec3 last{};
        long moves = 0;
        bool known = false;
    };
    State state_;
};

}  // namespace

std::unique_ptr<meld::sim::CodeModule> make_odometer() { return std::make_unique<Odometer>(); }
