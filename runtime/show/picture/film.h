// A film of a run: one frame after the other in the same colours, in a view that all of them fit into. Frames are seen twice, first
// measured and then painted, and none is kept.
#pragma once

#include <optional>

#include "runtime/base/error.h"
#include "runtime/base/process/parallel_for.h"
#include "runtime/show/picture/camera_path.h"
#include "runtime/show/picture/frame.h"
#include "runtime/show/picture/palette.h"
#include "runtime/show/picture/sheet.h"
#include "runtime/show/render/outline.h"

namespace meld::picture {

class Film {
  public:
    // `look` must outlive it.
    Film(const Look& look, const SheetOptions& sheet, CameraPath path);

    // First every frame is measured: its values, and how far it reaches. Memory: see Palette.
    void measure(const Frame& frame);
    // Then what all have in common is known. Errors: those of Layout::make().
    Result<void> settle();
    // Then frames that were measured get their colours, and one floor for all of them,
    void colour(Frame& frame) const;
    // and are painted, as the frame of this number of so many. Any thread may call it, with workers of its own. Errors: there is not
    // enough memory (4).
    Result<render::Image> paint(const Frame& frame, std::size_t number, std::size_t count, Workers& workers) const;
    bool camera_moves() const { return path_.moves(); }

  private:
    SheetOptions sheet_;
    CameraPath path_;
    Palette palette_;
    Callouts callouts_;
    render::Outline outline_;
    std::optional<Layout> layout_;
    render::Scene seen_;  // In place of all frames.
    std::optional<float> ground_ = {};
};

}  // namespace meld::picture
