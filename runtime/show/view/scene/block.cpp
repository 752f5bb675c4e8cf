#include "runtime/show/view/scene/block.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <ranges>
#include <span>

#include "runtime/show/picture/obstacles.h"

namespace meld::view {

namespace {

static_assert(std::endian::native == std::endian::little);

using nlohmann::ordered_json;

class Block {
  public:
    void reserve(std::size_t bytes) { bytes_.reserve(bytes); }
    template <class T>
    void put(const T& value) {
        bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
    void put(const render::Vec& at) {
        for (int i = 0; i < 3; ++i) put(at[i]);
    }
    void put(render::Rgb c) {
        for (const std::uint8_t part : {c.r, c.g, c.b, std::uint8_t{255}}) put(part);
    }
    void put_text(const std::string& text) {
        put(static_cast<std::uint32_t>(text.size()));
        bytes_ += text;
        bytes_.append((4 - text.size() % 4) % 4, '\0');
    }
    std::string take() { return std::move(bytes_); }

  private:
    std::string bytes_;
};

std::uint32_t low_word(std::uint64_t number) { return static_cast<std::uint32_t>(number); }
std::uint32_t high_word(std::uint64_t number) { return static_cast<std::uint32_t>(number >> 32); }

// Numbers of a page have 53 bits; those that need more are texts.
ordered_json end_of(render::Number number, bool whole) {
    const auto near = static_cast<double>(number);
    if (whole && std::abs(number) > 0x1p53L) return render::text_of(number, true);
    return near;
}

std::string css(render::Rgb c) { return fmt::format("#{:02x}{:02x}{:02x}", c.r, c.g, c.b); }

}  // namespace

Values values_of(const picture::Frame& frame) {
    Values out;
    const std::size_t count = frame.scene.places.size();
    std::map<std::string, std::uint32_t> known;
    const auto put_word = [&](std::size_t at, const std::string& word) {
        out.words.resize(count);
        const auto [found, fresh] = known.try_emplace(word, static_cast<std::uint32_t>(known.size() + 1));
        if (fresh) out.names.push_back(word);
        out.words[at] = found->second;
    };
    for (const auto& [at, number] : frame.numbers) {
        const auto near = static_cast<double>(number);
        if (static_cast<render::Number>(near) != number) {
            put_word(at, render::text_of(number, frame.whole_numbers));
            continue;
        }
        out.numbers.resize(count, std::numeric_limits<double>::quiet_NaN());
        out.numbers[at] = near;
    }
    for (const auto& [at, word] : frame.words) put_word(at, word);
    return out;
}

// Notes are at places; the page wants to know whose they are. They come in the order of catoms, mostly.
std::vector<std::uint32_t> catoms_of_notes(const render::Scene& scene) {
    std::vector<std::uint32_t> out;
    std::size_t from = 0;
    for (const render::Note& note : scene.notes) {
        std::size_t at = from;
        for (std::size_t tried = 0; tried < scene.places.size() && scene.places[at] != note.at; ++tried)
            at = at + 1 == scene.places.size() ? 0 : at + 1;
        out.push_back(static_cast<std::uint32_t>(at));
        from = at;
    }
    return out;
}

BlockEnd frame_end(const picture::Frame& frame) {
    const render::Scene& scene = frame.scene;
    std::vector<render::Triangle> triangles = picture::floor_of(scene);
    triangles.insert(triangles.end(), scene.obstacles.begin(), scene.obstacles.end());
    const auto arrows = std::ranges::count_if(scene.strokes, &render::Stroke::arrow);
    BlockEnd end{.lines = low_word(scene.strokes.size() - static_cast<std::size_t>(arrows)),
                 .arrows = static_cast<std::uint32_t>(arrows),
                 .labels = low_word(scene.notes.size()),
                 .triangles = low_word(triangles.size())};
    Block out;
    out.reserve(28 * scene.strokes.size() + 40 * scene.notes.size() + 36 * triangles.size());
    for (const bool arrow : {false, true})
        for (const render::Stroke& stroke : scene.strokes) {
            if (stroke.arrow != arrow) continue;
            out.put(stroke.from);
            out.put(stroke.to);
            out.put(stroke.colour);
        }
    const std::vector<std::uint32_t> owners = catoms_of_notes(scene);
    for (std::size_t i = 0; i < scene.notes.size(); ++i) {
        out.put(owners[i]);
        out.put_text(scene.notes[i].text);
    }
    for (const render::Triangle& triangle : triangles)
        for (const render::Vec& corner : triangle) out.put(corner);
    end.bytes = out.take();
    return end;
}

std::string frame_block(const picture::Frame& frame, std::span<const Cover> covers, const Values& values) {
    const render::Scene& scene = frame.scene;
    const bool wide = std::ranges::any_of(frame.ids, [](std::uint64_t id) { return high_word(id) != 0; });
    const BlockEnd end = frame_end(frame);
    const std::size_t catoms = scene.places.size();
    const std::uint32_t flags = (wide ? kWideIds : 0) | (covers.empty() ? 0 : kCovered) | (values.numbers.empty() ? 0 : kNumbers) |
                                (values.words.empty() ? 0 : kWords) | (scene.rounded.empty() ? 0 : kBodies);
    Block out;
    out.reserve(64 + 44 * catoms + end.bytes.size() + 32 * scene.rounded.size());
    const auto tick = static_cast<std::uint64_t>(frame.tick);
    for (const std::uint64_t number :
         {std::uint64_t{kBlockMagic}, std::uint64_t{kBlockVersion}, tick, tick >> 32, std::uint64_t{catoms}, std::uint64_t{flags},
          std::uint64_t{end.lines}, std::uint64_t{end.arrows}, std::uint64_t{end.labels}, static_cast<std::uint64_t>(scene.form),
          std::uint64_t{end.triangles}, std::uint64_t{0}, std::uint64_t{0}, std::uint64_t{0}, std::uint64_t{0}, std::uint64_t{0}})
        out.put(low_word(number));
    for (const render::Vec& place : scene.places) out.put(place);
    for (std::size_t i = 0; i < catoms; ++i) out.put(scene.diameter(i));
    for (const std::uint64_t id : frame.ids) out.put(low_word(id));
    if (wide)
        for (const std::uint64_t id : frame.ids) out.put(high_word(id));
    for (const render::Rgb colour : scene.colours) out.put(colour);
    for (const Cover& cover : covers) out.put(cover);
    for (const double number : values.numbers) out.put(number);
    for (const std::uint32_t word : values.words) out.put(word);
    std::string block = out.take();
    block += end.bytes;
    Block bodies;
    for (const render::RoundedBody& body : scene.rounded) {
        for (const float number : core_of(body)) bodies.put(number);
        bodies.put(render::Vec(body.turn.vec()));
        bodies.put(body.turn.w());
    }
    return block + bodies.take();
}

std::array<float, 4> core_of(const render::RoundedBody& body) {
    if (body.compound) return {body.rounding, 0, 0, -1 - static_cast<float>(*body.compound)};
    return {body.core.x(), body.core.y(), body.core.z(), body.rounding};
}

ordered_json compounds_json(const render::Scene& scene) {
    ordered_json out = ordered_json::array();
    for (const std::vector<render::CompoundSolid>& compound : scene.compounds) {
        ordered_json solids = ordered_json::array();
        for (const auto& [at, body] : compound) {
            ordered_json numbers = core_of(body);
            for (const float number : at) numbers.push_back(number);
            for (const float number : body.turn.coeffs()) numbers.push_back(number);
            solids.push_back(std::move(numbers));
        }
        out.push_back(std::move(solids));
    }
    return out;
}

ordered_json lamps_json(const render::Scene& scene) {
    ordered_json out = ordered_json::array();
    for (const auto& [at, radius] : scene.lamps) out.push_back({at.x(), at.y(), at.z(), radius});
    return out;
}

ordered_json legend_json(const std::optional<render::Legend>& legend) {
    if (!legend) return nullptr;
    ordered_json out{{"title", legend->title}};
    if (legend->scale) {
        ordered_json stops = ordered_json::array();
        for (const render::Rgb stop : legend->scale->map.stops()) stops.push_back(css(stop));
        const auto& [low, high, whole, map] = *legend->scale;
        out["scale"] = {{"low", end_of(low, whole)}, {"high", end_of(high, whole)}, {"whole", whole}, {"stops", std::move(stops)}};
        return out;
    }
    out["kinds"] = ordered_json::array();
    for (const auto& [name, colour] : legend->kinds) out["kinds"].push_back({name, css(colour)});
    return out;
}

ordered_json frame_words(const picture::Frame& frame, const std::optional<render::Legend>& legend) {
    constexpr float kNone = std::numeric_limits<float>::infinity();
    Eigen::Array3f low(kNone, kNone, kNone), high = -low;
    for (const render::Vec& place : frame.scene.places) {
        low = low.min(place.array());
        high = high.max(place.array());
    }
    ordered_json bounds;
    if (!frame.scene.places.empty()) bounds = {low.x(), low.y(), low.z(), high.x(), high.y(), high.z()};
    ordered_json words = {{"tick", frame.tick},
                          {"catoms", frame.catoms},
                          {"shown", frame.scene.places.size()},
                          {"legend", legend_json(legend)},
                          {"bounds", std::move(bounds)}};
    if (!frame.scene.compounds.empty()) words["compounds"] = compounds_json(frame.scene);
    if (!frame.scene.lamps.empty()) words["lamps"] = lamps_json(frame.scene);
    return words;
}

}  // namespace meld::view
