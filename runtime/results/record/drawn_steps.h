// The steps of a recording as they are drawn, each by itself: for pictures for which no run is made.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/results/record/drawing.h"
#include "runtime/results/record/recording_reader.h"

namespace meld::record {

class DrawnSteps {
  public:
    // Errors: it has no step, or no colours (6).
    static Result<DrawnSteps> of(RecordingReader recording);

    const std::vector<std::int64_t>& ticks() const { return recording_.ticks(); }
    // What Drawing::drawn() gave in this step, but for positions, which are of 32 bits. Errors: the file is damaged (6). Cost: reads the
    // step. Memory: some 60 bytes a catom.
    Result<Drawn> drawn(std::size_t step);

  private:
    explicit DrawnSteps(RecordingReader recording) : recording_(std::move(recording)) {}
    tl::unexpected<Error> damaged(std::size_t step, const char* what) const;
    Result<void> read_ids(std::size_t step, Drawn& drawn);
    Result<void> read_positions(std::size_t step, Drawn& drawn);
    template <class Row>
    Result<void> read_places(SeriesIndex series, std::size_t step, std::size_t count, std::vector<world::Vec3>& places);
    Result<void> read_colours(std::size_t step, Drawn& drawn);
    Result<void> read_diameters(std::size_t step, Drawn& drawn);
    Result<void> read_rounded(std::size_t step, Drawn& drawn);
    // Of all catoms, with turned(place, orientation).
    template <class Turned>
    Result<void> read_turns(SeriesIndex series, std::size_t step, std::size_t count, const Turned& turned);
    Result<void> read_joints(std::size_t step, Drawn& drawn);
    Result<void> read_tails(std::size_t step, Drawn& drawn);
    Result<void> read_labels(std::size_t step, Drawn& drawn);
    Result<void> read_lines(std::size_t step, Drawn& drawn);
    // Reads the rows of a step some at a time, and calls `take` with these. Errors: those of `take`; their number is not this one.
    template <class Row, class Take>
    Result<void> each(SeriesIndex series, std::size_t step, std::optional<std::uint64_t> count, const Take& take);

    RecordingReader recording_;
    SeriesIndex colours_ = 0;
    std::optional<SeriesIndex> diameters_ = {}, cores_ = {}, orientations_ = {}, turns_ = {}, labels_ = {}, tails_ = {};
    // Of joints.
    struct JointColumns {
        SeriesIndex first, second, kind, fate, first_anchor, second_anchor, axis;
    };
    std::optional<JointColumns> joints_ = {};
};

}  // namespace meld::record
