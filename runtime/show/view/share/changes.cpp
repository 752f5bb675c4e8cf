#include "runtime/show/view/share/changes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "runtime/show/view/scene/block.h"

namespace meld::view {

namespace {

template <class T>
void put(std::string& out, const T& value) {
    out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void put_ids(std::string& out, const std::vector<std::uint64_t>& ids) {
    for (const std::uint64_t id : ids) put(out, static_cast<std::uint32_t>(id));
    for (const std::uint64_t id : ids) put(out, static_cast<std::uint32_t>(id >> 32));
}

bool same_body(const render::RoundedBody& a, const render::RoundedBody& b) {
    return core_of(a) == core_of(b) && a.turn.coeffs() == b.turn.coeffs();
}

// Cores mostly stay as they are, and are packed well beside each other.
void put_bodies(std::string& out, const std::vector<render::RoundedBody>& bodies, const std::vector<std::size_t>& places) {
    for (const std::size_t i : places)
        for (const float number : core_of(bodies[i])) put(out, number);
    for (const std::size_t i : places)
        for (const float number : bodies[i].turn.coeffs()) put(out, number);
}

// What a catom's colour says if it has no value. While nobody has any, it is not known of what kind values will be: no word has this place.
std::uint32_t none(Changes::Colours colours) {
    return colours == Changes::Colours::Words ? 0 : std::bit_cast<std::uint32_t>(std::numeric_limits<float>::quiet_NaN());
}

std::string facts_json(const FactsOfCatoms& before, const FactsOfCatoms& now) {
    std::string out;
    const auto add = [&](std::uint64_t id, const std::string& list) {
        out += out.empty() ? "{" : ",";
        out += '"' + std::to_string(id) + "\":" + list;
    };
    for (const auto& [id, list] : now)
        if (const auto was = before.find(id); was == before.end() || was->second != list) add(id, list);
    for (const auto& [id, list] : before)
        if (!now.contains(id)) add(id, "[]");
    if (out.empty()) return out;
    out += '}';
    out.append((4 - out.size() % 4) % 4, ' ');
    return out;
}

}  // namespace

bool Changes::State::same(std::size_t i, const State& other, std::size_t j) const {
    return places[i] == other.places[j] && diameters[i] == other.diameters[j] && colours[i] == other.colours[j] &&
           (bodies.empty() || same_body(bodies[i], other.bodies[j]));
}

std::uint32_t Changes::stands_for(render::Number number, bool whole) {
    // So many differ hardly ever; of floats most are none of 24 bits, and a colour needs no more of them unless they are near each other.
    const std::size_t most = whole ? 65536 : 4096;
    const auto near = static_cast<float>(number);
    if (std::isnan(number)) return none(Colours::Numbers);
    if (near == number) return std::bit_cast<std::uint32_t>(near);
    auto found = places_of_numbers_.find(number);
    if (found == places_of_numbers_.end()) {
        if (numbers_.size() >= most) return std::bit_cast<std::uint32_t>(near);
        numbers_.push_back(number);
        found = places_of_numbers_.emplace(number, static_cast<std::uint32_t>(numbers_.size())).first;
    }
    return none(Colours::Numbers) | found->second;
}

std::vector<std::uint32_t> Changes::colours_of(const picture::Frame& frame) {
    colours_ = kind_of(frame);
    std::vector<std::uint32_t> out(frame.ids.size(), none(colours_));
    if (colours_ == Colours::Own && frame.coloured_by.empty())
        for (std::size_t i = 0; i < out.size(); ++i) {
            const render::Rgb c = frame.scene.colours[i];
            out[i] = 0xff000000U | static_cast<std::uint32_t>(c.b) << 16 | static_cast<std::uint32_t>(c.g) << 8 | c.r;
        }
    for (const auto& [at, number] : frame.numbers) out[at] = stands_for(number, frame.whole_numbers);
    for (const auto& [at, word] : frame.words) {
        const auto [found, fresh] = places_of_words_.try_emplace(word, static_cast<std::uint32_t>(words_.size() + 1));
        if (fresh) words_.push_back(word);
        out[at] = found->second;
    }
    return out;
}

std::string Changes::record(const picture::Frame& frame, FactsOfCatoms facts, bool key) {
    State now{.ids = frame.ids, .places = frame.scene.places, .bodies = frame.scene.rounded, .facts = std::move(facts)};
    const Colours colours_before = colours_;
    now.colours = colours_of(frame);
    // What said "none" before says something else now.
    key = key || colours_before != colours_;
    for (std::size_t i = 0; i < now.ids.size(); ++i) now.diameters.push_back(frame.scene.diameter(i));
    BlockEnd end = frame_end(frame);
    now.strokes = std::move(end.bytes);

    const State nothing;
    const State& before = key ? nothing : before_;
    std::vector<std::uint64_t> removed, set;
    std::vector<std::size_t> places;
    std::size_t was = 0;
    for (std::size_t i = 0; i < now.ids.size(); ++i) {
        for (; was < before.ids.size() && before.ids[was] < now.ids[i]; ++was) removed.push_back(before.ids[was]);
        const bool there = was < before.ids.size() && before.ids[was] == now.ids[i];
        if (!there || !now.same(i, before, was)) {
            set.push_back(now.ids[i]);
            places.push_back(i);
        }
        if (there) ++was;
    }
    removed.insert(removed.end(), before.ids.begin() + static_cast<std::ptrdiff_t>(was), before.ids.end());
    // A label says the place of its catom, which may be another one.
    const bool other_catoms = !removed.empty() || now.ids.size() != before.ids.size();
    const bool strokes = key || now.strokes != before.strokes || (end.labels > 0 && other_catoms);
    const std::string listed = facts_json(before.facts, now.facts);

    std::string out;
    const auto tick = static_cast<std::uint64_t>(frame.tick);
    const std::uint64_t kind = (key ? 0U : 1U) + (now.bodies.empty() ? 0U : 2U);
    for (const std::uint64_t number : {kind, tick, tick >> 32, frame.catoms, std::uint64_t{removed.size()}, std::uint64_t{set.size()},
                                       std::uint64_t{strokes ? 1U : 0U}, std::uint64_t{end.lines}, std::uint64_t{end.arrows},
                                       std::uint64_t{end.labels}, std::uint64_t{listed.size()}, std::uint64_t{end.triangles}})
        put(out, static_cast<std::uint32_t>(number));
    put_ids(out, removed);
    put_ids(out, set);
    for (const std::size_t i : places)
        for (int axis = 0; axis < 3; ++axis) put(out, now.places[i][axis]);
    for (const std::size_t i : places) put(out, now.diameters[i]);
    for (const std::size_t i : places) put(out, now.colours[i]);
    if (!now.bodies.empty()) put_bodies(out, now.bodies, places);
    if (strokes) out += now.strokes;
    out += listed;
    before_ = std::move(now);
    return out;
}

}  // namespace meld::view
