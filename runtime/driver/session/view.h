// `meldsim view`: shows a run in a browser, or two side by side (runtime/show/view).
#pragma once

#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/driver/questions/question_commands.h"
#include "runtime/driver/run/configuration_agreement.h"
#include "runtime/driver/setup/inputs.h"
#include "runtime/driver/setup/options.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace meld::driver {

// Its command line.
void add_view(CLI::App& app, Asking& asking);
// Those of them that say how and for how long the page is served; `of`: they are of this option of another command.
void add_serving(CLI::App& command, ViewOptions& view, CLI::Option* of = nullptr);
// The options of the command, as the processes of a run get them.
std::vector<std::string> view_arguments(const ViewOptions& view);

// Serves the run, on every process, until somebody ends it. Returns the exit code. Errors: the run cannot begin; the port is taken.
Result<int> view_run(const RunOptions& options, Inputs& inputs, const std::vector<Claim>& claims, comm::Communicator& comm);

}  // namespace meld::driver
