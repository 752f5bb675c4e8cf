// The world as a page edits it: what its text would be as a world, and the file that it is written to.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "runtime/base/error.h"
#include "runtime/driver/inputs.h"
#include "runtime/driver/options.h"

namespace meld::driver {

class WorldTab {
  public:
    using Json = nlohmann::ordered_json;
    // All of it outlives this. `summary` tells how fast the run is that is shown.
    WorldTab(const RunOptions& options, const Inputs& inputs, std::function<const sim::Summary&()> summary)
        : options_(options), inputs_(inputs), summary_(std::move(summary)) {}

    // {path, toml, writable} and what check() says. Errors: the file cannot be read.
    Result<Json> file() const;
    // {valid: true, lattice, catoms, exact, first, last, target, components, memory, seconds} or {valid: false, error}, with the line and
    // the column of the mistake. The run knows nothing of it. Cost: some milliseconds, and some 10 ns a catom near the surface.
    Result<Json> check(const std::string& toml) const;
    // Writes the file that --world has named, and no other. Errors: there is none, or it is another; the text is no world; those of files.
    Result<Json> save(const std::string& path, const std::string& toml) const;

  private:
    const RunOptions& options_;
    const Inputs& inputs_;
    std::function<const sim::Summary&()> summary_;
};

}  // namespace meld::driver
