#include "runtime/driver/run/run_configuration.h"

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <utility>

#include "runtime/base/files/input_file.h"
#include "runtime/base/hash.h"
#include "runtime/base/version.h"

namespace meld::driver {

namespace {

// The maximum number of bytes read to compare a program or an extension.
constexpr std::uint64_t kMostCompared_bytes = std::uint64_t{1} << 30;

// A hash of the content. A source that cannot be read again here, such as a pipe, is compared by name; the module contains what was read
// from it.
std::uint64_t hash_of_file(const std::string& path) {
    const Result<std::string> text = read_input(path, kMostCompared_bytes);
    return hash_text(text ? *text : path);
}

Claim claim(std::string name, std::string value) {
    const std::uint64_t hash = hash_text(value);
    return {.name = std::move(name), .shown = std::move(value), .hash = hash};
}

Claim option(std::string name, std::string value) {
    Claim out = claim(std::move(name), std::move(value));
    out.what_it_is = false;
    return out;
}

Claim files(std::string name, const std::vector<std::string>& paths) {
    Claim all{.name = std::move(name), .shown = fmt::format("{}", fmt::join(paths, ", "))};
    for (const std::string& path : paths) all.hash = hash_combine(all.hash, hash_of_file(path));
    return all;
}

// A body that is watched for is compared as it is written, a file by what is in it.
Claim watched(std::string name, const std::vector<std::string>& bodies) {
    Claim out = files(std::move(name), bodies);
    out.what_it_is = false;
    return out;
}

// With the option that it was given by.
std::string body_of(const RunOptions& options) {
    if (!options.question) return "";
    return (options.question->asks == Question::Asks::Until ? "--until " : "--while ") + options.question->body;
}

}  // namespace

std::vector<Claim> claims(const RunOptions& options, const Module& module, const world::World& world) {
    std::vector<std::string> parameters;
    for (const auto& [name, value] : world.set) parameters.push_back(name + "=" + value);
    Claim compiled{.name = "the module", .shown = module.path(), .hash = module.note().checksum, .code = ExitCode::ModuleRefused};
    std::vector<Claim> all = {claim("the version of Claymeld", std::string(kVersion)),
                              files("the program", {options.program}),
                              std::move(compiled),
                              {.name = "the world", .shown = world.path, .hash = world.source_hash},
                              claim("the parameters", fmt::format("{}", fmt::join(parameters, ", "))),
                              claim("the seed", std::to_string(world.seed)),
                              claim(kPortsClaim, std::string(world.ports_name())),
                              files("--extension", options.extensions),
                              option("--ticks", options.ticks < 0 ? "" : std::to_string(options.ticks)),
                              // Who has a time limit asks the others whether it has passed.
                              option("--timeout", options.timeout_seconds > 0 ? fmt::format("{}", options.timeout_seconds) : ""),
                              option("the body", body_of(options)),
                              option("--stats", options.stats ? "given" : ""),
                              option("--checkpoint", options.checkpoint),
                              option("--checkpoint-every", options.checkpoint_every),
                              option("--checkpoint-changes", options.checkpoint_changes ? "given" : "")};
    // Generators compute with real numbers, and another machine may do it otherwise.
    if (world.is_graph()) all.push_back({.name = "the graph", .shown = world.path, .hash = world.graph->hash()});
    for (const BodiesOption& watch : kWatches) all.push_back(watched(watch.name, options.*watch.bodies));
    for (const OutputOption& output : kOutputs) {
        // A replay records into a folder of its own.
        const bool own = output.path == &RunOptions::record && !options.replay.empty();
        all.push_back(option(output.name, own ? "" : options.*output.path));
    }
    return all;
}

}  // namespace meld::driver
