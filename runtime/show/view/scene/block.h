// A frame of a run as a page in a browser reads it: bytes for what there is much of, JSON for the rest.
//
// The block, in little endian: 16 numbers of 32 bits: kBlockMagic, kBlockVersion, tick (low, high), catoms, flags, lines, arrows, labels,
// form, triangles of obstacles, and zeros. Then of all catoms the places (3 floats), the diameters (a float), the ids (32 bits; with
// kWideIds, their high words behind them), the colours (red, green, blue, 255), with kCovered the covers (4 signed bytes each), with
// kNumbers the numbers that they are coloured by (a double; NaN: none), and with kWords the words (32 bits: which of Values::names,
// counted from 1; 0: none); then lines and arrows, each with both ends (6 floats) and its colour; then labels: the catom's place in the
// block, the length in bytes, and the text in UTF-8, padded with zeros to 4 bytes; then triangles (9 floats); then, with kBodies, of all
// catoms half the edges of their cores, their rounding, and how they are turned: x, y, z, w (8 floats). Of a compound, the
// first is the radius of the ball around it, and the fourth minus its place among compounds, from 1.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "runtime/show/picture/frame.h"
#include "runtime/show/render/caption.h"
#include "runtime/show/view/scene/thin.h"

namespace meld::view {

inline constexpr std::uint32_t kBlockMagic = 0x46444c4d;  // MLDF
inline constexpr std::uint32_t kBlockVersion = 2;
// Where the tick is, in bytes.
inline constexpr std::size_t kBlockTick = 8;
// Flags: some id has more than 32 bits; catoms that nobody sees are left out, and of the others it is known what covers them.
inline constexpr std::uint32_t kWideIds = 1, kCovered = 2;
// Of catoms the values that they are coloured by.
inline constexpr std::uint32_t kNumbers = 4, kWords = 8;
// Bodies that are no spheres.
inline constexpr std::uint32_t kBodies = 16;

// What catoms are coloured by, by their places. Numbers that a double does not hold are words.
struct Values {
    std::vector<double> numbers = {};       // NaN: none.
    std::vector<std::uint32_t> words = {};  // Which name, counted from 1; 0: none.
    std::vector<std::string> names = {};
};
Values values_of(const picture::Frame& frame);

// `covers`: of each catom, as of Thinned; or none. Cost: 28 bytes a catom, and those of the values.
std::string frame_block(const picture::Frame& frame, std::span<const Cover> covers = {}, const Values& values = {});

// What follows the catoms in a block, with how much there is of it.
struct BlockEnd {
    std::uint32_t lines = 0, arrows = 0, labels = 0, triangles = 0;
    std::string bytes = {};
};
BlockEnd frame_end(const picture::Frame& frame);

// The first four of the numbers of a body in a block.
std::array<float, 4> core_of(const render::RoundedBody& body);
// Of each compound a list of its solids: four numbers as core_of, the middle, and the rotation: x, y, z, w.
nlohmann::ordered_json compounds_json(const render::Scene& scene);

// Of each lamp x, y, z and its radius.
nlohmann::ordered_json lamps_json(const render::Scene& scene);

// Of each note the place in the scene of the catom that it is about.
std::vector<std::uint32_t> catoms_of_notes(const render::Scene& scene);

// What goes with it: `tick`, `catoms` (all there are), `shown`, `legend` (null, or as legend_json), and `bounds` of the middles of catoms:
// the least and the greatest x, y, z; null without catoms.
// Where there are compounds, also `compounds`, as compounds_json; where there are lamps, `lamps`, as lamps_json.
nlohmann::ordered_json frame_words(const picture::Frame& frame, const std::optional<render::Legend>& legend);

// `title`, and `scale` (`low` and `high`, of many digits as texts; `whole`, `stops`: colours at equal distances) or `kinds` (of each name
// and colour, "#rrggbb").
nlohmann::ordered_json legend_json(const std::optional<render::Legend>& legend);

}  // namespace meld::view
