// How busy each catom was between two steps of a recording: arrays of a run that is counted.
#pragma once

#include <cstdint>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "runtime/base/bytes.h"
#include "runtime/results/record/recording.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::record {

// Their names begin so.
inline constexpr std::string_view kLoadArrays = "load.";

class LoadMap {
  public:
    // Since the run was begun, or gone on with.
    struct Load {
        std::uint64_t evaluations = 0, messages = 0;
    };

    // What this process has counted: of catoms that have left it, and of one that is here.
    void send(const sim::Subdomain& subdomain, ByteWriter& out) const;
    static Load here(const sim::Subdomain& subdomain, sim::Catom catom);

    // A step on process 0: what has come from each, then add() for all catoms by their numbers, and what is listed is valid until the
    // next.
    void begin_step();
    void receive(ByteReader& in);
    void add(std::uint64_t id, const Load& here);
    void list(std::vector<RecordedArray>& arrays) const;

  private:
    struct Total {
        std::uint64_t id;
        Load load;
    };
    std::unordered_map<std::uint64_t, Load> elsewhere_;  // By process that they have left, added up.
    std::vector<Total> before_, now_;                    // By number.
    std::size_t next_ = 0;                               // Of those before.
    std::vector<std::int64_t> evaluations_, messages_;   // Of the step.
};

}  // namespace meld::record
