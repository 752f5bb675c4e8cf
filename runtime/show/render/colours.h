// Colours for values. The maps for numbers keep their order in print and for people who are colour-blind; those for kinds of things are
// told apart by them (Okabe and Ito, "Color Universal Design", 2008).
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "runtime/show/render/scene.h"

namespace meld::render {

class ColourMap {
  public:
    // viridis, cividis, magma, coolwarm, grey; nothing if there is none of this name.
    static std::optional<ColourMap> named(std::string_view name);
    static std::vector<std::string_view> names();

    // From 0, the least, to 1; beyond them as at them.
    Rgb at(double part) const;
    // At equal distances; between them colours are mixed.
    std::span<const Rgb> stops() const { return stops_; }

  private:
    explicit ColourMap(std::span<const Rgb> stops) : stops_(stops) {}
    std::span<const Rgb> stops_;  // At equal distances.
};

// For the i-th kind of thing. After eight they come again, paler.
Rgb kind_colour(std::size_t i);

// "#ff8800", "#f80", or one of: white, black, grey.
std::optional<Rgb> parse_colour(std::string_view text);

// How bright it looks, from 0 to 1.
double brightness(Rgb colour);

}  // namespace meld::render
