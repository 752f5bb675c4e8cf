// A CodeModule that acts and sends: each catom on the ground asks to be put on top of the pile, and the least of them is granted it
// in each tick. All greet their neighbours and say where they are, and who arrives prints how often it has asked.
#include <string>

#include "examples.h"

namespace {

class Pile : public meld::sim::CodeModule {
  public:
    Instances instances() const override { return Instances::PerCatom; }

    meld::Result<void> look_up(const meld::sim::Names& names) override {
        const auto move = names.action("moveTo", 3), print = names.action("print", 1), greeting = names.linear("greeting", 3);
        for (const auto& found : {move, print, greeting})
            if (!found) return tl::unexpected(found.error());
        move_ = *move;
        print_ = *print;
        greeting_ = *greeting;
        return {};
    }

    void run(meld::sim::CatomView& catom) override {
        const meld::world::Vec3 at = catom.position();
        if (at[2] == 0) {
            // Carried out in the next tick, if no catom with a smaller id wants the same place.
            catom.act(move_, {0, 0, catom.tick()});
            ++state_.requests;
        } else if (!state_.arrived) {
            catom.act(print_, {"arrived after " + std::to_string(state_.requests) + " requests"});
            state_.arrived = true;
        }
        for (const meld::sim::CatomId other : catom.neighbors())
            catom.send(other, greeting_, {meld::sim::CatomId{catom.id()}, "hello", std::vector<meld::sim::Argument>{at[0], at[1], at[2]}});
    }

    void save(meld::ByteWriter& out) const override { out.write(state_); }
    void load(meld::ByteReader& in) override { state_ = in.read<State>(); }

  private:
    struct State {
        std::int64_t requests = 0;
        bool arrived = false;
    };
    State state_;
    meld::sim::Predicate move_, print_, greeting_;
};

}  // namespace

std::unique_ptr<meld::sim::CodeModule> make_pile() { return std::make_unique<Pile>(); }
