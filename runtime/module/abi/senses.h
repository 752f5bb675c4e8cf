// The predicates that are read from the ensemble and stored nowhere, and those that store what catoms sense of their bodies, as described
// by the table senses.def.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace meld {

enum class WorldSource {
#define MELD_SENSE(source, word, arguments, wakes, facts, values, traits) source,
#include "runtime/module/abi/senses.def"
};

// The table's entry for a sense; senses.def explains each column.
struct SenseInfo {
    enum class Facts { One, Several, Links };
    enum class Values { Any, Port, PortCount };
    enum Trait : unsigned { kCells = 1, kCentre = 2, kAmoebots = 4 };

    WorldSource source = WorldSource::None;
    std::string_view word;
    std::size_t arguments = 0;
    std::uint64_t wakes = 0;
    Facts facts = Facts::One;
    Values values = Values::Any;
    unsigned traits = 0;

    bool has(Trait trait) const { return (traits & trait) != 0; }
};
const SenseInfo& info(WorldSource source);

struct SenseName {
    std::string_view word;
    std::size_t arguments = 0;
    WorldSource source = WorldSource::None;
};
// All names that programs may use, including other names for the same sense.
std::span<const SenseName> sense_names();
// None: the ensemble has no such sense.
WorldSource world_source(std::string_view word, std::size_t arguments);

// Whether only amoebots have a sense of this name.
bool is_amoebot_sense(std::string_view word);

// Whether it says which catoms touch, so that a rule may use it as a link to a neighbour.
inline bool is_link(WorldSource source) { return info(source).facts == SenseInfo::Facts::Links; }

// ---- what catoms sense of their bodies

enum class BodyQuantity {
    Obstacle,
    Contact,
    Connected,
    Load,
    Broke,
    Joint,
    Orientation,
    Velocity,
    Acceleration,
    Gyro,
    Accelerometer,
    Range,
    Light,
    Temperature,
    Pressure,
    Energy
};

struct BodySense {
    enum class Change { Touch, Distance, Angle, Share };

    BodyQuantity quantity = BodyQuantity::Obstacle;
    std::string_view word;
    std::size_t arguments = 0;
    Change change = Change::Touch;
};
std::span<const BodySense> body_senses();
// Whether one of them has this name.
bool is_body_sense(std::string_view word);

// ---- what nodes sense of neighbours within their range

enum class RangeQuantity {
#define MELD_RANGE_SENSE(quantity, word, arguments) quantity,
#include "runtime/module/abi/senses.def"
};

struct RangeSense {
    RangeQuantity quantity = RangeQuantity::Distance;
    std::string_view word;
    std::size_t arguments = 0;
};
std::span<const RangeSense> range_senses();
bool is_range_sense(std::string_view word);

// ---- what catoms sense where the world names their moves

struct MoveSense {
    std::string_view word;
    std::size_t arguments = 0;
};
std::span<const MoveSense> move_senses();
bool is_move_sense(std::string_view word);

}  // namespace meld
