// Who is linked with whom, as a table: for each catom a row of ports, and at each port a neighbour or nobody. A catom may have any number
// of ports. Kept where neighbours do not follow from geometry alone: for graphs, and where links are cut or take time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "runtime/base/large_array.h"
#include "runtime/base/prefetch.h"
#include "runtime/module/abi/geometry_abi.h"

namespace meld::world {

using Catom = std::uint32_t;  // An index on this process, not an id.
using Port = std::uint32_t;
// In tables of catoms: nobody is there.
inline constexpr std::int32_t kNobody = -1;

class Links {
  public:
    // apart: what a catom reads of its neighbours lies apart from them, in mailboxes, and somebody else says where (read_at). Otherwise it
    // is read in place.
    explicit Links(bool apart);

    // Memory for so many catoms and ports of all.
    void reserve(std::size_t catoms, std::size_t ports);
    // Gives a catom at least so many ports; the links at those it has stay. Cost: a copy of its row if it grows.
    void room(Catom catom, Port ports);
    // Links two catoms at a port of each that is vacant.
    void connect(Catom a, Port port_of_a, Catom b, Port port_of_b);
    // Removes the link at a port, on both sides.
    void disconnect(Catom catom, Port port);
    // All links of a catom go and are made anew, at the same ports.
    void renew(Catom catom);
    // Removes all links of a catom.
    void clear(Catom catom);

    Port ports(Catom catom) const { return catom < ports_.size() ? ports_[catom] : 0; }
    std::optional<Catom> at(Catom catom, Port port) const {
        const std::int32_t other = catom_[entry(catom, port)];
        return other < 0 ? std::nullopt : std::optional<Catom>(static_cast<Catom>(other));
    }
    Port port_there(Catom catom, Port port) const { return wide() ? there_wide_[entry(catom, port)] : there_[entry(catom, port)]; }
    // The lowest port without a link, or none.
    std::optional<Port> vacant(Catom catom) const;
    std::optional<Port> towards(Catom catom, Catom other) const;
    // Calls visit(port, neighbour), in the order of ports.
    template <class Visit>
    void each(Catom catom, const Visit& visit) const {
        for (Port port = 0, end = ports(catom); port < end; ++port)
            if (const std::int32_t other = catom_[entry(catom, port)]; other >= 0) visit(port, static_cast<Catom>(other));
    }

    // The same with the neighbour's port: visit(port, neighbour, port there).
    template <class Visit>
    void each_end(Catom catom, const Visit& visit) const {
        const Port end = ports(catom);
        if (end == 0) return;
        const std::size_t first = entry(catom, 0);
        const bool is_wide = wide();
        for (Port port = 0; port < end; ++port)
            if (const std::int32_t other = catom_[first + port]; other >= 0)
                visit(port, static_cast<Catom>(other), is_wide ? there_wide_[first + port] : Port{there_[first + port]});
    }

    // ---- where neighbours are read, if apart
    // A link was made or removed, as one of its ends sees it. A link that is made is read nowhere at first; one that is removed was read at
    // `read`, or nowhere (-1). Links of the start are read in place.
    struct Change {
        Catom reader;
        Port port;
        Catom other;
        std::int32_t read;
        bool made;
    };
    // What has changed since the last call, in order. Nothing the first time, when all links are those of the start, and if not apart.
    std::vector<Change> take_changes();
    bool has_changes() const { return !changes_.empty(); }
    void read_at(Catom catom, Port port, std::int32_t index) { read_[entry(catom, port)] = index; }
    std::int32_t read(Catom catom, Port port) const { return read_[entry(catom, port)]; }

    // ---- until when something is under way, if apart and somebody says so
    // From now on it is kept for each link and direction, at the port of the sender.
    void keep_last_arrivals() {
        keeps_last_ = true;
        last_.resize(catom_.size(), passed_);
    }
    // Those of a catom's links, by its ports, until links are made or removed.
    class LastArrivals {
      public:
        LastArrivals(std::uint16_t* last, std::int64_t now) : last_(last), now_(now) {}
        // How many ticks after `now` the latest arrives that was sent over a link; 0: all has arrived.
        std::int64_t ticks(Port port) const {
            const auto ticks = static_cast<std::int16_t>(last_[port] - static_cast<std::uint16_t>(now_));
            return ticks > 0 ? ticks : 0;
        }
        void set(Port port, std::int64_t ticks) { last_[port] = static_cast<std::uint16_t>(now_ + ticks); }

      private:
        std::uint16_t* last_;
        std::int64_t now_;
    };
    LastArrivals last_arrivals(Catom catom, std::int64_t now) { return {last_.data() + entry(catom, 0), now}; }
    // The tick in which the latest arrives that was sent over a link, if it is after `now`; otherwise `now`.
    std::int64_t last_arrival(Catom catom, Port port, std::int64_t now) const {
        const auto ticks = static_cast<std::int16_t>(last_[entry(catom, port)] - static_cast<std::uint16_t>(now));
        return ticks > 0 ? now + ticks : now;
    }
    void set_last_arrival(Catom catom, Port port, std::int64_t tick) { last_[entry(catom, port)] = static_cast<std::uint16_t>(tick); }
    // Where a run begins in a later tick than the first: nothing is under way.
    void begin_arrivals(std::int64_t now);
    // To be called at least every so many ticks, if nothing is longer under way: what has arrived before `now` is forgotten, so that it
    // never seems to be to come.
    static constexpr std::int64_t kForgetTicks = std::int64_t{1} << 14;
    void forget_arrivals(std::int64_t now);

    // ---- for loops over catoms that lie anywhere in memory: what they read soon is asked for ahead
    // The links of a catom.
    void ask_ahead(Catom catom) const {
        const std::size_t first = entry(catom, 0);
        ask_for(catom_.data() + first);
        if (wide())
            ask_for(there_wide_.data() + first);
        else
            ask_for(there_.data() + first);
        if (keeps_last_) ask_for(last_.data() + first);
    }
    // Where it reads over a link.
    void ask_ahead_read(Catom catom, Port port) const { ask_for(read_.data() + entry(catom, port)); }

    // Another one after each link that is made or removed.
    std::uint64_t version() const { return version_; }

    // Sets the arrays of the links form; they are those of catoms that have been given room. Valid until the table changes.
    void add_to(Geometry& g) const;
    std::size_t bytes() const;

  private:
    std::size_t entry(Catom catom, Port port) const { return (even_ > 0 ? std::size_t{catom} * even_ : std::size_t{first_[catom]}) + port; }
    static constexpr Port kNarrowPorts = Port{1} << 16;
    bool wide() const { return most_ > kNarrowPorts; }
    // Calls change(column) for the one of the two that is in use.
    template <class Change>
    void change_there(const Change& change) {
        if (wide())
            change(there_wide_);
        else
            change(there_);
    }
    void widen();
    void set(Catom catom, Port port, Catom other, Port there);
    void unset(Catom catom, Port port);
    void compact();

    bool apart_;
    LargeArray<std::uint32_t> first_, ports_;  // By catom.
    // By entry; rows that have grown leave theirs behind.
    LargeArray<std::int32_t> catom_;
    LargeArray<std::int32_t> read_;  // Only if apart: otherwise it would be the same as catom_.
    // One of the two: the first until some catom has more ports than its numbers can say.
    LargeArray<std::uint16_t> there_;
    LargeArray<std::uint32_t> there_wide_;
    LargeArray<std::uint16_t> last_;  // Ticks modulo 2^16; empty if nobody keeps them.
    std::uint16_t passed_ = 0;        // The tick of the last forget_arrivals(): nothing was sent over a link that is made after it.
    bool keeps_last_ = false;
    Port even_ = 0;  // All rows have so many ports and follow each other, so first_ need not be read; 0: they do not.
    std::size_t left_behind_ = 0;
    std::uint64_t version_ = 0;
    Port most_ = 0;
    std::vector<Change> changes_;
    bool at_start_ = true;  // Nobody has asked for changes yet.
};

}  // namespace meld::world
