// `meldsim shot`: a picture of a run at one tick or at several.
#pragma once

#include <span>

#include "runtime/base/error.h"
#include "runtime/base/files/output_file.h"
#include "runtime/driver/pictures/frame_observer.h"
#include "runtime/driver/setup/options.h"
#include "runtime/results/record/drawing.h"
#include "runtime/show/picture/frame.h"
#include "runtime/show/picture/sheet.h"
#include "runtime/sim/core/subdomain.h"
#include "runtime/world/description/world.h"

namespace meld::driver {

// Goes to each tick and takes the picture. Every process calls it.
Result<int> take_shot(const RunOptions& options, const world::World& world, Onlooker& onlooker);

// Paints the frames, writes the picture and prints what it is.
Result<void> finish_shot(const RunOptions& options, std::span<picture::Frame> frames, const picture::Look& look,
                         const picture::SheetOptions& sheet, OutputFile& file);

// Takes a picture of a run that has been started and has no program.
Result<void> shoot_start(const PictureOptions& picture, const world::World& world, sim::Subdomain& subdomain, record::Drawing& drawing);

}  // namespace meld::driver
