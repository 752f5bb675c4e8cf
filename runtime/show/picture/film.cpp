#include "runtime/show/picture/film.h"

#include <algorithm>
#include <utility>

namespace meld::picture {

Film::Film(const Look& look, const SheetOptions& sheet, CameraPath path)
    : sheet_(sheet),
      path_(std::move(path)),
      palette_(look),
      outline_(path_.moves() ? render::Outline::from_all_sides()
                             : render::Outline(path_.at(0, 0, 1), static_cast<float>(sheet.width) / static_cast<float>(sheet.height))) {}

void Film::measure(const Frame& frame) {
    palette_.include(frame);
    callouts_.include(frame);
    outline_.include(frame.scene);
    if (frame.scene.ground) ground_ = std::min(ground_.value_or(*frame.scene.ground), *frame.scene.ground);
}

Result<void> Film::settle() {
    Result<Layout> layout = Layout::make(1, palette_.settle(), callouts_, sheet_);
    if (!layout) return tl::unexpected<Error>(layout.error());
    layout_ = std::move(*layout);
    seen_ = outline_.scene();
    return {};
}

void Film::colour(Frame& frame) const {
    palette_.apply(frame);
    frame.scene.ground = ground_;
}

Result<render::Image> Film::paint(const Frame& frame, std::size_t number, std::size_t count, Workers& workers) const {
    render::Camera camera = layout_->camera(path_.at(frame.tick, number, count));
    camera.include(seen_);
    camera.fit();
    return layout_->paint({&frame, 1}, camera, workers);
}

}  // namespace meld::picture
