#include "runtime/world/model/read_model.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "runtime/world/model/run_in_child.h"
#include "runtime/world/model/solid.h"
#include "tests/unit/runtime_world_model/surfaces.h"

namespace meld::model {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

std::string error_of(const std::string& bytes, const std::string& path) {
    const Result<Triangles> read = read_model(bytes, path);
    return read ? "fine" : read.error().message();
}

TEST(ReadModel, ReadsEachMeshFormat) {
    const Triangles torus = torus_surface(10, 3, 24, 12);
    const std::pair<std::string, std::string> files[] = {
        {"a.stl", ascii_stl_of(torus)}, {"b.STL", binary_stl_of(torus)}, {"c.obj", obj_of(torus)}, {"d.ply", ply_of(torus)}};
    for (const auto& [path, bytes] : files) {
        const Result<Triangles> read = read_model(bytes, path);
        ASSERT_TRUE(read) << read.error().message();
        EXPECT_EQ(read->points.size(), torus.points.size()) << path;
        EXPECT_EQ(read->corners.size(), torus.corners.size()) << path;
        EXPECT_NEAR(volume_of(*read), volume_of(torus), 1e-3) << path;
        EXPECT_TRUE(Solid(*read).closed()) << path;
    }
}

// Two triangles of a glTF file, in which y is up and a node moves the mesh.
TEST(ReadModel, TurnsGltfUpright) {
    const std::string data = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAAEAAAAAA";  // (0, 0, 0) (1, 0, 0) (0, 2, 0)
    const std::string text = R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "translation": [0, 0, 5]}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 2, 0]}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,)" +
                             data + R"("}]})";
    const Result<Triangles> read = read_model(text, "a.gltf");
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_THAT(read->points, testing::UnorderedElementsAre(Vec3{0, -5, 0}, Vec3{1, -5, 0}, Vec3{0, -5, 2}));
}

TEST(ReadModel, SaysWhatIsNoModel) {
    EXPECT_THAT(error_of("x", "part.step"),
                StartsWith("part.step is not a model that can be read, by the end of its name. it may end with stl"));
    EXPECT_THAT(error_of("{", "part.gltf"), StartsWith("part.gltf is not a model: "));
    EXPECT_THAT(error_of("", "part.stl"), StartsWith("part.stl is not a model"));
    EXPECT_THAT(error_of("v 0 0 0\nv 1 0 0\nl 1 2\n", "line.obj"),
                testing::AnyOf(HasSubstr("has no triangles"), HasSubstr("is not a model")));
    EXPECT_THAT(error_of("no voxels", "a.vox"), StartsWith("a.vox is not a MagicaVoxel file: it does not begin as one"));
    EXPECT_THAT(error_of(std::string("VOX \x96\0\0\0", 8), "a.vox"), HasSubstr("there is no model in it"));
}

// Each ends in triangles or an error, and this process goes on.
TEST(ReadModel, SurvivesDamagedFiles) {
    const Triangles torus = torus_surface(10, 3, 8, 6);
    const std::pair<std::string, std::string> files[] = {
        {"a.stl", ascii_stl_of(torus)}, {"b.stl", binary_stl_of(torus)}, {"c.obj", obj_of(torus)}, {"d.ply", ply_of(torus)}};
    std::mt19937_64 random(4);
    int refused = 0;
    for (const auto& [path, bytes] : files) {
        for (int i = 0; i < 12; ++i) {
            std::string damaged = bytes;
            if (i % 2 == 0) damaged.resize(random() % damaged.size());
            for (int flips = i % 6; flips > 0 && !damaged.empty(); --flips)
                damaged[random() % damaged.size()] = static_cast<char>(random());
            const Result<Triangles> read = read_model(damaged, path);
            refused += !read;
            if (read) {
                for (const auto& corners : read->corners) ASSERT_LT(*std::ranges::max_element(corners), read->points.size());
            }
        }
    }
    EXPECT_GT(refused, 5);
}

TEST(InChild, ReportsCrashesAndLimits) {
    EXPECT_EQ(*run_in_child([] { return std::string("fine"); }, "x", {}), "fine");
    const auto message = [](const std::function<std::string()>& work, const ChildLimits& limits) {
        const Result<std::string> done = run_in_child(work, "part.stl cannot be read", limits);
        return done ? "fine" : done.error().problem;
    };
    EXPECT_THAT(message([]() -> std::string { std::abort(); }, {}), StartsWith("part.stl cannot be read: its reader crashed, "));
    EXPECT_EQ(message([]() -> std::string { throw 1; }, {}), "part.stl cannot be read: its reader gave up");
    EXPECT_EQ(message([] { return std::string(1 << 20, 'x'); }, {.answer_bytes = 1000}), "part.stl cannot be read: it is too large");
}

std::string number(std::int32_t value) { return {reinterpret_cast<const char*>(&value), 4}; }
std::string text(const std::string& value) { return number(static_cast<std::int32_t>(value.size())) + value; }
std::string chunk(const std::string& name, const std::string& content) {
    return name + number(static_cast<std::int32_t>(content.size())) + number(0) + content;
}
std::string dictionary(const std::vector<std::pair<std::string, std::string>>& entries) {
    std::string out = number(static_cast<std::int32_t>(entries.size()));
    for (const auto& [key, value] : entries) out += text(key) + text(value);
    return out;
}
std::string vox(const std::string& chunks) {
    return "VOX " + number(200) + "MAIN" + number(0) + number(static_cast<std::int32_t>(chunks.size())) + chunks;
}
// A bar of three voxels along x, and one more on its end.
const std::string kBar =
    chunk("SIZE", number(3) + number(1) + number(2)) + chunk("XYZI", number(4) + std::string("\0\0\0\1\1\0\0\1\2\0\0\1\2\0\1\1", 16));

TEST(ReadVoxels, MakesClosedSurfacesAroundWholeCoordinates) {
    const Result<Triangles> read = read_model(vox(kBar), "bar.vox");
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_DOUBLE_EQ(volume_of(*read), 4);
    const Solid solid(*read);
    EXPECT_TRUE(solid.closed());
    EXPECT_EQ(solid.low(), (Vec3{-0.5, -0.5, -0.5}));
    EXPECT_TRUE(solid.contains({2, 0, 1}));
    EXPECT_FALSE(solid.contains({1, 0, 1}));
}

TEST(ReadVoxels, PlacesModelsAsTheSceneSays) {
    // The second row of the rotation is the first axis, the first is the second axis, negative: a quarter turn about z.
    const std::string scene =
        chunk("nTRN", number(0) + dictionary({}) + number(1) + number(-1) + number(0) + number(1) + dictionary({})) +
        chunk("nGRP", number(1) + dictionary({}) + number(2) + number(2) + number(4)) +
        chunk("nTRN", number(2) + dictionary({}) + number(3) + number(-1) + number(0) + number(1) +
                          dictionary({{"_r", std::to_string(1 | 0 << 2 | 1 << 4)}, {"_t", "10 20 -3"}})) +
        chunk("nSHP", number(3) + dictionary({}) + number(1) + number(0) + dictionary({})) +
        chunk("nTRN", number(4) + dictionary({{"_hidden", "1"}}) + number(3) + number(-1) + number(0) + number(1) + dictionary({}));
    const Result<Triangles> read = read_model(vox(kBar + scene), "bar.vox");
    ASSERT_TRUE(read) << read.error().message();
    EXPECT_DOUBLE_EQ(volume_of(*read), 4);
    const Solid solid(*read);
    // x from -1 to 1 about the middle voxel becomes y; y turned is -y - 1 in whole voxels.
    EXPECT_EQ(solid.low(), (Vec3{8.5, 18.5, -4.5}));
    EXPECT_EQ(solid.high(), (Vec3{9.5, 21.5, -2.5}));
    EXPECT_TRUE(solid.contains({9, 21, -3}));
    EXPECT_FALSE(solid.contains({9, 19, -3}));
}

TEST(ReadVoxels, RefusesDamagedFiles) {
    const std::string whole = vox(kBar);
    for (std::size_t length = 20; length < whole.size(); ++length) EXPECT_NE(error_of(whole.substr(0, length), "a.vox"), "fine") << length;
    const std::string circle = chunk("nTRN", number(0) + dictionary({}) + number(0) + number(-1) + number(0) + number(0));
    EXPECT_THAT(error_of(vox(kBar + circle), "a.vox"), HasSubstr("its scene is not a tree"));
    const std::string missing = chunk("nSHP", number(0) + dictionary({}) + number(1) + number(7) + dictionary({}));
    EXPECT_THAT(error_of(vox(kBar + missing), "a.vox"), HasSubstr("there is no model 7 in it"));
}

}  // namespace
}  // namespace meld::model
