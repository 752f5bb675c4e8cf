#include "runtime/driver/study/row_store.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>

#include "runtime/base/files/output_file.h"
#include "runtime/base/process/copied_process.h"
#include "runtime/base/process/stage_clock.h"

namespace meld::driver {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kBeat_s = 5;
// Whoever has not been seen for so long is gone; clocks do not matter, since the file server tells the time of both.
constexpr double kGone_s = 120;

std::string host_name() {
    char name[256] = {};
    if (gethostname(name, sizeof name - 1) != 0) return "host";
    std::string text = name;
    std::ranges::replace_if(text, [](char c) { return c == '/' || c == ' '; }, '_');
    return text;
}

// Whether the row has a value for everything that the study asks for.
bool answers_all(const RowResult& result, const Study& study) {
    // A run that has failed was not measured, and would fail again.
    if (!result.fine) return true;
    for (const StudyDemand& demand : study.demands)
        if (!result.demands.contains(demand_key(demand))) return false;
    for (const StudyMeasure& measure : study.measures) {
        if (measure.ticks.empty() && !result.measures.contains(measure_key(measure))) return false;
        for (const std::int64_t tick : measure.ticks)
            if (!result.measures.contains(measure_key(measure, tick))) return false;
    }
    return true;
}

// Whom a claim names; nobody if it is gone, or is no link.
std::string owner_of(const std::string& claim) {
    std::error_code error;
    return fs::read_symlink(claim, error).string();
}

}  // namespace

std::string results_folder(const std::string& study, const std::string& folder) {
    return folder.empty() ? fs::path(study).replace_extension(".results").string() : folder;
}

Result<RowStore> RowStore::open(const std::string& folder) {
    RowStore store;
    store.folder_ = folder;
    store.name_ = fmt::format("{}-{}", host_name(), getpid());
    std::error_code error;
    for (const char* part : {"/claims", "/journals"}) {
        fs::create_directories(folder + part, error);
        if (error) return fail(fmt::format("cannot make the folder {}{}: {}", folder, part, error.message()), "Choose another with -o");
    }
    store.refresh();
    return store;
}

RowStore::RowStore(RowStore&& other) noexcept
    : folder_(std::move(other.folder_)),
      name_(std::move(other.name_)),
      journal_path_(std::move(other.journal_path_)),
      journal_(std::exchange(other.journal_, -1)),
      next_beat_(other.next_beat_),
      read_(std::move(other.read_)),
      results_(std::move(other.results_)),
      claimed_(std::move(other.claimed_)) {}

RowStore::~RowStore() {
    for (const auto& [key, mine] : claimed_) unlink((folder_ + "/claims/" + key).c_str());
    if (journal_ >= 0) close(journal_);
}

void RowStore::refresh() {
    std::error_code error;
    for (fs::directory_iterator at(folder_ + "/journals", error), end; !error && at != end; at.increment(error))
        if (at->path().extension() == ".jsonl") read_journal(at->path().string());
}

// Runs of one key are the same, whoever has made them and when: they differ in what they were asked. One that has failed may have failed
// for reasons of its machine.
void RowStore::keep(const std::string& key, RowResult result) {
    const auto [found, fresh] = results_.try_emplace(key);
    RowResult& known = found->second;
    if (!fresh && known.fine && !result.fine) return;
    if (!fresh && known.fine == result.fine) {
        result.measures.update(known.measures);
        result.demands.update(known.demands);
    }
    known = std::move(result);
}

// The last line may still be under way, or cut off where a process was killed: it is read when it is whole.
void RowStore::read_journal(const std::string& path) {
    std::uint64_t& done = read_[path];
    std::error_code error;
    if (fs::file_size(path, error) <= done || error) return;
    std::ifstream file(path, std::ios::binary);
    file.seekg(static_cast<std::streamoff>(done));
    for (std::string line; std::getline(file, line) && !file.eof(); done += line.size() + 1) {
        const Json json = Json::parse(line, nullptr, false);
        if (!json.is_object() || !json.contains("key") || !json["key"].is_string()) continue;
        if (auto result = row_result(json)) keep(json["key"].get<std::string>(), std::move(*result));
    }
}

const RowResult* RowStore::any(const StudyRow& row) const {
    const auto found = results_.find(row.key);
    return found == results_.end() ? nullptr : &found->second;
}

const RowResult* RowStore::find(const StudyRow& row, const Study& study) const {
    const RowResult* const result = any(row);
    return result != nullptr && answers_all(*result, study) ? result : nullptr;
}

bool RowStore::owner_lives(const std::string& owner) const {
    struct stat theirs{}, mine{};
    const std::string host = host_name() + "-";
    if (owner.starts_with(host) && kill(static_cast<pid_t>(std::atol(owner.c_str() + host.size())), 0) != 0 && errno == ESRCH) return false;
    if (stat((folder_ + "/journals/" + owner + ".jsonl").c_str(), &theirs) != 0) return false;
    return stat(journal_path_.c_str(), &mine) != 0 || static_cast<double>(mine.st_mtim.tv_sec - theirs.st_mtim.tv_sec) < kGone_s;
}

Result<bool> RowStore::claim(const StudyRow& row) {
    if (auto begun = begin_journal(); !begun) return tl::unexpected<Error>(begun.error());
    const std::string path = claim_path(row);
    for (int attempt = 0; attempt < 2; ++attempt) {
        if (symlink(name_.c_str(), path.c_str()) == 0) {
            claimed_[row.key] = true;
            return true;
        }
        if (errno != EEXIST) return tl::unexpected<Error>(cannot_write(path, errno));
        const std::string owner = owner_of(path);
        if (!owner.empty() && owner != name_ && owner_lives(owner)) return false;
        // Of those who take it away, one succeeds.
        const std::string away = fmt::format("{}.{}", path, name_);
        if (rename(path.c_str(), away.c_str()) == 0) unlink(away.c_str());
    }
    return false;
}

void RowStore::release(const StudyRow& row) {
    if (claimed_.erase(row.key) > 0) unlink(claim_path(row).c_str());
}

Result<void> RowStore::begin_journal() {
    if (journal_ >= 0) return {};
    journal_path_ = folder_ + "/journals/" + name_ + ".jsonl";
    journal_ = ::open(journal_path_.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    if (journal_ < 0) return tl::unexpected<Error>(cannot_write(journal_path_, errno));
    // Another process of this name was perhaps killed in the middle of a line.
    struct stat file{};
    char last = '\n';
    if (fstat(journal_, &file) == 0 && file.st_size > 0 && pread(journal_, &last, 1, file.st_size - 1) == 1 && last != '\n')
        if (!write_all(journal_, "\n")) return tl::unexpected<Error>(cannot_write(journal_path_, errno));
    beat();
    return {};
}

Result<void> RowStore::add(const StudyRow& row, const RowResult& result) {
    if (auto begun = begin_journal(); !begun) return begun;
    Json json = {{"key", row.key}};
    json.update(to_json(result));
    if (!write_all(journal_, json.dump(-1, ' ', true, Json::error_handler_t::replace) + "\n"))
        return tl::unexpected<Error>(cannot_write(journal_path_, errno));
    keep(row.key, result);
    // The claim stays, so that nobody who has not read the journal makes the row again.
    claimed_.erase(row.key);
    return {};
}

void RowStore::beat() {
    const double now = seconds_now();
    if (journal_ < 0 || now < next_beat_) return;
    next_beat_ = now + kBeat_s;
    futimens(journal_, nullptr);
}

void RowStore::clean() {
    for (const auto& [key, result] : results_) unlink((folder_ + "/claims/" + key).c_str());
}

}  // namespace meld::driver
