// Worlds of a study: files as they are, or with parameters put in.
#pragma once

#include <toml++/toml.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/driver/study/study_file.h"

namespace meld::driver {

// What a parameter has in one run.
using Chosen = std::vector<std::pair<const StudyAxis*, const StudyValue*>>;

// A world as a file, and a hash of its text and of the files that it names.
struct ComposedWorld {
    std::string path;  // Empty: the default world.
    std::uint64_t hash = 0;
};

class WorldTemplate {
  public:
    // Of a path, which may be empty for the default world. Errors: it cannot be read as TOML.
    static Result<WorldTemplate> read(const std::string& path);
    // Of a table of the study, whose files begin in this folder.
    WorldTemplate(const toml::table& keys, std::string folder);

    // Whether a string of the world has {NAME} in it.
    bool mentions(const std::string& name) const;
    // The world with these parameters: values of {NAME} in its strings, and of its keys. Made beside `folder`, unless it is a file that
    // stays as it is. Errors name the parameter.
    Result<ComposedWorld> compose(const Chosen& chosen, const std::string& folder) const;

  private:
    WorldTemplate() = default;
    std::string path_;
    std::string folder_;  // Where names of files begin: empty, or with a slash at its end.
    toml::table keys_;
    bool has_keys_ = false;
};

// The keys of a world with each file that they name from the root, so that the world can be written anywhere. Errors: it cannot be read.
Result<toml::table> world_keys_of(const std::string& path);

// Whether the name, or its first part, is that of a section or key of worlds.
bool names_world_key(const std::string& name);
// These keys, for messages.
const std::vector<std::string_view>& world_keys();

}  // namespace meld::driver
