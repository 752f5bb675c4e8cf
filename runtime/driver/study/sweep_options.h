// Of `meldsim sweep`.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "runtime/driver/setup/options.h"

namespace meld::driver {

struct SweepOptions {
    std::string study;
    std::string folder = {};  // Of results; empty: beside the study, STUDY.results.
    int jobs = 0;             // Runs at a time; 0: as there are processors.
    bool again = false;       // Rows that have failed are made again.
    bool as_is = false;       // Nothing is run.
    bool table = false;
    std::vector<std::string> plots = {};  // "Y~X"
    std::string image = {};               // Of the last plot.
    std::string memory = {};              // What the runs may take together, as "16GiB"; empty: what is free.
    std::string show = {};                // A row.
    bool print = false;                   // The command of that row is printed, and nothing is shown.
    ViewOptions view = {};                // How it is shown.
    std::string shrink = {};              // A row.
    std::uint64_t tries = 2000;           // Runs that shrinking may take.
    std::string still = {};               // A body that must hold at the end of these.
    int slurm = 0;                        // Tasks of a job array whose script is written; 0: none.
    bool quiet = false;
};

}  // namespace meld::driver
