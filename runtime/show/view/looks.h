// How a page wants to see a run: what of it, and for pictures from where.
#pragma once

#include "runtime/base/error.h"
#include "runtime/show/picture/frame.h"
#include "runtime/show/picture/sheet.h"
#include "runtime/show/view/fields.h"

namespace meld::view {

// From {colour, only, hide, links, arrows, labels, map, range: [low, high], size, exposed}. Errors: what is wrong with it; bodies are read
// later.
Result<picture::Look> look_of(const Json& json);

// From {azimuth, elevation, angle, target: [x, y, z], height} and the pixels of the picture, [width, height]. Without a target all is seen;
// `flat`: from above, if nothing is said. Errors: what is wrong with it.
Result<picture::SheetOptions> sheet_of(const Json& camera, const std::vector<double>& size, bool flat);

}  // namespace meld::view
