// Chooses the reader by the end of the name.
#include "runtime/world/model/read_model.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>

#include "runtime/base/did_you_mean.h"
#include "runtime/world/model/run_in_child.h"

namespace meld::model {
namespace {

constexpr std::array<std::string_view, 6> kFormats = {"stl", "obj", "ply", "gltf", "glb", "vox"};

// "stl" of "parts/Horn.STL".
std::string format_of(const std::string& path) {
    std::string format = std::filesystem::path(path).extension().string();
    if (!format.empty()) format.erase(0, 1);
    for (char& c : format)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return format;
}

template <class T>
void append(std::string& out, const std::vector<T>& values) {
    const std::uint64_t count = values.size();
    out.append(reinterpret_cast<const char*>(&count), sizeof count);
    out.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

template <class T>
bool take(std::string_view& in, std::vector<T>& values) {
    std::uint64_t count = 0;
    if (in.size() < sizeof count) return false;
    std::memcpy(&count, in.data(), sizeof count);
    in.remove_prefix(sizeof count);
    if (count > in.size() / sizeof(T)) return false;
    values.resize(count);
    if (count > 0) std::memcpy(values.data(), in.data(), count * sizeof(T));
    in.remove_prefix(count * sizeof(T));
    return true;
}

// What a child tells: 'T' and the triangles, or 'E', the problem, a zero, and the suggestion.
std::string packed(Result<Triangles> read) {
    if (!read) return "E" + read.error().problem + '\0' + read.error().suggestion;
    weld(*read);
    std::string out = "T";
    append(out, read->points);
    append(out, read->corners);
    return out;
}

Result<Triangles> unpacked(std::string_view answer, const std::string& path) {
    const bool fine = answer.starts_with('T');
    if (!fine && !answer.starts_with('E')) return fail(fmt::format("{} cannot be read: its reader does not answer", path));
    answer.remove_prefix(1);
    if (!fine) {
        const std::size_t end = std::min(answer.find('\0'), answer.size());
        return fail(std::string(answer.substr(0, end)), std::string(answer.substr(std::min(end + 1, answer.size()))));
    }
    Triangles triangles;
    if (!take(answer, triangles.points) || !take(answer, triangles.corners) || !answer.empty())
        return fail(fmt::format("{} cannot be read: the answer of its reader is not whole", path));
    // The reader may have damaged its own memory.
    for (const auto& corners : triangles.corners)
        for (const std::uint32_t corner : corners)
            if (corner >= triangles.points.size()) return fail(fmt::format("{}: a triangle has a corner that does not exist", path));
    return triangles;
}

}  // namespace

Result<Triangles> read_model(std::string_view bytes, const std::string& path) {
    const std::string format = format_of(path);
    if (std::ranges::find(kFormats, format) == kFormats.end())
        return fail(fmt::format("{} is not a model that can be read, by the end of its name", path),
                    fmt::format("it may end with {}", fmt::join(kFormats, ", ")));
    Result<Triangles> read;
    if (format == "vox") {
        read = read_voxels(bytes, path);
    } else {
        // Damaged files make the library compute for ever; whole ones take some microseconds for each hundred bytes.
        const ChildLimits limits{.processor_s = 2 + bytes.size() / 1'000'000};
        const Result<std::string> answer = run_in_child([&] { return packed(read_mesh_unprotected(bytes, format, path)); },
                                                        fmt::format("{} cannot be read", path), limits);
        read = answer ? unpacked(*answer, path) : tl::unexpected(answer.error());
    }
    if (read && read->corners.empty()) return fail(fmt::format("{} has no triangles", path), "export the model as a mesh");
    return read;
}

}  // namespace meld::model
