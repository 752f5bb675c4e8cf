// The recorder: a SimModule that writes positions, colours and chosen predicates to a VTKHDF file every few ticks.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "runtime/record/recording.h"
#include "runtime/sim/extension.h"
#include "runtime/sim/part_state.h"

namespace meld::record {

class Recorder : public sim::SimModule {
  public:
    // predicates: names of predicates whose first argument after the catom is recorded (1 or 0 where there is none).
    Recorder(std::string path, int every, std::vector<std::string> predicates, RecordingInfo info);
    Result<void> start(sim::PartState& part) override;
    Result<void> after(sim::PartState& part) override;
    void finish(sim::PartState& part) override;
    std::string outcome() const override { return outcome_; }

  private:
    struct Recorded {
        u32 predicate;
        std::string name;
        bool real;
    };
    Result<void> write(sim::PartState& part);
    void colour(sim::PartState& part);

    std::string path_;
    int every_;
    std::vector<std::string> wanted_;
    RecordingInfo info_;
    std::vector<Recorded> recorded_;
    std::optional<u32> set_color_;
    std::unordered_map<u64, std::uint32_t> colours_;  // By id, 0xRRGGBB; catoms that were never coloured are grey.
    std::optional<Recording> file_;
    std::int64_t last_step_ = -1;
    std::uint64_t steps_ = 0;
    std::string outcome_;
};

}  // namespace meld::record
