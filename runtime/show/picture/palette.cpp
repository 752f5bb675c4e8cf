#include "runtime/show/picture/palette.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

namespace meld::picture {

namespace {

// Whole numbers up to so many are kinds, with a colour and a line in the legend for each.
constexpr std::size_t kFewNumbers = 8;

}  // namespace

void Palette::include(const Frame& frame) {
    if (look_.colour.empty()) return;
    if (!any_) std::tie(any_, title_, whole_numbers_) = std::tuple(true, frame.coloured_by, frame.whole_numbers);
    for (const auto& [at, word] : frame.words) kinds_.try_emplace(word);
    for (const auto& [at, number] : frame.numbers) {
        low_ = std::min(low_, number);
        high_ = std::max(high_, number);
        if (few_.size() <= kFewNumbers) few_.insert(number);
    }
}

std::optional<render::Legend> Palette::settle() {
    if (look_.range) std::tie(low_, high_) = *look_.range;
    std::size_t i = 0;
    for (auto& [word, colour] : kinds_) colour = render::kind_colour(i++);
    if (!few_.empty()) return of_numbers();
    if (!kinds_.empty()) return of_words();
    return std::nullopt;
}

void Palette::apply(Frame& frame) const {
    if (look_.colour.empty()) return;
    std::ranges::fill(frame.scene.colours, render::Rgb{});
    for (const auto& [at, word] : frame.words) frame.scene.colours[at] = kinds_.at(word);
    for (const auto& [at, number] : frame.numbers) frame.scene.colours[at] = of_number(number);
}

render::Rgb Palette::of_number(double number) const { return look_.map.at(high_ > low_ ? (number - low_) / (high_ - low_) : 0.5); }

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
    if (whole_numbers_ && !look_.range && few_.size() <= kFewNumbers)
        for (const double number : few_) legend.kinds.emplace_back(fmt::format("{:.0f}", number), of_number(number));
    else
        legend.scale = {.low = low_, .high = high_, .whole = whole_numbers_, .map = look_.map};
    return legend;
}

}  // namespace meld::picture
