// Recordings: steps of the same tick, as bytes first, and the first that differs catom by catom.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "runtime/results/compare/compare.h"
#include "runtime/results/compare/recorded_step.h"
#include "runtime/results/record/load_map.h"

namespace meld::compare {

namespace {

using record::DescribedPredicate;
using record::RecordingReader;
using record::Rows;
using record::SeriesIndex;

// What tells of a run, as people call it.
constexpr std::array<std::pair<const char*, const char*>, 5> kRun = {{{"program", "the program"},
                                                                      {"world", "the world"},
                                                                      {"seed", "the seed"},
                                                                      {"lattice", "the lattice"},
                                                                      {"radius_metres", "the radius"}}};

// Two texts of many lines as the first lines that differ, two of one line as they are.
Difference text_difference(const std::string& what, const std::string& a, const std::string& b) {
    std::size_t at = 0, line = 1;
    const auto line_at = [](const std::string& text, std::size_t begin) {
        return begin < text.size() ? std::vector{text.substr(begin, text.find('\n', begin) - begin)} : std::vector<std::string>{};
    };
    while (true) {
        const std::vector<std::string> x = line_at(a, at), y = line_at(b, at);
        if (x != y || x.empty()) {
            const bool lines = a.find('\n') != std::string::npos || b.find('\n') != std::string::npos;
            return {lines ? fmt::format("{}, from line {} on", what, line) : what, x, y};
        }
        at += x[0].size() + 1;
        ++line;
    }
}

class Comparison {
  public:
    Comparison(RecordingReader& a, RecordingReader& b, Progress& progress) : readers_{&a, &b}, progress_(progress) {}

    Result<Report> run() {
        compare_runs();
        if (!a().ticks().empty() && !b().ticks().empty()) {
            if (auto paired = pair_series(); !paired) return tl::unexpected(paired.error());
            for (std::size_t side : {0u, 1u}) {
                Result<std::vector<Digest>> digests = readers_[side]->digests();
                if (!digests) return tl::unexpected(digests.error());
                digests_[side] = std::move(*digests);
            }
        }
        const std::vector<std::int64_t>&ticks_a = a().ticks(), &ticks_b = b().ticks();
        for (std::size_t i = 0, j = 0; i < ticks_a.size() || j < ticks_b.size();) {
            const bool first = i < ticks_a.size() && (j == ticks_b.size() || ticks_a[i] <= ticks_b[j]);
            const bool second = j < ticks_b.size() && (i == ticks_a.size() || ticks_b[j] <= ticks_a[i]);
            if (first && second && !report_.tick)
                if (auto done = compare_step({i, j}); !done) return tl::unexpected(done.error());
            if (first && !second) report_.lone_a.add(ticks_a[i]);
            if (second && !first) report_.lone_b.add(ticks_b[j]);
            i += first ? 1 : 0;
            j += second ? 1 : 0;
        }
        return std::move(report_);
    }

  private:
    RecordingReader& a() const { return *readers_[0]; }
    RecordingReader& b() const { return *readers_[1]; }

    void compare_runs() {
        for (const auto& [name, what] : kRun)
            if (const std::string x = a().about(name), y = b().about(name); x != y) report_.runs.push_back(text_difference(what, x, y));
    }

    // Errors: those of reading strings.
    Result<std::optional<SeriesPair>> pair(SeriesIndex in_a, SeriesIndex in_b) {
        const record::Series &x = a().series()[in_a], &y = b().series()[in_b];
        if (x.type != y.type || x.components != y.components || x.texts.empty() != y.texts.empty()) return std::optional<SeriesPair>();
        SeriesPair out{.in = {in_a, in_b}};
        if (x.texts.empty()) return std::optional(std::move(out));
        const auto of_a = a().texts(x.texts), of_b = b().texts(y.texts);
        for (const auto* each : {&of_a, &of_b})
            if (!*each) return tl::unexpected(each->error());
        out.renumbering = Renumbering(**of_b, **of_a);
        return std::optional(std::move(out));
    }

    // Names as pairs of places in a and b; what only one has is a difference of the runs.
    using Named = std::map<std::string, std::array<std::optional<SeriesIndex>, 2>>;
    Result<std::vector<SeriesPair>> pair_named(const Named& named, const std::string& before) {
        std::vector<SeriesPair> out;
        for (const auto& [name, places] : named) {
            std::optional<SeriesPair> both;
            if (places[0] && places[1]) {
                Result<std::optional<SeriesPair>> paired = pair(*places[0], *places[1]);
                if (!paired) return tl::unexpected(paired.error());
                both = std::move(*paired);
            }
            if (both)
                out.push_back(std::move(*both));
            else
                note_lone(before + name, places[0].has_value(), places[1].has_value());
        }
        return out;
    }
    void note_lone(const std::string& name, bool in_a, bool in_b) {
        const bool both = in_a && in_b;
        Difference one{"what is recorded", {}, {}};
        if (in_a) one.a.push_back(both ? name + ", of another type" : name);
        if (in_b) one.b.push_back(both ? name + ", of another type" : name);
        report_.runs.push_back(std::move(one));
    }

    Result<void> pair_series() {
        pair_predicates();
        for (const auto& [to, of] : {std::pair{&pairs_.ids, &RecordingReader::ids}, std::pair{&pairs_.points, &RecordingReader::points},
                                     std::pair{&pairs_.line_ends, &RecordingReader::line_ends}})
            to->in = {(a().*of)(), (b().*of)()};
        // The arrays of a predicate that has a table say less than the table does.
        std::set<std::string> covered_by_tables;
        for (const DescribedPredicate& p : pairs_.predicates)
            if (p.table) {
                covered_by_tables.insert(p.name + ".facts");
                for (const DescribedPredicate::Argument& argument : p.arguments) covered_by_tables.insert(argument.array);
            }
        const auto is_counted = [](RecordingReader* reader) {
            return std::ranges::any_of(reader->arrays(),
                                       [&](SeriesIndex index) { return reader->series()[index].name.starts_with(record::kLoadArrays); });
        };
        const bool counted = is_counted(&a()) && is_counted(&b());
        Named arrays;
        std::map<std::string, std::array<const record::SeriesTable*, 2>> tables;
        for (std::size_t side : {0u, 1u}) {
            for (const SeriesIndex index : readers_[side]->arrays()) {
                const std::string& name = readers_[side]->series()[index].name;
                // A run is the same whether it is counted or not.
                if (name.starts_with(record::kLoadArrays) && !counted) continue;
                if (!covered_by_tables.contains(name)) arrays[name][side] = index;
            }
            for (const record::SeriesTable& table : readers_[side]->tables()) tables[table.name][side] = &table;
        }
        Result<std::vector<SeriesPair>> paired = pair_named(arrays, "");
        if (!paired) return tl::unexpected(paired.error());
        pairs_.arrays = std::move(*paired);
        for (const auto& [name, both] : tables) {
            if (both[0] == nullptr || both[1] == nullptr) {
                note_lone("the facts of " + name, both[0] != nullptr, both[1] != nullptr);
                continue;
            }
            Named columns;
            for (std::size_t side : {0u, 1u})
                for (std::size_t i = 1; i < both[side]->columns.size(); ++i)
                    columns[readers_[side]->series()[both[side]->columns[i]].name][side] = both[side]->columns[i];
            Result<std::vector<SeriesPair>> rest = pair_named(columns, name + ".");
            if (!rest) return tl::unexpected(rest.error());
            rest->insert(rest->begin(), SeriesPair{.in = {both[0]->columns[0], both[1]->columns[0]}});
            pairs_.tables.emplace_back(name, std::move(*rest));
        }
        return {};
    }

    // Those that both describe alike.
    void pair_predicates() {
        for (const DescribedPredicate& one : a().predicates())
            if (std::ranges::find(b().predicates(), one) != b().predicates().end()) pairs_.predicates.push_back(one);
    }

    // Whether the series has the same bytes in both steps. What was alike in the step before, and is still where it was, is not read again.
    Result<bool> same(const SeriesPair& pair, const std::array<std::size_t, 2>& steps) {
        const Result<Rows> x = a().rows(pair.in[0], steps[0]), y = b().rows(pair.in[1], steps[1]);
        for (const auto* each : {&x, &y})
            if (!*each) return tl::unexpected(each->error());
        const auto known = alike_.find(pair.in[0]);
        if (known != alike_.end() && known->second == std::pair(*x, *y)) return true;
        const Result<bool> equal = alike(RowWindow(a(), pair.in[0], *x, nullptr), RowWindow(b(), pair.in[1], *y, &pair.renumbering));
        if (equal && *equal) alike_.insert_or_assign(pair.in[0], std::pair(*x, *y));
        return equal;
    }

    Result<void> compare_step(const std::array<std::size_t, 2>& steps) {
        const std::int64_t tick = a().ticks()[steps[0]];
        progress_.update([&] { return fmt::format("tick {} of {}", tick, a().ticks().back()); });
        std::vector<const SeriesPair*> all = {&pairs_.ids, &pairs_.points, &pairs_.line_ends};
        for (const SeriesPair& each : pairs_.arrays) all.push_back(&each);
        for (const auto& [name, columns] : pairs_.tables)
            for (const SeriesPair& each : columns) all.push_back(&each);
        for (const SeriesPair* each : all) {
            const Result<bool> equal = same(*each, steps);
            if (!equal) return tl::unexpected(equal.error());
            if (*equal) continue;
            if (auto described = describe_step(readers_, steps, pairs_, report_); !described) return described;
            // Only the order of lines differs, or which number a string has.
            if (report_.catoms == 0) break;
            report_.tick = tick;
            return {};
        }
        if (const Digest &x = digests_[0][steps[0]], &y = digests_[1][steps[1]]; x != y) {
            report_.tick = tick;
            report_.here = {{"digest", {x.to_string()}, {y.to_string()}}};
            report_.remark = "What differs is not recorded; record more predicates";
            return {};
        }
        ++report_.same_ticks;
        return {};
    }

    std::array<RecordingReader*, 2> readers_;
    Progress& progress_;
    StepPairs pairs_;
    std::map<SeriesIndex, std::pair<Rows, Rows>> alike_;
    std::array<std::vector<Digest>, 2> digests_;  // By step.
    Report report_{.kind = "recordings"};
};

}  // namespace

Result<Report> compare_recordings(const std::string& a, const std::string& b, Progress& progress) {
    Result<RecordingReader> first = RecordingReader::open(a), second = RecordingReader::open(b);
    for (const auto* each : {&first, &second})
        if (!*each) return tl::unexpected(each->error());
    return Comparison(*first, *second, progress).run();
}

}  // namespace meld::compare
