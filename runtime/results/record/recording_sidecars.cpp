// The sidecars of a recording: which steps they show. Those that hold changes alone are none of them: XDMF cannot say what they are.
#include <algorithm>
#include <bit>
#include <filesystem>

#include "runtime/results/record/recording_state.h"

namespace meld::record {

namespace {

constexpr std::int64_t kSidecarStepsAtOnce = 4096;

}  // namespace

// From the tables of the file, so that nothing need be kept of the steps.
void Recording::State::each_step(const std::function<void(const XdmfStep&)>& visit) const {
    const auto slab = [&](const std::string& name, const std::string& place_in_file, ColumnIndex column) {
        const ColumnShape& shape = hdf5->shape(column);
        return XdmfSlab{name, place_in_file, shape.type, shape.components, 0, hdf5->rows(column)};
    };
    XdmfStep step;
    step.points = slab("points", "/VTKHDF/Points", points->values);
    step.ends = slab("lines", "/VTKHDF/Lines/Connectivity", parts->line_ends());
    for (const auto& [name, column] : arrays) step.arrays.push_back(slab(name, "/VTKHDF/PointData/" + name, column.values));
    const PartTable::Sizes sizes = parts->sizes();
    const StepTable& whole = steps->whole();
    for (std::int64_t first = 0; first < whole.steps(); first += kSidecarStepsAtOnce) {
        const std::int64_t count = std::min(kSidecarStepsAtOnce, whole.steps() - first);
        const auto read = [&](StepColumn column) { return whole.read(column, first, count); };
        const std::vector<std::int64_t> times = read(values), part = read(part_offsets), point = read(point_offsets);
        const std::vector<std::int64_t> ends = read(connectivity_offsets);
        std::vector<std::vector<std::int64_t>> begins;
        for (const auto& [name, column] : arrays) begins.push_back(read(*column.offsets));
        for (std::size_t i = 0; i < times.size(); ++i) {
            const auto here = static_cast<std::size_t>(part[i]);
            step.time = std::bit_cast<double>(times[i]);
            step.rows = static_cast<std::uint64_t>(sizes.points[here]);
            step.lines = static_cast<std::uint64_t>(sizes.lines[here]);
            step.points.first_row = static_cast<std::uint64_t>(point[i]);
            step.ends.first_row = static_cast<std::uint64_t>(ends[4 * i + 1]);
            for (std::size_t k = 0; k < begins.size(); ++k) step.arrays[k].first_row = static_cast<std::uint64_t>(begins[k][i]);
            visit(step);
        }
    }
}

// Before the file is closed.
Result<void> Recording::State::write_sidecars() {
    const std::string name = std::filesystem::path(path).filename().string();
    const XdmfSteps all = [&](const std::function<void(const XdmfStep&)>& visit) {
        if (steps->steps() > 0) each_step(visit);
    };
    const std::uint64_t most_bytes = hdf5->stored_bytes();
    write_sidecar(*sidecar, name, XdmfShows::Catoms, all, most_bytes);
    if (line_sidecar) write_sidecar(*line_sidecar, name, XdmfShows::Lines, all, most_bytes);
    const auto written = sidecar->flush();
    return written && line_sidecar ? line_sidecar->flush() : written;
}

}  // namespace meld::record
