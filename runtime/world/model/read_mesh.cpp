// Meshes by the Open Asset Import Library.
#include <fmt/format.h>

#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <cmath>

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
    Assimp::Importer importer;
    // The importer deletes it.
    importer.SetIOHandler(new NoFiles);
    // Colours, normals and the like are not even read.
    importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
    const aiScene* scene = importer.ReadFileFromMemory(bytes.data(), bytes.size(), aiProcess_Triangulate, format.c_str());
    if (!scene) return fail(fmt::format("{} is not a model: {}", path, importer.GetErrorString()));
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
