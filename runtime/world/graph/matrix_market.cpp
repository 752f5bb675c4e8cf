// Matrix Market exchange format: coordinates of a sparse square matrix (https://math.nist.gov/MatrixMarket/formats.html).
#include <fmt/format.h>

#include <string>

#include "runtime/world/graph/fields.h"
#include "runtime/world/graph/files.h"

namespace meld::graph {
namespace {

tl::unexpected<Error> wrong(const std::string& path, std::size_t line, const std::string& problem, std::string cure = {}) {
    return fail(fmt::format("{}:{}: {}", path, line, problem), std::move(cure));
}

}  // namespace

Result<Table> read_matrix_market(const FileText& file) {
    const std::string_view first = file.text.substr(0, file.text.find('\n'));
    CsvRow fields(' ');
    std::vector<std::string> banner;
    const auto named = fields.split(first, file.path, 1);
    if (!named) return tl::unexpected<Error>(named.error());
    for (const std::string_view word : *named) {
        std::string& lower = banner.emplace_back(word);
        for (char& c : lower)
            if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    }
    if (banner.size() != 5 || banner[0] != "%%matrixmarket" || banner[1] != "matrix")
        return wrong(file.path, 1, "this is no Matrix Market file", "its first line is %%MatrixMarket matrix coordinate ...");
    if (banner[2] != "coordinate")
        return wrong(file.path, 1, fmt::format("a matrix in {} form has no links", banner[2]), "write it as coordinates");
    if (banner[3] == "complex") return wrong(file.path, 1, "numbers of links are not complex", "write it as real, integer or pattern");
    const std::size_t wanted = banner[3] == "pattern" ? 2 : 3;

    Table table;
    table.path = file.path;
    std::uint64_t rows = 0, columns = 0, entries = 0;
    bool sized = false;
    ColumnReader weight("weight");
    const auto done = each_line(file.text, [&](std::string_view line, std::size_t number) -> Result<void> {
        const auto split = fields.split(line, file.path, number);
        if (!split) return tl::unexpected<Error>(split.error());
        const std::span<const std::string_view> words = *split;
        if (!sized) {
            if (words.size() != 3 || !parse_whole(words[0], rows) || !parse_whole(words[1], columns) || !parse_whole(words[2], entries))
                return wrong(file.path, number, "here is no size of the matrix", "write rows, columns and entries");
            if (rows != columns)
                return wrong(file.path, number, fmt::format("a matrix of {} rows and {} columns is no graph", rows, columns),
                             "a graph has a square matrix");
            if (rows > kMaxNodes) return wrong(file.path, number, fmt::format("{} nodes are too many", rows));
            sized = true;
            table.ends.reserve(entries < file.text.size() ? entries : 0);
            return {};
        }
        std::uint64_t from = 0, to = 0;
        if (words.size() != wanted || !parse_whole(words[0], from) || !parse_whole(words[1], to))
            return wrong(file.path, number, fmt::format("'{}' is no entry of the matrix", line.substr(0, 40)),
                         wanted == 2 ? "write row and column" : "write row, column and value");
        if (from < 1 || to < 1 || from > rows || to > rows)
            return wrong(file.path, number, fmt::format("entry {} {} is not in a matrix of {} rows", from, to, rows),
                         "rows and columns are numbered from 1");
        table.add(from - 1, to - 1, number);
        if (wanted == 3) weight.add(words[2]);
        return {};
    });
    if (!done) return tl::unexpected<Error>(done.error());
    if (table.ends.size() != entries)
        return fail(fmt::format("{} has {} entries, and its size line says {}", file.path, table.ends.size(), entries),
                    "the file is cut off or damaged");
    table.node_count = rows;
    if (wanted == 3) table.columns.push_back(weight.take());
    return table;
}

}  // namespace meld::graph
