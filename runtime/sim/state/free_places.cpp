#include "runtime/sim/state/free_places.h"

#include <limits>
#include <optional>

#include "runtime/base/assert.h"

namespace meld::sim {

namespace {

// Catoms of one home follow each other.
struct Run {
    world::BrickKey home = 0;
    std::uint32_t count = 0;
};
constexpr std::size_t kRun_bytes = sizeof(world::BrickKey) + sizeof(std::uint32_t);
constexpr std::size_t kLink_bytes = sizeof(std::uint32_t) + 2;

}  // namespace

void FreePlaces::save(const world::Ensemble& ensemble, std::span<const world::Catom> catoms, std::span<const world::BrickKey> homes,
                      ByteWriter& out) {
    MELD_EXPECT(catoms.size() == homes.size(), "{} catoms, {} homes", catoms.size(), homes.size());
    std::vector<Run> runs;
    for (const world::BrickKey home : homes) {
        if (runs.empty() || runs.back().home != home) runs.push_back({home, 0});
        ++runs.back().count;
    }
    out.write_count(runs.size());
    for (const Run& run : runs) {
        out.write(run.home);
        out.write(run.count);
    }
    for (const world::Catom catom : catoms) {
        out.write(ensemble.id(catom));
        std::uint8_t count = 0;
        ByteWriter links;
        for (int port = 0; port < kMaxPorts; ++port) {
            const std::optional<world::Catom> other = ensemble.linked(catom, port);
            if (!other) continue;
            MELD_CHECK(ensemble.id(*other) <= std::numeric_limits<std::uint32_t>::max(), "catom @{} is linked", ensemble.id(*other));
            links.write(static_cast<std::uint32_t>(ensemble.id(*other)));
            links.write(static_cast<std::uint8_t>(port));
            links.write(static_cast<std::uint8_t>(ensemble.port_there(catom, port)));
            ++count;
        }
        out.write(count);
        out.write_bytes(links.view().data(), links.size());
    }
}

FreePlaces FreePlaces::read(ByteReader& in) {
    FreePlaces all;
    for (auto runs = in.read_count(kRun_bytes); runs > 0; --runs) {
        const auto home = in.read<world::BrickKey>();
        const auto count = in.read<std::uint32_t>();
        // Each catom takes some bytes of what follows.
        if (count > in.left()) break;
        all.homes_.insert(all.homes_.end(), count, home);
    }
    for (std::size_t i = 0; i < all.homes_.size(); ++i) {
        all.ids_.push_back(in.read<std::uint64_t>());
        all.first_link_.push_back(all.links_.size());
        for (auto links = in.read<std::uint8_t>(); links > 0 && in.left() >= kLink_bytes; --links) {
            Link& link = all.links_.emplace_back();
            link.other = in.read<std::uint32_t>();
            link.port = in.read<std::uint8_t>();
            link.port_there = in.read<std::uint8_t>();
        }
    }
    all.first_link_.push_back(all.links_.size());
    return all;
}

}  // namespace meld::sim
