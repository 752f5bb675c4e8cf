#include "runtime/results/facts/facts_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>

#include "runtime/base/files/input_file.h"
#include "runtime/base/files/line_reader.h"
#include "runtime/results/facts/fact_tables.h"
#include "runtime/results/facts/facts_csv.h"

namespace meld::record {

namespace {

constexpr std::uint64_t kMaxDescription_bytes = 64 << 20;

tl::unexpected<Error> wrong_line(const std::string& path, std::uint64_t line, const std::string& what) {
    return fail(fmt::format("{}:{}: {}", path, line, what), "Give what `meldsim run --facts-out` has written");
}

// The number at the beginning of a text; none if there is none.
std::optional<std::uint64_t> number_at(std::string_view text, std::size_t& end) {
    std::uint64_t value = 0;
    const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
    end = static_cast<std::size_t>(read.ptr - text.data());
    return read.ec == std::errc{} ? std::optional(value) : std::nullopt;
}

// "dist(@12, 3)." as its parts; whether it is one.
struct FactLine {
    std::string_view name;
    std::uint64_t catom = 0;
    std::size_t arguments = 0;  // The catom among them.
};
bool parse(std::string_view line, FactLine& out) {
    const std::size_t open = line.find("(@");
    if (open == std::string_view::npos || open == 0 || !line.ends_with(").")) return false;
    out.name = line.substr(0, open);
    std::size_t end = 0;
    const std::optional<std::uint64_t> catom = number_at(line.substr(open + 2), end);
    if (!catom) return false;
    out.catom = *catom;
    out.arguments = 1;
    int depth = 0;
    bool quoted = false;
    for (std::size_t i = open + 2 + end; i + 2 < line.size(); ++i) {
        const char c = line[i];
        if (quoted && c == '\\')
            ++i;
        else if (c == '"')
            quoted = !quoted;
        else if (quoted)
            continue;
        else if (c == '(' || c == '[' || c == '{')
            ++depth;
        else if (c == ')' || c == ']' || c == '}')
            --depth;
        else if (c == ',' && depth == 0)
            ++out.arguments;
    }
    return !quoted && depth == 0;
}

class TextFactsReader : public FactsReader {
  public:
    explicit TextFactsReader(const std::string& path) : lines_(path) {}

    Result<void> find_tables() {
        std::string line;
        while (true) {
            const std::uint64_t offset = lines_.offset(), number = lines_.number();
            if (!lines_.next(line)) break;
            FactLine fact;
            if (!parse(line, fact)) return wrong_line(lines_.path(), lines_.number(), "this is no fact");
            if (!places_.empty() && places_.back().name == fact.name && places_.back().arguments == fact.arguments) {
                ++places_.back().rows;
                continue;
            }
            for (const Place& place : places_)
                if (place.name == fact.name && place.arguments == fact.arguments)
                    return wrong_line(lines_.path(), lines_.number(), fmt::format("the facts of {} are not together", fact.name));
            places_.push_back({std::string(fact.name), fact.arguments, offset, number, 1});
        }
        for (const Place& place : places_) tables_.push_back({.name = place.name, .arguments = place.arguments});
        return lines_.outcome();
    }

    const std::vector<Table>& tables() const override { return tables_; }
    Result<void> begin(std::size_t table) override {
        lines_.seek(places_[table].offset, places_[table].line);
        left_ = places_[table].rows;
        return {};
    }
    Result<bool> next(FactRow& row) override {
        if (left_ == 0) return false;
        --left_;
        FactLine fact;
        if (!lines_.next(row.text) || !parse(row.text, fact)) {
            if (const auto read = lines_.outcome(); !read) return tl::unexpected(read.error());
            return wrong_line(lines_.path(), lines_.number(), "this is no fact any more");
        }
        row.catom = fact.catom;
        return true;
    }

  private:
    struct Place {
        std::string name;
        std::size_t arguments;
        std::uint64_t offset, line, rows;
    };
    LineReader lines_;
    std::vector<Place> places_;
    std::vector<Table> tables_;
    std::uint64_t left_ = 0;
};

class CsvFacts : public FactsReader {
  public:
    // Files by the names of their tables.
    Result<void> add(const std::string& name, const std::string& path) {
        LineReader lines(path);
        std::string heading;
        if (!lines.next(heading)) return no_heading(lines);
        if (heading != kCatomColumn && !heading.starts_with(std::string(kCatomColumn) + ","))
            return wrong_line(path, 1, "the first column is not that of the catoms");
        tables_.push_back({.name = name, .columns = heading});
        paths_.push_back(path);
        return {};
    }

    const std::vector<Table>& tables() const override { return tables_; }
    Result<void> begin(std::size_t table) override {
        lines_.emplace(paths_[table]);
        std::string heading;
        if (!lines_->next(heading)) return no_heading(*lines_);
        return {};
    }
    Result<bool> next(FactRow& row) override {
        if (!lines_->next(row.text)) {
            if (const auto fine = lines_->outcome(); !fine) return tl::unexpected(fine.error());
            return false;
        }
        std::size_t end = 0;
        const std::optional<std::uint64_t> catom = number_at(row.text, end);
        if (!catom || (end < row.text.size() && row.text[end] != ','))
            return wrong_line(lines_->path(), lines_->number(), "the row does not begin with the number of a catom");
        row.catom = *catom;
        return true;
    }

  private:
    static Result<void> no_heading(const LineReader& lines) {
        if (auto read = lines.outcome(); !read) return read;
        return fail(fmt::format("cannot read {}: it has no first line", lines.path()));
    }

    std::vector<Table> tables_;
    std::vector<std::string> paths_;
    std::optional<LineReader> lines_;
};

}  // namespace

Result<std::unique_ptr<FactsReader>> read_text_facts(const std::string& path) {
    auto out = std::make_unique<TextFactsReader>(path);
    if (const auto found = out->find_tables(); !found) return tl::unexpected(found.error());
    return out;
}

Result<std::unique_ptr<FactsReader>> read_csv_facts(const std::string& path) {
    auto out = std::make_unique<CsvFacts>();
    if (const auto added = out->add(std::filesystem::path(path).stem().string(), path); !added) return tl::unexpected(added.error());
    return out;
}

Result<std::unique_ptr<FactsReader>> read_csv_folder(const std::string& path) {
    const std::string description = (std::filesystem::path(path) / kDataPackage).string();
    const Result<std::string> text = read_input(description, kMaxDescription_bytes);
    if (!text) return tl::unexpected(text.error());
    auto out = std::make_unique<CsvFacts>();
    try {
        const nlohmann::json package = nlohmann::json::parse(*text);
        for (const auto& resource : package.at("resources")) {
            const std::string file = resource.at("path").get<std::string>();
            // A description names only files beside it.
            if (file.find('/') != std::string::npos) return fail(fmt::format("{} names {}, which is in another folder", description, file));
            const auto added = out->add(resource.at("name").get<std::string>(), (std::filesystem::path(path) / file).string());
            if (!added) return tl::unexpected(added.error());
        }
    } catch (const nlohmann::json::exception& error) {
        return fail(fmt::format("{} is not as meldsim writes it ({})", description, error.what()));
    }
    return out;
}

}  // namespace meld::record
