// What is known of submissions already: a file for each answer, by a hash of everything that it depends on.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "runtime/base/error.h"

namespace meld::driver {

class GradeStore {
  public:
    // Makes the folder. Errors: it cannot be written.
    static Result<GradeStore> open(const std::string& folder);

    std::optional<nlohmann::ordered_json> find(std::uint64_t key) const;
    // Errors: the disk is full.
    Result<void> keep(std::uint64_t key, const nlohmann::ordered_json& answer) const;
    // Where a page with this key is, or is to be.
    std::string page(std::uint64_t key) const;

  private:
    explicit GradeStore(std::string folder) : folder_(std::move(folder)) {}
    std::string path(std::uint64_t key) const;
    std::string folder_;
};

}  // namespace meld::driver
