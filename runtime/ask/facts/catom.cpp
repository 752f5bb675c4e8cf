#include "runtime/ask/facts/catom.h"

#include <algorithm>
#include <set>
#include <string_view>
#include <utility>

#include "runtime/base/bytes.h"
#include "runtime/engine/tuple/facts.h"

namespace meld::inspect {

namespace {

// Of the owner.
class Looker {
  public:
    Looker(const sim::Subdomain& subdomain, u64 id, sim::Catom catom) : subdomain_(subdomain), module_(subdomain.module), catom_(catom) {
        state_.id = id;
    }
    CatomState look() {
        place();
        for (const eval::Action& action : subdomain_.actions())
            if (action.catom == catom_) state_.actions.push_back(text(action.predicate, action.predicate, action.arguments));
        for (u32 p = 0; p < module_.predicate_count; ++p) {
            wait(p);
            given(p);
        }
        std::ranges::stable_sort(state_.coming, {}, &CatomState::Coming::tick);
        return std::move(state_);
    }

  private:
    void place() {
        const Geometry& g = subdomain_.geometry();
        const u32 site = g.catom_site[catom_];
        const world::Vec3 at = subdomain_.ensemble.position(catom_);
        state_.position = {at[0], at[1], at[2]};
        if (!subdomain_.ensemble.is_free())
            state_.cell = {cell_coordinate(g, site, 0), cell_coordinate(g, site, 1), cell_coordinate(g, site, 2)};
        each_link(g, catom_, [&](i32 port, u32 other) { state_.links.push_back({port, id_of(g, other)}); });
    }
    // With the name of one predicate and the types of another, which may have more arguments.
    std::string text(u32 name, u32 types, const Value* arguments) const {
        PredicateInfo p = module_.predicates[types];
        p.name = module_.predicates[name].name;
        p.arity = module_.predicates[name].arity;
        return tuple::print_fact(module_, p, state_.id, arguments);
    }
    template <class Visit>
    void each(u32 predicate, const Visit& visit) const {
        tuple::each_fact(module_, subdomain_.columns, subdomain_.geometry(), predicate, catom_, visit);
    }

    // p@later(A, X, Due): a fact of p that a rule has made for a later tick.
    void wait(u32 waiting) {
        const std::string_view name = module_.predicates[waiting].name;
        const std::size_t end = name.find("@later");
        if (end == std::string_view::npos || end + 6 != name.size()) return;
        const u16 arity = module_.predicates[waiting].arity;
        for (u32 p = 0; p < module_.predicate_count; ++p)
            if (name.substr(0, end) == module_.predicates[p].name && module_.predicates[p].arity + 1 == arity)
                each(waiting, [&](const Value* v) { state_.coming.push_back({text(p, waiting, v), v[arity - 1].integer}); });
    }
    // Facts that were given since the catom was last evaluated, by rules of others or from outside.
    void given(u32 p) {
        const u16 base = module_.predicates[p].base;
        if (base == kNone16 || base == p || module_.predicates[p].auxiliary || module_.predicates[p].column == kNone16) return;
        const u64 dirty = subdomain_.agenda().dirty(catom_);
        if ((dirty & module_.columns[module_.predicates[base].column].own_dirty) == 0) return;
        std::set<std::string> seen;
        each(p, [&](const Value* v) { seen.insert(text(p, p, v)); });
        each(base, [&](const Value* v) {
            if (std::string fact = text(p, base, v); !seen.contains(fact))
                state_.coming.push_back({std::move(fact), subdomain_.tick() + 1});
        });
    }

    const sim::Subdomain& subdomain_;
    const ModuleInfo& module_;
    sim::Catom catom_;
    CatomState state_;
};

void pack(const CatomState& state, ByteWriter& out) {
    out.write(state.id);
    out.write(state.cell.has_value());
    out.write(state.cell.value_or(std::array<std::int64_t, 3>{}));
    out.write(state.position);
    out.write_count(state.links.size());
    for (const CatomState::Link& link : state.links) out.write(link);
    out.write_count(state.actions.size());
    for (const std::string& action : state.actions) out.write_string(action);
    out.write_count(state.coming.size());
    for (const CatomState::Coming& coming : state.coming) {
        out.write_string(coming.fact);
        out.write(coming.tick);
    }
}

CatomState unpack(ByteReader& in) {
    CatomState state;
    state.id = in.read<u64>();
    const bool on_lattice = in.read<bool>();
    const auto cell = in.read<std::array<std::int64_t, 3>>();
    if (on_lattice) state.cell = cell;
    state.position = in.read<std::array<double, 3>>();
    for (u32 n = in.read_count(1); n > 0; --n) state.links.push_back(in.read<CatomState::Link>());
    for (u32 n = in.read_count(1); n > 0; --n) state.actions.push_back(in.read_string());
    for (u32 n = in.read_count(1); n > 0; --n) {
        std::string fact = in.read_string();
        state.coming.push_back({std::move(fact), in.read<std::int64_t>()});
    }
    return state;
}

}  // namespace

std::optional<CatomState> find_catom(sim::Subdomain& subdomain, u64 id) {
    subdomain.refresh();
    const std::optional<sim::Catom> catom = subdomain.ensemble.find(id);
    std::optional<CatomState> mine;
    if (catom && subdomain.owned(*catom)) mine = Looker(subdomain, id, *catom).look();
    if (subdomain.alone()) return mine;
    std::vector<comm::Packet> packets;
    if (mine && subdomain.comm.process() != 0) {
        ByteWriter out;
        pack(*mine, out);
        packets.push_back({0, out.take()});
        mine.reset();
    }
    for (const comm::Packet& packet : subdomain.comm.exchange(std::move(packets))) {
        ByteReader in(packet.bytes, "the state of a catom");
        mine = unpack(in);
    }
    return mine;
}

}  // namespace meld::inspect
