// What a person would write by hand for one program alone: the gradient, exact under retraction, neighbours by geometry.
// A catom keeps its value, its rank and a candidate per port, as docs/benchmarks.md describes; retraction follows the same
// ranks and quarantine. It is the floor that the compiled program is measured against.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "runtime/module/abi/geometry_abi.h"
#include "runtime/world/ensemble/ensemble.h"

namespace meld::bench {

class HandGradient {
  public:
    explicit HandGradient(const world::Ensemble& ensemble)
        : g_(ensemble.geometry()), cells_(ensemble.index_count()), queued_((ensemble.index_count() + 63) / 64, 0) {}

    void set_source(std::uint32_t catom, bool on) {
        cells_[catom].source = on;
        mark(catom);
    }

    // Ticks until nothing is left to do; returns how many.
    std::int64_t settle() {
        const std::int64_t from = now_;
        while (pending_ > 0 || !wakes_.empty()) tick();
        return now_ - from;
    }

    std::uint32_t value(std::uint32_t catom) const { return cells_[catom].value; }
    std::uint64_t evaluations = 0;
    std::uint64_t changes = 0;
    std::size_t bytes() const { return cells_.capacity() * sizeof(Cell) + queued_.capacity() * 8; }

  private:
    static constexpr std::uint32_t kNone = 0xffffffff;
    struct Cell {
        std::uint32_t value = kNone, rank = kNone;
        bool source = false;
    };
    struct Loss {
        std::uint32_t least_rank;
        std::int64_t time;
    };
    struct Change {
        std::uint32_t catom, value, rank;
    };

    void mark(std::uint32_t catom) {
        std::uint64_t& word = queued_[catom / 64];
        const std::uint64_t bit = std::uint64_t{1} << (catom % 64);
        pending_ += (word & bit) == 0;
        word |= bit;
    }

    void tick() {
        ++now_;
        while (!wakes_.empty() && wakes_.begin()->first <= now_) {
            for (const std::uint32_t c : wakes_.begin()->second) mark(c);
            wakes_.erase(wakes_.begin());
        }
        changes_.clear();
        if (pending_ > 0)
            for (std::size_t w = 0; w < queued_.size(); ++w) {
                for (std::uint64_t bits = queued_[w]; bits != 0; bits &= bits - 1)
                    evaluate(static_cast<std::uint32_t>(w * 64 + static_cast<std::size_t>(__builtin_ctzll(bits))));
                queued_[w] = 0;
            }
        pending_ = 0;
        for (const Change& c : changes_) {
            Cell& cell = cells_[c.catom];
            cell.value = c.value;
            cell.rank = c.rank;
            const std::uint32_t site = g_.catom_site[c.catom];
            for (std::int32_t port = 0; port < g_.ports; ++port)
                if (const std::int32_t other = catom_towards(g_, site, port); other >= 0) mark(static_cast<std::uint32_t>(other));
        }
        changes += changes_.size();
    }

    void evaluate(std::uint32_t catom) {
        ++evaluations;
        const Cell own = cells_[catom];
        const std::uint32_t site = g_.catom_site[catom];
        bool supported = own.source && own.value == 0, superseded = own.source && own.value != 0;
        std::uint32_t value[kMaxPorts], rank[kMaxPorts];
        int n = 0;
        for (std::int32_t port = 0; port < g_.ports; ++port) {
            const std::int32_t other = catom_towards(g_, site, port);
            if (other < 0 || cells_[static_cast<std::size_t>(other)].value == kNone) continue;
            value[n] = cells_[static_cast<std::size_t>(other)].value + 1;
            rank[n] = cells_[static_cast<std::size_t>(other)].rank + 1;
            supported = supported || (value[n] == own.value && rank[n] <= own.rank);
            ++n;
        }
        auto lost = losses_.find(catom);
        const auto ready = [&](std::uint32_t r) -> std::int64_t {
            return lost == losses_.end() || r <= lost->second.least_rank ? 0 : lost->second.time + r - lost->second.least_rank + 2;
        };
        std::uint32_t best = kNone, best_rank = kNone;
        if (own.value != kNone) {
            for (int i = 0; i < n; ++i) superseded = superseded || (value[i] < own.value && ready(rank[i]) <= now_);
            if (supported) {
                best = own.value;
                best_rank = own.rank;
            } else if (!superseded) {
                lost = losses_.try_emplace(catom, Loss{own.rank, now_}).first;
                if (own.rank < lost->second.least_rank) lost->second.least_rank = own.rank;
                lost->second.time = now_;
            }
        }
        if (own.source && best != 0) {
            best = 0;
            best_rank = 0;
        }
        std::int64_t wake = 0;
        for (int i = 0; i < n; ++i) {
            const bool better = value[i] < best || (value[i] == best && best != own.value && rank[i] < best_rank);
            if (!better) continue;
            if (const std::int64_t at = ready(rank[i]); at > now_) {
                wake = wake == 0 || at < wake ? at : wake;
            } else {
                best = value[i];
                best_rank = rank[i];
            }
        }
        if (wake != 0) wakes_[wake].push_back(catom);
        if (best != own.value || best_rank != own.rank) changes_.push_back({catom, best, best_rank});
    }

    Geometry g_;
    std::vector<Cell> cells_;
    std::vector<std::uint64_t> queued_;
    std::size_t pending_ = 0;
    std::vector<Change> changes_;
    std::map<std::uint32_t, Loss> losses_;
    std::map<std::int64_t, std::vector<std::uint32_t>> wakes_;
    std::int64_t now_ = 0;
};

}  // namespace meld::bench
