// What is written and drawn over a picture: title, legend, scale, words. The only use of Cairo.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "runtime/show/render/camera.h"
#include "runtime/show/render/colours.h"
#include "runtime/show/render/number.h"
#include "runtime/show/render/paint.h"

namespace meld::render {

// What colours mean.
struct Legend {
    std::string title = {};
    // Of numbers, from the least to the greatest.
    struct Scale {
        Number low = 0, high = 0;
        bool whole = true;  // They are whole numbers.
        ColourMap map;
    };
    std::optional<Scale> scale = {};
    std::vector<std::pair<std::string, Rgb>> kinds = {};
};

struct Caption {
    std::string title = {};                   // Above the picture.
    std::string line = {};                    // Below it, such as the tick.
    std::optional<Legend> legend = {};        // At its right.
    std::optional<double> catom_metres = {};  // The diameter of a catom, for a scale in metres; otherwise it is in catoms.
    bool scale = false;
    double callouts = 0;  // The width of the widest, in heights of a letter; 0: there are none.
    Rgb ink = {51, 51, 51};
};

// The room that this needs around a picture of so many pixels.
Margins margins(const Caption& caption, std::size_t width, std::size_t height);

// How wide a text is at most, in heights of a letter of any size.
double letters_wide(const std::string& text);
// How many callouts there is room for beside a picture of so many pixels.
std::size_t room_for_callouts(std::size_t width, std::size_t height);

// Also the notes of the scene, where what they are at is seen; and its callouts, for which there must be room.
void write_over(Painted& picture, const Scene& scene, const Camera& camera, const Caption& caption);

}  // namespace meld::render
