#include "runtime/results/compare/recorded_step.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <iterator>
#include <map>
#include <optional>
#include <set>

namespace meld::compare {

namespace {

using record::DescribedPredicate;
using record::ElementType;
using record::RecordingReader;

template <class T>
T element(const std::byte* row, int component) {
    T value;
    std::memcpy(&value, row + static_cast<std::size_t>(component) * sizeof value, sizeof value);
    return value;
}

// A number that is none has many forms of bits, which are told apart.
template <class Real, class Bits>
std::string real(const std::byte* row, int component) {
    const Real value = element<Real>(row, component);
    return value == value ? fmt::format("{}", value) : fmt::format("nan (bits {:x})", element<Bits>(row, component));
}

// The rows of the one or the other recording in a step.
class Side {
  public:
    Side(RecordingReader& reader, std::size_t step, std::size_t which) : reader_(reader), step_(step), which_(which) {}

    Result<RowWindow> window(const SeriesPair& pair) const {
        const Result<record::Rows> rows = reader_.rows(pair.in[which_], step_);
        if (!rows) return tl::unexpected(rows.error());
        // As they stand: what is shown is looked up in the strings of this recording.
        return RowWindow(reader_, pair.in[which_], *rows, nullptr);
    }
    const record::Series& series(const SeriesPair& pair) const { return reader_.series()[pair.in[which_]]; }

    Result<std::string> cell(const SeriesPair& pair, const std::byte* row, const std::string& type) const {
        const record::Series& s = series(pair);
        if (!s.texts.empty()) {
            const Result<const std::vector<std::string>*> texts = reader_.texts(s.texts);
            if (!texts) return tl::unexpected(texts.error());
            const auto number = element<std::int64_t>(row, 0);
            if (number < 0) return std::string("none");
            return static_cast<std::size_t>(number) < (*texts)->size() ? (**texts)[static_cast<std::size_t>(number)]
                                                                       : fmt::format("string {}", number);
        }
        std::vector<std::string> parts;
        for (int i = 0; i < s.components; ++i) parts.push_back(number(s.type, row, i, type));
        if (s.components == 1) return parts[0];
        return fmt::format("{}({})", type == "vec3" ? "vec3" : "", fmt::join(parts, ", "));
    }

  private:
    static std::string number(ElementType kind, const std::byte* row, int i, const std::string& type) {
        switch (kind) {
            case ElementType::Float32:
                return real<float, std::uint32_t>(row, i);
            case ElementType::Float64:
                return real<double, std::uint64_t>(row, i);
            case ElementType::UInt8:
                return std::to_string(element<std::uint8_t>(row, i));
            case ElementType::Int64:
                break;
        }
        const auto value = element<std::int64_t>(row, i);
        if (type == "node") return fmt::format("@{}", value);
        if (type == "bool") return value != 0 ? "true" : "false";
        return std::to_string(value);
    }

    RecordingReader& reader_;
    std::size_t step_, which_;
};

// The facts of a table, in the order of catoms.
class TableRows {
  public:
    static Result<TableRows> open(const Side& side, const std::string& name, const std::vector<SeriesPair>& columns,
                                  const DescribedPredicate* predicate) {
        TableRows out(side, name, columns, predicate);
        for (const SeriesPair& column : columns) {
            Result<RowWindow> window = side.window(column);
            if (!window) return tl::unexpected(window.error());
            out.windows_.push_back(std::move(*window));
        }
        if (const Result<void> first = out.look(); !first) return tl::unexpected(first.error());
        return out;
    }
    std::optional<std::uint64_t> catom() const { return catom_; }
    // The facts of this catom, in the order of their text; the next one follows.
    Result<std::vector<std::string>> take() {
        std::vector<std::string> facts;
        for (const std::uint64_t catom = *catom_; catom_ == catom;) {
            std::vector<std::string> cells = {fmt::format("@{}", catom)};
            for (const DescribedPredicate::Argument& argument : arguments_)
                for (std::size_t i = 1; i < columns_->size(); ++i) {
                    if (side_.series((*columns_)[i]).name != argument.name) continue;
                    const Result<const std::byte*> row = windows_[i].at(row_);
                    if (!row) return tl::unexpected(row.error());
                    Result<std::string> cell = side_.cell((*columns_)[i], *row, argument.type);
                    if (!cell) return tl::unexpected(cell.error());
                    cells.push_back(std::move(*cell));
                }
            facts.push_back(fmt::format("{}({})", name_, fmt::join(cells, ", ")));
            ++row_;
            if (const Result<void> done = look(); !done) return tl::unexpected(done.error());
        }
        std::sort(facts.begin(), facts.end());
        return facts;
    }

  private:
    TableRows(const Side& side, std::string name, const std::vector<SeriesPair>& columns, const DescribedPredicate* predicate)
        : side_(side), name_(std::move(name)), columns_(&columns) {
        if (predicate != nullptr) arguments_ = predicate->arguments;
        if (predicate == nullptr)
            for (std::size_t i = 1; i < columns.size(); ++i) arguments_.push_back({side.series(columns[i]).name, "", ""});
    }
    Result<void> look() {
        catom_.reset();
        if (row_ == windows_[0].count()) return {};
        const Result<const std::byte*> row = windows_[0].at(row_);
        if (!row) return tl::unexpected(row.error());
        catom_ = element<std::uint64_t>(*row, 0);
        return {};
    }

    Side side_;
    std::string name_;
    const std::vector<SeriesPair>* columns_;
    std::vector<DescribedPredicate::Argument> arguments_;
    std::vector<RowWindow> windows_;
    std::uint64_t row_ = 0;
    std::optional<std::uint64_t> catom_;
};

// All that a step says of one catom after the other.
class Catoms {
  public:
    static Result<Catoms> open(const Side& side, const StepPairs& pairs,
                               const std::vector<std::pair<std::uint64_t, std::uint64_t>>& lines) {
        Catoms out(side, pairs, lines);
        for (const SeriesPair* pair : {&pairs.ids, &pairs.points}) out.add(*pair);
        for (const SeriesPair& pair : pairs.arrays) out.add(pair);
        if (out.failure_) return tl::unexpected(*out.failure_);
        for (const auto& [name, columns] : pairs.tables) {
            Result<TableRows> table = TableRows::open(side, name, columns, predicate(pairs, name));
            if (!table) return tl::unexpected(table.error());
            out.tables_.push_back(std::move(*table));
        }
        if (const Result<void> first = out.look(); !first) return tl::unexpected(first.error());
        return out;
    }
    std::optional<std::uint64_t> id() const { return id_; }

    // What this catom has, by what it is called and in the order of its text, and goes on to the next.
    using Held = std::map<std::string, std::vector<std::string>>;
    Result<Held> take() {
        Held held;
        std::map<std::string, std::string> cells;
        for (std::size_t i = 1; i < windows_.size(); ++i) {
            const std::string& name = side_.series(*columns_[i]).name;
            const Result<const std::byte*> row = windows_[i].at(row_);
            if (!row) return tl::unexpected(row.error());
            Result<std::string> cell = side_.cell(*columns_[i], *row, type_of_[name]);
            if (!cell) return tl::unexpected(cell.error());
            cells[name] = std::move(*cell);
        }
        for (const DescribedPredicate& p : pairs_->predicates)
            if (!p.table) take_fact(p, cells, held);
        for (auto& [name, cell] : cells) held[name] = {std::move(cell)};
        for (TableRows& table : tables_) {
            // A row of a catom that is not in the step is damage, and is passed over.
            while (table.catom() && *table.catom() < *id_)
                if (const auto skipped = table.take(); !skipped) return tl::unexpected(skipped.error());
            if (table.catom() != id_) continue;
            Result<std::vector<std::string>> facts = table.take();
            if (!facts) return tl::unexpected(facts.error());
            if (!facts->empty()) held[facts->front().substr(0, facts->front().find('('))] = std::move(*facts);
        }
        for (; line_ < lines_->size() && (*lines_)[line_].first <= *id_; ++line_)
            if ((*lines_)[line_].first == *id_) held["line"].push_back(fmt::format("to @{}", (*lines_)[line_].second));
        if (const auto found = held.find("line"); found != held.end()) std::ranges::sort(found->second);
        ++row_;
        if (const Result<void> done = look(); !done) return tl::unexpected(done.error());
        return held;
    }

  private:
    Catoms(const Side& side, const StepPairs& pairs, const std::vector<std::pair<std::uint64_t, std::uint64_t>>& lines)
        : side_(side), pairs_(&pairs), lines_(&lines) {
        for (const DescribedPredicate& p : pairs.predicates)
            for (const DescribedPredicate::Argument& argument : p.arguments) type_of_[argument.array] = argument.type;
    }
    static const DescribedPredicate* predicate(const StepPairs& pairs, const std::string& name) {
        for (const DescribedPredicate& p : pairs.predicates)
            if (p.name == name) return &p;
        return nullptr;
    }
    void add(const SeriesPair& pair) {
        Result<RowWindow> window = side_.window(pair);
        if (!window) return void(failure_ = window.error());
        windows_.push_back(std::move(*window));
        columns_.push_back(&pair);
    }
    Result<void> look() {
        id_.reset();
        if (row_ == windows_[0].count()) return {};
        const Result<const std::byte*> row = windows_[0].at(row_);
        if (!row) return tl::unexpected(row.error());
        id_ = element<std::uint64_t>(*row, 0);
        return {};
    }
    // The arrays of a predicate become its fact.
    void take_fact(const DescribedPredicate& p, std::map<std::string, std::string>& cells, Held& held) const {
        const std::string counts = p.arguments.empty() ? p.name : p.name + ".facts";
        const auto count = cells.find(counts);
        if (count == cells.end()) return;
        std::vector<std::string> arguments = {fmt::format("@{}", *id_)};
        for (const DescribedPredicate::Argument& argument : p.arguments) {
            const auto cell = cells.find(argument.array);
            if (cell == cells.end()) return;
            arguments.push_back(cell->second);
        }
        const bool there = count->second != "0";
        for (const DescribedPredicate::Argument& argument : p.arguments) cells.erase(argument.array);
        cells.erase(counts);
        if (there) held[p.name] = {fmt::format("{}({})", p.name, fmt::join(arguments, ", "))};
    }

    Side side_;
    const StepPairs* pairs_;
    std::vector<RowWindow> windows_;
    std::vector<const SeriesPair*> columns_;
    std::vector<TableRows> tables_;
    std::map<std::string, std::string> type_of_;
    const std::vector<std::pair<std::uint64_t, std::uint64_t>>* lines_;  // By their first end.
    std::size_t line_ = 0;
    std::uint64_t row_ = 0;
    std::optional<std::uint64_t> id_;
    std::optional<Error> failure_;
};

using Lines = std::vector<std::pair<std::uint64_t, std::uint64_t>>;

// The lines of a step between numbers of catoms.
Result<Lines> lines_of(const Side& side, const StepPairs& pairs) {
    Result<RowWindow> ends = side.window(pairs.line_ends), ids = side.window(pairs.ids);
    for (const auto* each : {&ends, &ids})
        if (!*each) return tl::unexpected(each->error());
    Lines out;
    for (std::uint64_t row = 0; row + 1 < ends->count(); row += 2) {
        std::array<std::uint64_t, 2> line{};
        for (std::size_t i : {0u, 1u}) {
            const Result<const std::byte*> end = ends->at(row + i);
            if (!end) return tl::unexpected(end.error());
            const auto index = element<std::uint64_t>(*end, 0);
            if (index >= ids->count()) return fail("a line ends at a catom that is not there", "", ExitCode::RecordingRefused);
            const Result<const std::byte*> id = ids->at(index);
            if (!id) return tl::unexpected(id.error());
            line[i] = element<std::uint64_t>(*id, 0);
        }
        out.emplace_back(line[0], line[1]);
    }
    std::sort(out.begin(), out.end());
    return out;
}

std::vector<std::string> only_in(const std::vector<std::string>& here, const std::vector<std::string>& there) {
    std::vector<std::string> out;
    std::set_difference(here.begin(), here.end(), there.begin(), there.end(), std::back_inserter(out));
    return out;
}

std::vector<Difference> differences(const Catoms::Held& a, const Catoms::Held& b) {
    std::set<std::string> names;
    for (const Catoms::Held* each : {&a, &b})
        for (const auto& [name, lines] : *each) names.insert(name);
    std::vector<Difference> out;
    static const std::vector<std::string> kNone;
    for (const std::string& name : names) {
        const auto in_a = a.find(name), in_b = b.find(name);
        Difference one{name, only_in(in_a == a.end() ? kNone : in_a->second, in_b == b.end() ? kNone : in_b->second),
                       only_in(in_b == b.end() ? kNone : in_b->second, in_a == a.end() ? kNone : in_a->second)};
        if (!one.a.empty() || !one.b.empty()) out.push_back(std::move(one));
    }
    return out;
}

}  // namespace

Result<void> describe_step(std::array<RecordingReader*, 2> readers, std::array<std::size_t, 2> steps, const StepPairs& pairs,
                           Report& report) {
    const Side first(*readers[0], steps[0], 0), second(*readers[1], steps[1], 1);
    const Result<Lines> lines_a = lines_of(first, pairs), lines_b = lines_of(second, pairs);
    for (const auto* each : {&lines_a, &lines_b})
        if (!*each) return tl::unexpected(each->error());
    Result<Catoms> a = Catoms::open(first, pairs, *lines_a), b = Catoms::open(second, pairs, *lines_b);
    for (const auto* each : {&a, &b})
        if (!*each) return tl::unexpected(each->error());
    while (a->id() || b->id()) {
        const std::uint64_t id = !b->id() ? *a->id() : !a->id() ? *b->id() : std::min(*a->id(), *b->id());
        const bool in_a = a->id() == id, in_b = b->id() == id;
        const Result<Catoms::Held> held_a = in_a ? a->take() : Catoms::Held{}, held_b = in_b ? b->take() : Catoms::Held{};
        for (const auto* each : {&held_a, &held_b})
            if (!*each) return tl::unexpected(each->error());
        std::vector<Difference> here = differences(*held_a, *held_b);
        if (here.empty()) continue;
        if (++report.catoms > 1) continue;
        report.catom = id;
        report.here = std::move(here);
    }
    return {};
}

}  // namespace meld::compare
