#include "runtime/comm/transport/cluster_scheduler.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/random.h"
#include "runtime/comm/transport/threads.h"

namespace meld::comm {

namespace {

// For so many steps processes keep their speed, of which one may be this many times another.
constexpr std::uint64_t kStepsOfASpeed = 50;
constexpr std::uint64_t kSpeeds = 6;
// A message is seen after some steps of its reader, so who waits so long waits for ever.
constexpr std::uint64_t kIdleStepsEach = 20'000;

enum Use : std::uint64_t { kOfDraw = 1, kOfTurn, kOfSpeed };

}  // namespace

ClusterScheduler::ClusterScheduler(const ClusterOptions& options)
    : options_(options), woken_(static_cast<std::size_t>(options.processes)), there_(static_cast<std::size_t>(options.processes), true) {
    turn_ = next();
}

std::uint64_t ClusterScheduler::draw(std::uint64_t limit) { return random_bits(options_.seed, kOfDraw, draws_++, 0) % limit; }

// The speed of a process is a power of two, so that one is often far ahead of another.
int ClusterScheduler::next() {
    std::uint64_t sum = 0;
    const auto speed = [&](std::size_t process) {
        if (!there_[process]) return std::uint64_t{0};
        return std::uint64_t{1} << random_bits(options_.seed, kOfSpeed, steps_ / kStepsOfASpeed, process) % kSpeeds;
    };
    for (std::size_t process = 0; process < there_.size(); ++process) sum += speed(process);
    if (sum == 0) return -1;
    std::uint64_t drawn = random_bits(options_.seed, kOfTurn, steps_, 0) % sum;
    std::size_t process = 0;
    while (drawn >= speed(process)) drawn -= speed(process++);
    return static_cast<int>(process);
}

void ClusterScheduler::wait_for_turn(std::unique_lock<std::mutex>& lock, int process) {
    woken_[static_cast<std::size_t>(process)].wait(lock, [&] { return turn_ == process || failed_; });
    if (failed_) throw OtherProcessFailed();
}

void ClusterScheduler::begin(int process) {
    std::unique_lock lock(mutex_);
    wait_for_turn(lock, process);
}

void ClusterScheduler::end(int process) {
    const std::lock_guard lock(mutex_);
    there_[static_cast<std::size_t>(process)] = false;
    note_progress();
    turn_ = next();
    if (turn_ >= 0) woken_[static_cast<std::size_t>(turn_)].notify_one();
}

void ClusterScheduler::hand_over(int process) {
    std::unique_lock lock(mutex_);
    if (failed_) throw OtherProcessFailed();
    MELD_EXPECT(turn_ == process, "process {} acts in the turn of process {}", process, turn_);
    ++steps_;
    trace_ = random_bits(trace_, steps_, static_cast<std::uint64_t>(process), draws_);
    if (steps_ == options_.kill_at_step) {
        killed_ = process;
        throw ProcessKilled();
    }
    if (++idle_steps_ > kIdleStepsEach * there_.size()) {
        lock.unlock();
        break_with(fmt::format("all processes wait for each other since step {}", steps_ - idle_steps_));
    }
    turn_ = next();
    if (turn_ == process) return;
    woken_[static_cast<std::size_t>(turn_)].notify_one();
    wait_for_turn(lock, process);
}

void ClusterScheduler::fail(std::exception_ptr failure) {
    const std::lock_guard lock(mutex_);
    if (!failed_) failure_ = std::move(failure);
    failed_ = true;
    for (std::condition_variable& each : woken_) each.notify_all();
}

void ClusterScheduler::break_with(const std::string& what) {
    fail(std::make_exception_ptr(std::logic_error(what)));
    std::rethrow_exception(failure_);
}

ClusterRun ClusterScheduler::outcome() const {
    if (failure_ && killed_ < 0) std::rethrow_exception(failure_);
    return {steps_, trace_, killed_};
}

}  // namespace meld::comm
