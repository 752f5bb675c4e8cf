// How much of their strength features give: electromagnets by their current, up to what their iron takes, with the heat of their coils;
// plates by their voltage. Of permanent magnets, and of plates at the voltage of their table, nothing is stored.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "physics/bodies/actuation.h"
#include "physics/bodies/bodies.h"
#include "physics/bodies/types.h"
#include "runtime/base/bytes.h"
#include "runtime/base/process/parallel_for.h"

namespace meld::physics {

// Whether it is an electromagnet, whose strength follows from a current.
inline bool is_coil(const Feature& feature) { return feature.current_a > 0; }
// Whether its current or voltage can be set.
inline bool is_supplied(const Feature& feature) {
    return is_coil(feature) || feature.kind == FeatureKind::Plate || feature.kind == FeatureKind::Electrode;
}
// What it is supplied with when it is switched on and nothing else is said: A or V.
inline double rated_supply(const Feature& feature) { return is_coil(feature) ? feature.current_a : feature.strength; }

// The strength of an electromagnet at a current, A: s = s_l / (1 + s_l / s_m), where s_l = strength * current / rated current is that of
// the coil without saturation and s_m the saturation (the law of Froehlich and Kennelly: R. Bozorth, "Ferromagnetism", 1951). So
// the force between two grows with the square of their current at first, and ends at that of two saturated cores.
double strength_at(const Feature& coil, double current_a);
// The share of its current that a coil gets at a temperature, K: 1 up to the limit, less by `derating_per_k` for each kelvin above it.
double current_share(const Feature& coil, double kelvin);
// How much hotter than its surroundings a coil gets in the end, K: the power I^2 R times the thermal resistance.
double final_rise_k(const Feature& coil, double current_a);

// The features of bodies that are supplied otherwise than their table says, or that are warm.
class Coils {
  public:
    struct State {
        double rise_k = 0;  // Above the surroundings.
        float level = 0;    // Current, A, or voltage, V; not negative. The body's state says whether it is on, and which way.
        float share = 1;    // Of the feature's strength, in the present step.
    };

    // Call it for each table before bodies have it.
    void add_table(std::span<const Feature> table);
    // Whether any body has such features.
    bool possible() const { return width_ > 0; }
    // By feature; empty if there is nothing to know of this body.
    std::span<const State> of(BodyId body) const {
        if (body >= entry_of_.size() || entry_of_[body] == kNone) return {};
        return std::span<const State>(states_).subspan(std::size_t{entry_of_[body]} * width_, width_);
    }
    // What a feature of the body gives of its strength now.
    double share(BodyId body, std::size_t feature) const {
        const std::span<const State> states = of(body);
        return states.empty() ? 1 : static_cast<double>(states[feature].share);
    }
    double kelvin(const Feature& feature, BodyId body, std::size_t index) const;
    // Returns whether its level has changed.
    bool supply(std::span<const Feature> table, BodyId body, std::size_t feature, double level);
    void forget(BodyId body);

    // At the start of a step: currents and voltages become shares of strengths; coils that are hotter than they may be, and have no
    // derating, are switched off. Then each coil warms by I^2 R and cools through its thermal resistance, exactly for a constant current:
    // T(t) = T_end + (T - T_end) exp(-t / tau). Energy is drawn from the supply. Returns the slots of those whose strength has changed.
    // Cost: in proportion to the bodies with warm coils or currents. `bodies` has features.
    std::vector<std::uint32_t> step(std::span<const std::vector<Feature>> tables, Bodies& bodies, double dt_s, Workers& workers);
    // Whether any coil will yet change its temperature by more than this, K, as it is switched now.
    bool warming(std::span<const std::vector<Feature>> tables, const Bodies& bodies, double by_k) const;

    // All there is to know of a body, perhaps nothing.
    void write(BodyId body, ByteWriter& out) const;
    void read(BodyId body, ByteReader& in);
    std::size_t bytes() const;

  private:
    static constexpr std::uint32_t kNone = 0xffffffff;
    std::span<State> make(BodyId body);
    // Returns whether the strength of a feature has changed.
    bool step_body(std::span<const Feature> table, std::uint32_t slot, Bodies& bodies, std::span<State> states, double dt_s) const;
    static bool is_idle(std::span<const Feature> table, std::uint32_t on, std::span<const State> states);

    std::size_t width_ = 0;  // The features of the largest table, if any of them is supplied.
    std::vector<BodyId> body_of_;
    std::vector<State> states_;  // width_ for each entry.
    std::vector<std::uint32_t> entry_of_;
};

}  // namespace meld::physics
