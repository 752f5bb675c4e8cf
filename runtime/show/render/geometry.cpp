#include "runtime/show/render/geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "runtime/base/assert.h"
#include "runtime/show/library/embree_calls.h"
#include "runtime/show/render/cells.h"
#include "runtime/show/render/rounded.h"

namespace meld::render {

namespace {

// Of geometries in an Embree scene.
constexpr unsigned kCatoms = 0, kStrokes = 1, kObstacles = 2, kLamps = 3;

// Beyond this share of half a cube its faces bend towards its edges, so that cubes that touch can be told apart.
constexpr float kEdge = 0.86F;

// From so many balls on, those that no ray is likely to meet are left out.
constexpr std::size_t kMany = 50'000;
// Layers of balls that are drawn as they are. Fewer rays than one in a thousand get through so many.
constexpr int kLayers = 3;

// Faces of all cubes that are not against another one, four corners each.
struct Faces {
    std::vector<Vec> corners;
    std::vector<std::uint32_t> cubes;  // The cube of each.
};

Faces faces_of(const Scene& scene) {
    const std::optional<Cells> cells = scene.diameters.empty() ? Cells::of(scene, kAxes) : std::nullopt;
    Faces out;
    for (std::size_t i = 0; i < scene.places.size(); ++i)
        for (int axis = 0; axis < 3; ++axis)
            for (const int side : {0, 1}) {
                const auto way = static_cast<std::size_t>(2 * axis + side);
                if (cells && cells->has_next(i, way)) continue;
                const Vec& out_of = kAxes[way];
                const Vec u = Vec::Unit((axis + 1) % 3), v = Vec::Unit((axis + 2) % 3);
                for (const auto& [a, b] : {std::pair(-1, -1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, 1)})
                    out.corners.push_back(scene.places[i] +
                                          scene.diameter(i) / 2 * (out_of + static_cast<float>(a) * u + static_cast<float>(b) * v));
                out.cubes.push_back(static_cast<std::uint32_t>(i));
            }
    return out;
}

// The balls that rays can meet, and how large they are drawn.
struct Balls {
    std::vector<std::uint32_t> catoms;
    std::vector<float> radii;
};

// For each catom how many others are in front of it: of those that touch all around, if there are many; otherwise 0.
std::vector<std::uint8_t> depths_of(const Scene& scene, std::span<const Vec> ways) {
    const bool touch =
        (scene.form == Form::Sphere || scene.form == Form::Rounded) && scene.diameters.empty() && scene.places.size() >= kMany;
    const std::optional<Cells> cells = touch ? Cells::of(scene, ways) : std::nullopt;
    return cells ? cells->depths(kLayers + 1) : std::vector<std::uint8_t>(scene.places.size());
}

// Of many catoms on a lattice only those near the surface; behind them, balls so large that no ray gets through between them.
Balls balls_of(const Scene& scene) {
    Balls out;
    const std::vector<std::uint8_t> depths = depths_of(scene, scene.ways);
    // The gap in the middle of a cube of balls, or of six of them that touch, is no further away.
    const float tight = scene.ways.size() > 6 ? 0.7072F : 0.8661F;
    for (std::size_t i = 0; i < scene.places.size(); ++i) {
        if (depths[i] > kLayers) continue;
        out.catoms.push_back(static_cast<std::uint32_t>(i));
        out.radii.push_back(depths[i] == kLayers ? tight : scene.diameter(i) / 2);
    }
    return out;
}

// Cubes with round edges, and behind those near the surface some with sharp ones, between which no ray gets through.
struct RoundedCubes {
    std::vector<RoundedCube> cubes;
    std::vector<std::uint32_t> catoms;
};

RoundedCubes rounded_of(const Scene& scene) {
    RoundedCubes out;
    const std::vector<std::uint8_t> depths = depths_of(scene, kAxes);
    for (std::size_t i = 0; i < scene.places.size(); ++i) {
        if (depths[i] > kLayers) continue;
        const float diameter = scene.diameter(i);
        out.cubes.push_back({scene.places[i], diameter / 2, depths[i] == kLayers ? 0 : kRound * diameter});
        out.catoms.push_back(static_cast<std::uint32_t>(i));
    }
    return out;
}

template <class Solid>
void bounds_of(const RTCBoundsFunctionArguments* asked) {
    const Solid& solid = static_cast<const Solid*>(asked->geometryUserPtr)[asked->primID];
    RTCBounds& out = *asked->bounds_o;
    const Vec low = solid.middle - solid.reach(), high = solid.middle + solid.reach();
    std::tie(out.lower_x, out.lower_y, out.lower_z) = std::tuple(low.x(), low.y(), low.z());
    std::tie(out.upper_x, out.upper_y, out.upper_z) = std::tuple(high.x(), high.y(), high.z());
}

// Calls `meets(i, t)` for each of the rays that meets a rounded solid after t, nearer than anything before.
template <class Solid, class Meets>
void each_meeting(const int* valid, const Solid& cube, RTCRayN* rays, unsigned count, const Meets& meets) {
    for (unsigned i = 0; i < count; ++i) {
        if (valid[i] != -1) continue;
        const Vec from(RTCRayN_org_x(rays, count, i), RTCRayN_org_y(rays, count, i), RTCRayN_org_z(rays, count, i));
        const Vec along(RTCRayN_dir_x(rays, count, i), RTCRayN_dir_y(rays, count, i), RTCRayN_dir_z(rays, count, i));
        if (const auto t = cube.enters(from, along, RTCRayN_tfar(rays, count, i))) meets(i, from, along, *t);
    }
}

template <class Solid>
void meet_rounded(const RTCIntersectFunctionNArguments* asked) {
    const Solid& cube = static_cast<const Solid*>(asked->geometryUserPtr)[asked->primID];
    const unsigned count = asked->N;
    RTCRayN* const rays = RTCRayHitN_RayN(asked->rayhit, count);
    RTCHitN* const hits = RTCRayHitN_HitN(asked->rayhit, count);
    each_meeting(asked->valid, cube, rays, count, [&](unsigned i, const Vec& from, const Vec& along, float t) {
        const Vec normal = cube.normal(from + t * along);
        RTCRayN_tfar(rays, count, i) = t;
        RTCHitN_Ng_x(hits, count, i) = normal.x();
        RTCHitN_Ng_y(hits, count, i) = normal.y();
        RTCHitN_Ng_z(hits, count, i) = normal.z();
        RTCHitN_primID(hits, count, i) = asked->primID;
        RTCHitN_geomID(hits, count, i) = asked->geomID;
        RTCHitN_instID(hits, count, i, 0) = RTC_INVALID_GEOMETRY_ID;
    });
}

template <class Solid>
void hide_behind_rounded(const RTCOccludedFunctionNArguments* asked) {
    const Solid& cube = static_cast<const Solid*>(asked->geometryUserPtr)[asked->primID];
    each_meeting(asked->valid, cube, asked->ray, asked->N, [&](unsigned i, const Vec&, const Vec&, float) {
        RTCRayN_tfar(asked->ray, asked->N, i) = -std::numeric_limits<float>::infinity();
    });
}

// The two halves of each hexagon, with corners between its neighbours.
Faces hexagons_of(const Scene& scene) {
    std::array<Vec, 6> corner;
    for (int i = 0; i < 6; ++i) {
        const float angle = static_cast<float>(2 * i + 1) * std::numbers::pi_v<float> / 6;
        corner[static_cast<std::size_t>(i)] = Vec(std::cos(angle), std::sin(angle), 0) / std::sqrt(3.0F);
    }
    Faces out;
    for (std::size_t i = 0; i < scene.places.size(); ++i)
        for (const auto& half : {std::array{0, 1, 2, 3}, std::array{3, 4, 5, 0}}) {
            for (const int c : half) out.corners.push_back(scene.places[i] + scene.diameter(i) * corner[static_cast<std::size_t>(c)]);
            out.cubes.push_back(static_cast<std::uint32_t>(i));
        }
    return out;
}

// The normal of a cube's face bent towards the nearest edges.
Vec bent(const Vec& normal, const Vec& from_middle, float half) {
    Vec out = normal;
    for (int axis = 0; axis < 3; ++axis) {
        const float part = from_middle[axis] / half;
        if (std::abs(normal[axis]) < 0.5F && std::abs(part) > kEdge)
            out[axis] += std::copysign((std::abs(part) - kEdge) / (1 - kEdge), part);
    }
    return out.normalized();
}

constexpr std::size_t kTogether = 16;  // Rays that Embree follows at a time.

void set_out(std::span<const Geometry::Ray> rays, float within, RTCRay16& out, std::array<int, kTogether>& valid) {
    for (std::size_t i = 0; i < kTogether; ++i) {
        valid[i] = i < rays.size() ? -1 : 0;
        const Geometry::Ray& ray = rays[std::min(i, rays.size() - 1)];
        out.org_x[i] = ray.from.x();
        out.org_y[i] = ray.from.y();
        out.org_z[i] = ray.from.z();
        out.tnear[i] = 0;
        out.dir_x[i] = ray.along.x();
        out.dir_y[i] = ray.along.y();
        out.dir_z[i] = ray.along.z();
        out.time[i] = 0;
        out.tfar[i] = within;
        out.mask[i] = ~0U;
        out.id[i] = 0;
        out.flags[i] = 0;
    }
}

}  // namespace

struct Geometry::Parts {
    explicit Parts(const Scene& of) : scene(of) {}
    ~Parts() {
        if (rays != nullptr) rtcReleaseScene(rays);
        if (device != nullptr) rtcReleaseDevice(device);
    }
    Parts(const Parts&) = delete;
    Parts& operator=(const Parts&) = delete;

    // Room for the corners of a geometry; nothing if there is no memory.
    template <class Item>
    Item* room(RTCGeometry geometry, RTCBufferType type, RTCFormat format, std::size_t count) {
        return static_cast<Item*>(rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(Item), count));
    }
    bool add(RTCGeometry geometry, unsigned number) {
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(rays, geometry, number);
        rtcReleaseGeometry(geometry);
        return rtcGetDeviceError(device) == RTC_ERROR_NONE;
    }
    bool add_points() {
        const bool discs = scene.form == Form::Disc;
        RTCGeometry points = rtcNewGeometry(device, discs ? RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT : RTC_GEOMETRY_TYPE_SPHERE_POINT);
        Balls seen = balls_of(scene);
        const std::size_t count = seen.catoms.size();
        auto* const balls = room<std::array<float, 4>>(points, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, count);
        auto* const normals = discs ? room<std::array<float, 3>>(points, RTC_BUFFER_TYPE_NORMAL, RTC_FORMAT_FLOAT3, count) : nullptr;
        const bool enough = balls != nullptr && (!discs || normals != nullptr);
        for (std::size_t i = 0; enough && i < count; ++i) {
            const Vec& at = scene.places[seen.catoms[i]];
            balls[i] = {at.x(), at.y(), at.z(), seen.radii[i]};
            if (discs) normals[i] = {0, 0, 1};
        }
        if (count < scene.places.size()) owners = std::move(seen.catoms);
        return add(points, kCatoms) && enough;
    }
    bool add_rounded() {
        RoundedCubes seen = rounded_of(scene);
        cubes = std::move(seen.cubes);
        owners = std::move(seen.catoms);
        return add_solids(cubes);
    }
    bool add_bodies() {
        for (std::size_t i = 0; i < scene.places.size(); ++i)
            scene.each_solid(i, [&](const Vec& middle, const RoundedBody& body) {
                boxes.push_back(RoundedBox::of(body, middle));
                if (!scene.compounds.empty()) owners.push_back(static_cast<std::uint32_t>(i));
            });
        return add_solids(boxes);
    }
    template <class Solid>
    bool add_solids(std::vector<Solid>& solids) {
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(solids.size()));
        rtcSetGeometryUserData(geometry, solids.data());
        rtcSetGeometryBoundsFunction(geometry, bounds_of<Solid>, nullptr);
        rtcSetGeometryIntersectFunction(geometry, meet_rounded<Solid>);
        rtcSetGeometryOccludedFunction(geometry, hide_behind_rounded<Solid>);
        return add(geometry, kCatoms);
    }
    bool add_faces(Faces faces) {
        RTCGeometry quads = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_QUAD);
        const std::size_t count = faces.corners.size();
        auto* const corners = room<std::array<float, 3>>(quads, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, count);
        auto* const indices = room<std::array<std::uint32_t, 4>>(quads, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT4, count / 4);
        const bool enough = corners != nullptr && indices != nullptr;
        for (std::size_t i = 0; enough && i < count; ++i) {
            corners[i] = {faces.corners[i].x(), faces.corners[i].y(), faces.corners[i].z()};
            indices[i / 4][i % 4] = static_cast<std::uint32_t>(i);
        }
        owners = std::move(faces.cubes);
        return add(quads, kCatoms) && enough;
    }
    // A stroke is one tube; an arrow is a tube and a cone.
    bool add_strokes() {
        std::vector<std::array<float, 4>> ends;
        const auto tube = [&](const Vec& from, float thick, const Vec& to, float thin, std::size_t stroke) {
            ends.push_back({from.x(), from.y(), from.z(), thick});
            ends.push_back({to.x(), to.y(), to.z(), thin});
            tube_owners.push_back(static_cast<std::uint32_t>(stroke));
        };
        for (std::size_t i = 0; i < scene.strokes.size(); ++i) {
            const Stroke& s = scene.strokes[i];
            const float length = (s.to - s.from).norm();
            const float head = s.arrow ? std::min(0.5F * length, 6 * s.radius) : 0;
            const Vec neck = length > 0 ? Vec(s.to - (s.to - s.from) * (head / length)) : s.to;
            tube(s.from, s.radius, neck, s.radius, i);
            if (head > 0) tube(neck, 2.5F * s.radius, s.to, 0.02F * s.radius, i);
        }
        if (ends.empty()) return true;
        RTCGeometry curves = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE);
        auto* const points = room<std::array<float, 4>>(curves, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, ends.size());
        auto* const starts = room<std::uint32_t>(curves, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT, ends.size() / 2);
        const bool enough = points != nullptr && starts != nullptr;
        if (enough) std::ranges::copy(ends, points);
        for (std::size_t i = 0; enough && i < ends.size() / 2; ++i) starts[i] = static_cast<std::uint32_t>(2 * i);
        return add(curves, kStrokes) && enough;
    }
    bool add_obstacles() {
        const std::size_t count = scene.obstacles.size();
        if (count == 0) return true;
        RTCGeometry triangles = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* const corners = room<std::array<float, 3>>(triangles, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, 3 * count);
        auto* const indices = room<std::array<std::uint32_t, 3>>(triangles, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, count);
        const bool enough = corners != nullptr && indices != nullptr;
        for (std::size_t i = 0; enough && i < 3 * count; ++i) {
            const Vec& at = scene.obstacles[i / 3][i % 3];
            corners[i] = {at.x(), at.y(), at.z()};
            indices[i / 3][i % 3] = static_cast<std::uint32_t>(i);
        }
        return add(triangles, kObstacles) && enough;
    }
    bool add_lamps() {
        const std::size_t count = scene.lamps.size();
        if (count == 0) return true;
        RTCGeometry points = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
        auto* const balls = room<std::array<float, 4>>(points, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, count);
        for (std::size_t i = 0; balls != nullptr && i < count; ++i) {
            const auto& [at, radius] = scene.lamps[i];
            balls[i] = {at.x(), at.y(), at.z(), radius};
        }
        return add(points, kLamps) && balls != nullptr;
    }
    bool fill() {
        rays = rtcNewScene(device);
        if (rays == nullptr) return false;
        const bool many = scene.places.size() > 4'000'000;
        rtcSetSceneFlags(rays, many ? RTC_SCENE_FLAG_COMPACT : RTC_SCENE_FLAG_NONE);
        if (many) rtcSetSceneBuildQuality(rays, RTC_BUILD_QUALITY_LOW);
        const bool catoms = scene.places.empty()          ? true
                            : !scene.rounded.empty()      ? add_bodies()
                            : scene.form == Form::Cube    ? add_faces(faces_of(scene))
                            : scene.form == Form::Hexagon ? add_faces(hexagons_of(scene))
                            : scene.form == Form::Rounded ? add_rounded()
                                                          : add_points();
        if (!catoms || !add_strokes() || !add_obstacles() || !add_lamps()) return false;
        rtcCommitScene(rays);
        return rtcGetDeviceError(device) == RTC_ERROR_NONE;
    }

    const Scene& scene;
    RTCDevice device = nullptr;
    RTCScene rays = nullptr;
    std::vector<std::uint32_t> owners;  // The catoms of faces, balls and cubes; empty: each has the number of its own.
    std::vector<RoundedCube> cubes;
    std::vector<RoundedBox> boxes;  // Of bodies.
    std::vector<std::uint32_t> tube_owners;
};

Geometry::Geometry(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
Geometry::Geometry(Geometry&&) noexcept = default;
Geometry::~Geometry() = default;

Result<Geometry> Geometry::build(const Scene& scene, int threads) {
    MELD_EXPECT(scene.colours.size() == scene.places.size(), "{} colours for {} catoms", scene.colours.size(), scene.places.size());
    auto parts = std::make_unique<Parts>(scene);
    parts->device = rtcNewDevice(fmt::format("threads={},user_threads=0,set_affinity=0", threads).c_str());
    if (parts->device == nullptr || !parts->fill())
        return fail(fmt::format("there is not enough memory for a picture of {} catoms", scene.places.size()),
                    "Show fewer of them, with --only or --hide", ExitCode::LimitHit);
    return Geometry(std::move(parts));
}

Geometry::Hit Geometry::seen_by(const Ray& ray, float distance, Vec normal, std::uint32_t geometry, std::uint32_t primitive) const {
    const Scene& scene = parts_->scene;
    normal.normalize();
    if (normal.dot(ray.along) > 0) normal = -normal;
    if (geometry == kStrokes) {
        const std::uint32_t stroke = parts_->tube_owners[primitive];
        return {distance, normal, scene.strokes[stroke].colour, static_cast<std::uint32_t>(scene.places.size()) + stroke};
    }
    // One thing: between its triangles there are no edges to be seen.
    if (geometry == kObstacles)
        return {distance, normal, kObstacle, static_cast<std::uint32_t>(scene.places.size() + scene.strokes.size())};
    if (geometry == kLamps)
        return {distance, normal, kLamp, static_cast<std::uint32_t>(scene.places.size() + scene.strokes.size() + 1), true};
    const std::uint32_t catom = parts_->owners.empty() ? primitive : parts_->owners[primitive];
    if (scene.form == Form::Cube && scene.rounded.empty())
        normal = bent(normal, ray.from + distance * ray.along - scene.places[catom], scene.diameter(catom) / 2);
    return {distance, normal, scene.colours[catom], catom};
}

void Geometry::hits(std::span<const Ray> rays, std::vector<std::optional<Hit>>& out) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    out.assign(rays.size(), std::nullopt);
    for (std::size_t first = 0; first < rays.size(); first += kTogether) {
        const std::span<const Ray> these = rays.subspan(first, std::min(kTogether, rays.size() - first));
        alignas(64) std::array<int, kTogether> valid{};
        RTCRayHit16 all;
        set_out(these, std::numeric_limits<float>::infinity(), all.ray, valid);
        std::ranges::fill(all.hit.geomID, RTC_INVALID_GEOMETRY_ID);
        rtcIntersect16(valid.data(), parts_->rays, &context, &all);
        for (std::size_t i = 0; i < these.size(); ++i)
            if (all.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID)
                out[first + i] = seen_by(these[i], all.ray.tfar[i], Vec(all.hit.Ng_x[i], all.hit.Ng_y[i], all.hit.Ng_z[i]),
                                         all.hit.geomID[i], all.hit.primID[i]);
    }
}

void Geometry::meets(std::span<const Ray> rays, float within, std::vector<std::uint8_t>& out) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    out.resize(rays.size());
    for (std::size_t first = 0; first < rays.size(); first += kTogether) {
        const std::span<const Ray> these = rays.subspan(first, std::min(kTogether, rays.size() - first));
        alignas(64) std::array<int, kTogether> valid{};
        RTCRay16 all;
        set_out(these, within, all, valid);
        rtcOccluded16(valid.data(), parts_->rays, &context, &all);
        for (std::size_t i = 0; i < these.size(); ++i) out[first + i] = all.tfar[i] < 0 ? 1 : 0;
    }
}

}  // namespace meld::render
