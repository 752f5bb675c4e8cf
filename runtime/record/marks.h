// What catoms have put into the picture of a run: colours, labels and lines. Private to runtime/record.
#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "runtime/sim/core/subdomain.h"
#include "runtime/tuple/program_actions.h"

namespace meld::record {

// Each process collects what its catoms ask for; the process that writes gets it before each step, and keeps it all. So a catom
// keeps its colour when it moves to another process.
class Marks {
  public:
    void start(const tuple::ProgramActions& actions);
    bool labels() const { return labels_set_; }
    bool lines() const { return lines_drawn_; }

    // After a tick, on every process: what was asked for in it.
    void collect(sim::Subdomain& part);
    // Moves what has been collected since the last call into `out`; receive() reads it on the writing process, of all processes in
    // any order, and begin_step() before the first.
    void send(ByteWriter& out);
    void begin_step();
    void receive(ByteReader& in);

    // On the writing process, of a catom by its id; grey and empty where it has none.
    std::uint32_t colour(u64 id) const;
    const std::string& label(u64 id) const;
    // Pairs of ids, in order. Call it when all processes have been received.
    std::vector<std::pair<u64, u64>> drawn();

  private:
    // Of several in one step the one of the latest tick counts.
    struct Colour {
        i64 tick = -1;
        std::uint32_t rgb = 0;
    };
    struct Label {
        i64 tick = -1;
        std::string text;
    };
    // From a catom to another; to itself it takes its lines away. A passing one is in this step alone.
    struct Line {
        i64 tick = 0;
        u64 from = 0, to = 0;
        bool passing = false;
    };

    bool labels_set_ = false, lines_drawn_ = false;  // Whether the program has such actions.
    std::unordered_map<u64, Colour> new_colours_, colours_;
    std::unordered_map<u64, Label> new_labels_, labels_;
    std::vector<Line> new_lines_, received_;
    std::set<std::pair<u64, u64>> lines_;
};

}  // namespace meld::record
