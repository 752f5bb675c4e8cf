// How a run that is looked at begins: with its world or from a checkpoint, with modules that write nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/driver/run/configuration_agreement.h"
#include "runtime/driver/setup/inputs.h"
#include "runtime/driver/setup/options.h"
#include "runtime/results/record/drawing.h"
#include "runtime/results/timeline/timeline.h"
#include "runtime/sim/state/checkpoint_folder.h"

namespace meld::driver {

// The checkpoint at which a session begins, if it does not begin with the world; the newest before this tick, or of all. Every process
// calls it.
Result<std::unique_ptr<sim::OpenCheckpoint>> open_beginning(const RunOptions& options, const std::vector<Claim>& claims,
                                                            const world::World& world, comm::Communicator& comm,
                                                            std::optional<std::int64_t> before = {});

// The run from its first tick or from a checkpoint on. Errors: also, the checkpoint does not give back its state.
Result<std::unique_ptr<timeline::Timeline>> start_timeline(const RunOptions& options, const Inputs& inputs, timeline::Timeline::Make make,
                                                           const sim::OpenCheckpoint* from, std::size_t history_bytes);

// What follows the drawing of catoms in each of the simulations that a timeline makes.
class Drawings {
  public:
    void note(const sim::Simulation& simulation, record::Drawing& drawing) { of_[&simulation] = &drawing; }
    // Of the present run of a timeline, while it has made no other that it still needs.
    record::Drawing& of(timeline::Timeline& timeline);

  private:
    std::map<const sim::Simulation*, record::Drawing*> of_;
};

// Makes the simulations of a timeline. With `drawings`, what catoms draw is followed: from where the run began, or from where it was
// recorded; begin_drawing() is for the others. All of it outlives the timeline. Errors: the recording whose run it is cannot be read.
Result<timeline::Timeline::Make> make_simulations(const RunOptions& options, Inputs& inputs, comm::Communicator& comm, Drawings* drawings);

// From here on what catoms draw is followed in a run whose checkpoint knows nothing of it: the timeline begins anew, with what is returned.
// Otherwise `make` is returned. Every process calls it.
Result<timeline::Timeline::Make> begin_drawing(const RunOptions& options, const Inputs& inputs, comm::Communicator& comm,
                                               timeline::Timeline& timeline, timeline::Timeline::Make make, Drawings& drawings);

}  // namespace meld::driver
