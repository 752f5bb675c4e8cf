#include "runtime/driver/grade/grade_store.h"

#include <fmt/format.h>

#include <filesystem>

#include "runtime/base/files/input_file.h"
#include "runtime/base/files/output_file.h"

namespace meld::driver {

namespace {

constexpr std::uint64_t kMostKept_bytes = std::uint64_t{64} << 20;

}  // namespace

Result<GradeStore> GradeStore::open(const std::string& folder) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) return fail(fmt::format("cannot make the folder {}: {}", folder, error.message()));
    return GradeStore(std::filesystem::absolute(folder, error).string());
}

std::string GradeStore::path(std::uint64_t key) const { return fmt::format("{}/{:016x}.json", folder_, key); }
std::string GradeStore::page(std::uint64_t key) const { return fmt::format("{}/{:016x}.html", folder_, key); }

std::optional<nlohmann::ordered_json> GradeStore::find(std::uint64_t key) const {
    const Result<std::string> text = read_input(path(key), kMostKept_bytes);
    if (!text) return std::nullopt;
    nlohmann::ordered_json answer = nlohmann::ordered_json::parse(*text, nullptr, false);
    if (answer.is_discarded()) return std::nullopt;
    return answer;
}

Result<void> GradeStore::keep(std::uint64_t key, const nlohmann::ordered_json& answer) const {
    return write_file(path(key), answer.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

}  // namespace meld::driver
