// A picture of one frame of a run, or of several side by side, seen from the same place and in the same colours.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include "runtime/base/error.h"
#include "runtime/base/process/parallel_for.h"
#include "runtime/show/picture/frame.h"
#include "runtime/show/render/camera.h"
#include "runtime/show/render/caption.h"
#include "runtime/show/render/image.h"
#include "runtime/show/render/paint.h"

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

// What the callouts of all frames need.
class Callouts {
  public:
    void include(const Frame& frame);
    std::size_t most() const { return most_; }  // Of one frame.
    double widest() const { return widest_; }   // In heights of a letter; 0: there are none.
    // Errors: one names a catom that is in no frame (2).
    Result<void> check() const;

  private:
    std::size_t most_ = 0;
    double widest_ = 0;
    std::optional<std::vector<std::uint64_t>> missing_ = {};  // In all frames so far.
};

// Where frames and words are on a sheet.
class Layout {
  public:
    // Of so many frames. Errors: there is no room for them, or for their callouts; a callout names a catom that is not there.
    static Result<Layout> make(std::size_t frames, const std::optional<render::Legend>& legend, const Callouts& callouts,
                               const SheetOptions& options);

    // For what is in the frames; nothing is included yet.
    render::Camera camera(const render::View& view) const;
    // Frames with their colours, as the camera sees them, which must fit. Any thread may call it, with workers of its own. Errors: there
    // is not enough memory (4).
    Result<render::Image> paint(std::span<const Frame> frames, const render::Camera& camera, Workers& workers) const;

  private:
    // In pixels.
    struct Panels {
        std::size_t left = 0, top = 0, width = 0, height = 0;  // Of the first one.
        std::size_t columns = 1;
    };
    static Panels panels_of(std::size_t frames, const SheetOptions& options, const render::Margins& margins);

    SheetOptions options_;
    render::Caption around_, within_;
    Panels panels_;
    render::Margins margins_;  // In a panel.
};

// Gives the catoms of the frames their colours. Errors: there is not enough memory (4).
Result<render::Image> paint_sheet(std::span<Frame> frames, const Look& look, const SheetOptions& options, Workers& workers);

}  // namespace meld::picture
