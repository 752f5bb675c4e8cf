// Instead of what calls the Open Asset Import Library and TinyXML in a program that is built without them.
#include <fmt/format.h>

#include "runtime/world/model/read_model.h"
#include "runtime/world/model/visiblesim.h"

namespace meld::model {

namespace {

constexpr const char* kBuiltWith = "Use a meldsim that was built with -DCLAYMELD_MODELS=ON";

}  // namespace

Result<Triangles> read_mesh_unprotected(std::string_view, const std::string&, const std::string& path) {
    return fail(fmt::format("{} is a mesh, and this meldsim was built to read voxels (.vox) only", path), kBuiltWith);
}

Result<ImportedWorld> import_visiblesim(std::string_view, const std::string& path, std::string_view) {
    return fail(fmt::format("{}: this meldsim was built without XML, in which configurations of VisibleSim are", path), kBuiltWith);
}

}  // namespace meld::model
