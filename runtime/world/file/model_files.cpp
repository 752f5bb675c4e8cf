// Opening models for shapes.
#include "runtime/world/file/model_files.h"

#include <fmt/format.h>

#include <utility>

#include "runtime/world/file/toml_reader.h"
#include "runtime/world/model/read_model.h"

namespace meld::world {
namespace {

std::string warning_of(const std::string& path, const model::Solid::Openness& open) {
    return fmt::format(
        "the surface of {} is open: {} of its {} edges belong to an odd number of triangles, and {} of {} rows through it cross it an odd "
        "number of times. Of the three rows through each cell, the majority decides. Close its holes",
        path, open.open_edges, open.edges, open.odd_rows, open.rows);
}

}  // namespace

Result<std::shared_ptr<const model::Solid>> WorldModels::open(std::string_view name) {
    const std::string path = reader_.beside(std::string(name));
    if (const auto known = known_.find(path); known != known_.end()) return known->second;
    const Result<std::string> bytes = reader_.read_file(path, model::kMaxModel_bytes);
    if (!bytes) return tl::unexpected(bytes.error());
    Result<model::Triangles> triangles = model::read_model(*bytes, path);
    if (!triangles) return tl::unexpected(triangles.error());
    auto solid = std::make_shared<const model::Solid>(std::move(*triangles));
    if (!solid->closed()) warnings_.push_back(warning_of(path, solid->openness()));
    known_.emplace(path, solid);
    return solid;
}

}  // namespace meld::world
