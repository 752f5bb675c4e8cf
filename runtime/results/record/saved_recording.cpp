// A recording that a later process goes on with.
//
// What is saved of it is small: how long its columns are, and what the last step was. The rest is in the file, which is compared with that
// before anything of it changes. What the file has beyond the saved state is cut off before the next step: first the rows of the steps,
// so that readers no longer see them, then what they referred to. A process that is killed meanwhile leaves all that was saved.
#include <fmt/format.h>

#include <algorithm>
#include <ranges>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/hash.h"
#include "runtime/results/record/recording_state.h"

namespace meld::record {

namespace {

// Besides the last chunk of each column.
constexpr std::uint64_t kCutBytes = 64 << 10;

tl::unexpected<Error> cannot_go_on(const std::string& path, const std::string& why) {
    return fail(fmt::format("cannot go on with {}: {}", path, why), "Put it back as the run left it");
}

}  // namespace

std::int64_t run_hash(const RecordingInfo& info) {
    ByteWriter all;
    for (const std::string* text : {&info.program, &info.world, &info.lattice, &info.predicates}) all.write_string(*text);
    for (const std::string& argument : info.arguments) all.write_string(argument);
    all.write(info.seed);
    all.write(info.radius);
    return static_cast<std::int64_t>(hash_bytes(all.view()));
}

void Recording::save(ByteWriter& out) const {
    const State& state = *state_;
    MELD_CHECK(!state.failure && state.steps->steps() > 0, "a recording of {} steps is saved", state.steps->steps());
    out.write_string(state.place);
    out.write(state.hdf5->size_bytes());
    state.hdf5->save(out);
    state.steps->save(out);
    state.parts->save(out);
    out.write(state.most_rows);
    for (const StepColumn column : {state.values, state.part_offsets, state.number_of_parts, state.point_offsets, state.cell_offsets,
                                    state.connectivity_offsets, state.digest_low, state.digest_high})
        out.write(column);
    out.write(*state.points);
    const auto write_all = [&](const auto& map, const auto& write) {
        out.write_count(map.size());
        for (const auto& [name, item] : map) {
            out.write_string(name);
            write(item);
        }
    };
    write_all(state.arrays, [&](const SeriesColumn& column) { out.write(column); });
    write_all(state.texts, [&](const TextTable& table) { table.save(out); });
    write_all(state.tables, [&](const FactSeries& table) { table.save(out); });
}

void Recording::State::load(ByteReader& saved) {
    steps.emplace(*hdf5, saved);
    parts.emplace(*hdf5, saved);
    most_rows = saved.read<std::uint64_t>();
    for (StepColumn* column :
         {&values, &part_offsets, &number_of_parts, &point_offsets, &cell_offsets, &connectivity_offsets, &digest_low, &digest_high})
        *column = saved.read<StepColumn>();
    points = saved.read<SeriesColumn>();
    const auto read_all = [&](auto& map, const auto& read) {
        for (auto left = saved.read_count(sizeof(std::uint32_t)); left > 0; --left) {
            std::string name = saved.read_string();
            map.emplace(std::move(name), read());
        }
    };
    read_all(arrays, [&] { return saved.read<SeriesColumn>(); });
    read_all(texts, [&] { return TextTable(*hdf5, saved); });
    read_all(tables, [&] { return FactSeries(saved); });
}

// Whether the file has the last step of the saved state.
bool Recording::State::matches() {
    return steps->matches() && points->matches(*hdf5) &&
           std::ranges::all_of(arrays | std::views::values, [&](const SeriesColumn& column) { return column.matches(*hdf5); }) &&
           std::ranges::all_of(tables | std::views::values, [&](const FactSeries& table) { return table.matches(*hdf5); });
}

Result<Recording> Recording::reopen(const std::string& path, const RecordingInfo& info, ByteReader& saved) {
    auto state = std::make_unique<State>();
    state->path = path;
    const std::string place = saved.read_string();
    const auto size_bytes = saved.read<std::uint64_t>();
    auto output = OutputFile::reopen(path, place, size_bytes, info.durability);
    if (!output) return tl::unexpected(output.error());
    state->output.emplace(std::move(*output));
    state->place = *state->output->place();
    state->hdf5 = std::make_unique<Hdf5File>(state->place, info.durability, saved);
    if (state->hdf5->failed()) return cannot_go_on(path, state->hdf5->failure());
    if (state->hdf5->attribute("/meld", kRunAttribute) != run_hash(info)) return cannot_go_on(path, "it is a recording of another run");
    state->load(saved);
    if (saved.failed()) return tl::unexpected(saved.outcome().error());
    const bool matches = !state->hdf5->failed() && state->matches();
    if (state->hdf5->failed()) return cannot_go_on(path, state->hdf5->failure());
    if (!matches) return cannot_go_on(path, fmt::format("its step {} is not the one that was written", state->steps->steps() - 1));
    state->to_be_cut = true;
    if (const auto sidecars = state->open_sidecars(info); !sidecars) return tl::unexpected(sidecars.error());
    return Recording(std::move(state));
}

Result<void> Recording::State::cut() {
    if (!to_be_cut) return {};
    std::uint64_t bytes = kCutBytes;
    for (ColumnIndex column = 0; column < hdf5->columns(); ++column) {
        const ColumnShape& shape = hdf5->shape(column);
        bytes += shape.chunk_rows * static_cast<std::uint64_t>(shape.components) * size_of(shape.type);
    }
    if (const auto reason = reserve(bytes)) return cannot_write(*reason);
    steps->cut();
    for (ColumnIndex column = 0; column < hdf5->columns(); ++column) hdf5->shorten(column, hdf5->rows(column));
    hdf5->flush();
    to_be_cut = false;
    if (!hdf5->failed()) return {};
    failure = cannot_write(hdf5->failure()).value();
    return tl::unexpected(*failure);
}

Result<void> Recording::secure() {
    State& state = *state_;
    if (state.failure) return tl::unexpected(*state.failure);
    Result<void> safe = state.output->sync();
    if (!safe) state.failure = safe.error();
    return safe;
}

}  // namespace meld::record
