// Writes a digest of the state after every tick, one line `tick N DIGEST` each.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "runtime/base/files/output_file.h"
#include "runtime/results/record/state_digest.h"
#include "runtime/sim/core/extension.h"
#include "runtime/sim/core/subdomain.h"

namespace meld::record {

class DigestFile : public sim::SimModule {
  public:
    // Process 0 has the file, except in a run that goes on from a checkpoint, where load_rest() opens it to append to it. A run that
    // branches off there has a file of its own. Every check_every ticks the digest is compared with that of the whole state; 0: never.
    DigestFile(std::string path, Durability durability, std::optional<OutputFile> file, std::int64_t check_every = 0)
        : path_(std::move(path)), durability_(durability), file_(std::move(file)), check_every_(check_every) {}
    Result<void> after(sim::Subdomain& subdomain) override;
    Result<void> saveable() const override { return {}; }
    Result<void> secure(sim::Subdomain& subdomain) override;
    // Where the file is, and how long, with its last bytes.
    void save_rest(const sim::Subdomain& subdomain, ByteWriter& out) const override;
    Result<void> load_rest(sim::Subdomain& subdomain, ByteReader& in) override;
    Result<void> resumed(sim::Subdomain& subdomain) override;
    void finish(sim::Subdomain& subdomain) override;
    Result<void> ending() const override { return ending_; }

  private:
    std::string path_;
    Durability durability_;
    std::optional<OutputFile> file_;
    std::int64_t check_every_;
    RunningDigest running_;
    std::string place_;  // Of the bytes, from the first line on; empty for a stream.
    std::string last_line_;
    std::optional<std::uint64_t> resumes_at_;  // The length to which what comes after the checkpoint is cut off.
    Result<void> ending_;
};

}  // namespace meld::record
