// Sets of facts: table by table, catom by catom.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include "runtime/results/compare/compare.h"
#include "runtime/results/facts/facts_reader.h"

namespace meld::compare {

namespace {

using record::FactRow;
using record::FactsReader;

Result<std::unique_ptr<FactsReader>> reader_of(const std::string& path, Kind kind) {
    switch (kind) {
        case Kind::CsvFile:
            return record::read_csv_facts(path);
        case Kind::CsvFolder:
            return record::read_csv_folder(path);
        case Kind::Hdf5Facts:
            return record::read_hdf5_facts(path);
        default:
            return record::read_text_facts(path);
    }
}

// The facts of a table, those of a catom at a time.
class FactsByCatom {
  public:
    FactsByCatom(FactsReader& reader, const std::string& path) : reader_(reader), path_(path) {}

    Result<void> begin(std::size_t table) {
        if (auto begun = reader_.begin(table); !begun) return begun;
        table_ = reader_.tables()[table].name;
        there_ = true;
        if (auto first = reader_.next(ahead_); !first || !*first) return end(first);
        return next();
    }
    // Whether there is one.
    explicit operator bool() const { return !facts_.empty(); }
    std::uint64_t catom() const { return catom_; }
    // In the order of their text.
    const std::vector<std::string>& facts() const { return facts_; }

    Result<void> next() {
        facts_.clear();
        if (!there_) return {};
        catom_ = ahead_.catom;
        while (ahead_.catom == catom_) {
            facts_.push_back(std::move(ahead_.text));
            if (auto more = reader_.next(ahead_); !more || !*more) {
                there_ = false;
                if (!more) return tl::unexpected(more.error());
                break;
            }
            if (ahead_.catom < catom_)
                return fail(fmt::format("{}: the facts of {} are not in the order of catoms: {} comes after {}", path_, table_,
                                        ahead_.catom, catom_),
                            "Give what `meldsim run --facts-out` has written");
        }
        std::sort(facts_.begin(), facts_.end());
        return {};
    }

  private:
    Result<void> end(const Result<bool>& last) {
        there_ = false;
        facts_.clear();
        return last ? Result<void>{} : tl::unexpected(last.error());
    }

    FactsReader& reader_;
    const std::string& path_;
    std::string table_;
    FactRow ahead_;
    bool there_ = false;
    std::uint64_t catom_ = 0;
    std::vector<std::string> facts_;
};

class FactsComparison {
  public:
    FactsComparison(std::array<FactsReader*, 2> readers, std::array<const std::string*, 2> paths, std::array<Kind, 2> kinds,
                    std::uint64_t most, Progress& progress)
        : readers_(readers), paths_(paths), kinds_(kinds), most_(most), progress_(progress) {}

    Result<Report> run() {
        Report report{.kind = "facts"};
        for (const TablePair& pair : pairs()) {
            if (pair.in[0] && pair.in[1]) {
                const std::string &a = table(0, *pair.in[0]).columns, &b = table(1, *pair.in[1]).columns;
                if (a != b) report.runs.push_back({"the columns of " + pair.name, {a}, {b}});
            }
            Result<PredicateFacts> facts = compare_table(pair);
            if (!facts) return tl::unexpected(facts.error());
            report.facts.push_back(std::move(*facts));
        }
        return report;
    }

  private:
    // A table in the one, in the other, or in both.
    struct TablePair {
        std::string name;
        std::array<std::optional<std::size_t>, 2> in;
    };
    const FactsReader::Table& table(std::size_t side, std::size_t index) const { return readers_[side]->tables()[index]; }

    std::vector<TablePair> pairs() const {
        // A CSV file has the facts of the only predicate, and its name is the user's choice.
        const auto one_table = [&](std::size_t side) { return readers_[side]->tables().size() == 1; };
        if ((kinds_[0] == Kind::CsvFile || kinds_[1] == Kind::CsvFile) && one_table(0) && one_table(1))
            return {{table(kinds_[0] == Kind::CsvFile && kinds_[1] != Kind::CsvFile ? 1 : 0, 0).name, {0, 0}}};
        std::map<std::pair<std::string, std::size_t>, std::array<std::optional<std::size_t>, 2>> found;
        for (std::size_t side : {0u, 1u})
            for (std::size_t i = 0; i < readers_[side]->tables().size(); ++i)
                found[{table(side, i).name, table(side, i).arguments}][side] = i;
        std::map<std::string, std::size_t> namesakes;
        for (const auto& [key, in] : found) ++namesakes[key.first];
        std::vector<TablePair> out;
        for (const auto& [key, in] : found) {
            const auto& [name, arguments] = key;
            out.push_back({namesakes[name] == 1 ? name : fmt::format("{}.{}", name, arguments), in});
        }
        return out;
    }

    Result<PredicateFacts> compare_table(const TablePair& pair) {
        PredicateFacts out{.name = pair.name};
        FactsByCatom a(*readers_[0], *paths_[0]), b(*readers_[1], *paths_[1]);
        if (pair.in[0])
            if (auto begun = a.begin(*pair.in[0]); !begun) return tl::unexpected(begun.error());
        if (pair.in[1])
            if (auto begun = b.begin(*pair.in[1]); !begun) return tl::unexpected(begun.error());
        static const std::vector<std::string> kNone;
        while (a || b) {
            progress_.update([&] { return fmt::format("{}, catom {}", pair.name, a ? a.catom() : b.catom()); });
            const bool first = a && (!b || a.catom() <= b.catom()), second = b && (!a || b.catom() <= a.catom());
            count(first ? a.facts() : kNone, second ? b.facts() : kNone, out);
            if (first)
                if (auto done = a.next(); !done) return tl::unexpected(done.error());
            if (second)
                if (auto done = b.next(); !done) return tl::unexpected(done.error());
        }
        return out;
    }

    void count(const std::vector<std::string>& a, const std::vector<std::string>& b, PredicateFacts& out) const {
        if (a == b) return void(out.both += a.size());
        std::vector<std::string> only;
        std::set_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(only));
        out.both += a.size() - only.size();
        take(only, out.only_a, out.a);
        std::set_difference(b.begin(), b.end(), a.begin(), a.end(), std::back_inserter(only));
        take(only, out.only_b, out.b);
    }
    void take(std::vector<std::string>& facts, std::uint64_t& count, std::vector<std::string>& examples) const {
        count += facts.size();
        for (std::string& fact : facts)
            if (examples.size() < most_) examples.push_back(std::move(fact));
        facts.clear();
    }

    std::array<FactsReader*, 2> readers_;
    std::array<const std::string*, 2> paths_;
    std::array<Kind, 2> kinds_;
    std::uint64_t most_;
    Progress& progress_;
};

}  // namespace

Result<Report> compare_facts(const std::string& a, Kind kind_a, const std::string& b, Kind kind_b, std::uint64_t most_examples,
                             Progress& progress) {
    const Result<std::unique_ptr<FactsReader>> first = reader_of(a, kind_a), second = reader_of(b, kind_b);
    for (const auto* each : {&first, &second})
        if (!*each) return tl::unexpected(each->error());
    return FactsComparison({first->get(), second->get()}, {&a, &b}, {kind_a, kind_b}, most_examples, progress).run();
}

}  // namespace meld::compare
