// Everything that the handlers use is atomic without locks, and they call only functions that POSIX lists as safe in handlers.
#include "runtime/base/interrupt.h"

#include <time.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstring>

#include "runtime/base/assert.h"
#include "runtime/base/error.h"
#include "runtime/base/leftovers.h"

namespace meld::interrupt {

namespace {

// Fires when the patience ends. A timer of this process, with a signal that nothing else uses here.
constexpr int kPatienceEnds = SIGALRM;
constexpr std::int64_t kNanoseconds = 1'000'000'000;

std::atomic<int> first{0};
std::atomic<std::int64_t> first_ns{0};
std::atomic<Answer> answer{Answer::AtOnce};
std::atomic<const char*> last_words{nullptr};
std::atomic<int> repeated_signal{0};
std::atomic<bool> by_signal{false};
timer_t patience;
std::atomic<bool> handling{false};
static_assert(std::atomic<int>::is_always_lock_free && std::atomic<std::int64_t>::is_always_lock_free &&
              std::atomic<Answer>::is_always_lock_free && std::atomic<const char*>::is_always_lock_free);

std::int64_t now_ns() {
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return now.tv_sec * kNanoseconds + now.tv_nsec;
}

int code_after(int signal) { return signal == SIGTERM ? 128 + SIGTERM : static_cast<int>(ExitCode::Interrupted); }

[[noreturn]] void leave(int signal) {
    Leftover::remove_all();
    const char* words = last_words.load();
    // If standard error cannot be written, there is nowhere to report it.
    if (words != nullptr && ::write(STDERR_FILENO, words, std::strlen(words)) < 0) errno = 0;
    if (by_signal.load()) {
        std::signal(signal, SIG_DFL);
        sigset_t only;
        sigemptyset(&only);
        sigaddset(&only, signal);
        pthread_sigmask(SIG_UNBLOCK, &only, nullptr);
        ::raise(signal);
    }
    ::_exit(code_after(signal));
}

void arm() {
    constexpr auto ns = static_cast<std::int64_t>(kPatience_s * static_cast<double>(kNanoseconds));
    itimerspec after{};
    after.it_value = {.tv_sec = ns / kNanoseconds, .tv_nsec = ns % kNanoseconds};
    timer_settime(patience, 0, &after, nullptr);
}

void on_interrupt(int signal) {
    const int before_errno = errno;
    int none = 0;
    const bool is_first = first.compare_exchange_strong(none, signal);
    const Answer now = answer.load();
    if (!is_first && signal == repeated_signal.load()) return;
    if (!is_first) leave(first.load());
    if (now == Answer::AtOnce) leave(signal);
    first_ns.store(now_ns());
    if (now == Answer::Soon) arm();
    errno = before_errno;
}

void on_end_of_patience(int) {
    if (answer.load() == Answer::Soon) leave(first.load());
}

}  // namespace

void handle(std::initializer_list<int> signals, int repeated) {
    MELD_CHECK(!handling.exchange(true), "interrupts are handled already");
    repeated_signal.store(repeated);
    sigevent event{};
    event.sigev_notify = SIGEV_SIGNAL;
    event.sigev_signo = kPatienceEnds;
    MELD_CHECK(timer_create(CLOCK_MONOTONIC, &event, &patience) == 0, "no timer: {}", std::strerror(errno));
    struct sigaction action{};
    // Interrupted calls resume by themselves: code that polls asks received().
    action.sa_flags = SA_RESTART;
    action.sa_handler = on_end_of_patience;
    sigaction(kPatienceEnds, &action, nullptr);
    action.sa_handler = on_interrupt;
    for (const int signal : signals) {
        struct sigaction before{};
        sigaction(signal, nullptr, &before);
        if (before.sa_handler != SIG_IGN) sigaction(signal, &action, nullptr);
    }
}

void end_by_signal() { by_signal.store(true); }

void set_last_words(const char* words) { last_words.store(words); }

int received() { return first.load(std::memory_order_relaxed); }

int exit_code() { return code_after(received()); }

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
