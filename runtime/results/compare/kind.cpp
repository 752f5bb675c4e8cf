#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "runtime/results/compare/compare.h"
#include "runtime/results/facts/fact_tables.h"
#include "runtime/results/facts/facts_csv.h"
#include "runtime/results/hdf5/file_kind.h"

namespace meld::compare {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kHdf5 = "\x89HDF\r\n\x1a\n";

tl::unexpected<Error> unknown(const std::string& path) {
    return fail(fmt::format("{} is nothing that meldsim can compare", path),
                "Give recordings, folders of checkpoints, digests, or facts that meldsim run has written");
}

Result<Kind> kind_of_folder(const std::string& path) {
    std::error_code error;
    if (fs::exists(fs::path(path) / record::kDataPackage, error)) return Kind::CsvFolder;
    if (!sim::checkpoint_ticks(path).empty()) return Kind::Checkpoints;
    return unknown(path);
}

}  // namespace

bool begins_as_hdf5(const std::string& path) {
    std::error_code error;
    if (!fs::is_regular_file(path, error)) return false;
    std::ifstream in(path, std::ios::binary);
    std::array<char, kHdf5.size()> bytes{};
    in.read(bytes.data(), bytes.size());
    return in && std::string_view(bytes.data(), bytes.size()) == kHdf5;
}

Result<Kind> kind_of(const std::string& path) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (!fs::exists(status)) return fail(fmt::format("cannot read {}: {}", path, std::strerror(error ? error.value() : ENOENT)));
    if (fs::is_directory(status)) return kind_of_folder(path);
    // What is compared is read more than once.
    if (!fs::is_regular_file(status)) return fail(fmt::format("cannot read {}: it is no regular file", path));
    std::ifstream in(path, std::ios::binary);
    if (!in) return fail(fmt::format("cannot read {}: {}", path, std::strerror(errno)));
    std::array<char, 64> bytes{};
    in.read(bytes.data(), bytes.size());
    const std::string_view begin(bytes.data(), static_cast<std::size_t>(in.gcount()));
    if (begin.empty()) return Kind::Empty;
    if (begin.starts_with(kHdf5)) {
        switch (record::kind_of_hdf5(path)) {
            case record::Hdf5Kind::Recording:
                return Kind::Recording;
            case record::Hdf5Kind::Facts:
                return Kind::Hdf5Facts;
            case record::Hdf5Kind::Other:
                return unknown(path);
        }
    }
    if (begin.starts_with("tick ")) return Kind::Digests;
    const std::string column = record::kCatomColumn;
    if (begin.starts_with(column + ",") || begin.starts_with(column + "\n")) return Kind::CsvFile;
    if (begin.find("(@") != std::string_view::npos && begin.substr(0, begin.find("(@")).find_first_of(" \n\t\"{") == std::string_view::npos)
        return Kind::TextFacts;
    return unknown(path);
}

const char* name_of(Kind kind) {
    switch (kind) {
        case Kind::Digests:
            return "a file of digests";
        case Kind::Recording:
            return "a recording";
        case Kind::TextFacts:
            return "a file of facts as text";
        case Kind::CsvFile:
        case Kind::CsvFolder:
            return "a table of facts as CSV";
        case Kind::Hdf5Facts:
            return "a file of facts as HDF5";
        case Kind::Checkpoints:
            return "a folder of checkpoints";
        case Kind::Empty:
            return "an empty file";
    }
    return "";
}

}  // namespace meld::compare
