// Everything that the handlers use is atomic without locks, and they call only functions that POSIX lists as safe in handlers.
#include "runtime/base/process/interrupt.h"

#include <fmt/format.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstring>

#include "runtime/base/assert.h"
#include "runtime/base/error.h"
#include "runtime/base/process/liveness.h"
#include "runtime/base/temporary_files.h"

namespace meld::interrupt {

namespace {

// The signal of the timers, which nobody else uses here; as a cause it means that the time is up.
constexpr int kTimer = SIGALRM;
enum Timer : int { kPatienceEnds, kTimeIsUp };
constexpr std::int64_t kNanoseconds = 1'000'000'000;

std::atomic<int> first{0};
std::atomic<std::int64_t> first_ns{0};
std::atomic<Answer> answer{Answer::AtOnce};
std::atomic<const char*> last_words{nullptr};
std::atomic<void (*)()> last_step{nullptr};
std::atomic<std::uint64_t> repeated_signals{0};  // A bit for each.
std::atomic<bool> by_signal{false};
timer_t patience;
timer_t time_limit;
std::array<char, 200> words_when_time_is_up{};
std::atomic<bool> handling{false};
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<std::int64_t>::is_always_lock_free &&
              std::atomic<Answer>::is_always_lock_free && std::atomic<const char*>::is_always_lock_free &&
              std::atomic<void (*)()>::is_always_lock_free);

std::int64_t now_ns() {
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return now.tv_sec * kNanoseconds + now.tv_nsec;
}

int code_after(int signal) {
    if (signal == kTimer) return static_cast<int>(ExitCode::LimitHit);
    return signal == SIGTERM ? 128 + SIGTERM : static_cast<int>(ExitCode::Interrupted);
}

void set_waiting(int how, std::initializer_list<int> signals) {
    sigset_t set;
    sigemptyset(&set);
    for (const int signal : signals) sigaddset(&set, signal);
    pthread_sigmask(how, &set, nullptr);
}

[[noreturn]] void leave(int signal) {
    Leftover::remove_all();
    if (void (*const step)() = last_step.load(); step != nullptr) step();
    const char* words = last_words.load();
    if (words != nullptr && signal == kTimer) words = words_when_time_is_up.data();
    // Where standard error takes nothing, nobody can be told.
    if (words != nullptr && ::write(STDERR_FILENO, words, std::strlen(words)) < 0) errno = 0;
    if (words != nullptr) liveness::note_told();
    if (by_signal.load() && signal != kTimer) {
        std::signal(signal, SIG_DFL);
        set_waiting(SIG_UNBLOCK, {signal});
        ::raise(signal);
    }
    ::_exit(code_after(signal));
}

// 0 seconds: never.
void set(timer_t timer, double seconds) {
    const auto ns = static_cast<std::int64_t>(seconds * static_cast<double>(kNanoseconds));
    itimerspec after{};
    after.it_value = {.tv_sec = ns / kNanoseconds, .tv_nsec = ns % kNanoseconds};
    timer_settime(timer, 0, &after, nullptr);
}

void arm() { set(patience, kPatience_s); }

void on_interrupt(int signal) {
    const int before_errno = errno;
    int none = 0;
    const bool is_first = first.compare_exchange_strong(none, signal);
    const Answer now = answer.load();
    if (!is_first && (repeated_signals.load() >> signal & 1) != 0) return;
    if (!is_first) leave(first.load());
    if (now == Answer::AtOnce) leave(signal);
    first_ns.store(now_ns());
    if (now == Answer::Soon) arm();
    errno = before_errno;
}

void on_timer(int, siginfo_t* information, void*) {
    if (information->si_value.sival_int == kTimeIsUp) {
        // Whoever has been told to end is at it.
        if (first.load() == 0) on_interrupt(kTimer);
    } else if (answer.load() == Answer::Soon) {
        leave(first.load());
    }
}

void make(Timer which, timer_t& timer) {
    sigevent event{};
    event.sigev_notify = SIGEV_SIGNAL;
    event.sigev_signo = kTimer;
    event.sigev_value.sival_int = which;
    MELD_CHECK(timer_create(CLOCK_MONOTONIC, &event, &timer) == 0, "no timer: {}", std::strerror(errno));
}

}  // namespace

bool is_ignored(int signal) {
    struct sigaction action{};
    sigaction(signal, nullptr, &action);
    return action.sa_handler == SIG_IGN;
}

void handle(std::initializer_list<int> signals, std::initializer_list<int> repeated) {
    MELD_CHECK(!handling.exchange(true), "interrupts are handled already");
    for (const int signal : repeated) repeated_signals.fetch_or(std::uint64_t{1} << signal);
    make(kPatienceEnds, patience);
    make(kTimeIsUp, time_limit);
    struct sigaction action{};
    // Interrupted calls go on by themselves: whoever polls asks received().
    action.sa_flags = SA_RESTART | SA_SIGINFO;
    action.sa_sigaction = on_timer;
    sigaction(kTimer, &action, nullptr);
    action.sa_flags = SA_RESTART;
    action.sa_handler = on_interrupt;
    for (const int signal : signals)
        if (!is_ignored(signal)) sigaction(signal, &action, nullptr);
    set_waiting(SIG_UNBLOCK, signals);
}

void hold(std::initializer_list<int> signals) { set_waiting(SIG_BLOCK, signals); }

void end_by_signal() { by_signal.store(true); }

void set_last_words(const char* words) {
    last_words.store(words);
    if (words == nullptr) liveness::note_told();
}

void set_last_step(void (*step)()) { last_step.store(step); }

int received() { return first.load(std::memory_order_relaxed); }

bool forget_request() {
    const int signal = received();
    if (signal == SIGTERM || signal == SIGHUP || signal == kTimer) return false;
    first.store(0);
    return true;
}

int exit_code() { return code_after(received()); }

TimeLimit::TimeLimit(std::string_view name, double seconds) {
    MELD_CHECK(handling.load() && seconds > 0, "{} seconds", seconds);
    const auto end = fmt::format_to_n(words_when_time_is_up.data(), words_when_time_is_up.size() - 1,
                                      "{}: the time limit of {} s has passed. Raise --timeout\n", name, seconds);
    *end.out = '\0';
    // A limit that rounds to no time at all is still one.
    set(time_limit, std::max(seconds, 1e-6));
}

TimeLimit::~TimeLimit() { set(time_limit, 0); }

bool time_is_up() { return received() == kTimer; }

bool overdue() {
    if (received() == 0 || answer.load(std::memory_order_relaxed) != Answer::Soon) return false;
    const std::int64_t since = first_ns.load();
    return since != 0 && now_ns() - since > static_cast<std::int64_t>(kStep_s * static_cast<double>(kNanoseconds));
}

Answering::Answering(Answer now) : before_(answer.exchange(now)) {
    if (received() == 0) return;
    // It came while another answer was in force.
    if (now == Answer::AtOnce) leave(received());
    if (now == Answer::Soon) arm();
}

Answering::~Answering() {
    answer.store(before_);
    if (received() != 0 && before_ == Answer::Soon) arm();
}

Undivided::Undivided() : had_received_(received() != 0), before_(answer.exchange(Answer::Patiently)) {}

Undivided::~Undivided() {
    answer.store(before_);
    if (had_received_ || received() == 0) return;
    if (before_ == Answer::AtOnce) leave(received());
    if (before_ == Answer::Soon) arm();
}

}  // namespace meld::interrupt
