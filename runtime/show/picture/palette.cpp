#include "runtime/show/picture/palette.h"

#include <algorithm>
#include <cstdint>
#include <tuple>
#include <utility>

namespace meld::picture {

namespace {

// Whole numbers up to so many are kinds, with a colour and a line in the legend for each.
constexpr std::size_t kFewNumbers = 8;

}  // namespace

void Palette::include(const Frame& frame) {
    const bool of_lines = look_.colour.empty();
    if (of_lines && frame.line_numbers.empty()) return;
    if (!any_)
        std::tie(any_, title_, whole_numbers_) = of_lines ? std::tuple(true, frame.lines_coloured_by, frame.whole_line_numbers)
                                                          : std::tuple(true, frame.coloured_by, frame.whole_numbers);
    for (const auto& [at, word] : frame.words) kinds_.try_emplace(word);
    for (const auto& [at, number] : of_lines ? frame.line_numbers : frame.numbers) {
        low_ = std::min(low_, number);
        high_ = std::max(high_, number);
        if (few_.size() <= kFewNumbers) few_.insert(number);
    }
}

std::optional<render::Legend> Palette::settle() {
    if (look_.range) std::tie(low_, high_) = *look_.range;
    std::size_t i = 0;
    for (auto& [word, colour] : kinds_) colour = render::kind_colour(i++);
    if (!few_.empty() && whole_numbers_ && !look_.range && few_.size() <= kFewNumbers) colour_few();
    if (!few_.empty()) return of_numbers();
    if (!kinds_.empty()) return of_words();
    return std::nullopt;
}

void Palette::apply(Frame& frame) const {
    if (look_.colour.empty()) {
        for (const auto& [at, number] : frame.line_numbers) frame.scene.strokes[at].colour = of_number(number);
        return;
    }
    std::ranges::fill(frame.scene.colours, render::Rgb{});
    for (const auto& [at, word] : frame.words) frame.scene.colours[at] = kinds_.at(word);
    for (const auto& [at, number] : frame.numbers) frame.scene.colours[at] = of_number(number);
}

render::Rgb Palette::of_number(render::Number number) const {
    if (const auto one = few_colours_.find(number); one != few_colours_.end()) return one->second;
    return look_.map.at(high_ > low_ ? static_cast<double>((number - low_) / (high_ - low_)) : 0.5);
}

// Where two of them are so near each other that they would look alike, they are at equal distances.
void Palette::colour_few() {
    std::map<render::Number, render::Rgb> colours;
    std::set<std::tuple<std::uint8_t, std::uint8_t, std::uint8_t>> seen;
    for (const render::Number number : few_) {
        const render::Rgb c = colours.emplace(number, of_number(number)).first->second;
        seen.emplace(c.r, c.g, c.b);
    }
    std::size_t i = 0;
    if (seen.size() < few_.size())
        for (auto& [number, colour] : colours) colour = look_.map.at(static_cast<double>(i++) / static_cast<double>(few_.size() - 1));
    few_colours_ = std::move(colours);
}

render::Legend Palette::of_words() const {
    render::Legend legend{.title = title_};
    if (kinds_.size() == 1 && kinds_.begin()->first == kHolds)
        legend = {.kinds = {{title_, kinds_.begin()->second}}};
    else
        legend.kinds.assign(kinds_.begin(), kinds_.end());
    return legend;
}

render::Legend Palette::of_numbers() const {
    render::Legend legend{.title = title_};
    if (!few_colours_.empty())
        for (const auto& [number, colour] : few_colours_) legend.kinds.emplace_back(render::text_of(number, true), colour);
    else
        legend.scale = {.low = low_, .high = high_, .whole = whole_numbers_, .map = look_.map};
    return legend;
}

}  // namespace meld::picture
