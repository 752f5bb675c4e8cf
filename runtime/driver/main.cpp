// meldsim: run Meld programs on ensembles of catoms.
#include "runtime/driver/meldsim.h"

#include "runtime/base/files/standard_streams.h"
#include "runtime/base/process/deep_stack.h"

int main(int argc, char** argv) {
    meld::prepare_standard_streams();
    meld::end_when_memory_runs_out("meldsim");
    return meld::end_standard_output("meldsim", meld::ending_when_memory_runs_out([&] { return meld::driver::run_meldsim(argc, argv); }));
}
