#include "runtime/results/record/whole_copy.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <deque>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "runtime/results/record/recording.h"

namespace meld::record {

namespace {

// Numbers are written in their shortest form, from which the same number is read.
template <class Number>
Number number_of(const std::string& text) {
    Number number{};
    std::from_chars(text.data(), text.data() + text.size(), number);
    return number;
}

// One step in memory, series by series.
class StepCopy {
  public:
    // `last` are the rows of each series in the step before, and then in this one.
    StepCopy(RecordingReader& recording, std::size_t step, std::map<SeriesIndex, Rows>& last)
        : recording_(recording), step_(step), last_(last) {}

    template <class Row>
    Result<std::vector<Row>> rows_of(SeriesIndex series, std::optional<std::uint64_t> count = {}) {
        const Result<Rows> rows = recording_.rows(series, step_);
        if (!rows) return tl::unexpected(rows.error());
        const std::size_t row_bytes = recording_.series()[series].row_bytes();
        if ((count && rows->count != *count) || row_bytes % sizeof(Row) != 0) return damaged("rows are missing");
        std::vector<Row> out(rows->count * row_bytes / sizeof(Row));
        if (auto done = recording_.read(series, *rows, 0, rows->count, out.data()); !done) return tl::unexpected(done.error());
        return out;
    }

    // The array stays valid as long as this object.
    Result<RecordedArray> array(SeriesIndex index, std::uint64_t rows) {
        const Series& series = recording_.series()[index];
        RecordedArray out{.name = series.name, .components = series.components};
        const Result<Rows> here = recording_.rows(index, step_);
        if (!here) return tl::unexpected(here.error());
        const auto before = last_.find(index);
        out.same = before != last_.end() && before->second == *here && here->count == rows;
        last_.insert_or_assign(index, *here);
        if (out.same) out.type = type_of(series);
        if (out.same) return out;
        if (!series.texts.empty()) return texts(index, rows, std::move(out));
        if (series.type == ElementType::Float32) return damaged("an array is not as we write it");
        Result<std::vector<std::byte>> bytes = rows_of<std::byte>(index, rows);
        if (!bytes) return tl::unexpected(bytes.error());
        out.type = type_of(series);
        out.data = bytes_.emplace_back(std::move(*bytes)).data();
        return out;
    }

    tl::unexpected<Error> damaged(const char* what) const {
        return fail(fmt::format("cannot read {}: in tick {}, {}", recording_.path(), recording_.ticks()[step_], what),
                    "It is damaged, or was written by another version", ExitCode::RecordingRefused);
    }

  private:
    static RecordedArray::Type type_of(const Series& series) {
        if (!series.texts.empty()) return RecordedArray::Text;
        if (series.type == ElementType::Float64) return RecordedArray::Float64;
        return series.type == ElementType::UInt8 ? RecordedArray::UInt8 : RecordedArray::Int64;
    }
    Result<RecordedArray> texts(SeriesIndex index, std::uint64_t rows, RecordedArray out) {
        const std::string& group = recording_.series()[index].texts;
        const auto known = recording_.texts(group);
        if (!known) return tl::unexpected(known.error());
        const Result<std::vector<std::int64_t>> numbers = rows_of<std::int64_t>(index, rows);
        if (!numbers) return tl::unexpected(numbers.error());
        std::vector<std::string>& all = texts_.emplace_back();
        for (const std::int64_t number : *numbers) {
            if (number >= static_cast<std::int64_t>((*known)->size())) return damaged("a string is not there");
            all.push_back(number < 0 ? std::string() : (**known)[static_cast<std::size_t>(number)]);
        }
        out.type = RecordedArray::Text;
        out.texts = group;
        out.data = all.data();
        return out;
    }

    RecordingReader& recording_;
    std::size_t step_;
    std::map<SeriesIndex, Rows>& last_;
    std::deque<std::vector<std::byte>> bytes_;
    std::deque<std::vector<std::string>> texts_;
};

Result<void> copy_step(RecordingReader& recording, std::size_t step, const Digest& digest, std::map<SeriesIndex, Rows>& last,
                       Recording& copy) {
    StepCopy from(recording, step, last);
    const auto ids = from.rows_of<std::uint64_t>(recording.ids());
    if (!ids) return tl::unexpected(ids.error());
    if (!std::ranges::is_sorted(*ids)) return from.damaged("the numbers of catoms are out of order");
    const auto places = from.rows_of<RecordedPosition>(recording.points(), ids->size());
    if (!places) return tl::unexpected(places.error());
    std::vector<RecordedArray> arrays;
    for (const SeriesIndex index : recording.arrays()) {
        const Result<RecordedArray> one = from.array(index, ids->size());
        if (!one) return tl::unexpected(one.error());
        arrays.push_back(*one);
    }
    const auto lines = from.rows_of<std::int64_t>(recording.line_ends());
    if (!lines) return tl::unexpected(lines.error());
    std::vector<RecordedLine> pairs;
    for (std::size_t i = 0; i + 1 < lines->size(); i += 2) pairs.push_back({(*lines)[i], (*lines)[i + 1]});
    std::vector<RecordedTable> tables;
    std::vector<std::pair<const SeriesTable*, RecordedTable::Kind>> all;
    for (const SeriesTable& table : recording.tables()) all.emplace_back(&table, RecordedTable::Kind::Facts);
    if (recording.joints()) all.emplace_back(&*recording.joints(), RecordedTable::Kind::Joints);
    for (const auto& [each, kind] : all) {
        const SeriesTable& table = *each;
        const Result<Rows> rows = recording.rows(table.columns[0], step);
        if (!rows) return tl::unexpected(rows.error());
        RecordedTable& one = tables.emplace_back(RecordedTable{.name = table.name, .rows = rows->count, .columns = {}, .kind = kind});
        for (const SeriesIndex index : table.columns) {
            const Result<RecordedArray> column = from.array(index, rows->count);
            if (!column) return tl::unexpected(column.error());
            one.columns.push_back(*column);
        }
        one.same = std::ranges::all_of(one.columns, &RecordedArray::same);
        // All columns are there, or none is looked at.
        for (std::size_t i = 0; i < one.columns.size() && !one.same; ++i)
            if (one.columns[i].same) {
                last.erase(table.columns[i]);
                const Result<RecordedArray> column = from.array(table.columns[i], rows->count);
                if (!column) return tl::unexpected(column.error());
                one.columns[i] = *column;
            }
    }
    return copy.step(static_cast<double>(recording.ticks()[step]), *places, *ids, arrays, pairs, tables, digest);
}

}  // namespace

Result<void> copy_whole(RecordingReader& recording, const std::string& path, const std::function<Result<void>(std::size_t)>& before) {
    const Result<std::vector<Digest>> digests = recording.digests();
    if (!digests) return tl::unexpected(digests.error());
    RecordingInfo info = {.program = recording.about("program"),
                          .world = recording.about("world"),
                          .seed = number_of<std::uint64_t>(recording.about("seed")),
                          .arguments = recording.arguments(),
                          .lattice = recording.about("lattice"),
                          .radius = number_of<double>(recording.about("radius_metres")),
                          .all_whole = true,
                          .provenance = recording.about("provenance"),
                          .made_by = recording.about("made_by"),
                          .predicates = recording.about("predicates")};
    RunCounts counts;
    for (const auto& [name, value] : recording.counts()) {
        counts.emplace_back(name, static_cast<std::int64_t>(value));
        info.counts.push_back(name);
    }
    for (std::size_t step = 0; step < digests->size() && !info.lines; ++step) {
        const Result<Rows> lines = recording.rows(recording.line_ends(), step);
        if (!lines) return tl::unexpected(lines.error());
        info.lines = lines->count > 0;
    }
    Result<Recording> copy = Recording::create(path, info);
    if (!copy) return tl::unexpected(copy.error());
    std::map<SeriesIndex, Rows> last;
    for (std::size_t step = 0; step < digests->size(); ++step) {
        if (auto fine = before(step); !fine) return fine;
        if (auto done = copy_step(recording, step, (*digests)[step], last, *copy); !done) return done;
    }
    if (!counts.empty()) copy->count(counts);
    return copy->close();
}

}  // namespace meld::record
