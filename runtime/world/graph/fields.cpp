#include "runtime/world/graph/fields.h"

#include <fmt/format.h>

#include <cmath>

namespace meld::graph {
std::string_view trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(" \t");
    return first == std::string_view::npos ? text.substr(0, 0) : text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

char Fields::separator_of(std::string_view line) {
    for (const char separator : {',', ';', '\t'})
        if (line.find(separator) != std::string_view::npos) return separator;
    return ' ';
}

const std::vector<std::string_view>& Fields::split(std::string_view line) {
    fields_.clear();
    for (std::size_t at = 0; at <= line.size();) {
        if (separator_ == ' ') {
            at = line.find_first_not_of(" \t", at);
            if (at == std::string_view::npos) break;
        } else {
            // Blanks before a quote.
            const std::size_t begin = line.find_first_not_of(' ', at);
            if (begin != std::string_view::npos && line[begin] == '"') at = begin;
        }
        if (at < line.size() && line[at] == '"') {
            const std::size_t close = std::min(line.find('"', at + 1), line.size());
            fields_.push_back(line.substr(at + 1, close - at - 1));
            at = std::min(close + 1, line.size());
            if (separator_ == ' ') continue;
            at = std::min(line.find(separator_, at), line.size()) + 1;
            continue;
        }
        const std::size_t end = std::min(separator_ == ' ' ? line.find_first_of(" \t", at) : line.find(separator_, at), line.size());
        fields_.push_back(trimmed(line.substr(at, end - at)));
        at = end + 1;
    }
    return fields_;
}

void ColumnReader::add(std::string_view field) {
    if (auto* integers = std::get_if<0>(&column_.values)) {
        std::int64_t whole = 0;
        if (parse_whole(field, whole)) return integers->push_back(whole);
        std::vector<double> numbers(integers->begin(), integers->end());
        double number = 0;
        if (parse_whole(field, number) && std::isfinite(number)) {
            column_.values = std::move(numbers);
        } else {
            std::vector<std::string> words;
            for (const std::int64_t i : *integers) words.push_back(fmt::format("{}", i));
            column_.values = std::move(words);
        }
    }
    if (auto* numbers = std::get_if<1>(&column_.values)) {
        double number = 0;
        if (parse_whole(field, number) && std::isfinite(number)) return numbers->push_back(number);
        std::vector<std::string> words;
        for (const double x : *numbers) words.push_back(fmt::format("{}", x));
        column_.values = std::move(words);
    }
    std::get<2>(column_.values).emplace_back(field);
}

}  // namespace meld::graph
