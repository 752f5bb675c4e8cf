// The world as a page edits it: what its text would be as a world, and the file that it is written to.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "runtime/base/error.h"
#include "runtime/driver/setup/inputs.h"
#include "runtime/driver/setup/options.h"
#include "runtime/show/view/viewer.h"

namespace meld::driver {

class WorldTab {
  public:
    using Json = nlohmann::ordered_json;
    // All of it outlives this. `evaluation`: how many seconds one takes in the run that is shown, if that is known.
    WorldTab(const RunOptions& options, const Inputs& inputs, std::function<std::optional<double>()> evaluation)
        : options_(options), inputs_(inputs), evaluation_(std::move(evaluation)) {}

    // {path, toml, writable} and what check() says. Errors: the file cannot be read.
    Result<view::Reply> file() const;
    // {valid: true, lattice, catoms, exact, first, last, target, components, memory, seconds} or {valid: false, error}, with the line and
    // the column of the mistake. Of a world on a lattice that is not too large, also its catoms as a frame. The run
    // knows nothing of it. Cost: some milliseconds, and some 10 ns a catom near the surface.
    Result<view::Reply> check(const std::string& toml) const;
    // Writes the file that --world has named, and no other. Errors: there is none, or it is another; the text is no world; those of files.
    Result<view::Reply> save(const std::string& path, const std::string& toml) const;

  private:
    const RunOptions& options_;
    const Inputs& inputs_;
    std::function<std::optional<double>()> evaluation_;
};

}  // namespace meld::driver
