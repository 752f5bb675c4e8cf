#include "runtime/world/file/link_terms.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "runtime/base/did_you_mean.h"
#include "runtime/world/graph/fields.h"

namespace meld::world {
namespace {

constexpr std::uint64_t kMaxFile_bytes = std::uint64_t{1} << 30;

using Single = NetworkOptions::Single;

class TermsFile {
  public:
    TermsFile(std::string path, const std::vector<std::string_view>& keys, const NetworkOptions& network)
        : path_(std::move(path)), network_(network), fields_(',') {
        for (const std::string_view key : keys)
            if (key != "reorder") terms_.push_back(key);
    }

    Result<std::vector<Single>> read(std::string_view text) {
        bool named = false;
        const auto done = graph::each_line(text, [&](std::string_view line, std::size_t number) -> Result<void> {
            line_ = number;
            if (named) return add(line);
            named = true;
            fields_ = CsvRow(CsvRow::separator_of(line));
            return name_columns(line);
        });
        if (!done) return tl::unexpected<Error>(done.error());
        if (!named) return fail(path_ + ": it is empty", "begin with a line of names: from,to,loss");
        return sorted();
    }

  private:
    tl::unexpected<Error> wrong(std::size_t column, const std::string& problem, std::string cure) const {
        return fail(fmt::format("{}:{}:{}: {}", path_, line_, column, problem), std::move(cure));
    }

    Result<void> name_columns(std::string_view line) {
        const auto names = fields_.split(line, path_, line_);
        if (!names) return tl::unexpected<Error>(names.error());
        for (const std::string_view name : *names) columns_.emplace_back(name);
        if (columns_.size() < 3 || columns_[0] != "from" || columns_[1] != "to")
            return wrong(1, "the first line does not name the columns", fmt::format("begin with a line such as from,to,{}", terms_.back()));
        for (std::size_t i = 2; i < columns_.size(); ++i) {
            if (std::ranges::find(terms_, columns_[i]) == terms_.end())
                return wrong(fields_.column(i), fmt::format("links of this network have no term `{}`", columns_[i]),
                             did_you_mean(columns_[i], terms_));
            if (std::find(columns_.begin(), columns_.begin() + static_cast<std::ptrdiff_t>(i), columns_[i]) !=
                columns_.begin() + static_cast<std::ptrdiff_t>(i))
                return wrong(fields_.column(i), fmt::format("two columns are named `{}`", columns_[i]), "name each column once");
        }
        return {};
    }

    Result<void> add(std::string_view line) {
        const auto split = fields_.split(line, path_, line_);
        if (!split) return tl::unexpected<Error>(split.error());
        const std::span<const std::string_view> fields = *split;
        if (fields.size() != columns_.size())
            return wrong(1, fmt::format("here are {} fields, and the first line has {}", fields.size(), columns_.size()),
                         "give each link a value for each column");
        Single one{.terms = network_.terms, .line = line_};
        for (std::size_t i = 0; i < 2; ++i) {
            std::uint64_t& end = i == 0 ? one.from : one.to;
            if (!graph::parse_whole(fields[i], end))
                return wrong(fields_.column(i), fmt::format("'{}' is no number of a catom", fields[i].substr(0, 40)),
                             "write the numbers of both ends: 3,4");
        }
        if (one.from == one.to)
            return wrong(1, fmt::format("@{} has no link to itself", one.from), "write two catoms, or take the line out");
        // A link whose least delay is above the most of the network has just that.
        bool most = false;
        for (std::size_t i = 2; i < fields.size(); ++i) {
            if (auto set = term(columns_[i], fields[i], fields_.column(i), one.terms); !set) return set;
            most = most || columns_[i] == "most";
        }
        if (!most) one.terms.most = std::max(one.terms.most, one.terms.least);
        if (one.terms.most < one.terms.least)
            return wrong(1, fmt::format("most is {}, and least is {}", one.terms.most, one.terms.least),
                         "make most greater, or least smaller");
        const std::uint32_t bound = network_.kind == NetworkKind::Lossy ? one.terms.bound() : one.terms.most;
        if (bound > kMostTicks)
            return wrong(1, fmt::format("a message may be under way for {} ticks, and the maximum is {}", bound, kMostTicks),
                         "make retry or tries smaller");
        singles_.push_back(one);
        return {};
    }

    Result<void> term(const std::string& name, std::string_view field, std::size_t column, LinkTerms& terms) const {
        if (name == "loss" || name == "duplicate") {
            double& value = name == "loss" ? terms.loss : terms.duplicate;
            if (graph::parse_whole(field, value) && value >= 0 && value <= 1) return {};
            return wrong(column, fmt::format("'{}' is no probability", field.substr(0, 40)), "write a number from 0 to 1");
        }
        std::uint32_t& value = name == "least" ? terms.least : name == "most" ? terms.most : name == "retry" ? terms.retry : terms.tries;
        if (graph::parse_whole(field, value) && value >= 1 && value <= kMostTicks) return {};
        return wrong(column, fmt::format("'{}' is no {}", field.substr(0, 40), name == "tries" ? "number of tries" : "number of ticks"),
                     fmt::format("write a whole number from 1 to {}", kMostTicks));
    }

    Result<std::vector<Single>> sorted() {
        std::ranges::stable_sort(singles_, {}, [](const Single& one) { return std::pair(one.from, one.to); });
        const auto twice =
            std::ranges::adjacent_find(singles_, [](const Single& a, const Single& b) { return a.from == b.from && a.to == b.to; });
        if (twice == singles_.end()) return std::move(singles_);
        line_ = std::next(twice)->line;
        return wrong(1, fmt::format("the link from @{} to @{} is in line {} already", twice->from, twice->to, twice->line),
                     "take one of the lines out");
    }

    std::string path_;
    const NetworkOptions& network_;
    CsvRow fields_;
    std::vector<std::string_view> terms_;  // That a link of this network has.
    std::vector<std::string> columns_;
    std::vector<Single> singles_;
    std::size_t line_ = 0;
};

}  // namespace

void read_link_terms(TomlReader& reader, const Section& section, const std::string& name, const std::vector<std::string_view>& keys,
                     NetworkOptions& network) {
    if (reader.error() || !section.find("links")->is_string()) return;
    const std::string path = reader.beside(name);
    const Result<std::string> text = reader.read_file(path, kMaxFile_bytes);
    if (!text) return reader.wrong(section.find("links")->source(), text.error().problem, text.error().suggestion);
    Result<std::vector<Single>> singles = TermsFile(path, keys, network).read(*text);
    if (!singles) return reader.wrong(singles.error());
    network.singles = std::move(*singles);
    network.singles_path = path;
}

}  // namespace meld::world
