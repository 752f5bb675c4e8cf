// The parts of a recording: how many points, vertices and lines a step has, and where its cells are. Private to runtime/results/record.
//
// A "part" in the sense of VTKHDF. Steps with as many catoms and the same lines share one, with its connectivity 0, 1, 2, ...
#pragma once

#include <xxhash.h>

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <tuple>
#include <vector>

#include "runtime/results/hdf5/hdf5_file.h"
#include "runtime/results/record/recording.h"

namespace meld::record {

// Where the cells of a part are, by kind: vertices, lines, and two kinds that stay empty.
struct Part {
    std::int64_t index = 0;
    std::array<std::int64_t, 4> cell_offsets = {};
    std::array<std::int64_t, 4> connectivity_offsets = {};
};

class PartTable {
  public:
    // The file must stay. Makes the groups and columns of cells; those of vertices with the first part.
    explicit PartTable(Hdf5File& file);
    // Of a file that is opened again, in the state that save() wrote: the parts are found by reading them.
    PartTable(Hdf5File& file, ByteReader& saved);
    void save(ByteWriter& out) const;

    // The part with so many catoms and these lines, which is written if it is new.
    const Part& part_with(std::uint64_t rows, std::span<const RecordedLine> lines);

    // The ends of all lines, and how many points and lines the parts have.
    ColumnIndex line_ends() const { return columns_.connectivity[1]; }
    struct Sizes {
        std::vector<std::int64_t> points, lines;
    };
    Sizes sizes() const;

  private:
    // How many catoms, and which lines.
    struct Key {
        std::uint64_t rows = 0, lines = 0;
        XXH128_hash_t hash = {};
        auto order() const { return std::tuple(rows, lines, hash.low64, hash.high64); }
        bool operator<(const Key& other) const { return order() < other.order(); }
    };
    static Key key_of(std::uint64_t rows, std::span<const RecordedLine> lines);
    void make_ids(std::size_t kind, std::uint64_t chunk_rows);
    void count_up(ColumnIndex column, std::uint64_t numbers);
    void write_vertices(std::uint64_t rows, Part& part);
    void write_lines(std::span<const RecordedLine> lines, Part& part);

    Hdf5File& file_;
    struct Columns {
        ColumnIndex number_of_points = 0;
        std::array<ColumnIndex, 4> number_of_cells = {}, number_of_connectivity_ids = {}, offsets = {}, connectivity = {};
    };
    Columns columns_;
    std::map<Key, Part> parts_;
    std::map<std::uint64_t, std::int64_t> connectivity_of_rows_;  // Of so many vertices.
    std::int64_t next_cell_offset_ = 0;
    std::int64_t next_line_offset_ = 1;  // See write_lines.
};

}  // namespace meld::record
