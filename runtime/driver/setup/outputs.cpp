#include "runtime/driver/setup/outputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <iterator>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "runtime/base/files/output_paths.h"
#include "runtime/driver/setup/watch_options.h"
#include "runtime/results/record/recording.h"

namespace meld::driver {

Durability durability(const RunOptions& options) { return options.sync ? Durability::Machine : Durability::Process; }

namespace {

// What files with such endings are, and the command that makes them; the ending that it gives them, if it is another one.
struct Made {
    const char *what, *command, *option, *ending;
    std::array<std::string_view, 4> endings;
};
constexpr Made kMade[] = {
    {"a film", "meldsim movie", "-o", "", {".mp4", ".webm"}},
    {"a film", "meldsim movie", "-o", ".mp4", {".mov", ".avi", ".mkv", ".gif"}},
    {"a picture", "meldsim shot", "-o", "", {".png"}},
    {"a picture", "meldsim shot", "-o", ".png", {".jpg", ".jpeg", ".svg", ".pdf"}},
    {"a table", "meldsim export", "-o", "", {".csv"}},
    {"a model", "meldsim export", "-o", "", {".ply", ".glb", ".xyz"}},
    {"a page", "meldsim view", "--share", "", {".html"}},
    {"a page", "meldsim view", "--share", ".html", {".htm"}},
    {"a recording", "meldsim run", "--record", "", {".vtkhdf"}},
};

bool lies_in(const std::string& path, const std::string& folder) {
    std::error_code error;
    const auto folder_of = [&](const std::string& file) {
        return std::filesystem::weakly_canonical(std::filesystem::absolute(file, error), error).parent_path();
    };
    return !path.empty() && folder_of(path) == folder_of(folder + "file");
}

}  // namespace

std::vector<NamedPath> inputs_of(const RunOptions& options, const std::string& world) {
    std::vector<NamedPath> paths = {{"the program", options.program}, {"the world", world}, {"the recording", options.replay}};
    for (const std::string& file : options.events) paths.push_back({"--events", file});
    for (const std::string& file : options.link) paths.push_back({"--link", file});
    for (const std::string& file : options.extensions) paths.push_back({"--extension", file});
    for (const std::string& text : options.watch)
        if (names_watch_file(text)) paths.push_back({"--watch", text});
    return paths;
}

Result<void> check_name(const NamedOutput& output) {
    const std::filesystem::path path = output.path;
    std::string ending = path.extension().string();
    std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const auto made =
        std::ranges::find_if(kMade, [&](const Made& each) { return std::ranges::find(each.endings, ending) != each.endings.end(); });
    if (ending.empty() || ending == output.ending || made == std::end(kMade)) return {};
    const std::string stem = (path.parent_path() / path.stem()).string(), name = stem + output.ending;
    return fail(fmt::format("cannot write {}: {}, and this is the name of {}", output.path, output.what, made->what),
                fmt::format("Write {} {}; `{} {} {} {}{}` makes {}", output.option, name, made->command,
                            output.target.empty() ? name : output.target, made->option, stem, *made->ending != '\0' ? made->ending : ending,
                            made->what));
}

Result<void> check_output(const RunOptions& options, const std::string& world, const std::string& option, const std::string& path) {
    std::vector<NamedPath> paths = inputs_of(options, world);
    paths.push_back({option, path, NamedPath::Written});
    return check_distinct(paths);
}

Result<void> check_outputs(const RunOptions& options, const std::string& world) {
    std::vector<NamedPath> paths = inputs_of(options, world);
    for (const OutputOption& output : kOutputs) paths.push_back({output.name, options.*output.path, NamedPath::Written});
    paths.push_back({"--json", options.json ? "-" : "", NamedPath::Written});
    if (!options.record.empty())
        for (const char* sidecar : {record::kSidecar, record::kLinesSidecar})
            paths.push_back({"the sidecar of --record", options.record + sidecar, NamedPath::Written});
    if (auto distinct = check_distinct(paths); !distinct) return distinct;
    // A run that goes on has a recording already.
    if (options.resume.empty())
        if (auto fits = check_name({"--record", options.record, "a recording is VTKHDF", ".vtkhdf", ""}); !fits) return fits;
    if (options.facts_out.empty()) return {};
    if (record::facts_form(options.facts_out) == record::FactsForm::CsvFolder)
        for (const OutputOption& output : kOutputs)
            if (output.path != &RunOptions::facts_out && lies_in(options.*output.path, options.facts_out))
                return fail(fmt::format("{} and --facts-out both write into the folder {}", output.name, options.facts_out),
                            "Give one of them another folder");
    return record::check_facts_path(options.facts_out);
}

Result<void> open_outputs(const RunOptions& options, const ModuleInfo& module, Outputs& outputs) {
    if (!options.facts_out.empty()) {
        auto facts = record::open_facts(options.facts_out, module, durability(options));
        if (!facts) return tl::unexpected(facts.error());
        outputs.facts = std::move(*facts);
    }
    for (const auto& [path, file] : {std::pair{&options.profile, &outputs.profile}, std::pair{&options.junit, &outputs.junit}}) {
        if (path->empty()) continue;
        auto opened = OutputFile::open(*path, Appears::Whole, durability(options));
        if (!opened) return tl::unexpected(opened.error());
        file->emplace(std::move(*opened));
    }
    // A run that goes on appends to the digests it had.
    if (options.digest.empty() || !options.resume.empty()) return {};
    auto digest = OutputFile::open(options.digest, Appears::AtOnce, durability(options));
    if (!digest) return tl::unexpected(digest.error());
    outputs.digest.emplace(std::move(*digest));
    return {};
}

bool results_at_standard_output(const RunOptions& options) {
    return options.json || is_standard_output(options.facts_out) || is_standard_output(options.digest) ||
           is_standard_output(options.profile) || is_standard_output(options.junit);
}

}  // namespace meld::driver
