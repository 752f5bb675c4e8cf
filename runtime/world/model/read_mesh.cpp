// Meshes by the Open Asset Import Library.
#include <fmt/format.h>

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <algorithm>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstring>

#include "runtime/world/model/read_model.h"

namespace meld::model {
namespace {

// A model may name other files, which would be no part of the world: there are none.
class NoFiles : public Assimp::IOSystem {
  public:
    bool Exists(const char*) const override { return false; }
    char getOsSeparator() const override { return '/'; }
    Assimp::IOStream* Open(const char*, const char*) override { return nullptr; }
    void Close(Assimp::IOStream*) override {}
};

Vec3 vec3_of(const aiVector3D& v) { return {v.x, v.y, v.z}; }

// The library's words, in which the bytes that it was given have a name of its own.
std::string said_of(std::string words, const std::string& path) {
    static constexpr std::string_view kBytes = "$$$___magic___$$$";
    for (std::size_t at = 0; (at = words.find(kBytes, at)) != std::string::npos; at += path.size()) {
        // With the ending that it has put behind it.
        const std::size_t end = words.find_first_not_of("abcdefghijklmnopqrstuvwxyz.", at + kBytes.size());
        const std::size_t last = words.find_last_not_of('.', (end == std::string::npos ? words.size() : end) - 1) + 1;
        words.replace(at, last - at, path);
    }
    while (words.ends_with('.')) words.pop_back();
    return words;
}

// What is wrong with a binary STL file that is cut off. It begins with 80 bytes of text and the number of triangles, 50 bytes each.
Result<void> check_stl(std::string_view bytes, const std::string& path) {
    constexpr std::size_t kHead = 84, kTriangle = 50;
    if (bytes.substr(0, std::min(bytes.size(), kHead)).find('\0') == std::string_view::npos || bytes.size() < kHead) return {};
    std::uint32_t count = 0;
    std::memcpy(&count, bytes.data() + kHead - sizeof count, sizeof count);
    const std::size_t there = (bytes.size() - kHead) / kTriangle;
    if (there >= count) return {};
    return fail(fmt::format("{} is cut off: it has {} of the {} triangles that it announces", path, there, count),
                "copy or export it again");
}

// Adds the triangles of one mesh under a node.
Result<void> add_mesh(const aiMesh& mesh, const aiMatrix4x4& place, const std::string& path, Triangles& all) {
    if (all.corners.size() + mesh.mNumFaces > kMaxTriangles)
        return fail(fmt::format("{} has more than {} million triangles", path, kMaxTriangles / 1'000'000),
                    "simplify it: details below the size of a catom are lost anyway");
    const auto first = static_cast<std::uint32_t>(all.points.size());
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
        const Vec3 point = vec3_of(place * mesh.mVertices[i]);
        for (const double x : point)
            if (!std::isfinite(x)) return fail(fmt::format("{}: a coordinate of a corner is not a finite number", path));
        all.points.push_back(point);
    }
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
        const aiFace& face = mesh.mFaces[i];
        // Points and lines have no part in a surface.
        if (face.mNumIndices != 3) continue;
        for (unsigned k = 0; k < 3; ++k)
            if (face.mIndices[k] >= mesh.mNumVertices) return fail(fmt::format("{}: a triangle has a corner that does not exist", path));
        all.corners.push_back({first + face.mIndices[0], first + face.mIndices[1], first + face.mIndices[2]});
    }
    return {};
}

}  // namespace

Result<Triangles> read_mesh_unprotected(std::string_view bytes, const std::string& format, const std::string& path) {
    if (format == "stl")
        if (const auto whole = check_stl(bytes, path); !whole) return tl::unexpected<Error>(whole.error());
    Assimp::Importer importer;
    // The importer deletes it.
    importer.SetIOHandler(new NoFiles);
    // Colours, normals and the like are not even read.
    importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
    const aiScene* scene = importer.ReadFileFromMemory(bytes.data(), bytes.size(), aiProcess_Triangulate, format.c_str());
    if (!scene) return fail(fmt::format("{} is not a model: {}", path, said_of(importer.GetErrorString(), path)));
    if (!scene->mRootNode) return fail(fmt::format("{} is not a model: nothing is placed in it", path));
    Triangles all;
    // A file may place one mesh many times.
    std::vector<std::pair<const aiNode*, aiMatrix4x4>> left = {{scene->mRootNode, scene->mRootNode->mTransformation}};
    while (!left.empty()) {
        const auto [node, place] = left.back();
        left.pop_back();
        for (unsigned i = 0; i < node->mNumMeshes; ++i) {
            if (node->mMeshes[i] >= scene->mNumMeshes) return fail(fmt::format("{}: a mesh does not exist that is placed", path));
            if (auto added = add_mesh(*scene->mMeshes[node->mMeshes[i]], place, path, all); !added) return tl::unexpected(added.error());
        }
        for (unsigned i = node->mNumChildren; i-- > 0;) left.emplace_back(node->mChildren[i], place * node->mChildren[i]->mTransformation);
    }
    if (format == "gltf" || format == "glb")
        for (Vec3& point : all.points) point = {point[0], -point[2], point[1]};
    return all;
}

}  // namespace meld::model
