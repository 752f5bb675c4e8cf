#include "runtime/show/render/colours.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

namespace meld::render {

namespace {

constexpr Rgb hex(std::uint32_t rgb) {
    return {static_cast<std::uint8_t>(rgb >> 16), static_cast<std::uint8_t>(rgb >> 8), static_cast<std::uint8_t>(rgb)};
}

// Of matplotlib, at ten places; between them straight lines differ from it by less than the eye sees.
constexpr std::array kViridis = {hex(0x440154), hex(0x482878), hex(0x3e4989), hex(0x31688e), hex(0x26828e),
                                 hex(0x1f9e89), hex(0x35b779), hex(0x6ece58), hex(0xb5de2b), hex(0xfde725)};
constexpr std::array kCividis = {hex(0x00224e), hex(0x123570), hex(0x3b496c), hex(0x575d6d), hex(0x707173),
                                 hex(0x8a8678), hex(0xa59c74), hex(0xc3b369), hex(0xe1cc55), hex(0xfee838)};
constexpr std::array kMagma = {hex(0x000004), hex(0x180f3d), hex(0x440f76), hex(0x721f81), hex(0x9e2f7f),
                               hex(0xcd4071), hex(0xf1605d), hex(0xfd9668), hex(0xfeca8d), hex(0xfcfdbf)};
// For numbers on both sides of a middle (Moreland, "Diverging Color Maps for Scientific Visualization", 2009).
constexpr std::array kCoolwarm = {hex(0x3b4cc0), hex(0x6788ee), hex(0x9abbff), hex(0xc9d7f0), hex(0xdddddd),
                                  hex(0xedd1c2), hex(0xf7a889), hex(0xe26952), hex(0xb40426)};
constexpr std::array kGrey = {hex(0x303030), hex(0xf0f0f0)};

const std::array<std::pair<std::string_view, std::span<const Rgb>>, 5> kMaps = {
    {{"viridis", kViridis}, {"cividis", kCividis}, {"magma", kMagma}, {"coolwarm", kCoolwarm}, {"grey", kGrey}}};

constexpr std::array kKinds = {hex(0xe69f00), hex(0x56b4e9), hex(0x009e73), hex(0xf0e442),
                               hex(0x0072b2), hex(0xd55e00), hex(0xcc79a7), hex(0x606060)};

std::uint8_t between(std::uint8_t a, std::uint8_t b, double part) {
    return static_cast<std::uint8_t>(std::lround(a + part * (static_cast<double>(b) - a)));
}

Rgb mixed(Rgb a, Rgb b, double part) { return {between(a.r, b.r, part), between(a.g, b.g, part), between(a.b, b.b, part)}; }

}  // namespace

std::optional<ColourMap> ColourMap::named(std::string_view name) {
    const auto* const found = std::ranges::find(kMaps, name, &std::pair<std::string_view, std::span<const Rgb>>::first);
    if (found == kMaps.end()) return std::nullopt;
    return ColourMap(found->second);
}

std::vector<std::string_view> ColourMap::names() {
    std::vector<std::string_view> out;
    for (const auto& [name, stops] : kMaps) out.push_back(name);
    return out;
}

Rgb ColourMap::at(double part) const {
    const double place = std::clamp(part, 0.0, 1.0) * static_cast<double>(stops_.size() - 1);
    const std::size_t before = std::min(static_cast<std::size_t>(place), stops_.size() - 2);
    return mixed(stops_[before], stops_[before + 1], place - static_cast<double>(before));
}

Rgb kind_colour(std::size_t i) {
    const std::size_t rounds = i / kKinds.size();
    return mixed(kKinds[i % kKinds.size()], {255, 255, 255}, 1 - std::pow(0.6, static_cast<double>(rounds)));
}

std::optional<Rgb> parse_colour(std::string_view text) {
    if (text == "white") return Rgb{255, 255, 255};
    if (text == "black") return Rgb{0, 0, 0};
    if (text == "grey") return Rgb{};
    if ((text.size() != 7 && text.size() != 4) || text[0] != '#') return std::nullopt;
    std::uint32_t value = 0;
    const auto read = std::from_chars(text.data() + 1, text.data() + text.size(), value, 16);
    if (read.ec != std::errc{} || read.ptr != text.data() + text.size()) return std::nullopt;
    if (text.size() == 7) return hex(value);
    return hex((value >> 8 & 15) * 0x110000 | (value >> 4 & 15) * 0x1100 | (value & 15) * 0x11);
}

double brightness(Rgb colour) { return (0.299 * colour.r + 0.587 * colour.g + 0.114 * colour.b) / 255; }

}  // namespace meld::render
