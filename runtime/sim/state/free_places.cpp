#include "runtime/sim/state/free_places.h"

#include <cstring>
#include <limits>
#include <optional>

#include "runtime/base/assert.h"
#include "runtime/sim/state/reading.h"

namespace meld::sim {

namespace {

constexpr std::size_t kHome_bytes = sizeof(world::BrickKey) + sizeof(std::uint32_t);

// Numbers that are small, unless a catom may have any number of links.
template <class T>
void write_narrow(const std::vector<std::uint32_t>& all, ByteWriter& out) {
    for (const std::uint32_t each : all) out.write(static_cast<T>(each));
}

template <class T>
void write_all(const std::vector<T>& all, ByteWriter& out) {
    out.write_bytes(all.data(), all.size() * sizeof(T));
}

// So many of them; zeros if the bytes end too early.
template <class T>
std::vector<T> read_all(std::size_t count, ByteReader& in) {
    const std::span<const std::byte> bytes = in.read_bytes(count * sizeof(T));
    std::vector<T> all(bytes.size() / sizeof(T));
    if (!bytes.empty()) std::memcpy(all.data(), bytes.data(), bytes.size());
    return all;
}

std::uint32_t number(const world::Ensemble& ensemble, world::Catom catom) {
    const std::uint64_t id = ensemble.id(catom);
    MELD_CHECK(id <= std::numeric_limits<std::uint32_t>::max(), "catom @{} is at an arbitrary position", id);
    return static_cast<std::uint32_t>(id);
}

}  // namespace

void FreePlaces::save(const world::Ensemble& ensemble, const std::optional<Nodes>& nodes, std::span<const world::Catom> catoms,
                      std::span<const world::BrickKey> homes, ByteWriter& out) {
    MELD_EXPECT(catoms.size() == homes.size(), "{} catoms, {} homes", catoms.size(), homes.size());
    std::vector<Home> runs;
    for (const world::BrickKey home : homes) {
        if (runs.empty() || runs.back().home != home) runs.push_back({home, 0});
        ++runs.back().count;
    }
    out.write_count(runs.size());
    for (const Home& run : runs) {
        out.write(run.home);
        out.write(run.count);
    }
    std::vector<std::uint32_t> ids, others, counts, ports, ports_there;
    ids.reserve(catoms.size()), counts.reserve(catoms.size());
    for (const world::Catom catom : catoms) {
        ids.push_back(nodes ? *nodes->find(ensemble.id(catom)) : number(ensemble, catom));
        const std::size_t before = others.size();
        const auto add = [&](int port, world::Catom other) {
            if (number(ensemble, other) < ids.back()) return;
            others.push_back(number(ensemble, other));
            ports.push_back(static_cast<std::uint32_t>(port));
            ports_there.push_back(static_cast<std::uint32_t>(ensemble.port_there(catom, port)));
        };
        if (!ensemble.is_graph()) ensemble.each_link(catom, add);
        counts.push_back(static_cast<std::uint32_t>(others.size() - before));
    }
    const bool wide = ensemble.has_any_ports() && !ensemble.is_graph();
    const auto write_numbers = [&](const std::vector<std::uint32_t>& all) {
        wide ? write_all(all, out) : write_narrow<std::uint8_t>(all, out);
    };
    out.write(wide);
    write_all(ids, out), write_numbers(counts);
    write_all(others, out), write_numbers(ports), write_numbers(ports_there);
}

Result<FreePlaces> FreePlaces::read(ByteReader& in) {
    FreePlaces all;
    all.homes_.resize(in.read_count(kHome_bytes));
    std::uint64_t catoms = 0;
    for (Home& run : all.homes_) {
        run.home = in.read<world::BrickKey>();
        run.count = in.read<std::uint32_t>();
        catoms += run.count;
    }
    const bool wide = in.read<std::uint8_t>() != 0;
    const auto read_numbers = [&](std::size_t count) {
        if (wide) return read_all<std::uint32_t>(count, in);
        const auto narrow = read_all<std::uint8_t>(count, in);
        return std::vector<std::uint32_t>(narrow.begin(), narrow.end());
    };
    // Each catom takes some bytes of what follows.
    if (catoms > in.left()) return damaged("has more bodies than bytes");
    all.ids_ = read_all<std::uint32_t>(catoms, in);
    const auto counts = read_numbers(catoms);
    all.first_link_.resize(counts.size() + 1);
    for (std::size_t i = 0; i < counts.size(); ++i) all.first_link_[i + 1] = all.first_link_[i] + counts[i];
    const std::size_t links = all.first_link_.back();
    const auto others = read_all<std::uint32_t>(links, in);
    const auto ports = read_numbers(links), ports_there = read_numbers(links);
    if (in.failed()) return damaged("ends in the midst of its links");
    all.links_.resize(links);
    for (std::size_t i = 0; i < links; ++i) all.links_[i] = {others[i], ports[i], ports_there[i]};
    return all;
}

}  // namespace meld::sim
