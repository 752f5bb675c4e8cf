// What the options of a picture say: bodies, sizes, ticks, where the camera is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/driver/setup/options.h"
#include "runtime/show/picture/camera_path.h"
#include "runtime/show/picture/frame.h"
#include "runtime/show/picture/sheet.h"
#include "runtime/world/description/world.h"

namespace meld::driver {

// Stands for the end of a run, or where its checkpoint is.
inline constexpr std::int64_t kEnd = -1;

// The last tick that is asked for, or kEnd. Errors: what is wrong with the options and can be known before anything is run.
Result<std::int64_t> last_tick_of(const PictureOptions& options);

// The errors of these functions are those of last_tick_of().
Result<picture::Look> look_of(const PictureOptions& options);
// From above where all is in a plane; otherwise from the side.
Result<picture::SheetOptions> sheet_of(const PictureOptions& options, const world::World& world);
// The ticks of a picture; where it is not said otherwise, the end.
Result<std::vector<std::int64_t>> ticks_of(const std::vector<std::string>& texts);
// The order in which they come, the run going forward only: nothing is looked at twice.
std::vector<std::size_t> order_of(const std::vector<std::int64_t>& ticks, bool at_checkpoint);

// What the options of a film say.
struct MovieOrders {
    std::optional<std::int64_t> from = {}, to = {};  // kEnd: the end.
    std::vector<picture::CameraPath::Key> keys = {};
};
Result<MovieOrders> movie_of(const MovieOptions& options);

}  // namespace meld::driver
