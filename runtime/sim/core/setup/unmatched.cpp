#include "runtime/sim/core/setup/unmatched.h"

#include <cstddef>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/terminal/log.h"

namespace meld::sim {

void Unmatched::add(bool matches_here, std::function<std::string()> warning) {
    matched_.push_back(matches_here);
    warnings_.push_back(std::move(warning));
}

void Unmatched::warn() {
    if (warnings_.empty()) return;
    const std::size_t bytes = (matched_.size() + 7) / 8;
    std::vector<std::byte> bits(bytes);
    for (std::size_t i = 0; i < matched_.size(); ++i)
        if (matched_[i]) bits[i / 8] |= std::byte{1} << (i % 8);
    if (comm_.processes() > 1) {
        const std::vector<std::byte> all = comm_.allgather(bits);
        MELD_CHECK(all.size() == bytes * static_cast<std::size_t>(comm_.processes()), "{} bytes for {} things", all.size(),
                   matched_.size());
        for (std::size_t i = 0; i < all.size(); ++i) bits[i % bytes] |= all[i];
    }
    if (comm_.process() != 0) return;
    const log::FewWarnings few;
    for (std::size_t i = 0; i < warnings_.size(); ++i)
        if ((bits[i / 8] >> (i % 8) & std::byte{1}) == std::byte{0}) log::warning("{}", warnings_[i]());
}

}  // namespace meld::sim
