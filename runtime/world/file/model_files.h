// The models that a world names: each file is read once, whatever names it.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "runtime/world/shapes/expression.h"

namespace meld::world {

class TomlReader;

class WorldModels : public ModelFiles {
  public:
    explicit WorldModels(TomlReader& reader) : reader_(reader) {}
    // `name` is relative to the folder of the world. Errors: those of read_input and of read_model. Cost: some microseconds a triangle.
    Result<std::shared_ptr<const model::Solid>> open(std::string_view name) override;
    // What is wrong with models that are used nevertheless.
    const std::vector<std::string>& warnings() const { return warnings_; }

  private:
    TomlReader& reader_;
    std::map<std::string, std::shared_ptr<const model::Solid>> known_;  // By path.
    std::vector<std::string> warnings_;
};

}  // namespace meld::world
