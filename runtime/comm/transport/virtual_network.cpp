#include "runtime/comm/transport/virtual_network.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "runtime/base/assert.h"

namespace meld::comm {

namespace {

// A message is seen after fewer steps than this.
constexpr std::uint64_t kLongestWay = 40;
// What is true is noticed once in so many looks.
constexpr std::uint64_t kLooks = 3;

}  // namespace

VirtualNetwork::VirtualNetwork(const ClusterOptions& options)
    : processes(options.processes),
      scheduler(options),
      barriers(static_cast<std::size_t>(processes)),
      meetings(static_cast<std::size_t>(processes)),
      channels_(static_cast<std::size_t>(processes) * static_cast<std::size_t>(processes)),
      begun_(static_cast<std::size_t>(processes)) {
    for (auto& each : offers) each.resize(static_cast<std::size_t>(processes));
}

void VirtualNetwork::begin_operation(int process, const std::string& name) {
    const std::uint64_t number = begun_[static_cast<std::size_t>(process)]++;
    const std::size_t at = number - known_;
    if (at == names_.size()) names_.push_back(name);
    if (names_[at] != name) scheduler.break_with(fmt::format("a process calls {} while another one calls {}", name, names_[at]));
    const std::uint64_t all = std::ranges::min(begun_);
    for (; known_ < all; ++known_) names_.pop_front();
    scheduler.note_progress();
    scheduler.hand_over(process);
}

// A send that is not synchronous may be complete at once, because the library has copied it, or with its receipt: programs must not rely
// on either.
void VirtualTransport::send(std::span<const std::byte> bytes, int to, int tag, Kind kind) {
    auto message = std::make_shared<VirtualNetwork::Message>();
    message->tag = tag;
    message->bytes = bytes;
    message->seen_from = network_.scheduler.now() + network_.scheduler.draw(kLongestWay);
    message->complete = kind == Kind::Standard && network_.scheduler.draw(2) == 0;
    if (message->complete) {
        message->kept.assign(bytes.begin(), bytes.end());
        message->bytes = message->kept;
    } else {
        sent_.push_back(message);
    }
    network_.channel(process_, to).push_back(std::move(message));
    network_.scheduler.note_progress();
    network_.scheduler.hand_over(process_);
}

void VirtualTransport::receive(std::span<std::byte> bytes, int from, int tag) { wanted_.push_back({bytes, from, tag}); }

std::shared_ptr<VirtualNetwork::Message> VirtualTransport::first(int from, int tag) const {
    for (const auto& message : network_.channel(from, process_)) {
        if (message->tag != tag) continue;
        return message->seen_from <= network_.scheduler.now() ? message : nullptr;
    }
    return nullptr;
}

void VirtualTransport::remove(int from, const std::shared_ptr<VirtualNetwork::Message>& message) {
    VirtualNetwork::Channel& channel = network_.channel(from, process_);
    channel.erase(std::ranges::find(channel, message));
    message->complete = true;
    network_.scheduler.note_progress();
}

bool VirtualTransport::complete() {
    for (std::size_t i = 0; i < wanted_.size(); ++i) {
        Wanted& w = wanted_[i];
        const auto like = [&](const Wanted& other) { return !other.complete && other.from == w.from && other.tag == w.tag; };
        if (w.complete || std::any_of(wanted_.begin(), wanted_.begin() + static_cast<std::ptrdiff_t>(i), like)) continue;
        const auto message = first(w.from, w.tag);
        if (!message) continue;
        if (message->bytes.size() > w.bytes.size())
            network_.scheduler.break_with(fmt::format("process {} has room for {} bytes of process {}, which sends {}", process_,
                                                      w.bytes.size(), w.from, message->bytes.size()));
        std::ranges::copy(message->bytes, w.bytes.begin());
        remove(w.from, message);
        w.complete = true;
    }
    const bool all = std::ranges::all_of(wanted_, &Wanted::complete) &&
                     std::ranges::all_of(sent_, [](const auto& message) { return message->complete; });
    if (!all || network_.scheduler.draw(kLooks) != 0) return false;
    wanted_.clear();
    sent_.clear();
    network_.scheduler.note_progress();
    return true;
}

std::optional<Packet> VirtualTransport::take(int tag) {
    if (network_.scheduler.draw(kLooks) != 0) return std::nullopt;
    const auto begin = static_cast<int>(network_.scheduler.draw(static_cast<std::uint64_t>(processes())));
    for (int i = 0; i < processes(); ++i) {
        const int from = (begin + i) % processes();
        const auto message = first(from, tag);
        if (!message) continue;
        Packet packet{from, {message->bytes.begin(), message->bytes.end()}};
        remove(from, message);
        return packet;
    }
    return std::nullopt;
}

void VirtualTransport::begin_barrier() {
    ++network_.barriers[static_cast<std::size_t>(process_)];
    network_.scheduler.note_progress();
}

bool VirtualTransport::barrier_is_over() {
    const std::uint64_t mine = network_.barriers[static_cast<std::size_t>(process_)];
    if (std::ranges::min(network_.barriers) < mine || network_.scheduler.draw(kLooks) != 0) return false;
    network_.scheduler.note_progress();
    return true;
}

std::vector<std::vector<std::byte>> VirtualTransport::meet(std::span<const std::byte> offer) {
    const std::uint64_t meeting = network_.meetings[static_cast<std::size_t>(process_)]++;
    auto& offers = network_.offers[meeting % 2];
    offers[static_cast<std::size_t>(process_)].assign(offer.begin(), offer.end());
    network_.scheduler.note_progress();
    // Nobody is two meetings ahead, so nobody offers there anew before all have looked.
    while (std::ranges::min(network_.meetings) <= meeting) pause();
    const std::vector<std::vector<std::byte>> all = offers;
    pause();
    return all;
}

void VirtualTransport::swap_words(std::span<const std::uint64_t> mine, std::span<std::uint64_t> theirs) {
    const auto all = meet(std::as_bytes(mine));
    for (std::size_t from = 0; from < all.size(); ++from)
        std::memcpy(&theirs[from], all[from].data() + static_cast<std::size_t>(process_) * sizeof(std::uint64_t), sizeof(std::uint64_t));
}

}  // namespace meld::comm
