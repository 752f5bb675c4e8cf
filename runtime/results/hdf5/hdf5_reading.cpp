#include "runtime/results/hdf5/hdf5_reading.h"

#include <fmt/format.h>

#include <algorithm>

#include "runtime/results/hdf5/file_kind.h"

namespace meld::record {

namespace {

// Negative: whether it is there cannot be read.
htri_t exists(hid_t file, const std::string& path) { return path == "/" ? 1 : H5Lexists(file, path.c_str(), H5P_DEFAULT); }

// A string of any length, or one of a fixed length; empty if it is neither.
std::string text_from(hid_t file, hid_t type, const auto& read) {
    if (H5Tget_class(type) != H5T_STRING) return "";
    if (H5Tis_variable_str(type) > 0) {
        char* text = nullptr;
        if (read(static_cast<void*>(&text)) < 0 || text == nullptr) return "";
        std::string out = text;
        H5free_memory(text);
        return out;
    }
    // A text that was never written takes no space in the file, however long it claims to be.
    hsize_t size_bytes = 0;
    if (H5Fget_filesize(file, &size_bytes) < 0 || H5Tget_size(type) > size_bytes) return "";
    std::string out(H5Tget_size(type), '\0');
    if (read(static_cast<void*>(out.data())) < 0) return "";
    return out.c_str();
}

constexpr hssize_t kMostTexts = 1 << 20;

// An attribute that is one value.
struct Attribute {
    Handle id, type;
    bool there = false;

    Attribute(hid_t file, const std::string& group, const std::string& name)
        : id(open(file, group, name)), type(H5Aget_type(id), H5Tclose) {
        const Handle space(H5Aget_space(id), H5Sclose);
        there = id >= 0 && H5Sget_simple_extent_npoints(space) == 1;
    }

  private:
    static Handle open(hid_t file, const std::string& group, const std::string& name) {
        const bool there = exists(file, group) > 0 && H5Aexists_by_name(file, group.c_str(), name.c_str(), H5P_DEFAULT) > 0;
        return {there ? H5Aopen_by_name(file, group.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT) : H5I_INVALID_HID, H5Aclose};
    }
};

}  // namespace

Result<std::vector<std::string>> names_in(hid_t file, const std::string& group) {
    std::vector<std::string> names;
    const htri_t there = exists(file, group);
    if (there == 0) return names;
    const auto take = [](hid_t, const char* name, const H5L_info_t*, void* to) -> herr_t {
        static_cast<std::vector<std::string>*>(to)->emplace_back(name);
        return 0;
    };
    hsize_t from = 0;
    if (there < 0 || H5Literate_by_name(file, group.c_str(), H5_INDEX_NAME, H5_ITER_INC, &from, take, &names, H5P_DEFAULT) < 0)
        return fail(fmt::format("{} cannot be read: {}", group, text_of_last_error()));
    std::sort(names.begin(), names.end());
    return names;
}

std::string attribute(hid_t file, const std::string& group, const std::string& name) {
    const Attribute found(file, group, name);
    if (!found.there) return "";
    if (const auto number = number_attribute(file, group, name)) return std::to_string(*number);
    if (H5Tget_class(found.type) == H5T_FLOAT) {
        double value = 0;
        return H5Aread(found.id, H5T_NATIVE_DOUBLE, &value) < 0 ? "" : fmt::format("{}", value);
    }
    return text_from(file, found.type, [&](void* to) { return H5Aread(found.id, found.type, to); });
}

std::optional<std::uint64_t> number_attribute(hid_t file, const std::string& group, const std::string& name) {
    const Attribute found(file, group, name);
    std::uint64_t value = 0;
    if (!found.there || H5Tget_class(found.type) != H5T_INTEGER || H5Aread(found.id, H5T_NATIVE_UINT64, &value) < 0) return std::nullopt;
    return value;
}

std::string text_at(hid_t file, const std::string& path) {
    if (exists(file, path) <= 0) return "";
    const Handle id(H5Dopen2(file, path.c_str(), H5P_DEFAULT), H5Dclose);
    const Handle type(H5Dget_type(id), H5Tclose), space(H5Dget_space(id), H5Sclose);
    if (H5Sget_simple_extent_npoints(space) != 1) return "";
    return text_from(file, type, [&](void* to) { return H5Dread(id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, to); });
}

std::vector<std::string> texts_at(hid_t file, const std::string& path) {
    std::vector<std::string> out;
    if (exists(file, path) <= 0) return out;
    const Handle id(H5Dopen2(file, path.c_str(), H5P_DEFAULT), H5Dclose);
    const Handle type(H5Dget_type(id), H5Tclose), space(H5Dget_space(id), H5Sclose);
    const hssize_t count = H5Sget_simple_extent_npoints(space);
    if (H5Tis_variable_str(type) <= 0 || count <= 0 || count > kMostTexts) return out;
    std::vector<char*> texts(static_cast<std::size_t>(count));
    if (H5Dread(id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, static_cast<void*>(texts.data())) < 0) return out;
    for (const char* text : texts) out.emplace_back(text == nullptr ? "" : text);
    H5Dvlen_reclaim(type, space, H5P_DEFAULT, static_cast<void*>(texts.data()));
    return out;
}

Hdf5Kind kind_of_hdf5(const std::string& path) {
    const Handle file(open_to_read(path), H5Fclose);
    if (file < 0) return Hdf5Kind::Other;
    if (attribute(file, "/meld", "format") == kRecordingFormat) return Hdf5Kind::Recording;
    return attribute(file, "/", "format") == kFactsFormat ? Hdf5Kind::Facts : Hdf5Kind::Other;
}

}  // namespace meld::record
