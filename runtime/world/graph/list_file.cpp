// Lists of links and of nodes.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "runtime/world/graph/fields.h"
#include "runtime/world/graph/files.h"

namespace meld::graph {
namespace {

// What programs call the two ends of a link in a first line. Letters could be nodes themselves.
constexpr std::array<std::string_view, 14> kEndNames = {"from",  "to",    "source", "target", "src",  "dst",  "node1",
                                                        "node2", "start", "end",    "head",   "tail", "node", "other"};

std::string lower(std::string_view text) {
    std::string out(text);
    for (char& c : out)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return out;
}

bool is_number(std::string_view field) {
    std::uint64_t number = 0;
    return parse_whole(field, number);
}

bool is_end_name(std::string_view field) { return std::ranges::find(kEndNames, lower(field)) != kEndNames.end(); }

tl::unexpected<Error> wrong(const std::string& path, std::size_t line, std::size_t column, const std::string& problem, std::string cure) {
    return fail(fmt::format("{}:{}:{}: {}", path, line, column, problem), std::move(cure));
}

class ListReader {
  public:
    explicit ListReader(const FileText& file) : file_(file), fields_(' ') { table_.path = file.path; }

    Result<Table> read() {
        look_at_first_lines();
        const auto done = each_line(file_.text, [&](std::string_view line, std::size_t number) -> Result<void> {
            if (named_ && number == first_line_) return {};
            return add(line, number);
        });
        if (!done) return tl::unexpected<Error>(done.error());
        for (ColumnReader& column : columns_) table_.columns.push_back(column.take());
        return std::move(table_);
    }

  private:
    // The first line names the columns if its ends have such names, or if they are words and those of the second line are numbers.
    void look_at_first_lines() {
        std::vector<std::string> names;
        bool words = false, first_numbers = true, second_numbers = false;
        int seen = 0;
        static_cast<void>(each_line(file_.text, [&](std::string_view line, std::size_t number) -> Result<void> {
            if (++seen > 2) return fail("");
            if (seen == 1) {
                separator_ = CsvRow::separator_of(line);
                first_line_ = number;
            }
            CsvRow splitter(separator_);
            const auto split = splitter.split(line, file_.path, number);
            // It is reported when it is read as a link.
            if (!split) return tl::unexpected<Error>(split.error());
            const std::span<const std::string_view> fields = *split;
            const bool numbers = fields.size() >= 2 && is_number(fields[0]) && is_number(fields[1]);
            if (seen == 2) return second_numbers = numbers, Result<void>();
            first_numbers = numbers;
            words = fields.size() >= 2 && is_end_name(fields[0]) && is_end_name(fields[1]);
            for (const std::string_view field : fields) names.emplace_back(field);
            return {};
        }));
        named_ = names.size() >= 2 && !first_numbers && (words || second_numbers);
        fields_ = CsvRow(separator_);
        count_ = names.size();
        for (std::size_t i = 2; i < names.size(); ++i)
            columns_.emplace_back(named_ ? names[i] : i == 2 ? std::string("weight") : fmt::format("column{}", i + 1));
        table_.ends.reserve(file_.text.size() / 16);
    }

    Result<void> add(std::string_view line, std::size_t number) {
        const auto split = fields_.split(line, file_.path, number);
        std::span<const std::string_view> fields = fields_.fields();
        // networkx writes the attributes of a link as a dictionary of Python.
        if (fields.size() > 2 && fields[2].starts_with('{')) {
            if (fields[2] != "{}")
                return wrong(file_.path, number, fields_.column(2), "this is a dictionary of Python",
                             "write the columns themselves: networkx.write_edgelist(G, path, data=[\"weight\"])");
            fields = fields.subspan(0, 2);
            if (count_ == 3) columns_.clear(), count_ = 2;
        }
        if (!split) return tl::unexpected<Error>(split.error());
        if (fields.size() < 2)
            return wrong(file_.path, number, 1, fmt::format("'{}' is no link", line.substr(0, 40)),
                         "write the two nodes of a link, and then its columns");
        if (fields.size() != count_)
            return wrong(file_.path, number, 1, fmt::format("here are {} fields, and the first line has {}", fields.size(), count_),
                         "give each link the same columns");
        Ends ends;
        for (std::size_t i = 0; i < 2; ++i)
            if (const auto known = node(fields[i], number, fields_.column(i), i == 0 ? ends.from : ends.to); !known) return known;
        table_.add(ends.from, ends.to, number);
        for (std::size_t i = 2; i < fields.size(); ++i) columns_[i - 2].add(fields[i]);
        return {};
    }

    Result<void> node(std::string_view field, std::size_t line, std::size_t column, std::uint64_t& out) {
        if (field.empty()) return wrong(file_.path, line, column, "here is no node", "write the two nodes of a link");
        const bool digits = field.find_first_not_of("0123456789") == std::string_view::npos;
        if (!table_.names.words() && digits) {
            numbers_ = true;
            if (parse_whole(field, out) && out <= kMaxNumber) return {};
            return wrong(file_.path, line, column, fmt::format("{} is too large for a node", field), "number nodes from 0");
        }
        std::int64_t number = 0;
        if (parse_whole(field, number) && number < 0 && !table_.names.words())
            return wrong(file_.path, line, column, fmt::format("{} is no node", field), "number nodes from 0");
        if (numbers_)
            return wrong(file_.path, line, column, fmt::format("'{}' is a word, and the nodes before are numbers", field.substr(0, 40)),
                         "write all nodes as numbers, or all as words: n1, n2");
        out = table_.names.number_of(field);
        return {};
    }

    FileText file_;
    Table table_;
    char separator_ = ' ';
    CsvRow fields_;
    bool named_ = false, numbers_ = false;
    std::size_t first_line_ = 0, count_ = 0;
    std::vector<ColumnReader> columns_;
};

}  // namespace

Result<Table> read_list(const FileText& file) { return ListReader(file).read(); }

Result<void> read_nodes(const FileText& file, Table& table) {
    std::vector<ColumnReader> columns;
    char separator = ' ';
    std::size_t count = 0, rows = 0;
    // The first column that is no node.
    std::size_t skipped = 1;
    std::unordered_map<std::uint64_t, std::size_t> lines;
    const auto done = each_line(file.text, [&](std::string_view line, std::size_t number) -> Result<void> {
        const bool first = count == 0;
        if (first) separator = CsvRow::separator_of(line);
        CsvRow splitter(separator);
        const auto split = splitter.split(line, file.path, number);
        if (!split) return tl::unexpected<Error>(split.error());
        const std::span<const std::string_view> fields = *split;
        if (first) {
            count = fields.size();
            // A list of places alone numbers its nodes from 0.
            if (fields[0] == "x" && !table.names.words() && table.ends.empty()) skipped = 0;
            for (std::size_t i = skipped; i < count; ++i) columns.emplace_back(std::string(fields[i]));
            if (count > 1 && is_number(fields[1]))
                return wrong(file.path, number, 1, "the first line does not name the columns", "write node,x,y");
            // Nodes alone need no name.
            if (count > 1 || !is_number(fields[0])) return {};
        }
        if (fields.size() != count)
            return wrong(file.path, number, 1, fmt::format("here are {} fields, and the first line names {}", fields.size(), count),
                         "give each node the same columns");
        std::uint64_t node = rows;
        if (skipped > 0 && table.names.words())
            node = table.names.number_of(fields[0]);
        else if (skipped > 0 && (!parse_whole(fields[0], node) || node > kMaxNumber))
            return wrong(file.path, number, splitter.column(0), fmt::format("'{}' is no node", fields[0].substr(0, 40)),
                         "write the number of a node, as the links do");
        const auto [at, fresh] = lines.try_emplace(node, number);
        if (!fresh)
            return wrong(file.path, number, 1, fmt::format("node {} is listed already, in line {}", fields[0], at->second),
                         "take one of them out");
        table.nodes.push_back(node);
        for (std::size_t i = skipped; i < count; ++i) columns[i - skipped].add(fields[i]);
        ++rows;
        return {};
    });
    if (!done) return done;
    for (Row row = 0; row < table.ends.size(); ++row)
        for (const std::uint64_t node : {table.ends[row].from, table.ends[row].to})
            if (!lines.contains(node))
                return fail(fmt::format("{}: {} does not list node {}", table.place(row), file.path,
                                        table.names.words() ? table.names.all()[node] : fmt::format("{}", node)),
                            "list all nodes, or none");
    table.nodes_listed = true;
    for (ColumnReader& column : columns) table.node_columns.push_back(column.take());
    return {};
}

}  // namespace meld::graph
