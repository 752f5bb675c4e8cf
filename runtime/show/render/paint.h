// What rays see: catoms under a sky and a sun, with soft shadows, and a line where one is in front of another far behind it.
#pragma once

#include <optional>

#include "runtime/base/process/parallel_for.h"
#include "runtime/show/render/camera.h"
#include "runtime/show/render/geometry.h"
#include "runtime/show/render/image.h"

namespace meld::render {

struct Quality {
    std::size_t samples = 2;  // Rays through a pixel, along each side.
    std::size_t sky = 2;      // Rays to the sky from where each of them ends; 4 if one goes through a pixel.
    bool edges = false;       // Draw lines where one catom or one side of it ends, as in Lines.
};

struct Painted {
    Image image;
    std::vector<float> distances;  // For each pixel how far away the nearest thing in it is; infinite: nothing.
};

// Transparent where there is nothing, if there is no background. The same for any number of threads.
// Cost: one ray a sample, and a ray to the sun and those to the sky from each that meets something: some 0.1 us each, 16 together.
Painted paint(const Scene& scene, const Geometry& geometry, const Camera& camera, std::size_t width, std::size_t height,
              std::optional<Rgb> background, const Quality& quality, Workers& workers);

}  // namespace meld::render
