// A picture of one frame of a run, or of several side by side, seen from the same place and in the same colours.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "runtime/base/error.h"
#include "runtime/base/parallel_for.h"
#include "runtime/picture/frame.h"
#include "runtime/render/camera.h"
#include "runtime/render/image.h"
#include "runtime/render/paint.h"

namespace meld::picture {

struct SheetOptions {
    std::size_t width = 1280, height = 720;  // Of the whole picture, in pixels.
    std::size_t columns = 0;                 // 0: so that frames are as large as can be.
    render::View view = {};
    std::optional<render::Aim> aim = {};  // Otherwise so that everything fits.
    render::Quality quality = {};
    std::optional<render::Rgb> background = render::Rgb{255, 255, 255};
    std::string title = {};
    bool words = true;  // Ticks, legend and scale; the title is written in any case.
    bool scale = false;
    std::optional<double> catom_metres = {};  // Its diameter, for the scale.
};

// Gives the catoms of the frames their colours. Errors: there is not enough memory (4).
Result<render::Image> paint_sheet(std::span<Frame> frames, const Look& look, const SheetOptions& options, Workers& workers);

}  // namespace meld::picture
