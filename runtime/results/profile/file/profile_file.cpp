#include "runtime/results/profile/file/profile_file.h"

#include <fmt/format.h>

#include <optional>
#include <utility>

#include "runtime/base/files/input_file.h"
#include "runtime/base/shallow_json.h"

namespace meld::profile {

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kKey = "claymeld_profile";
constexpr int kVersion = 1;
constexpr int kGreatestDepth = 8;
constexpr std::uint64_t kMost_bytes = std::uint64_t{4} << 30;

Result<Json> parse(const std::string& path, const std::string& text) {
    std::optional<Json> file = parse_shallow<Json>(text, kGreatestDepth);
    if (!file) return no_profile(path, fmt::format("it is nested more than {} levels deep", kGreatestDepth));
    return std::move(*file);
}

}  // namespace

tl::unexpected<Error> no_profile(const std::string& path, const std::string& why) {
    return fail(fmt::format("{} is no profile: {}", path, why), "Give a file that meldsim run --profile has written",
                ExitCode::RecordingRefused);
}

tl::unexpected<Error> part_missing(const std::string& path, const nlohmann::json::exception& error) {
    return no_profile(path, fmt::format("a part is missing or of another kind ({})", error.what()));
}

std::string file_text(const Json& run, const Json& statistics) {
    const Json file = {{kKey, kVersion}, {"run", run}, {"statistics", statistics}};
    // Escapes text that is not visible, and everything that is not ASCII.
    return file.dump(-1, ' ', true, Json::error_handler_t::replace) + "\n";
}

Result<Profile> read_profile(const std::string& path) {
    const Result<std::string> text = read_input(path, kMost_bytes);
    if (!text) return tl::unexpected(text.error());
    Result<Json> parsed = parse(path, *text);
    if (!parsed) return tl::unexpected(parsed.error());
    Json& file = *parsed;
    if (!file.is_object() || !file.contains(kKey)) return no_profile(path, "it is not whole, or something else");
    if (file[kKey] != kVersion) return no_profile(path, "it is of another version of Claymeld");
    return Profile{std::move(file["run"]), std::move(file["statistics"])};
}

}  // namespace meld::profile
