#include "runtime/show/view/mailbox.h"

#include <algorithm>
#include <utility>

namespace meld::view {

namespace {

constexpr std::size_t kMostRequests = 32;
// Of what is not written yet. One more answer may come on top, whatever its size.
constexpr std::size_t kMostWaiting_bytes = std::size_t{1} << 20;

std::size_t size_of(const Sent& sent) { return sent.text.size() + sent.binary.size(); }

}  // namespace

bool Mailbox::put(Request request) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return closed_ || requests_.size() < kMostRequests; });
    if (closed_) return false;
    requests_.push_back(std::move(request));
    return true;
}

std::optional<Mailbox::Request> Mailbox::take() {
    const std::lock_guard lock(mutex_);
    if (closed_ || requests_.empty() || waiting_bytes_ > kMostWaiting_bytes) return std::nullopt;
    Request request = std::move(requests_.front());
    requests_.pop_front();
    changed_.notify_all();
    return request;
}

void Mailbox::send(Sent sent) {
    const std::lock_guard lock(mutex_);
    if (closed_) return;
    if (!sent.kind.empty()) {
        const auto old = std::ranges::find(to_write_, sent.kind, &Sent::kind);
        if (old != to_write_.end()) {
            waiting_bytes_ -= size_of(*old);
            to_write_.erase(old);
        }
    }
    waiting_bytes_ += size_of(sent);
    to_write_.push_back(std::move(sent));
    changed_.notify_all();
}

std::optional<Sent> Mailbox::next_to_write() {
    std::unique_lock lock(mutex_);
    waiting_bytes_ -= std::exchange(writing_bytes_, 0);
    changed_.wait(lock, [&] { return closed_ || !to_write_.empty(); });
    if (closed_) return std::nullopt;
    Sent sent = std::move(to_write_.front());
    to_write_.pop_front();
    writing_bytes_ = size_of(sent);
    return sent;
}

void Mailbox::close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    requests_.clear();
    to_write_.clear();
    changed_.notify_all();
}

}  // namespace meld::view
