// Groups of options that several commands of meldsim have.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "runtime/cli/command_line.h"
#include "runtime/driver/setup/options.h"

namespace meld::driver {

template <class Ticks>
void add_ticks(CLI::App& command, Ticks& ticks, const std::string& text) {
    command.add_option("--ticks", ticks, text)->check(cli::whole_number(0, std::numeric_limits<std::int64_t>::max() - 1))->type_name("INT");
}

// Numbers that are optional are those of another run, if they are not given.
template <class Number>
void add_processes(CLI::App& command, Number& processes, Number& threads) {
    CLI::Option* const n = command.add_option("-n,--processes", processes, "Number of processes, started through mpirun");
    n->check(cli::whole_number(1, 100000))->type_name("INT");
    CLI::Option* const t = command.add_option("--threads", threads, "Worker threads in each process");
    t->check(cli::whole_number(1, 1024))->type_name("INT");
    if constexpr (std::is_same_v<Number, int>)
        for (CLI::Option* option : {n, t}) option->capture_default_str();
}

// When a run is started again. The texts begin as its command says.
template <class Number, class Text>
void add_supervision(CLI::App& command, Number& retries, Text& heartbeat, const std::string& how = "How", const std::string& a = "A") {
    CLI::Option* const r =
        command.add_option("--retries", retries, how + " often to go on from the checkpoint when a process is killed, crashes or hangs");
    r->check(cli::whole_number(0, 1000000))->type_name("INT");
    CLI::Option* const h =
        command.add_option("--heartbeat", heartbeat, a + " run without a sign of life for so long hangs; off: it may take any time");
    h->type_name("TIME");
    if constexpr (std::is_same_v<Number, int>)
        for (CLI::Option* option : {r, h}) option->capture_default_str();
}

// Options that may be given several times, with one value each.
CLI::Option* add_list(CLI::App& command, const std::string& name, std::vector<std::string>& values, const char* type, const char* text);
// What is run besides the program; `world`: what the option says of the world.
void add_inputs(CLI::App& command, RunOptions& run, const char* world);
// The program, and all that it is run with.
CLI::Option* add_program(CLI::App& command, RunOptions& run);
// The files that a run writes, and what it says.
void add_outputs(CLI::App& command, RunOptions& run);

}  // namespace meld::driver
