#include "compiler/driver/apply_fixes.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <iostream>
#include <map>
#include <set>
#include <system_error>
#include <utility>

#include "runtime/base/files/output_file.h"
#include "runtime/base/terminal/terminal_text.h"

namespace meld::driver {

using diagnostics::Edit;
using diagnostics::Fix;

namespace {

// A file that will change. Several programs may include it, under several paths.
struct Changed {
    source::File file;
    diagnostics::Edits edits = {};
    std::set<std::pair<std::uint32_t, std::string>> fixes = {};  // By the place of the message and title, to count each once.
};

// The fixes of one round. One mistake may hide another, and fixes may be in each other's way: one that is in the way of an earlier one
// waits for the next round, which sees the text after it.
class Round {
  public:
    Result<void> add(const Compilation& c) {
        const auto on_disk = [&](std::uint32_t file) { return c.files.file(file).on_disk(); };
        for (const diagnostics::Diagnostic& message : c.report.sorted()) {
            const std::vector<Fix> fixes = diagnostics::exact(c.files, message.fixes, on_disk);
            const auto safe = std::find_if(fixes.begin(), fixes.end(), [](const Fix& fix) { return fix.safe; });
            if (safe == fixes.end()) continue;
            bool fits = true;
            for (const Edit& edit : safe->edits) {
                const Result<Changed*> changed = changing(c.files.file(edit.span));
                if (!changed) return tl::unexpected(changed.error());
                fits = fits && (*changed)->edits.fits(edit);
            }
            for (const Edit& edit : safe->edits) {
                if (!fits) break;
                Changed& changed = **changing(c.files.file(edit.span));
                changed.edits.add(edit);
                changed.fixes.emplace(message.span.begin, safe->title);
            }
        }
        return {};
    }

    bool none() const { return changed_.empty(); }
    // Of what it is going to change: never the same again, unless fixes undo each other.
    std::size_t hash() const {
        std::size_t result = 0;
        for (const auto& [path, changed] : changed_) result = result * 31 + std::hash<std::string>()(path + '\0' + changed.file.text());
        return result;
    }

    // Adds how many fixes each file has got.
    Result<void> write(std::map<std::string, std::size_t>& applied) const {
        for (const auto& [path, changed] : changed_) {
            const std::string& shown = changed.file.path();
            if (auto written = write_file(shown, changed.edits.applied(changed.file.text())); !written) return written;
            applied[shown] += changed.fixes.size();
        }
        return {};
    }

  private:
    Result<Changed*> changing(const source::File& file) {
        if (OutputFile::names_stream(file.path())) return fail(fmt::format("cannot fix {}: it is not a file", file.path()));
        std::error_code error;
        const std::string path = std::filesystem::weakly_canonical(file.path(), error).string();
        Changed& changed = changed_.try_emplace(path, Changed{.file = source::File(file.path(), file.text())}).first->second;
        if (changed.file.text() != file.text()) return fail(fmt::format("{} has changed while it was read", file.path()), "Try again");
        return &changed;
    }

    std::map<std::string, Changed> changed_;
};

}  // namespace

Result<void> apply_fixes(const std::vector<std::string>& programs, const CompileOptions& options) {
    // What comes from a pipe can be read once, and then only by one of the rounds and the check after them.
    for (const std::string& path : programs)
        if (OutputFile::names_stream(path)) return fail(fmt::format("cannot fix {}: it is not a file", path));
    CompileOptions only_check = options;
    only_check.last = Stage::Program;
    std::map<std::string, std::size_t> applied;  // How many, by file.
    Result<void> done;
    std::set<std::size_t> rounds;
    while (done) {
        Round round;
        for (const std::string& path : programs) {
            Compilation c;
            if (compile(path, only_check, c) && done) done = round.add(c);
        }
        if (round.none() || !rounds.insert(round.hash()).second) break;
        if (done) done = round.write(applied);
    }
    for (const auto& [path, count] : applied)
        std::cerr << fmt::format("{}: {} fix{} applied\n", visible(path), count, count == 1 ? "" : "es");
    return done;
}

}  // namespace meld::driver
