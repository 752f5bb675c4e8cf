#include "runtime/comm/launch/shutdown.h"

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <thread>

#include "runtime/comm/launch/launch.h"

namespace meld::comm {

namespace {

using std::chrono::milliseconds;

// To look at all processes of a machine may take a few milliseconds.
constexpr milliseconds kBetweenLooks{50};
// A process that does not handle the signal by then has not begun to compute, or never will.
constexpr milliseconds kUntilReady{500};
// Processes end together. Where one has, or all have, the rest follows soon or not at all; mpirun itself is in no hurry.
constexpr milliseconds kAfterOthers{1500};
// It gives the processes a second from SIGTERM to SIGKILL.
constexpr milliseconds kUntilGone{1000};

// The file that execvp() finds.
ProgramFile find_program(const std::string& name) {
    if (name.find('/') != std::string::npos) return program_at(name);
    const char* path = std::getenv("PATH");
    std::string folders = path == nullptr ? "/bin:/usr/bin" : path;
    for (std::size_t begin = 0; begin <= folders.size();) {
        const std::size_t end = std::min(folders.find(':', begin), folders.size());
        const std::string file = folders.substr(begin, end - begin) + "/" + name;
        if (access(file.c_str(), X_OK) == 0) return program_at(file);
        begin = end + 1;
    }
    return {};
}

}  // namespace

Shutdown::Shutdown(pid_t mpirun, const std::string& program, int processes)
    : mpirun_(mpirun), program_(find_program(program)), processes_of_run_(static_cast<std::size_t>(processes)) {
    prctl(PR_SET_CHILD_SUBREAPER, 1);
}

Shutdown::~Shutdown() { prctl(PR_SET_CHILD_SUBREAPER, 0); }

void Shutdown::ask(int signal) {
    if (asked_) return;
    asked_ = true;
    signal_ = signal;
    asked_at_ = all_there_at_ = next_look_ = Clock::now();
    // Nothing can end under an mpirun that is stopped.
    kill(mpirun_, SIGCONT);
    look();
}

void Shutdown::forget() {
    asked_ = false;
    told_.clear();
}

void Shutdown::insist() {
    if (insisted_) return;
    asked_ = insisted_ = true;
    insisted_at_ = Clock::now();
    kill(mpirun_, SIGTERM);
}

void Shutdown::kill_now() {
    asked_ = insisted_ = true;
    kill_all();
}

std::vector<pid_t> Shutdown::processes() const {
    std::vector<pid_t> found = descendants_of(getpid());
    std::erase_if(found, [&](pid_t process) { return program_of(process) != program_; });
    return found;
}

// A signal that finds no handler ends a process; that is for mpirun to do.
void Shutdown::tell(const std::vector<pid_t>& processes) {
    for (const pid_t process : processes) {
        if (told_.contains(process) || !catches(process, signal_)) continue;
        // Those on other machines hear of it through mpirun, and so do those here once more: a session would take that for another request.
        if (told_.empty() && processes.size() < processes_of_run_ && signal_ == kEndWellSignal) kill(mpirun_, signal_);
        kill(process, signal_);
        told_.insert(process);
    }
}

void Shutdown::look() {
    const Clock::time_point now = Clock::now();
    if (!asked_ || now < next_look_) return;
    next_look_ = now + kBetweenLooks;
    const std::vector<pid_t> here = processes();
    if (killed_ || (insisted_ && now > insisted_at_ + kUntilKilled)) return kill_all();
    if (insisted_) return;

    tell(here);
    const auto is_told = [&](pid_t process) { return told_.contains(process); };
    const bool all_told = !told_.empty() && std::ranges::all_of(here, is_told);
    const bool stopped = std::ranges::any_of(here, is_stopped);
    if (here.size() >= told_.size() && !here.empty()) all_there_at_ = now;
    if ((!all_told || stopped) && now > asked_at_ + kUntilReady) return insist();
    if (now <= all_there_at_ + kAfterOthers) return;
    insisted_ = !here.empty();
    kill_all();
}

void Shutdown::kill_all() {
    killed_ = true;
    for (const pid_t process : descendants_of(getpid())) kill(process, SIGKILL);
}

// mpirun removes it itself, unless it is killed.
void Shutdown::remove_session() const {
    std::array<char, 256> name{};
    gethostname(name.data(), name.size() - 1);
    const std::string host = name.data();
    for (const char* variable : {"OMPI_MCA_orte_tmpdir_base", "TMPDIR", "TEMP", "TMP", ""}) {
        const char* folder = *variable == '\0' ? "/tmp" : std::getenv(variable);
        if (folder == nullptr) continue;
        for (const std::string& shown : {host, host.substr(0, host.find('.'))}) {
            std::error_code none;
            std::filesystem::remove_all(fmt::format("{}/ompi.{}.{}/pid.{}", folder, shown, geteuid(), mpirun_), none);
        }
    }
}

void Shutdown::clean_up() {
    const Clock::time_point end = Clock::now() + kUntilGone;
    bool left = true;
    while (left && Clock::now() < end) {
        kill_all();
        while (waitpid(-1, nullptr, WNOHANG) > 0) {
        }
        left = waitpid(-1, nullptr, WNOHANG) == 0 || errno == EINTR;
        if (left) std::this_thread::sleep_for(milliseconds(5));
    }
    remove_session();
}

}  // namespace meld::comm
