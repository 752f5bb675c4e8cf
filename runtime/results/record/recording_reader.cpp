#include "runtime/results/record/recording_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <system_error>
#include <utility>

#include "runtime/results/hdf5/file_kind.h"
#include "runtime/results/hdf5/hdf5_dataset.h"
#include "runtime/results/hdf5/hdf5_library.h"
#include "runtime/results/hdf5/hdf5_reading.h"
#include "runtime/results/record/recording.h"

namespace meld::record {

namespace {

constexpr std::uint64_t kStepsAtOnce = 4096;
constexpr std::size_t kMostCounts = 1000;
constexpr double kMaxTick = 9e15;  // Floats are exact up to there.

// A column of the table of steps, of which some thousand rows are in memory.
struct StepWindow {
    Dataset values;
    std::uint64_t first = 0, count = 0;
    std::vector<std::int64_t> rows = {};
};

// A table of steps. The first holds whole steps, the second those that are changes of the step before; not all recordings have it.
struct StepPlace {
    std::size_t table = 0, row = 0;
};
constexpr std::array<const char*, 2> kTables = {"/VTKHDF/Steps/", "/meld/changes/Steps/"};

// Those of one step in a series, as they were read last.
struct SomeChanges {
    std::uint64_t begin = 0, end = 0;
    std::vector<std::int64_t> rows = {};
    std::vector<std::byte> values = {};
};

}  // namespace

struct RecordingReader::State {
    std::string path;
    std::unique_ptr<Handle> file;
    std::uint64_t size_bytes = 0;
    std::map<std::string, std::string> about;
    std::vector<std::int64_t> ticks;
    std::vector<StepPlace> places;  // By step.
    std::vector<Series> series;
    std::vector<Dataset> values;      // By series.
    std::vector<std::string> begins;  // By series: the column of the steps with its first rows.
    std::vector<std::string> counts;  // By series: the column with how many; empty: the catoms of the step.
    std::vector<std::string> ranges;  // By series: the column with which changes count; empty: there can be none.
    std::map<SeriesIndex, SomeChanges> changes;
    std::vector<SeriesIndex> arrays;
    SeriesIndex line_ends = 0;
    std::vector<SeriesTable> tables;
    std::optional<SeriesTable> joints;
    std::vector<DescribedPredicate> predicates;
    std::map<std::string, StepWindow> columns;
    std::vector<std::int64_t> points_of_part, lines_of_part;
    std::map<std::string, std::vector<std::string>> texts;

    tl::unexpected<Error> damaged(const std::string& what) const {
        return fail(fmt::format("cannot read {}: {}", path, what), "It is damaged, or was written by another version",
                    ExitCode::RecordingRefused);
    }
    Result<void> read_about();
    Result<void> read_predicates();
    Result<std::vector<double>> times_in(std::size_t table) const;
    Result<void> read_ticks();
    Result<void> read_changes(SeriesIndex index, const Rows& rows);
    Result<void> find_series();
    Result<void> find_joints();
    Result<SeriesIndex> add(const std::string& place, Series series, std::string begin, std::string count);
    Result<std::vector<std::string>> names(const std::string& group) const;
    Result<std::vector<std::int64_t>> numbers(const std::string& place) const;
    Result<std::int64_t> of_step(const std::string& column, std::size_t step, std::size_t component = 0);
};

Result<void> RecordingReader::State::read_about() {
    if (attribute(*file, "/meld", "format") != kRecordingFormat)
        return fail(path + " is no recording of meldsim", "Give a file that `meldsim run --record` has written",
                    ExitCode::RecordingRefused);
    if (const std::string version = attribute(*file, "/meld", "version");
        version != std::to_string(kRecordingVersion) && version != std::to_string(kWholeVersion))
        return fail(fmt::format("{} is a recording of version {}, and this meldsim reads versions {} and {}", path,
                                version.empty() ? "none" : version, kWholeVersion, kRecordingVersion),
                    "Read it with the meldsim that wrote it", ExitCode::RecordingRefused);
    for (const char* name : {"seed", "lattice", "radius_metres"}) about[name] = attribute(*file, "/meld", name);
    for (const char* name : {"program", "world", "provenance", "made_by", "predicates"})
        about[name] = text_at(*file, std::string("/meld/") + name);
    return {};
}

Result<void> RecordingReader::State::read_predicates() {
    try {
        const nlohmann::json described = nlohmann::json::parse(about["predicates"]);
        if (!described.is_array()) return damaged("its predicates are not a list");
        for (const auto& predicate : described) {
            DescribedPredicate& one = predicates.emplace_back();
            one.name = predicate.at("name").get<std::string>();
            one.table = predicate.at("table").get<bool>();
            for (const auto& argument : predicate.at("arguments"))
                one.arguments.push_back({argument.at("name").get<std::string>(), argument.at("type").get<std::string>(),
                                         argument.at("array").get<std::string>()});
        }
    } catch (const nlohmann::json::exception& error) {
        return damaged(fmt::format("its list of predicates is not as we write it ({})", error.what()));
    }
    return {};
}

Result<std::vector<double>> RecordingReader::State::times_in(std::size_t table) const {
    const std::string place = kTables[table];
    const std::optional<std::uint64_t> count = number_attribute(*file, place.substr(0, place.size() - 1), "NSteps");
    const std::optional<Dataset> times = Dataset::open(*file, place + "Values");
    if (!times || times->type() != ElementType::Float64 || times->components() != 1 || !count) return damaged("it has no table of steps");
    // Rows that were never written do not fill memory.
    if (*count > times->rows() || *count > size_bytes) return damaged("its table of steps is too short");
    std::vector<double> all(*count);
    if (const auto done = times->read(0, *count, all.data()); !done) return damaged(done.error().problem);
    return all;
}

// A table says all that there was when it was read. The table of changes, which is read last, says which of all steps its own are: if one
// is missing before them, it was written in the meantime, and what follows it is left out.
Result<void> RecordingReader::State::read_ticks() {
    const Result<std::vector<double>> whole = times_in(0);
    if (!whole) return tl::unexpected(whole.error());
    std::vector<double> changed;
    std::vector<std::int64_t> step_of;
    if (H5Lexists(*file, "/meld/changes", H5P_DEFAULT) > 0 && H5Lexists(*file, "/meld/changes/Steps", H5P_DEFAULT) > 0) {
        Result<std::vector<double>> times = times_in(1);
        if (!times) return tl::unexpected(times.error());
        Result<std::vector<std::int64_t>> steps = numbers(std::string(kTables[1]) + "StepNumber");
        if (!steps) return tl::unexpected(steps.error());
        if (steps->size() < times->size()) return damaged("its table of changes is too short");
        changed = std::move(*times);
        step_of = std::move(*steps);
    }
    for (std::size_t i = 0, j = 0; i < whole->size() || j < changed.size();) {
        const bool here = j < changed.size() && step_of[j] == static_cast<std::int64_t>(places.size());
        if (!here && i == whole->size()) break;
        const double time = here ? changed[j] : (*whole)[i];
        if (!(time >= 0 && time <= kMaxTick)) return damaged("it has a tick that cannot be");
        ticks.push_back(static_cast<std::int64_t>(time));
        places.push_back(here ? StepPlace{1, j++} : StepPlace{0, i++});
    }
    if (!std::is_sorted(ticks.begin(), ticks.end(), std::less_equal<>())) return damaged("its ticks are out of order");
    return {};
}

Result<std::vector<std::string>> RecordingReader::State::names(const std::string& group) const {
    Result<std::vector<std::string>> found = names_in(*file, group);
    if (!found) return damaged(found.error().problem);
    return found;
}

Result<SeriesIndex> RecordingReader::State::add(const std::string& place, Series one, std::string begin, std::string count) {
    std::optional<Dataset> dataset = Dataset::open(*file, place);
    if (!dataset) return damaged(place + " is missing, or not as we write it");
    one.type = dataset->type();
    one.components = dataset->components();
    if (!one.texts.empty() && (one.type != ElementType::Int64 || one.components != 1)) return damaged(place + " has no numbers of strings");
    series.push_back(std::move(one));
    values.push_back(std::move(*dataset));
    begins.push_back(std::move(begin));
    counts.push_back(std::move(count));
    ranges.emplace_back();
    return series.size() - 1;
}

Result<void> RecordingReader::State::find_series() {
    // An empty recording has no column of positions yet.
    if (ticks.empty()) return {};
    constexpr SeriesIndex points = 0;
    if (auto done = add("/VTKHDF/Points", {.name = "position"}, "PointOffsets", ""); !done) return tl::unexpected(done.error());
    if (auto done = add("/VTKHDF/PointData/id", {.name = "id"}, "PointDataOffsets/id", ""); !done) return tl::unexpected(done.error());
    if (series[0].components != 3 || series[0].type != ElementType::Float32 || series[1].components != 1 ||
        series[1].type != ElementType::Int64)
        return damaged("its positions or numbers of catoms are not as we write them");
    const bool has_changes = std::ranges::any_of(places, [](const StepPlace& place) { return place.table == 1; });
    const auto exists = [&](const std::string& place) { return H5Lexists(*file, place.c_str(), H5P_DEFAULT) > 0; };
    if (has_changes) ranges[points] = "PointChanges";
    const Result<std::vector<std::string>> texts_here = names("/meld/texts"), data = names("/VTKHDF/PointData"),
                                           table_names = names("/meld/facts");
    for (const auto* each : {&texts_here, &data, &table_names})
        if (!*each) return tl::unexpected(each->error());
    // Arrays of strings have those in a group of their name; a column of a table has those of the array with the same argument.
    const auto texts_of = [&](const std::string& array) {
        return std::binary_search(texts_here->begin(), texts_here->end(), array) ? array : std::string();
    };
    for (const std::string& name : *data) {
        if (name == "id") continue;
        const auto added = add("/VTKHDF/PointData/" + name, {.name = name, .texts = texts_of(name)}, "PointDataOffsets/" + name, "");
        if (!added) return tl::unexpected(added.error());
        arrays.push_back(*added);
        if (const std::string range = "PointDataChanges/" + name; has_changes && exists(kTables[1] + range)) ranges[*added] = range;
    }
    const auto ends = add("/VTKHDF/Lines/Connectivity", {.name = "line"}, "", "");
    if (!ends) return tl::unexpected(ends.error());
    line_ends = *ends;
    if (series[line_ends].type != ElementType::Int64 || series[line_ends].components != 1)
        return damaged("its lines are not as we write them");
    std::map<std::pair<std::string, std::string>, std::string> array_of;
    for (const DescribedPredicate& predicate : predicates)
        for (const DescribedPredicate::Argument& argument : predicate.arguments) array_of[{predicate.name, argument.name}] = argument.array;
    for (const std::string& table : *table_names) {
        SeriesTable one{table, {}};
        const Result<std::vector<std::string>> columns_here = names("/meld/facts/" + table);
        if (!columns_here) return tl::unexpected(columns_here.error());
        for (const std::string& column : *columns_here) {
            const auto array = array_of.find({table, column});
            const auto added = add(fmt::format("/meld/facts/{}/{}", table, column),
                                   {.name = column, .texts = array == array_of.end() ? "" : texts_of(array->second)},
                                   fmt::format("FactOffsets/{}/{}", table, column), "FactCounts/" + table);
            if (!added) return tl::unexpected(added.error());
            if (column == "catom")
                one.columns.insert(one.columns.begin(), *added);
            else
                one.columns.push_back(*added);
        }
        if (one.columns.empty() || series[one.columns[0]].name != "catom" || series[one.columns[0]].type != ElementType::Int64)
            return damaged(fmt::format("its facts of {} have no catoms", table));
        tables.push_back(std::move(one));
    }
    return find_joints();
}

Result<void> RecordingReader::State::find_joints() {
    if (H5Lexists(*file, kJoints, H5P_DEFAULT) <= 0) return {};
    const Result<std::vector<std::string>> columns_here = names(kJoints);
    if (!columns_here) return tl::unexpected(columns_here.error());
    joints.emplace(SeriesTable{"joints", {}});
    for (const std::string& column : *columns_here) {
        const auto added =
            add(fmt::format("{}/{}", kJoints, column), {.name = column}, fmt::format("{}/{}", kJointOffsets, column), kJointCount);
        if (!added) return tl::unexpected(added.error());
        joints->columns.push_back(*added);
    }
    return {};
}

Result<std::vector<std::int64_t>> RecordingReader::State::numbers(const std::string& place) const {
    const std::optional<Dataset> dataset = Dataset::open(*file, place);
    // Numbers that compress to nothing do not fill memory.
    if (!dataset || dataset->type() != ElementType::Int64 || dataset->components() != 1 || dataset->rows() > size_bytes)
        return damaged(place + " is missing, or not as we write it");
    std::vector<std::int64_t> out(dataset->rows());
    if (const auto done = dataset->read(0, out.size(), out.data()); !done) return damaged(done.error().problem);
    return out;
}

Result<std::int64_t> RecordingReader::State::of_step(const std::string& column, std::size_t step, std::size_t component) {
    const auto& [table, row] = places[step];
    const std::string place = kTables[table] + column;
    auto known = columns.find(place);
    if (known == columns.end()) {
        std::optional<Dataset> dataset = Dataset::open(*file, place);
        if (!dataset || dataset->type() != ElementType::Int64) return damaged(fmt::format("its steps have no {}", column));
        known = columns.emplace(place, StepWindow{std::move(*dataset)}).first;
    }
    StepWindow& window = known->second;
    const auto components = static_cast<std::size_t>(window.values.components());
    if (row >= window.values.rows() || component >= components) return damaged(fmt::format("its {} end too early", column));
    if (row < window.first || row >= window.first + window.count) {
        window.first = row;
        window.count = std::min<std::uint64_t>(kStepsAtOnce, window.values.rows() - row);
        window.rows.resize(window.count * components);
        if (const auto done = window.values.read(window.first, window.count, window.rows.data()); !done)
            return damaged(done.error().problem);
    }
    return window.rows[(row - window.first) * components + component];
}

Result<RecordingReader> RecordingReader::open(const std::string& path) {
    auto state = std::make_unique<State>();
    state->path = path;
    std::error_code error;
    state->size_bytes = std::filesystem::file_size(path, error);
    if (error == std::errc::operation_not_supported) return fail(fmt::format("cannot read {}: it is no regular file", path));
    if (error) return fail(fmt::format("cannot read {}: {}", path, error.message()));
    state->file = std::make_unique<Handle>(open_to_read(path), H5Fclose);
    if (*state->file < 0 && H5Fis_hdf5(path.c_str()) == 0)
        return fail(path + " is not a recording", "Give a file that meldsim run --record has written", ExitCode::RecordingRefused);
    if (*state->file < 0) return state->damaged(text_of_last_error());
    for (const auto& part : {&State::read_about, &State::read_predicates, &State::read_ticks, &State::find_series})
        if (const Result<void> done = (*state.*part)(); !done) return tl::unexpected(done.error());
    if (!state->ticks.empty())
        for (const auto& [place, to] : {std::pair{"/VTKHDF/NumberOfPoints", &State::points_of_part},
                                        std::pair{"/VTKHDF/Lines/NumberOfCells", &State::lines_of_part}}) {
            Result<std::vector<std::int64_t>> read = state->numbers(place);
            if (!read) return tl::unexpected(read.error());
            (*state).*to = std::move(*read);
        }
    return RecordingReader(std::move(state));
}

RecordingReader::RecordingReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
RecordingReader::RecordingReader(RecordingReader&&) noexcept = default;
RecordingReader::~RecordingReader() = default;

const std::string& RecordingReader::path() const { return state_->path; }
std::string RecordingReader::about(const std::string& name) const {
    const auto known = state_->about.find(name);
    return known == state_->about.end() ? "" : known->second;
}
std::vector<std::string> RecordingReader::arguments() const { return texts_at(*state_->file, "/meld/arguments"); }
std::vector<std::pair<std::string, std::uint64_t>> RecordingReader::counts() const {
    const auto number = [&](const std::string& name) { return number_attribute(*state_->file, "/meld/counts", name); };
    std::vector<std::pair<std::string, std::uint64_t>> all;
    if (number(kCountsKnown).value_or(0) == 0) return all;
    std::istringstream names(text_at(*state_->file, "/meld/counts/names"));
    for (std::string name; std::getline(names, name, ',') && all.size() < kMostCounts;)
        if (const auto count = number(name)) all.emplace_back(name, *count);
    return all;
}
const std::vector<std::int64_t>& RecordingReader::ticks() const { return state_->ticks; }

Result<std::vector<Digest>> RecordingReader::digests() const {
    std::vector<Digest> out;
    for (std::size_t i = 0; i < state_->ticks.size(); ++i) {
        const Result<std::int64_t> low = state_->of_step("StateDigestLow", i), high = state_->of_step("StateDigestHigh", i);
        for (const auto* half : {&low, &high})
            if (!*half) return tl::unexpected(half->error());
        out.emplace_back(static_cast<std::uint64_t>(*low), static_cast<std::uint64_t>(*high));
    }
    return out;
}
const std::vector<Series>& RecordingReader::series() const { return state_->series; }
const std::vector<SeriesIndex>& RecordingReader::arrays() const { return state_->arrays; }
SeriesIndex RecordingReader::line_ends() const { return state_->line_ends; }
const std::vector<SeriesTable>& RecordingReader::tables() const { return state_->tables; }
const std::optional<SeriesTable>& RecordingReader::joints() const { return state_->joints; }
const std::vector<DescribedPredicate>& RecordingReader::predicates() const { return state_->predicates; }

Result<Rows> RecordingReader::rows(SeriesIndex index, std::size_t step) {
    State& s = *state_;
    const bool lines = index == s.line_ends;
    const Result<std::int64_t> first = lines ? s.of_step("ConnectivityIdOffsets", step, 1) : s.of_step(s.begins[index], step);
    if (!first) return tl::unexpected(first.error());
    const auto there = static_cast<std::int64_t>(s.values[index].rows());
    std::int64_t count = 0;
    if (!s.counts[index].empty()) {
        const Result<std::int64_t> facts = s.of_step(s.counts[index], step);
        if (!facts) return tl::unexpected(facts.error());
        count = *facts;
    } else {
        const Result<std::int64_t> part = s.of_step("PartOffsets", step);
        if (!part) return tl::unexpected(part.error());
        const std::vector<std::int64_t>& of_part = lines ? s.lines_of_part : s.points_of_part;
        if (*part < 0 || static_cast<std::uint64_t>(*part) >= of_part.size()) return s.damaged("a step is of a part that is not there");
        count = of_part[static_cast<std::size_t>(*part)];
        // A line has two ends.
        if (lines && count <= there) count *= 2;
    }
    if (*first < 0 || count < 0 || *first > there || count > there - *first)
        return s.damaged(fmt::format("step {} refers to rows of {} that are not there", step, s.series[index].name));
    Rows rows{static_cast<std::uint64_t>(*first), static_cast<std::uint64_t>(count)};
    if (s.ranges[index].empty() || s.places[step].table == 0) return rows;
    const Result<std::int64_t> begin = s.of_step(s.ranges[index], step), end = s.of_step(s.ranges[index], step, 1);
    for (const auto* each : {&begin, &end})
        if (!*each) return tl::unexpected(each->error());
    if (*begin < 0 || *end < *begin || *end - *begin > count)
        return s.damaged(fmt::format("step {} refers to changes of {} that cannot be", step, s.series[index].name));
    rows.changes_begin = static_cast<std::uint64_t>(*begin);
    rows.changes_end = static_cast<std::uint64_t>(*end);
    return rows;
}

// Fewer than the step has rows, which rows() has found out.
Result<void> RecordingReader::State::read_changes(SeriesIndex index, const Rows& rows) {
    SomeChanges& known = changes[index];
    if (known.begin == rows.changes_begin && known.end == rows.changes_end) return {};
    const Series& one = series[index];
    const std::string place = index == 0 ? "/meld/changes/Points" : "/meld/changes/PointData/" + one.name;
    const std::optional<Dataset> at = Dataset::open(*file, place + "/row"), what = Dataset::open(*file, place + "/value");
    if (!at || !what || at->type() != ElementType::Int64 || at->components() != 1 || what->type() != one.type ||
        what->components() != one.components)
        return damaged(place + " is missing, or not as we write it");
    const std::uint64_t count = rows.changes_end - rows.changes_begin;
    SomeChanges read = {rows.changes_begin, rows.changes_end, std::vector<std::int64_t>(count),
                        std::vector<std::byte>(count * one.row_bytes())};
    Result<void> done = at->read(rows.changes_begin, count, read.rows.data());
    if (done) done = what->read(rows.changes_begin, count, read.values.data());
    if (!done) return damaged(done.error().problem);
    for (const std::int64_t row : read.rows)
        if (row < 0 || static_cast<std::uint64_t>(row) >= rows.count) return damaged(one.name + " changes where no row is");
    known = std::move(read);
    return {};
}

Result<void> RecordingReader::read(SeriesIndex index, const Rows& rows, std::uint64_t first, std::uint64_t count, void* to) {
    State& s = *state_;
    if (const auto done = s.values[index].read(rows.first + first, count, to); !done) return s.damaged(done.error().problem);
    if (rows.changes_begin == rows.changes_end) return {};
    if (auto done = s.read_changes(index, rows); !done) return done;
    const SomeChanges& changes = s.changes[index];
    const std::size_t row_bytes = s.series[index].row_bytes();
    for (std::size_t i = 0; i < changes.rows.size(); ++i)
        if (const auto row = static_cast<std::uint64_t>(changes.rows[i]); row >= first && row < first + count)
            std::memcpy(static_cast<std::byte*>(to) + (row - first) * row_bytes, changes.values.data() + i * row_bytes, row_bytes);
    return {};
}

Result<const std::vector<std::string>*> RecordingReader::texts(const std::string& group) {
    State& s = *state_;
    if (const auto known = s.texts.find(group); known != s.texts.end()) return &known->second;
    const Result<std::vector<std::int64_t>> ends = s.numbers(fmt::format("/meld/texts/{}/ends", group));
    if (!ends) return tl::unexpected(ends.error());
    const std::optional<Dataset> bytes = Dataset::open(*s.file, fmt::format("/meld/texts/{}/text", group));
    if (!bytes || bytes->type() != ElementType::UInt8 || bytes->components() != 1 || bytes->rows() > s.size_bytes)
        return s.damaged("its strings are not as we write them");
    std::string all(bytes->rows(), '\0');
    if (const auto done = bytes->read(0, all.size(), all.data()); !done) return s.damaged(done.error().problem);
    std::vector<std::string>& out = s.texts[group];
    std::int64_t begin = 0;
    for (const std::int64_t end : *ends) {
        if (end < begin || static_cast<std::uint64_t>(end) > all.size()) return s.damaged("its strings overlap");
        out.push_back(all.substr(static_cast<std::size_t>(begin), static_cast<std::size_t>(end - begin)));
        begin = end;
    }
    return &out;
}

}  // namespace meld::record
