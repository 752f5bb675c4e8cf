#include "runtime/results/record/load_map.h"

#include <utility>

namespace meld::record {

void LoadMap::send(const sim::Subdomain& subdomain, ByteWriter& out) const {
    const auto& left = subdomain.counts()->left();
    out.write_count(left.size());
    for (const auto& [id, load] : left) out.write(Total{id, {load.evaluations, load.messages().messages}});
}

LoadMap::Load LoadMap::here(const sim::Subdomain& subdomain, sim::Catom catom) {
    const eval::CatomSums sums = subdomain.counts()->sums(catom);
    return {sums.evaluations, sums.messages.messages};
}

void LoadMap::begin_step() {
    elsewhere_.clear();
    before_ = std::exchange(now_, {});
    now_.reserve(before_.size());
    next_ = 0;
    evaluations_.clear();
    messages_.clear();
}

void LoadMap::receive(ByteReader& in) {
    for (auto left = in.read_count(sizeof(Total)); left > 0; --left) {
        const auto total = in.read<Total>();
        Load& sum = elsewhere_[total.id];
        sum.evaluations += total.load.evaluations;
        sum.messages += total.load.messages;
    }
}

void LoadMap::add(std::uint64_t id, const Load& here) {
    Load total = here;
    if (const auto more = elsewhere_.find(id); more != elsewhere_.end()) {
        total.evaluations += more->second.evaluations;
        total.messages += more->second.messages;
    }
    now_.push_back({id, total});
    while (next_ < before_.size() && before_[next_].id < id) ++next_;
    const Load before = next_ < before_.size() && before_[next_].id == id ? before_[next_].load : Load{};
    evaluations_.push_back(static_cast<std::int64_t>(total.evaluations - before.evaluations));
    messages_.push_back(static_cast<std::int64_t>(total.messages - before.messages));
}

void LoadMap::list(std::vector<RecordedArray>& arrays) const {
    arrays.push_back({"load.evaluations", RecordedArray::Int64, evaluations_.data(), 1});
    arrays.push_back({"load.messages", RecordedArray::Int64, messages_.data(), 1});
}

}  // namespace meld::record
