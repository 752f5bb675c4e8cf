// The recorder: a SimModule that writes positions, what catoms draw and chosen predicates to a VTKHDF file every few ticks.
#pragma once

#include <algorithm>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "runtime/base/large_array.h"
#include "runtime/results/record/appearance.h"
#include "runtime/results/record/joint_table.h"
#include "runtime/results/record/load_map.h"
#include "runtime/results/record/recorded_predicate.h"
#include "runtime/results/record/recording.h"
#include "runtime/results/record/state_digest.h"
#include "runtime/sim/core/extension.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::record {

class Recorder : public sim::SimModule {
  public:
    // A run that is loaded from a snapshot appends to its recording, or branches off and begins one of its own, with what catoms have
    // drawn so far.
    enum class Loaded { Appends, Begins };
    // predicates: names of predicates whose facts are recorded.
    Recorder(std::string path, int every, std::vector<std::string> predicates, RecordingInfo info, Loaded loaded = Loaded::Appends);
    // How busy each catom was is recorded too: the run is counted.
    void add_load() { load_.emplace(); }
    // At its end, the recording says what the run has counted.
    void add_counts(std::function<RunCounts()> counts) { counts_ = std::move(counts); }
    Result<void> start(sim::Subdomain& subdomain) override;
    Result<void> after(sim::Subdomain& subdomain) override;
    Result<void> saveable() const override { return {}; }
    Result<void> secure(sim::Subdomain& subdomain) override;
    Result<void> resume(sim::Subdomain& subdomain) override;
    // How far the recording is, and what has been drawn since its last step.
    void save_rest(const sim::Subdomain& subdomain, ByteWriter& out) const override;
    Result<void> load_rest(sim::Subdomain& subdomain, ByteReader& in) override;
    Result<void> resumed(sim::Subdomain& subdomain) override;
    void finish(sim::Subdomain& subdomain) override;
    std::string outcome() const override { return outcome_; }
    Result<void> ending() const override { return ending_; }

  private:
    struct RecordedRow {
        u64 id;
        RecordedPosition position;
        world::Vec3 tail;
        double diameter;
        world::RoundedBody rounded;
    };
    static RecordedRow row_of(const sim::Subdomain& subdomain, sim::Catom catom);
    // A step as its columns, in the order of ids, and what of it is not as it was in the step before.
    struct Step {
        LargeArray<u64> ids;
        LargeArray<RecordedPosition> positions;
        std::vector<world::Vec3> tails;                          // Of amoebots alone.
        std::vector<double> diameters;                           // If bodies differ in size.
        std::vector<std::array<double, 4>> cores, orientations;  // If some are no spheres; the second also where joints hold spheres.
        LargeArray<std::uint8_t> colours;
        std::vector<std::string> labels;
        bool updated = false;  // Made of the step before: these are the rows that are not as they were in it.
        std::vector<u64> moved, changed_tails, changed_diameters, changed_cores, changed_orientations, changed_colours, changed_labels;
    };
    // What is recorded: finds the predicates, and completes info_.
    Result<void> prepare(sim::Subdomain& subdomain);
    // Which arrays say what catoms look like. Motion knows that once it has started, and of a run that goes on only at the end of loading.
    // Errors: a predicate has the name of one.
    Result<void> find_looks(const sim::Subdomain& subdomain);
    // Makes the file, with a first step.
    Result<void> begin(sim::Subdomain& subdomain);
    Result<void> add_predicates(const sim::Subdomain& subdomain);
    Result<void> keep(Result<Recording> file);
    Result<void> write(sim::Subdomain& subdomain);
    // Finds the catoms of this process of which something may have changed since the last step. True: they are what it takes to make this
    // step of the last one; the same on all processes.
    bool find_changes(sim::Subdomain& subdomain);
    bool note_ids(const sim::Subdomain& subdomain);
    // A body that turns where it is has changed, too.
    void note_turns(const sim::Subdomain& subdomain);
    // All that a step has, from all processes.
    std::vector<std::vector<std::byte>> gather(sim::Subdomain& subdomain, bool whole);
    std::vector<std::byte> pack(sim::Subdomain& subdomain, bool whole);
    // What stands before the rows; and a row with what is recorded of it.
    void pack_appearance(const sim::Subdomain& subdomain, ByteWriter& out);
    void pack_facts(sim::Subdomain& subdomain, sim::Catom catom, ByteWriter& out) const;
    // A step anew: appearance, then rows in the order of their ids.
    void begin_rows(std::size_t most);
    void read_appearance(ByteReader& in);
    void add_row(const RecordedRow& row, ByteReader& facts);
    void add_rounded(const world::RoundedBody& body);
    void read_rows(const std::vector<std::vector<std::byte>>& all);
    // A step of the one before it.
    void begin_update();
    // In a column, with what the file would have before and now.
    template <class Column>
    static void replace(Column& column, u64 row, const typename Column::value_type& value, std::vector<u64>& changed) {
        // -0.0 is not 0.0 in the file.
        if (std::memcmp(&column[row], &value, sizeof value) == 0) return;
        column[row] = value;
        changed.push_back(row);
    }
    void replace_rounded(u64 row, const world::RoundedBody& body);
    // Of the last step. In most runs the numbers have no gaps.
    bool has_row(u64 id) const { return (id < step_.ids.size() && step_.ids[id] == id) || std::ranges::binary_search(step_.ids, id); }
    u64 row_with(u64 id) const { return id < step_.ids.size() && step_.ids[id] == id ? id : find_row(id); }
    u64 find_row(u64 id) const;
    void update_rows(const std::vector<std::vector<std::byte>>& all);
    void end_update();
    void update_appearance();
    // The same of a run of one process, where nothing is sent.
    void read_own_appearance(sim::Subdomain& subdomain);
    void take_own(const sim::Subdomain& subdomain);
    void read_own_rows(sim::Subdomain& subdomain);
    bool own_are_as_before(const sim::Subdomain& subdomain) const;
    RowsOfCatoms changed_rows(const sim::Subdomain& subdomain);
    void update_own_rows(sim::Subdomain& subdomain);
    std::vector<RecordedLine> lines_between(std::span<const u64> ids);
    Result<void> write_step(const sim::Subdomain& subdomain, const Digest& state, std::span<const world::JointLook> joints);

    std::string path_;
    int every_;
    std::vector<std::string> wanted_;
    bool has_tails_ = false, has_diameters_ = false, has_rounded_ = false, has_turns_ = false, has_joints_ = false;
    RecordingInfo info_;
    Loaded loaded_;
    std::vector<RecordedPredicate> recorded_;  // With their facts in the last step.
    Appearance appearance_;
    RunningDigest digest_;
    sim::Touched* touched_ = nullptr;  // The subdomain's.
    LargeArray<sim::Catom> changed_;   // Since the last step.
    LargeArray<u32> changed_rows_;
    std::vector<std::array<double, 4>> recorded_turns_;  // In the last step, by catom.
    std::vector<u64> recorded_ids_;  // Of several processes, by catom: its number in the last step; none: it was not there.
    bool follows_ = false;           // The last step was written, so the next may be made of it.
    Step step_;                      // The last one; on the process that writes.
    JointTable joints_;
    std::optional<LoadMap> load_;
    std::function<RunCounts()> counts_;
    std::optional<Recording> file_;
    std::int64_t last_step_ = -1;
    std::uint64_t steps_ = 0;
    std::string outcome_;
    Result<void> ending_;
};

}  // namespace meld::record
