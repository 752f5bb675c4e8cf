#include "runtime/module/abi/senses.h"

#include <algorithm>
#include <array>
#include <iterator>

#include "runtime/base/assert.h"
#include "runtime/module/abi/storage_abi.h"

namespace meld {

namespace {

using Facts = SenseInfo::Facts;
using Values = SenseInfo::Values;
constexpr unsigned kCells = SenseInfo::kCells, kCentre = SenseInfo::kCentre, kAmoebots = SenseInfo::kAmoebots;

constexpr SenseInfo kSenses[] = {
#define MELD_SENSE(source, word, arguments, wakes, facts, values, traits) \
    {WorldSource::source, word, arguments, wakes, Facts::facts, Values::values, traits},
#include "runtime/module/abi/senses.def"
};

constexpr std::size_t arguments_of(WorldSource source) { return kSenses[static_cast<std::size_t>(source)].arguments; }

constexpr SenseName kAllNames[] = {
#define MELD_SENSE(source, word, arguments, wakes, facts, values, traits) {word, arguments, WorldSource::source},
#define MELD_SENSE_ALIAS(source, word) {word, arguments_of(WorldSource::source), WorldSource::source},
#include "runtime/module/abi/senses.def"
};

// Those that have a word.
constexpr auto kNames = [] {
    constexpr auto written = [](const SenseName& name) { return !name.word.empty(); };
    std::array<SenseName, std::ranges::count_if(kAllNames, written)> names;
    std::ranges::copy_if(kAllNames, names.begin(), written);
    return names;
}();

constexpr BodySense kBodySenses[] = {
#define MELD_BODY_SENSE(quantity, word, arguments, change) {BodyQuantity::quantity, word, arguments, BodySense::Change::change},
#include "runtime/module/abi/senses.def"
};

constexpr RangeSense kRangeSenses[] = {
#define MELD_RANGE_SENSE(quantity, word, arguments) {RangeQuantity::quantity, word, arguments},
#include "runtime/module/abi/senses.def"
};

constexpr MoveSense kMoveSenses[] = {
#define MELD_MOVE_SENSE(word, arguments) {word, arguments},
#include "runtime/module/abi/senses.def"
};

}  // namespace

const SenseInfo& info(WorldSource source) {
    const auto index = static_cast<std::size_t>(source);
    MELD_EXPECT(index < std::size(kSenses), "sense {}", index);
    return kSenses[index];
}

std::span<const SenseName> sense_names() { return kNames; }

WorldSource world_source(std::string_view word, std::size_t arguments) {
    const auto found =
        std::ranges::find_if(kNames, [&](const SenseName& name) { return name.word == word && name.arguments == arguments; });
    return found == kNames.end() ? WorldSource::None : found->source;
}

bool is_amoebot_sense(std::string_view word) {
    return std::ranges::any_of(kNames,
                               [&](const SenseName& name) { return name.word == word && info(name.source).has(SenseInfo::kAmoebots); });
}

std::span<const BodySense> body_senses() { return kBodySenses; }

bool is_body_sense(std::string_view word) {
    return std::ranges::any_of(kBodySenses, [&](const BodySense& sense) { return sense.word == word; });
}

std::span<const RangeSense> range_senses() { return kRangeSenses; }

bool is_range_sense(std::string_view word) {
    return std::ranges::any_of(kRangeSenses, [&](const RangeSense& sense) { return sense.word == word; });
}

std::span<const MoveSense> move_senses() { return kMoveSenses; }

bool is_move_sense(std::string_view word) {
    return std::ranges::any_of(kMoveSenses, [&](const MoveSense& sense) { return sense.word == word; });
}

}  // namespace meld
