#include "runtime/results/hdf5/step_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <span>

#include "runtime/base/assert.h"

namespace meld::record {

namespace {

constexpr std::uint64_t kStepsPerChunk = 256;
constexpr const char* kLink = "Steps";

// The table to which the step is written; readers see the other one in the meantime.
std::size_t turn(std::int64_t step) { return step % 2 == 0 ? 0 : 1; }

}  // namespace

std::string StepTable::table(std::size_t number) const { return fmt::format("{}/{}", place_.group, number); }

StepTable::StepTable(Hdf5File& file, const StepTablePlace& place) : file_(file), place_(place) {
    file_.make_group(place_.group);
    for (const std::size_t number : {0u, 1u}) {
        file_.make_group(table(number));
        file_.set_attribute(table(number), "NSteps", std::int64_t{0});
    }
    for (const char* group : {"PointDataOffsets", "FactOffsets", "FactCounts"}) make_group(group);
    file_.link(place_.seen_in, kLink, table(turn(1)));
}

StepTable::StepTable(Hdf5File& file, const StepTablePlace& place, ByteReader& saved) : file_(file), place_(place) {
    steps_ = saved.read<std::int64_t>();
    for (auto left = saved.read_count(sizeof(Column)); left > 0; --left) columns_.push_back(saved.read<Column>());
}

void StepTable::save(ByteWriter& out) const {
    out.write(steps_);
    out.write_count(columns_.size());
    for (const Column& column : columns_) out.write(column);
}

bool StepTable::matches() const {
    const std::string shown = file_.linked(place_.seen_in, kLink);
    for (const std::size_t number : {0u, 1u}) {
        if (shown != table(number)) continue;
        if (steps_ == 0) return true;
        if (file_.attribute(shown, "NSteps").value_or(0) < steps_) return false;
        return std::ranges::all_of(columns_, [&](const Column& column) {
            std::vector<std::int64_t> row(column.components);
            file_.read_rows(column.in[number], static_cast<std::uint64_t>(steps_ - 1), 1, row.data());
            return std::ranges::equal(row, std::span(column.last).first(column.components));
        });
    }
    return false;
}

// Of a table that readers do not see.
void StepTable::shorten(std::size_t number, std::int64_t rows) {
    for (const Column& column : columns_) file_.shorten(column.in[number], static_cast<std::uint64_t>(rows));
    file_.change_attribute(table(number), "NSteps", rows);
}

void StepTable::show(std::size_t number) {
    file_.flush();
    file_.link(place_.seen_in, kLink, table(number));
    file_.flush_names(place_.seen_in);
}

// The table that readers see is never shortened: if it is the one that is to have all steps, they see the other one for a while.
void StepTable::cut() {
    const std::size_t last = turn(steps_ - 1), other = turn(steps_);
    const std::string shown = file_.linked(place_.seen_in, kLink);
    const bool has_more = file_.attribute(shown, "NSteps") != steps_;
    if (shown == table(last) && has_more) {
        shorten(other, steps_);
        show(other);
    }
    if (shown != table(last) || has_more) {
        shorten(last, steps_);
        show(last);
    }
    shorten(other, std::max<std::int64_t>(steps_ - 1, 0));
    file_.flush();
}

void StepTable::make_group(const std::string& name) {
    for (const std::size_t number : {0u, 1u}) file_.make_group(table(number) + "/" + name);
}

StepColumn StepTable::add_column(const std::string& name, ElementType type, int components) {
    MELD_CHECK(size_of(type) == sizeof(std::int64_t) && components <= 4, "column '{}'", name);
    Column column;
    column.components = static_cast<std::size_t>(components);
    for (const std::size_t number : {0u, 1u}) {
        const ColumnShape shape = {
            .type = type, .components = components, .chunk_rows = kStepsPerChunk, .readable_at_once = place_.seen_early || steps_ > 0};
        // The table to be written lacks the last step, which is written together with the next.
        const std::int64_t rows = number == turn(steps_) ? std::max<std::int64_t>(steps_ - 1, 0) : steps_;
        column.in[number] = file_.make_column(table(number) + "/" + name, shape, static_cast<std::uint64_t>(rows));
    }
    columns_.push_back(column);
    return columns_.size() - 1;
}

void StepTable::set(StepColumn column, std::int64_t value) { columns_[column].next = {value}; }
void StepTable::set(StepColumn column, double value) { set(column, std::bit_cast<std::int64_t>(value)); }
void StepTable::set(StepColumn column, const std::array<std::int64_t, 4>& values) { columns_[column].next = values; }

std::vector<std::int64_t> StepTable::read(StepColumn column, std::int64_t first, std::int64_t count) const {
    const Column& read = columns_[column];
    std::vector<std::int64_t> rows(static_cast<std::size_t>(count) * read.components);
    file_.read_rows(read.in[turn(steps_ - 1)], static_cast<std::uint64_t>(first), static_cast<std::uint64_t>(count), rows.data());
    return rows;
}

// What the table refers to is in the file before the table, the table before the link.
void StepTable::commit() {
    const std::size_t number = turn(steps_);
    const std::int64_t first = std::max<std::int64_t>(steps_ - 1, 0);
    for (Column& column : columns_) {
        std::vector<std::int64_t> rows;
        if (first < steps_) rows.assign(column.last.begin(), column.last.begin() + static_cast<std::ptrdiff_t>(column.components));
        rows.insert(rows.end(), column.next.begin(), column.next.begin() + static_cast<std::ptrdiff_t>(column.components));
        file_.write_rows(column.in[number], static_cast<std::uint64_t>(first), static_cast<std::uint64_t>(steps_ + 1 - first), rows.data());
        column.last = column.next;
    }
    ++steps_;
    file_.change_attribute(table(number), "NSteps", steps_);
    show(number);
}

}  // namespace meld::record
