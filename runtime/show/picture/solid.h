// Catoms as triangles, for programs that show solids.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "runtime/show/render/scene.h"

namespace meld::picture {

struct Solid {
    std::vector<render::Vec> places = {}, normals = {};    // Of corners; of length 1.
    std::vector<render::Rgb> colours = {};                 // Of corners.
    std::vector<std::array<std::uint32_t, 3>> faces = {};  // Counter-clockwise from outside.
    bool flat = false;                                     // It has no inside: discs and hexagons.
};

// Without catoms that have neighbours on all sides, and without faces between two cubes. Balls are rounder the fewer there are: they have
// 320, 80 or 20 faces. Strokes and notes are no part of it. Memory: some 0.6 to 8 kB for each ball that is left.
Solid solid_of(const render::Scene& scene);

}  // namespace meld::picture
