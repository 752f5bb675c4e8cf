#include "runtime/results/record/drawing.h"

#include <algorithm>
#include <numeric>

#include "runtime/base/bytes.h"
#include "runtime/base/process/liveness.h"
#include "runtime/comm/transport/gather_to_root.h"
#include "runtime/results/record/joint_table.h"

namespace meld::record {

std::optional<std::size_t> Drawn::find(u64 id) const {
    const auto found = std::ranges::lower_bound(ids, id);
    if (found == ids.end() || *found != id) return std::nullopt;
    return static_cast<std::size_t>(found - ids.begin());
}

std::array<double, 4> Drawn::turn(std::size_t at) const {
    return !rounded.empty() ? rounded[at].turn : !turns.empty() ? turns[at] : std::array<double, 4>{1, 0, 0, 0};
}

world::Vec3 tail_position(const sim::Subdomain& subdomain, sim::Catom catom) {
    const world::Ensemble& ensemble = subdomain.ensemble;
    return ensemble.has_amoebots() ? subdomain.lattice.position(ensemble.tail(catom)) : ensemble.position(catom);
}

Result<void> Drawing::start(sim::Subdomain& subdomain) {
    appearance_.start(subdomain.program_actions);
    return {};
}

Result<void> Drawing::after(sim::Subdomain& subdomain) {
    appearance_.collect(subdomain);
    return {};
}

void Drawing::save_rest(const sim::Subdomain& subdomain, ByteWriter& out) const {
    const bool keeps = subdomain.comm.process() == 0;
    out.write(keeps);
    appearance_.save(keeps, out);
}

Result<void> Drawing::load_rest(sim::Subdomain& subdomain, ByteReader& in) {
    const bool kept = in.read<bool>();
    Appearance others;
    (subdomain.comm.process() == 0 ? appearance_ : others).load(kept, in);
    in.read_bytes(in.left());
    return {};
}

void Drawing::begin(const sim::Subdomain& subdomain, std::size_t most, Drawn& drawn) {
    drawn.ids.reserve(most);
    drawn.positions.reserve(most);
    if (subdomain.has_diameters()) drawn.diameters.reserve(most);
    if (subdomain.has_rounded()) drawn.rounded.reserve(most);
    if (subdomain.has_turns() && !subdomain.has_rounded()) drawn.turns.reserve(most);
    if (subdomain.ensemble.has_amoebots()) drawn.tails.reserve(most);
    drawn.colours.reserve(most);
    if (appearance_.labels()) drawn.labels.reserve(most);
}

void Drawing::add(const sim::Subdomain& subdomain, const DrawnRow& row, Drawn& drawn) const {
    liveness::beat();
    drawn.ids.push_back(row.id);
    drawn.positions.push_back(row.position);
    if (subdomain.has_diameters()) drawn.diameters.push_back(row.diameter);
    if (subdomain.has_rounded())
        drawn.rounded.push_back(row.rounded);
    else if (subdomain.has_turns())
        drawn.turns.push_back(row.rounded.turn);
    if (subdomain.ensemble.has_amoebots()) drawn.tails.push_back(row.tail);
    drawn.colours.push_back(appearance_.colour(row.id));
    if (appearance_.labels()) drawn.labels.push_back(appearance_.label(row.id));
}

Drawing::DrawnRow Drawing::row_of(const sim::Subdomain& subdomain, sim::Catom catom) {
    const world::Vec3 position = subdomain.ensemble.position(catom);
    return {subdomain.ensemble.id(catom), position, subdomain.ensemble.has_amoebots() ? tail_position(subdomain, catom) : position,
            subdomain.diameter(catom), subdomain.rounded(catom)};
}

// Nothing is sent, and in most runs catoms stand in the order of their numbers.
void Drawing::draw_own(const sim::Subdomain& subdomain, Drawn& drawn) {
    ByteWriter out;
    appearance_.send(out);
    appearance_.begin_step();
    ByteReader in(out.view(), "what is drawn on a process");
    appearance_.receive(in);
    std::vector<sim::Catom> catoms;
    catoms.reserve(subdomain.ensemble.owned_count());
    for (sim::Catom c = 0; c < subdomain.ensemble.index_count(); ++c)
        if (subdomain.owned(c)) catoms.push_back(c);
    const auto id_of = [&](sim::Catom c) { return subdomain.ensemble.id(c); };
    if (!std::ranges::is_sorted(catoms, {}, id_of)) std::ranges::sort(catoms, {}, id_of);
    begin(subdomain, catoms.size(), drawn);
    for (const sim::Catom c : catoms) add(subdomain, row_of(subdomain, c), drawn);
}

// Process 0 gets all that the others send, and the others nothing.
void Drawing::draw_all(sim::Subdomain& subdomain, Drawn& drawn) {
    ByteWriter out;
    out.reserve(subdomain.ensemble.owned_count() * sizeof(DrawnRow));
    appearance_.send(out);
    for (sim::Catom c = 0; c < subdomain.ensemble.index_count(); ++c) {
        liveness::beat();
        if (subdomain.owned(c)) out.write(row_of(subdomain, c));
    }
    std::vector<std::vector<std::byte>> all;
    std::vector<comm::Packet> packets;
    if (subdomain.comm.process() == 0)
        all.push_back(out.take());
    else
        packets.push_back({.process = 0, .bytes = out.take()});
    for (comm::Packet& packet : subdomain.comm.exchange(std::move(packets))) all.push_back(std::move(packet.bytes));
    if (subdomain.comm.process() != 0) return;

    std::vector<DrawnRow> rows;
    appearance_.begin_step();
    for (const auto& part : all) {
        ByteReader in(part, "what is drawn on a process");
        appearance_.receive(in);
        while (!in.done()) rows.push_back(in.read<DrawnRow>());
    }
    std::ranges::sort(rows, {}, &DrawnRow::id);
    begin(subdomain, rows.size(), drawn);
    for (const DrawnRow& row : rows) add(subdomain, row, drawn);
}

bool Drawing::draws_cells_only(const sim::Subdomain& subdomain) const {
    return !subdomain.ensemble.is_free() && !subdomain.ensemble.has_amoebots() && !subdomain.has_diameters() && !subdomain.has_turns() &&
           !subdomain.has_joints() && !appearance_.labels() && !appearance_.lines();
}

void Drawing::catch_up(sim::Subdomain& subdomain) {
    ByteWriter out;
    appearance_.send(out);
    appearance_.begin_step();
    for (const auto& part : comm::gather_to_root(subdomain.comm, out.take())) {
        ByteReader in(part, "what is drawn on a process");
        appearance_.receive(in);
    }
}

Drawn Drawing::drawn(sim::Subdomain& subdomain) {
    Drawn drawn;
    if (subdomain.alone())
        draw_own(subdomain, drawn);
    else
        draw_all(subdomain, drawn);
    drawn.joints = all_joints(subdomain);
    if (subdomain.comm.process() != 0) return drawn;
    for (const auto& [from, to] : appearance_.drawn()) {
        const auto a = drawn.find(from), b = drawn.find(to);
        if (a && b) drawn.lines.emplace_back(*a, *b);
    }
    return drawn;
}

}  // namespace meld::record
