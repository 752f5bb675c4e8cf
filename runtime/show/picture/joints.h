// Joints of bodies as what they are: a hinge is a pin along its axis, a slider a rail, a ball a ball.
#pragma once

#include <cstddef>
#include <span>

#include "runtime/results/record/drawing.h"
#include "runtime/show/render/scene.h"

namespace meld::picture {

// Adds to the scene those joints that are drawn and whose two catoms are shown, and an arm to each catom that ends before its anchor.
// `places` are those of catoms in the scene by their places in what is drawn, -1 of those that are not shown. Nothing is added if there are
// so many joints that the picture would be of them alone. Cost: about a hundred triangles for each.
void add_joints(const record::Drawn& drawn, std::span<const std::ptrdiff_t> places, render::Scene& scene);

}  // namespace meld::picture
