// Files with models: meshes of triangles (STL, OBJ, PLY, glTF) and voxels (MagicaVoxel).
#pragma once

#include <string>
#include <string_view>

#include "runtime/base/error.h"
#include "runtime/world/model/triangles.h"

namespace meld::model {

// The largest file that is read.
inline constexpr std::uint64_t kMaxModel_bytes = std::uint64_t{1} << 30;

// The surface of the model in a file with these bytes; the end of `path` names the format, and the rest of it is for messages. Points are
// welded, and z is up: glTF, where y is up, is turned. Meshes are read by another process, so a damaged file cannot harm this one, and
// whatever a file says, that process may take at most 4 GiB, and 2 s and 1 s for each megabyte. Errors: an unknown format, a damaged file,
// no triangles, too many of them, a coordinate that is not finite.
Result<Triangles> read_model(std::string_view bytes, const std::string& path);

// The surface of the voxels of a MagicaVoxel file, a cube with sides of 1 around each point with integer coordinates, as they stand in its
// scene, z up. Only faces that are seen. Errors: as above.
Result<Triangles> read_voxels(std::string_view bytes, const std::string& path);

// Reads a mesh in this process; `format` is the end of a file name, as "stl". Damaged bytes may crash it.
Result<Triangles> read_mesh_unprotected(std::string_view bytes, const std::string& format, const std::string& path);

}  // namespace meld::model
