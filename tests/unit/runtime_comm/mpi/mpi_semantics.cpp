// One process of the MPI tests: runs every semantic case in both kinds of exchange. Started by mpirun, once for each number
// of processes; process 0 prints, and the exit code says whether all went well. With "fail N", process N leaves by an exception and the
// others must be ended, not hang; with "abort N" it calls abort(42).
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <string_view>

#include "runtime/comm/transport/mpi_options.h"
#include "tests/unit/runtime_comm/semantics.h"

namespace {

using namespace meld::comm;

int run_cases(ExchangeKind kind, const char* name) {
    const auto communicator = make_mpi(MpiOptions{.exchange = kind, .chunk_bytes = 65'536});
    for (const semantics::Case& test : semantics::all_cases()) {
        test.run(*communicator);
        communicator->barrier();
        if (communicator->process() == 0) std::printf("%s.%s: ok\n", name, test.name.c_str());
    }
    return 0;
}

int run_unhappy(std::string_view what, int failing_process) {
    const auto communicator = make_mpi();
    if (communicator->process() == failing_process && what == "abort") communicator->abort(42);
    if (communicator->process() == failing_process) throw std::runtime_error("failed on purpose");
    communicator->exchange({});
    return 0;
}

}  // namespace

int main(int argc, char** argv) try {
    if (!under_mpi()) {
        std::fprintf(stderr, "start me with mpirun\n");
        return 2;
    }
    const auto outlive_all = make_mpi();
    if (argc == 3) return run_unhappy(argv[1], std::atoi(argv[2]));
    run_cases(ExchangeKind::Consensus, "Consensus");
    run_cases(ExchangeKind::Counts, "Counts");
    return run_cases(ExchangeKind::Automatic, "Automatic");
} catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
