#include "runtime/show/view/kept/kept_values.h"

#include <algorithm>
#include <bit>

namespace meld::view {

void KeptValues::resize(std::size_t catoms) {
    if (catoms <= values_.size()) return;
    values_.resize(catoms);
    has_.resize((catoms + 63) / 64);
    chunks_.resize((catoms + kChunk - 1) / kChunk);
}

bool KeptValues::set(std::uint64_t catom, std::optional<std::uint64_t> value) {
    const bool had = has(catom);
    if (had == value.has_value() && (!had || values_[catom] == *value)) return false;
    const bool words = kind_ == Kind::Holds || kind_ == Kind::Text;
    if (words && had) give_back(values_[catom]);
    if (words && value) ++counts_[*value];
    const std::uint64_t bit = std::uint64_t{1} << (catom % 64);
    has_[catom / 64] = value ? has_[catom / 64] | bit : has_[catom / 64] & ~bit;
    values_[catom] = value.value_or(0);
    chunks_[catom / kChunk].known = false;
    return true;
}

std::uint64_t KeptValues::word(const std::string& text) {
    const auto [found, fresh] = by_text_.try_emplace(text, free_.empty() ? words_.size() : free_.back());
    if (!fresh) return found->second;
    if (free_.empty()) {
        words_.emplace_back();
        counts_.push_back(0);
    } else {
        free_.pop_back();
    }
    words_[found->second] = text;
    return found->second;
}

void KeptValues::give_back(std::uint64_t word) {
    if (--counts_[word] > 0) return;
    by_text_.erase(words_[word]);
    free_.push_back(word);
}

render::Number KeptValues::number(std::uint64_t bits) const {
    if (kind_ == Kind::Whole) return static_cast<render::Number>(static_cast<std::int64_t>(bits));
    return std::bit_cast<double>(bits);
}

void KeptValues::put(std::uint64_t catom, std::size_t place, picture::Frame& frame) const {
    if (!has(catom)) return;
    if (kind_ == Kind::Whole || kind_ == Kind::Real)
        frame.numbers.emplace_back(place, number(values_[catom]));
    else
        frame.words.emplace_back(place, words_[values_[catom]]);
}

template <class Less>
void KeptValues::look(std::size_t chunk, const Less& less) {
    Chunk& of = chunks_[chunk];
    of = {.known = true};
    std::uint64_t before = 0;
    const std::size_t end = std::min(values_.size(), (chunk + 1) * kChunk);
    for (std::size_t catom = chunk * kChunk; catom < end; ++catom) {
        if (!has(catom)) continue;
        const std::uint64_t value = values_[catom];
        // Neighbours often have the same.
        if (of.any && value == before) continue;
        before = value;
        if (!of.any || less(value, of.low)) of.low = value;
        if (!of.any || less(of.high, value)) of.high = value;
        of.any = true;
        if (of.few.size() < kFew && std::ranges::find(of.few, value) == of.few.end()) of.few.push_back(value);
    }
}

picture::Frame KeptValues::witness() {
    picture::Frame out;
    if (kind_ == Kind::Holds || kind_ == Kind::Text) {
        for (std::size_t i = 0; i < words_.size(); ++i)
            if (counts_[i] > 0) out.words.emplace_back(0, words_[i]);
        return out;
    }
    out.whole_numbers = kind_ == Kind::Whole;
    std::vector<render::Number> few;
    for (std::size_t i = 0; i < chunks_.size(); ++i) {
        if (!chunks_[i].known && kind_ == Kind::Whole)
            look(i, [](std::uint64_t a, std::uint64_t b) { return static_cast<std::int64_t>(a) < static_cast<std::int64_t>(b); });
        else if (!chunks_[i].known)
            look(i, [](std::uint64_t a, std::uint64_t b) { return std::bit_cast<double>(a) < std::bit_cast<double>(b); });
        const Chunk& chunk = chunks_[i];
        if (!chunk.any) continue;
        for (const std::uint64_t end : {chunk.low, chunk.high}) out.numbers.emplace_back(0, number(end));
        for (const std::uint64_t value : chunk.few)
            if (few.size() < kFew && std::ranges::find(few, number(value)) == few.end()) few.push_back(number(value));
    }
    for (const render::Number number : few) out.numbers.emplace_back(0, number);
    return out;
}

}  // namespace meld::view
