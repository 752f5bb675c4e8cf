#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string>
#include <vector>

#include "runtime/base/hash.h"
#include "runtime/base/version.h"
#include "runtime/driver/about/about.h"
#include "runtime/results/record/provenance.h"
#include "runtime/results/record/recording_reader.h"

namespace meld::driver {

namespace {

using RecordingFacts = nlohmann::ordered_json;

std::vector<std::string> what_a_recording_lacks(const record::RecordingReader& recording, const AboutRun& about, bool begun_before) {
    std::vector<std::string> lacks;
    const std::vector<std::int64_t>& ticks = recording.ticks();
    const auto made = static_cast<std::size_t>(ticks.back() - ticks.front() + 1);
    if (ticks.size() < made) lacks.push_back(fmt::format("the ticks between its steps: it has {} of {}", ticks.size(), made));
    std::vector<std::string> names;
    for (const record::DescribedPredicate& each : recording.predicates()) names.push_back(each.name);
    lacks.push_back(names.empty() ? "facts: the world names no predicates to record"
                                  : fmt::format("facts of other predicates than {}", fmt::join(names, ", ")));
    lacks.emplace_back("the digits of positions beyond those of 32-bit numbers");
    if (!about.code.empty()) lacks.emplace_back("the code of extern functions and extensions: only its hashes");
    lacks.emplace_back("the compiled module, the compiler and the MPI library: only their versions");
    if (begun_before) lacks.emplace_back("the checkpoint at which its run branched off: without that it cannot be made again");
    if (about.made_by.is_null()) lacks.emplace_back("what made it, and the command: an earlier version has recorded it");
    if (about.counts.is_null())
        lacks.emplace_back("counts: its run did not come to its end, or an earlier version has recorded it");
    else if (about.counts.value("ticks", std::int64_t{0}) != about.tick)
        lacks.push_back(
            fmt::format("counts of its last ticks: they are those up to tick {}", about.counts.value("ticks", std::int64_t{0})));
    return lacks;
}

}  // namespace

nlohmann::ordered_json object_in(const std::string& text) {
    RecordingFacts json = RecordingFacts::parse(text, nullptr, false);
    return json.is_object() ? json : RecordingFacts();
}

Result<AboutRun> about_recording(const std::string& path) {
    const Result<record::RecordingReader> recording = record::RecordingReader::open(path);
    if (!recording) return tl::unexpected<Error>(recording.error());
    if (recording->ticks().empty()) return fail(path + " has no step", "", ExitCode::RecordingRefused);
    const Result<record::Provenance> p = record::provenance_from_json(recording->about("provenance"));
    if (!p) return fail(fmt::format("{}: {}", path, p.error().problem), p.error().suggestion, p.error().code);
    const Result<std::vector<Digest>> digests = recording->digests();
    if (!digests) return tl::unexpected<Error>(digests.error());
    AboutRun about{.kind = "recording", .name = path};
    for (const auto& source : p->program) about.program.push_back({source.path, hash_text(source.text)});
    about.world.push_back({p->world_path, hash_text(p->world)});
    for (const auto& [name, text] : p->world_files) about.world.push_back({name, hash_text(text)});
    for (const auto* files : {&p->linked, &p->extensions})
        for (const record::CodeFile& file : *files) about.code.push_back({file.path, file.hash});
    for (const auto& [name, value] : p->set) about.set.push_back(fmt::format("{}={}", name, value));
    about.limits = p->limits;
    about.seed = p->seed;
    about.tick = recording->ticks().back();
    about.digest = digests->back().to_string();
    about.steps = recording->ticks().size();
    const RecordingFacts made = object_in(recording->about("made_by"));
    if (!made.is_null()) {
        about.made_by = made.value("versions", RecordingFacts());
        about.folder = made.value("folder", "");
        for (const auto& word : made.value("command", RecordingFacts::array()))
            if (word.is_string()) about.typed.push_back(word);
    } else {
        about.made_by = RecordingFacts{{"claymeld", p->version}};
    }
    for (const auto& [count, value] : recording->counts()) about.counts[count] = value;
    // Another version may make other states.
    about.again = {"meldsim", "replay", path};
    if (!p->forked_from.empty()) about.again = about.typed;
    about.lacks = what_a_recording_lacks(*recording, about, !p->forked_from.empty());
    if (p->version != kVersion) about.lacks.push_back(fmt::format("what version {} replays: use {}", kVersion, p->version));
    return about;
}

}  // namespace meld::driver
