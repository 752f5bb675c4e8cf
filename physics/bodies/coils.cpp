// Currents, voltages and heat of features, body by body.
#include "physics/bodies/coils.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "runtime/base/assert.h"

namespace meld::physics {

namespace {

constexpr std::size_t kEntriesPerJob = 1024;
// A coil that is off and nearer to its surroundings than this is as cold as they are.
constexpr double kCold_k = 1e-6;

bool is_on(std::uint32_t on, std::size_t feature) { return (on >> feature & 1) != 0; }

double current_of(const Feature& coil, const Coils::State& state) {
    return static_cast<double>(state.level) * current_share(coil, coil.ambient_k + state.rise_k);
}

bool is_too_hot(const Feature& coil, const Coils::State& state) {
    return coil.hottest_k > 0 && coil.derating_per_k == 0 && coil.ambient_k + state.rise_k > coil.hottest_k;
}

// Of the strength in its table, which is above 0.
double share_of(const Feature& feature, const Coils::State& state) {
    if (!(feature.strength > 0)) return 0;
    if (!is_coil(feature)) return static_cast<double>(state.level) / feature.strength;
    return strength_at(feature, current_of(feature, state)) / feature.strength;
}

}  // namespace

double strength_at(const Feature& coil, double current_a) {
    const double linear = coil.strength * current_a / coil.current_a;
    return coil.saturation > 0 ? linear / (1 + linear / coil.saturation) : linear;
}

double current_share(const Feature& coil, double kelvin) {
    if (!(coil.hottest_k > 0) || !(kelvin > coil.hottest_k)) return 1;
    return std::max(0.0, 1 - coil.derating_per_k * (kelvin - coil.hottest_k));
}

double final_rise_k(const Feature& coil, double current_a) {
    return current_a * current_a * coil.resistance_ohm * coil.thermal_resistance_k_w;
}

void Coils::add_table(std::span<const Feature> table) {
    if (table.size() <= width_ || std::ranges::none_of(table, is_supplied)) return;
    std::vector<State> wider(body_of_.size() * table.size());
    for (std::size_t entry = 0; entry < body_of_.size(); ++entry)
        std::copy_n(states_.begin() + static_cast<std::ptrdiff_t>(entry * width_), width_,
                    wider.begin() + static_cast<std::ptrdiff_t>(entry * table.size()));
    states_ = std::move(wider), width_ = table.size();
}

double Coils::kelvin(const Feature& feature, BodyId body, std::size_t index) const {
    const std::span<const State> states = of(body);
    return feature.ambient_k + (states.empty() ? 0 : states[index].rise_k);
}

std::span<Coils::State> Coils::make(BodyId body) {
    if (body >= entry_of_.size()) entry_of_.resize(body + std::size_t{1}, kNone);
    if (entry_of_[body] == kNone) {
        entry_of_[body] = static_cast<std::uint32_t>(body_of_.size());
        body_of_.push_back(body);
        states_.resize(body_of_.size() * width_);
    }
    return std::span<State>(states_).subspan(std::size_t{entry_of_[body]} * width_, width_);
}

bool Coils::supply(std::span<const Feature> table, BodyId body, std::size_t feature, double level) {
    MELD_EXPECT(feature < table.size() && is_supplied(table[feature]) && level >= 0, "{} of feature {}", level, feature);
    const bool is_new = of(body).empty();
    if (is_new && !is_coil(table[feature]) && level == table[feature].strength) return false;
    const std::span<State> states = make(body);
    if (is_new)
        for (std::size_t i = 0; i < table.size(); ++i) states[i] = {0, static_cast<float>(rated_supply(table[i])), 1};
    const auto now = static_cast<float>(level);
    return std::exchange(states[feature].level, now) != now || is_new;
}

void Coils::forget(BodyId body) {
    if (of(body).empty()) return;
    const std::uint32_t entry = std::exchange(entry_of_[body], kNone), last = static_cast<std::uint32_t>(body_of_.size() - 1);
    if (entry != last) {
        std::copy_n(states_.begin() + static_cast<std::ptrdiff_t>(last * width_), width_,
                    states_.begin() + static_cast<std::ptrdiff_t>(entry * width_));
        body_of_[entry] = body_of_[last];
        entry_of_[body_of_[entry]] = entry;
    }
    body_of_.pop_back();
    states_.resize(body_of_.size() * width_);
}

// Nothing to remember: what is on has the level of its table, and nothing is warm.
bool Coils::is_idle(std::span<const Feature> table, std::uint32_t on, std::span<const State> states) {
    for (std::size_t i = 0; i < table.size(); ++i) {
        if (!is_supplied(table[i])) continue;
        if (states[i].rise_k > kCold_k) return false;
        if (is_on(on, i) && (is_coil(table[i]) || static_cast<double>(states[i].level) != table[i].strength)) return false;
    }
    return true;
}

bool Coils::step_body(std::span<const Feature> table, std::uint32_t slot, Bodies& bodies, std::span<State> states, double dt_s) const {
    Bodies::FeatureState& body = bodies.features[slot];
    bool changed = false;
    for (std::size_t i = 0; i < table.size(); ++i) {
        const Feature& feature = table[i];
        State& state = states[i];
        if (!is_supplied(feature)) continue;
        if (is_on(body.on, i) && is_too_hot(feature, state)) body.on &= ~(std::uint32_t{1} << i), changed = true;
        const bool on = is_on(body.on, i);
        if (on) {
            const auto share = static_cast<float>(share_of(feature, state));
            changed = changed || share != state.share;
            state.share = share;
        }
        if (!is_coil(feature)) continue;
        const double current = on ? current_of(feature, state) : 0;
        if (on) bodies.energy[slot] += current * current * feature.resistance_ohm * dt_s;
        if (feature.thermal_resistance_k_w == 0) continue;
        const double end = final_rise_k(feature, current);
        state.rise_k = end + (state.rise_k - end) * std::exp(-dt_s / feature.cooling_s);
    }
    return changed;
}

std::vector<std::uint32_t> Coils::step(std::span<const std::vector<Feature>> tables, Bodies& bodies, double dt_s, Workers& workers) {
    if (body_of_.empty()) return {};
    MELD_EXPECT(bodies.features.size() == bodies.count() && dt_s > 0, "{} bodies, {} s", bodies.count(), dt_s);
    std::vector<std::uint8_t> changed(body_of_.size()), over(body_of_.size());
    workers.run((body_of_.size() + kEntriesPerJob - 1) / kEntriesPerJob, [&](int, std::size_t job) {
        for (std::size_t entry = job * kEntriesPerJob; entry < std::min(body_of_.size(), (job + 1) * kEntriesPerJob); ++entry) {
            over[entry] = !bodies.has(body_of_[entry]);
            if (over[entry]) continue;
            const std::uint32_t slot = bodies.slot(body_of_[entry]);
            const std::vector<Feature>& table = tables[bodies.features[slot].table];
            const std::span<State> states = std::span<State>(states_).subspan(entry * width_, width_);
            changed[entry] = step_body(table, slot, bodies, states, dt_s);
            over[entry] = is_idle(table, bodies.features[slot].on, states);
        }
    });
    std::vector<std::uint32_t> woken;
    // Backwards, since the last one takes the place of one that ends.
    for (std::size_t entry = body_of_.size(); entry-- > 0;) {
        if (changed[entry]) woken.push_back(bodies.slot(body_of_[entry]));
        if (over[entry]) forget(body_of_[entry]);
    }
    return woken;
}

bool Coils::warming(std::span<const std::vector<Feature>> tables, const Bodies& bodies, double by_k) const {
    for (std::size_t entry = 0; entry < body_of_.size(); ++entry) {
        if (!bodies.has(body_of_[entry])) continue;
        const Bodies::FeatureState& body = bodies.features[bodies.slot(body_of_[entry])];
        const std::vector<Feature>& table = tables[body.table];
        for (std::size_t i = 0; i < table.size(); ++i) {
            if (!is_coil(table[i]) || table[i].thermal_resistance_k_w == 0) continue;
            const State& state = states_[entry * width_ + i];
            const double end = is_on(body.on, i) ? final_rise_k(table[i], current_of(table[i], state)) : 0;
            if (std::abs(end - state.rise_k) > by_k) return true;
        }
    }
    return false;
}

void Coils::write(BodyId body, ByteWriter& out) const {
    const std::span<const State> states = of(body);
    out.write(!states.empty());
    for (const State& state : states) out.write(state);
}

void Coils::read(BodyId body, ByteReader& in) {
    forget(body);
    if (!in.read<bool>()) return;
    for (State& state : make(body)) state = in.read<State>();
}

std::size_t Coils::bytes() const {
    return body_of_.capacity() * sizeof(BodyId) + states_.capacity() * sizeof(State) + entry_of_.capacity() * sizeof(std::uint32_t);
}

}  // namespace meld::physics
