// What catoms look like, as their actions say (setColor, setLabel, drawLine): colours, labels and lines. Private to runtime/results/record.
#pragma once

#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "runtime/engine/tuple/program_actions.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::record {

// Each process collects the requests of its catoms; the process that writes gets them before each step and stores them all. So a catom
// keeps its colour when it migrates.
class Appearance {
  public:
    void start(const tuple::ProgramActions& actions);
    bool labels() const { return labels_set_; }
    bool lines() const { return lines_drawn_; }

    // After a tick, on every process: collects the requests of the tick.
    void collect(sim::Subdomain& subdomain);
    // Moves what was collected since the last call into `out`; the writing process reads them with receive(), from all processes in any
    // order, and calls begin_step() first.
    void send(ByteWriter& out);
    void begin_step();
    void receive(ByteReader& in);
    // Of whom colours or labels have come since begin_step(), in any order; some perhaps again.
    const std::vector<u64>& news() const { return news_; }
    // How often colours or labels have come: pictures with the same number have the same ones.
    std::uint64_t changes() const { return changes_; }

    // What is collected and not sent yet, on every process; on the writing process also what is drawn so far. Of what was saved on any
    // number of processes, the writing process loads everything.
    void save(bool writes, ByteWriter& out) const;
    void load(bool wrote, ByteReader& in);

    // On the writing process, for a catom by its id; grey and empty if it has none.
    std::uint32_t colour(u64 id) const;
    const std::string& label(u64 id) const;
    // Pairs of ids, in order. Call it when that of all processes has been received.
    std::vector<std::pair<u64, u64>> drawn();

  private:
    // If a catom has several in one step, that of the latest tick counts.
    struct Colour {
        i64 tick = -1;
        std::uint32_t rgb = 0;
    };
    struct Label {
        i64 tick = -1;
        std::string text;
    };
    using Colours = std::unordered_map<u64, Colour>;
    using Labels = std::unordered_map<u64, Label>;
    static void write(const Colours& colours, ByteWriter& out);
    static void write(const Labels& labels, ByteWriter& out);
    void read(Colours& colours, ByteReader& in);
    void read(Labels& labels, ByteReader& in);
    void write_new(ByteWriter& out) const;
    // From one catom to another; a line to itself removes all its lines. A passing line is in this step only.
    struct Line {
        i64 tick = 0;
        u64 from = 0, to = 0;
        bool passing = false;
    };

    bool labels_set_ = false, lines_drawn_ = false;  // Whether the program has such actions.
    Colours new_colours_, colours_;
    Labels new_labels_, labels_;
    std::vector<Line> new_lines_, received_;
    std::set<std::pair<u64, u64>> lines_;
    std::vector<u64> news_;
    std::uint64_t changes_ = 0;
};

}  // namespace meld::record
