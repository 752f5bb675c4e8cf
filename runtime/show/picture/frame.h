// What of a run is in a picture, asked in Meld: a body says what is coloured, shown, joined or named.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/results/record/drawing.h"
#include "runtime/show/render/caption.h"
#include "runtime/show/render/number.h"
#include "runtime/show/render/scene.h"
#include "runtime/sim/core/subdomain.h"
#include "runtime/world/description/world.h"
#include "runtime/world/lattice/lattice.h"

namespace meld::picture {

// A label beside the picture, with a line to a catom: to one of this number, or to each of a body, which has its value, or the body itself.
struct Callout {
    std::optional<std::uint64_t> catom = {};
    std::string body = {};
    std::string text = {};  // Of the catom.
};

// A plane at right angles to an axis; what is on one side of it is not shown.
struct Cut {
    int axis = 0;
    float at = 0;
    bool above = false;  // Otherwise what is below is kept.
    bool keeps(float x) const { return above ? x >= at : x <= at; }
};

// Bodies may be empty. Each is about the first of its variables that is a catom. The value of a catom is that of the last other variable;
// of several the least.
struct Look {
    std::string colour = {};  // By value; of a body without another variable, those for which it holds.
    std::string only = {};    // These are shown,
    std::string hide = {};    // and these are not.
    bool exposed = false;     // On a lattice only those with a free cell beside them.
    std::optional<Cut> cut = {};
    // A line from the catom to the next variable that is a catom, or along a vec3 or three numbers; or an arrow. Where catoms have no
    // values, it has the colour of the last variable behind these, if that is a number.
    std::string links = {};
    std::string arrows = {};
    std::string labels = {};  // The value is written at the catom.
    std::vector<Callout> callouts = {};
    render::ColourMap map = *render::ColourMap::named("viridis");
    std::optional<std::pair<double, double>> range = {};  // Of numbers; otherwise from the least to the greatest that are shown.
    std::optional<render::Form> form = {};                // Otherwise that of the lattice.
    std::optional<float> size = {};                       // Of catoms, as a part of their diameters; otherwise so that lines are seen.
    bool ground = false;                                  // A floor below what is shown, for shadows.
    bool skips_mistakes = false;                          // A body that is wrong is left out: Frame::mistakes.
};

// The word for catoms for which a body holds that has no value.
inline constexpr const char* kHolds = "holds";

// A moment of a run.
struct Frame {
    std::int64_t tick = 0;
    std::uint64_t catoms = 0;             // All there are, also those that are not shown.
    render::Scene scene = {};             // In the colours that catoms have given themselves.
    std::vector<std::uint64_t> ids = {};  // Of the catoms that are shown, by their places in the scene; in order.
    std::string coloured_by = {};         // What colours are to mean.
    // Values of catoms that are shown, by their places in the scene: numbers, or words for anything else.
    std::vector<std::pair<std::size_t, render::Number>> numbers = {};
    std::vector<std::pair<std::size_t, std::string>> words = {};
    bool whole_numbers = true;
    // The same of lines and arrows, by their places among the strokes of the scene.
    std::string lines_coloured_by = {};
    std::vector<std::pair<std::size_t, render::Number>> line_numbers = {};
    bool whole_line_numbers = true;
    std::vector<std::uint64_t> missing = {};  // Catoms that callouts name and that are not there.
    std::vector<Error> mistakes = {};         // In bodies that were left out; each begins with the name of its option.
};

// How catoms on such a lattice look.
render::Form form_of(world::LatticeKind lattice);

// The run as it is between two ticks, on process 0; an empty frame on the others. Every process calls it. Errors: mistakes in a body,
// unless the look skips them; a variable that is to be a catom is none.
Result<Frame> look_at(sim::Subdomain& subdomain, record::Drawing& drawing, const Look& look);

// The same of what is drawn alone, without a run: nothing is asked, so bodies in the look mean nothing. The world is no graph.
Frame look_at(const record::Drawn& drawn, const world::World& world, std::int64_t tick, const Look& look);

// Gives the catoms of all frames the colours of their values, which mean the same in each. Nothing is to be told if values have none.
std::optional<render::Legend> colour(std::span<Frame> frames, const Look& look);

}  // namespace meld::picture
