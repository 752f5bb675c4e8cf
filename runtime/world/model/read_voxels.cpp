// MagicaVoxel files: chunks with a name, the length of their content, and that of the chunks inside them. A scene is a graph of transforms
// (nTRN), groups (nGRP) and shapes (nSHP), which place models (SIZE and XYZI); older files have models only.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "runtime/world/model/read_model.h"

namespace meld::model {
namespace {

using Int3 = std::array<std::int64_t, 3>;

constexpr std::uint64_t kMaxVoxels = 20'000'000;
// Far more than a scene of people has; a damaged one may be a circle.
constexpr std::size_t kMaxSceneDepth = 200, kMaxPlacements = 1'000'000;
constexpr std::int64_t kMaxCoordinate = 1 << 20;

class Bytes {
  public:
    explicit Bytes(std::string_view rest) : rest_(rest) {}
    bool whole() const { return whole_; }
    bool empty() const { return rest_.empty(); }

    std::string_view take(std::size_t count) {
        if (count > rest_.size()) {
            whole_ = false;
            count = rest_.size();
        }
        const std::string_view taken = rest_.substr(0, count);
        rest_.remove_prefix(count);
        return taken;
    }

    std::int32_t number() {
        std::array<unsigned char, 4> raw{};
        const std::string_view taken = take(4);
        std::memcpy(raw.data(), taken.data(), taken.size());
        return static_cast<std::int32_t>(std::uint32_t{raw[0]} | std::uint32_t{raw[1]} << 8 | std::uint32_t{raw[2]} << 16 |
                                         std::uint32_t{raw[3]} << 24);
    }

    // A length; a negative one is not whole.
    std::size_t length() {
        const std::int32_t value = number();
        if (value < 0) whole_ = false;
        return value < 0 ? 0 : static_cast<std::size_t>(value);
    }

    std::map<std::string, std::string> dictionary() {
        std::map<std::string, std::string> out;
        const std::size_t count = length();
        for (std::size_t i = 0; i < count && whole_; ++i) {
            const std::string key(take(length()));
            out[key] = std::string(take(length()));
        }
        return out;
    }

  private:
    std::string_view rest_;
    bool whole_ = true;
};

struct Model {
    Int3 size{};
    std::vector<std::array<std::uint8_t, 3>> voxels;
};

// Row i of the turned axes is sign[i] times axis[i].
struct Turn {
    std::array<std::size_t, 3> axis{0, 1, 2};
    std::array<std::int64_t, 3> sign{1, 1, 1};
};

struct Place {
    Turn turn;
    Int3 by{};
};

struct SceneNode {
    Place place;
    std::vector<std::int32_t> children, models;
    bool hidden = false;
};

// Doubled coordinates, so that the centres of voxels are whole.
Int3 turned(const Turn& turn, const Int3& p) {
    Int3 out;
    for (std::size_t i = 0; i < 3; ++i) out[i] = turn.sign[i] * p[turn.axis[i]];
    return out;
}

Place inside(const Place& outer, const Place& inner) {
    Place both;
    for (std::size_t i = 0; i < 3; ++i) {
        both.turn.axis[i] = inner.turn.axis[outer.turn.axis[i]];
        both.turn.sign[i] = outer.turn.sign[i] * inner.turn.sign[outer.turn.axis[i]];
    }
    both.by = turned(outer.turn, inner.by);
    for (std::size_t i = 0; i < 3; ++i) both.by[i] += outer.by[i];
    return both;
}

std::optional<std::int64_t> integer(std::string_view text) {
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || value < -kMaxCoordinate || value > kMaxCoordinate) return std::nullopt;
    return value;
}

class VoxelFile {
  public:
    explicit VoxelFile(const std::string& path) : path_(path) {}

    Result<void> read(std::string_view bytes) {
        Bytes file(bytes);
        if (file.take(4) != "VOX ") return damaged("it does not begin as one");
        file.number();
        if (auto done = read_chunks(file); !done) return done;
        if (models_.empty()) return damaged("there is no model in it");
        return {};
    }

    // The voxels of the scene, each once, packed; or of the first model if there is no scene.
    Result<std::vector<std::uint64_t>> voxels() {
        if (nodes_.empty()) {
            // Without a scene, corner voxel (0, 0, 0) is at the origin: what place_model() moves back by.
            Place alone;
            for (std::size_t i = 0; i < 3; ++i) alone.by[i] = models_[0].size[i] / 2;
            if (auto done = place_model(models_[0], alone); !done) return tl::unexpected(done.error());
        } else if (auto done = place_scene(); !done) {
            return tl::unexpected(done.error());
        }
        std::sort(found_.begin(), found_.end());
        found_.erase(std::unique(found_.begin(), found_.end()), found_.end());
        return std::move(found_);
    }

  private:
    tl::unexpected<Error> damaged(std::string_view why) const {
        return fail(fmt::format("{} is not a MagicaVoxel file: {}", path_, why), "save it again");
    }

    Result<void> read_chunks(Bytes& file) {
        while (!file.empty()) {
            const std::string_view name = file.take(4);
            const std::size_t content_bytes = file.length(), children_bytes = file.length();
            Bytes content(file.take(content_bytes));
            // The chunks in MAIN are all there are; they follow it.
            if (!file.whole() || (name != "MAIN" && (static_cast<void>(file.take(children_bytes)), !file.whole())))
                return damaged("it ends too early");
            if (auto done = read_chunk(name, content); !done) return done;
            if (!content.whole()) return damaged(fmt::format("its chunk {} ends too early", name));
        }
        return {};
    }

    Result<void> read_chunk(std::string_view name, Bytes& in) {
        if (name == "SIZE") {
            Model& model = models_.emplace_back();
            for (std::int64_t& side : model.size) side = in.number();
        } else if (name == "XYZI") {
            if (models_.empty() || !models_.back().voxels.empty()) return damaged("it has voxels without a size");
            const std::size_t count = in.length();
            const std::string_view raw = in.take(4 * count);
            for (std::size_t i = 0; i + 3 < raw.size(); i += 4)
                models_.back().voxels.push_back(
                    {static_cast<std::uint8_t>(raw[i]), static_cast<std::uint8_t>(raw[i + 1]), static_cast<std::uint8_t>(raw[i + 2])});
        } else if (name == "nTRN") {
            return read_transform(in);
        } else if (name == "nGRP") {
            SceneNode& node = nodes_[in.number()];
            node.hidden = in.dictionary()["_hidden"] == "1";
            const std::size_t count = in.length();
            for (std::size_t i = 0; i < count && in.whole(); ++i) node.children.push_back(in.number());
        } else if (name == "nSHP") {
            SceneNode& node = nodes_[in.number()];
            node.hidden = in.dictionary()["_hidden"] == "1";
            // Further models are later frames of an animation.
            if (in.length() > 0) node.models.push_back(in.number());
        }
        return {};
    }

    Result<void> read_transform(Bytes& in) {
        SceneNode& node = nodes_[in.number()];
        node.hidden = in.dictionary()["_hidden"] == "1";
        node.children.push_back(in.number());
        in.number();
        in.number();
        if (in.length() == 0) return {};
        const std::map<std::string, std::string> frame = in.dictionary();
        if (const auto at = frame.find("_r"); at != frame.end()) {
            const auto bits = integer(at->second);
            const std::size_t first = bits ? static_cast<std::size_t>(*bits & 3) : 3,
                              second = bits ? static_cast<std::size_t>(*bits >> 2 & 3) : 3;
            if (first > 2 || second > 2 || first == second) return damaged(fmt::format("'{}' is not a rotation", at->second));
            node.place.turn.axis = {first, second, 3 - first - second};
            for (std::size_t i = 0; i < 3; ++i) node.place.turn.sign[i] = *bits >> (4 + i) & 1 ? -1 : 1;
        }
        if (const auto at = frame.find("_t"); at != frame.end()) {
            std::string_view rest = at->second;
            for (std::size_t i = 0; i < 3; ++i) {
                const std::size_t end = std::min(rest.find(' '), rest.size());
                const auto value = integer(rest.substr(0, end));
                if (!value) return damaged(fmt::format("'{}' is not a translation", at->second));
                node.place.by[i] = *value;
                rest.remove_prefix(std::min(end + 1, rest.size()));
            }
        }
        return {};
    }

    Result<void> place_scene() {
        struct Step {
            std::int32_t node;
            Place place;
            std::size_t depth;
        };
        // The scene's root is its first transform, number 0.
        std::vector<Step> left = {{nodes_.begin()->first, {}, 0}};
        for (std::size_t steps = 0; !left.empty(); ++steps) {
            const Step step = left.back();
            left.pop_back();
            const auto at = nodes_.find(step.node);
            if (at == nodes_.end() || step.depth > kMaxSceneDepth || steps > kMaxPlacements) return damaged("its scene is not a tree");
            if (at->second.hidden) continue;
            const Place place = inside(step.place, at->second.place);
            for (const std::int32_t child : at->second.children) left.push_back({child, place, step.depth + 1});
            for (const std::int32_t model : at->second.models) {
                if (model < 0 || static_cast<std::size_t>(model) >= models_.size())
                    return damaged(fmt::format("there is no model {} in it", model));
                if (auto done = place_model(models_[static_cast<std::size_t>(model)], place); !done) return done;
            }
        }
        return {};
    }

    // A model turns about the corner of its middle voxel.
    Result<void> place_model(const Model& model, const Place& place) {
        if (found_.size() + model.voxels.size() > kMaxVoxels)
            return fail(fmt::format("{} has more than {} million voxels", path_, kMaxVoxels / 1'000'000), "make its scene smaller");
        for (const auto& voxel : model.voxels) {
            Int3 doubled;
            for (std::size_t i = 0; i < 3; ++i) doubled[i] = 2 * (voxel[i] - model.size[i] / 2) + 1;
            doubled = turned(place.turn, doubled);
            std::uint64_t key = 0;
            for (std::size_t i = 0; i < 3; ++i) {
                const std::int64_t at = (doubled[i] - 1) / 2 + place.by[i];
                if (at < -kMaxCoordinate + 1 || at >= kMaxCoordinate - 1)
                    return damaged(fmt::format("a voxel is {} away from the origin", at));
                key = key << 21 | static_cast<std::uint64_t>(at + kMaxCoordinate);
            }
            found_.push_back(key);
        }
        return {};
    }

    const std::string& path_;
    std::vector<Model> models_;
    std::map<std::int32_t, SceneNode> nodes_;
    std::vector<std::uint64_t> found_;
};

// The two triangles of a voxel's face, counter-clockwise as seen from outside.
void add_face(const Int3& voxel, std::size_t axis, int side, Triangles& out) {
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    const auto first = static_cast<std::uint32_t>(out.points.size());
    for (const auto& [du, dv] : {std::pair(-0.5, -0.5), std::pair(0.5, -0.5), std::pair(0.5, 0.5), std::pair(-0.5, 0.5)}) {
        Vec3 point;
        point[axis] = static_cast<double>(voxel[axis]) + 0.5 * side;
        point[u] = static_cast<double>(voxel[u]) + du;
        point[v] = static_cast<double>(voxel[v]) + dv;
        out.points.push_back(point);
    }
    const std::uint32_t second = side > 0 ? 1 : 2, third = side > 0 ? 2 : 1;
    out.corners.push_back({first, first + second, first + third});
    out.corners.push_back({first, first + (side > 0 ? 2 : 3), first + (side > 0 ? 3 : 2)});
}

}  // namespace

Result<Triangles> read_voxels(std::string_view bytes, const std::string& path) {
    VoxelFile file(path);
    if (auto done = file.read(bytes); !done) return tl::unexpected(done.error());
    const Result<std::vector<std::uint64_t>> voxels = file.voxels();
    if (!voxels) return tl::unexpected(voxels.error());
    Triangles out;
    for (const std::uint64_t key : *voxels) {
        Int3 voxel;
        for (std::size_t i = 0; i < 3; ++i) voxel[i] = static_cast<std::int64_t>(key >> (42 - 21 * i) & 0x1fffff) - kMaxCoordinate;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            for (const int side : {-1, 1}) {
                const std::uint64_t step = std::uint64_t{1} << (42 - 21 * axis);
                if (std::binary_search(voxels->begin(), voxels->end(), side > 0 ? key + step : key - step)) continue;
                add_face(voxel, axis, side, out);
            }
        }
        if (out.corners.size() > kMaxTriangles)
            return fail(fmt::format("{} has more than {} million faces", path, kMaxTriangles / 2'000'000), "make its scene smaller");
    }
    weld(out);
    return out;
}

}  // namespace meld::model
