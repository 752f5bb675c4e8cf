// A frame of a run as a page in a browser reads it: bytes for what there is much of, JSON for the rest.
//
// The block, in little endian: 16 numbers of 32 bits: kBlockMagic, kBlockVersion, tick (low, high), catoms, flags, lines, arrows, labels,
// form, and zeros. Then of all catoms the places (3 floats), the diameters (a float), the ids (32 bits; with kWideIds, their high words
// behind them) and the colours (red, green, blue, 255); then lines and arrows, each with both ends (6 floats) and its colour; then labels:
// the catom's place in the block, the length in bytes, and the text in UTF-8, padded with zeros to 4 bytes.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "runtime/picture/frame.h"
#include "runtime/render/caption.h"

namespace meld::view {

inline constexpr std::uint32_t kBlockMagic = 0x46444c4d;  // MLDF
inline constexpr std::uint32_t kBlockVersion = 1;
inline constexpr std::uint32_t kWideIds = 1;  // A flag: some id has more than 32 bits.

// Cost: 28 bytes a catom.
std::string frame_block(const picture::Frame& frame);

// What goes with it: `tick`, `catoms` (all there are), `shown`, `legend` (null, or as legend_json), and `bounds` of the middles of catoms:
// the least and the greatest x, y, z; null without catoms.
nlohmann::ordered_json frame_words(const picture::Frame& frame, const std::optional<render::Legend>& legend);

// `title`, and `scale` (`low`, `high`, `whole`, `stops`: colours at equal distances) or `kinds` (of each name and colour, "#rrggbb").
nlohmann::ordered_json legend_json(const std::optional<render::Legend>& legend);

}  // namespace meld::view
