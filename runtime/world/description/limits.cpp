// The limits of a run: what stands in [limits] or --limit, and otherwise what follows from memory.
#include "runtime/world/description/limits.h"

#include <algorithm>
#include <charconv>
#include <limits>

#include <fmt/format.h>

#include "runtime/base/units.h"

namespace meld::world {

namespace {

// Facts of one predicate at one catom may take this share of the memory, if each takes so much while it is derived.
constexpr std::uint64_t kShare = 8, kFact_bytes = 64;
constexpr std::uint64_t kLeastFacts = 100'000, kMaxFacts = std::uint64_t{1} << 31;
// Where rules may make ever more.
constexpr std::uint64_t kGrowingFacts = 10'000, kGrowingDerivations = 100'000;
// A second of work or so: linear rules may go on for ever, whatever they compute.
constexpr std::uint64_t kFirings = 20'000'000;

}  // namespace

FactLimits fact_limits(const Limits& limits, std::uint64_t memory_bytes) {
    if (const auto most = limits.max_facts_per_catom) return {*most, *most};
    return {std::clamp(memory_bytes / kShare / kFact_bytes, kLeastFacts, kMaxFacts), kGrowingFacts};
}

DerivationLimits derivation_limits(const Limits& limits) {
    if (const auto most = limits.max_derivations_per_tick) return {*most, *most, *most};
    return {kFirings, std::numeric_limits<std::uint64_t>::max(), kGrowingDerivations};
}

Result<void> set_limit(World& world, const std::string& setting) {
    const std::size_t equals = setting.find('=');
    const std::string name = setting.substr(0, equals), value = equals == std::string::npos ? "" : setting.substr(equals + 1);
    const auto wrong = [&](const std::string& why) {
        return fail(fmt::format("--limit {}: {}", setting, why),
                    "Write --limit facts=N, derivations=N, ticks=N, list=N or memory=SIZE, such as --limit facts=50000");
    };
    Limits& limits = world.limits;
    if (name == "memory") {
        const Result<std::uint64_t> bytes = parse_bytes(value);
        if (!bytes) return wrong(bytes.error().problem);
        limits.memory_bytes = *bytes;
        return {};
    }
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
    const bool known = name == "facts" || name == "derivations" || name == "ticks" || name == "list";
    if (!known) return wrong(fmt::format("there is no limit `{}`", name));
    const std::uint64_t most =
        name == "list" ? std::numeric_limits<std::uint32_t>::max() : static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
    if (error != std::errc() || end != value.data() + value.size() || number == 0 || number > most)
        return wrong(fmt::format("`{}` is no number from 1 to {}", value, most));
    if (name == "facts") limits.max_facts_per_catom = number;
    if (name == "derivations") limits.max_derivations_per_tick = number;
    if (name == "ticks") limits.max_ticks = number;
    if (name == "list") limits.max_list = number;
    return {};
}

}  // namespace meld::world
