#include "runtime/world/graph/fields.h"

#include <fmt/format.h>

#include <cmath>

namespace meld::graph {

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
