// A hash of everything that a file in the module cache depends on.
#pragma once

#include <fmt/format.h>
#include <xxhash.h>

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace meld {

class ContentHash {
  public:
    ContentHash() : state_(XXH3_createState(), &XXH3_freeState) { XXH3_128bits_reset(state_.get()); }

    // The length goes first, so that moving a byte from one text to the next changes the hash.
    void add(std::string_view text) {
        add(text.size());
        XXH3_128bits_update(state_.get(), text.data(), text.size());
    }
    void add(std::uint64_t number) { XXH3_128bits_update(state_.get(), &number, sizeof number); }

    std::string digest() const {
        const XXH128_hash_t hash = XXH3_128bits_digest(state_.get());
        return fmt::format("{:016x}{:016x}", hash.high64, hash.low64);
    }

  private:
    std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> state_;
};

}  // namespace meld
