// Writes a digest of the state after every tick, one line `tick N DIGEST` each.
#pragma once

#include <optional>

#include "runtime/base/output_file.h"
#include "runtime/sim/core/extension.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::record {

class DigestFile : public sim::SimModule {
  public:
    // Process 0 has the file.
    explicit DigestFile(std::optional<OutputFile> file) : file_(std::move(file)) {}
    Result<void> after(sim::Subdomain& part) override;
    void finish(sim::Subdomain& part) override;
    Result<void> ending() const override { return ending_; }

  private:
    std::optional<OutputFile> file_;
    Result<void> ending_;
};

}  // namespace meld::record
