#include "runtime/driver/pictures/whole_recording.h"

#include <fmt/format.h>

#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "runtime/base/files/standard_streams.h"
#include "runtime/base/process/interrupt.h"
#include "runtime/base/terminal/progress.h"
#include "runtime/base/units.h"
#include "runtime/driver/setup/print_error.h"
#include "runtime/results/compare/compare.h"
#include "runtime/results/record/whole_copy.h"

namespace meld::driver {

namespace {

// A copy has all that the recording has.
Result<void> asks_for_all(const PictureOptions& picture) {
    const PictureOptions usual;
    const std::pair<const char*, bool> given[] = {{"--tick", !std::get<ExportOptions>(picture.of).ticks.empty()},
                                                  {"--colour", picture.colour != usual.colour},
                                                  {"--map", picture.map != usual.map},
                                                  {"--range", picture.range != usual.range},
                                                  {"--only", picture.only != usual.only},
                                                  {"--hide", picture.hide != usual.hide},
                                                  {"--form", picture.form != usual.form},
                                                  {"--catom-size", picture.catom_size != usual.catom_size}};
    for (const auto& [option, is_given] : given)
        if (is_given) return fail(fmt::format("{}: a .vtkhdf file is a copy of the whole recording", option), "Leave it out");
    return {};
}

Result<record::RecordingReader> open_to_copy(const std::string& path) {
    std::error_code error;
    if (std::filesystem::exists(path, error) && !compare::begins_as_hdf5(path))
        return fail(fmt::format("{} is not a recording, and a .vtkhdf file is made of one", path),
                    "Record the run with `meldsim run --record`, and export that");
    return record::RecordingReader::open(path);
}

Result<void> write(const RunOptions& options) {
    const std::string& to = options.debug->picture->file;
    if (auto all = asks_for_all(*options.debug->picture); !all) return all;
    Result<record::RecordingReader> recording = open_to_copy(options.program);
    if (!recording) return tl::unexpected<Error>(recording.error());
    const std::vector<std::int64_t> ticks = recording->ticks();
    if (ticks.empty()) return fail(options.program + " has no step", "", ExitCode::RecordingRefused);
    {
        std::optional<Progress> progress;
        if (!options.quiet) progress.emplace();
        auto copied = record::copy_whole(*recording, to, [&](std::size_t step) -> Result<void> {
            if (interrupt::received() != 0) return fail("interrupted", "", ExitCode::Interrupted);
            if (progress) progress->update([&] { return fmt::format("step {} of {}", step + 1, ticks.size()); });
            return {};
        });
        if (!copied) return copied;
    }
    if (options.json) return print(stdout, nlohmann::ordered_json{{"file", to}, {"ticks", ticks}}.dump() + "\n");
    if (options.quiet) return {};
    return print(stdout, fmt::format("{}: {} step{}, all of them whole\n", to, grouped(ticks.size()), ticks.size() == 1 ? "" : "s"));
}

}  // namespace

bool is_recording_name(const std::string& path) { return path.ends_with(".vtkhdf"); }

int export_recording(const RunOptions& options) {
    interrupt::handle({SIGINT, SIGTERM, SIGHUP});
    interrupt::set_last_words("meldsim: interrupted before its end\n");
    const interrupt::Answering patiently(interrupt::Answer::Patiently);
    const Result<void> done = write(options);
    if (done) return static_cast<int>(ExitCode::Fine);
    const int code = print_error(done.error());
    return done.error().code == ExitCode::Interrupted ? interrupt::exit_code() : code;
}

}  // namespace meld::driver
