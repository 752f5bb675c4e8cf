#include "runtime/sim/state/take_over.h"

#include <fmt/format.h>

#include <algorithm>

#include "runtime/engine/tuple/facts.h"

namespace meld::sim {

namespace {

bool stores_given(const ModuleInfo& module, u32 predicate) {
    return module.predicates[predicate].base == predicate && module.predicates[predicate].column != kNone16;
}

// The predicate whose given facts another one stores.
const PredicateInfo& user_of(const ModuleInfo& module, u32 store) {
    for (u32 i = 0; i < module.predicate_count; ++i)
        if (module.predicates[i].base == store && i != store) return module.predicates[i];
    return module.predicates[store];
}

// What waits for its time or for a link is known by the predicate that it will be.
std::string shown_name(const PredicateInfo& p) {
    const std::string name = p.name;
    return name.substr(0, name.find('@'));
}

// Actions are compared by their arguments alone: whether one repeats is said in each declaration.
bool same_declaration(const ModuleInfo& was, const PredicateInfo& p, const ModuleInfo& now, const PredicateInfo& q) {
    return tuple::declaration(was, p) == tuple::declaration(now, q);
}

}  // namespace

TakeOver::TakeOver(tuple::Schema was, const ModuleInfo& now, FactStore& facts) : was_(std::move(was)), now_(now), facts_(facts) {
    find_ways();
}

// Predicates of the program come before auxiliaries that have their names.
std::optional<u32> TakeOver::find(const PredicateInfo& p) const {
    for (const bool auxiliary : {false, true})
        for (u32 i = 0; i < now_.predicate_count; ++i)
            if (const PredicateInfo& q = now_.predicates[i];
                q.auxiliary == auxiliary && q.arity == p.arity && std::string_view(q.name) == p.name)
                return i;
    return std::nullopt;
}

// A predicate of this name that has come with another number of arguments: the declaration was edited.
const PredicateInfo* TakeOver::other_arity(const PredicateInfo& p) const {
    const auto was = [&](u16 arity) { return tuple::find_predicate(was_.module(), p.name, arity).has_value(); };
    for (u32 i = 0; i < now_.predicate_count; ++i)
        if (const PredicateInfo& q = now_.predicates[i]; !q.auxiliary && std::string_view(q.name) == p.name && !was(q.arity)) return &q;
    return nullptr;
}

TakeOver::Way TakeOver::way_of_given(u32 from) const {
    const ModuleInfo& was = was_.module();
    const PredicateInfo& p = user_of(was, from);
    Way way{.from = from, .name = shown_name(p)};
    const std::optional<u32> found = find(p);
    if (!found) {
        const PredicateInfo* const other = p.auxiliary ? nullptr : other_arity(p);
        if (other != nullptr) way.changed = tuple::declaration(now_, *other);
        return way;
    }
    const PredicateInfo& q = now_.predicates[*found];
    if (!same_declaration(was, p, now_, q)) {
        if (!p.auxiliary) way.changed = tuple::declaration(now_, q);
        return way;
    }
    if (q.base == kNone16 || now_.predicates[q.base].column == kNone16) return way;
    // A sense that now keeps its first value only, or all of them, is sensed again.
    if (p.kind == PredicateKind::Sensed && now_.predicates[q.base].storage != was.predicates[from].storage) return way;
    way.to = q.base;
    return way;
}

std::optional<u32> TakeOver::same_action(u32 from) const {
    const PredicateInfo& p = was_.module().predicates[from];
    const std::optional<u32> found = find(p);
    return found && same_declaration(was_.module(), p, now_, now_.predicates[*found]) ? found : std::nullopt;
}

TakeOver::Way TakeOver::way_of_action(u32 from) const {
    Way way{.from = from, .done = true, .name = shown_name(was_.module().predicates[from])};
    const std::optional<u32> found = same_action(from);
    if (!found) return way;
    const PredicateInfo& q = now_.predicates[*found];
    // Where neighbours read an action they have not seen what is written here.
    if (q.column != kNone16 && q.rank_offset == kNone32 && q.storage != Storage::PerLink && !now_.columns[q.column].exported)
        way.to = *found;
    return way;
}

void TakeOver::find_ways() {
    const ModuleInfo& was = was_.module();
    actions_.resize(was.predicate_count);
    for (u32 i = 0; i < was.predicate_count; ++i) {
        if (was.predicates[i].kind == PredicateKind::Action) actions_[i] = same_action(i);
        if (stores_given(was, i))
            ways_.push_back(way_of_given(i));
        else if (was.predicates[i].kind == PredicateKind::Action && was.predicates[i].column != kNone16)
            ways_.push_back(way_of_action(i));
    }
}

void TakeOver::load(std::span<const tuple::SavedCatom> catoms, ByteReader& in) {
    const ModuleInfo& was = was_.module();
    tuple::Columns columns(was, 1);
    columns.resize(catoms.size());
    std::vector<tuple::SavedCatom> all(catoms.size());
    for (u32 i = 0; i < all.size(); ++i)
        if (catoms[i].owned) all[i] = {i, true};
    columns.load(all, in);
    if (in.failed()) return;
    // All are evaluated as a whole: the agenda says nothing new.
    in.read_block();
    for (Way& way : ways_)
        for (u32 i = 0; i < all.size(); ++i) {
            if (!catoms[i].owned) continue;
            // Facts of a link lie by ports, and only rules derive them.
            tuple::each_fact(was, columns, Geometry{}, way.from, i, [&](const Value* arguments) {
                ++way.facts;
                if (!way.to) return;
                if (way.done)
                    tuple::give_fact(now_, facts_.columns, *way.to, catoms[i].catom, arguments, 0);
                else
                    facts_.give(*way.to, catoms[i].catom, arguments);
            });
        }
}

void TakeOver::load_passing(const std::function<std::optional<u32>(u64)>& find_catom, ByteReader& in) {
    // Losses, undefined derivations, and what waits for a time belong to what is derived anew.
    for (int i = 0; i < 4; ++i) in.read_block();
    const ModuleInfo& was = was_.module();
    ByteReader actions(in.read_block(), "the actions of a snapshot", ByteReader::Origin::Outside);
    FactStore::each_saved_action(was, std::move(actions), [&](u64 id, u16 predicate, const Value* arguments) {
        const std::optional<u32> catom = find_catom(id);
        if (!catom) return;
        if (const std::optional<u32> now = actions_[predicate])
            facts_.evaluator.restore_action(*catom, static_cast<u16>(*now), arguments);
        else
            ++lost_actions_[predicate];
    });
}

Result<TakenOver> TakeOver::outcome(comm::Communicator& comm) const {
    const ModuleInfo& was = was_.module();
    std::vector<u64> sums(ways_.size() + was.predicate_count, 0);
    for (std::size_t i = 0; i < ways_.size(); ++i) sums[i] = ways_[i].facts;
    for (const auto& [predicate, count] : lost_actions_) sums[ways_.size() + predicate] = count;
    const std::vector<std::byte> all = comm.allgather(std::as_bytes(std::span(sums)));
    std::fill(sums.begin(), sums.end(), 0);
    for (ByteReader in(all, "how many facts are taken over"); !in.done();)
        for (u64& sum : sums) sum += in.read<u64>();

    TakenOver out;
    for (std::size_t i = 0; i < ways_.size(); ++i) {
        const Way& way = ways_[i];
        if (sums[i] == 0 || way.done) continue;
        const PredicateInfo& p = user_of(was, way.from);
        if (!way.changed.empty() && p.kind != PredicateKind::Sensed)
            return fail(
                fmt::format("{} fact{} of {} cannot be taken over: the program now declares {}", sums[i], sums[i] == 1 ? "" : "s",
                            tuple::declaration(was, p), way.changed),
                fmt::format("Declare {} as it was; or give the changed predicate another name, and these facts are dropped", way.name),
                ExitCode::RecordingRefused);
        // The world senses again what it has sensed.
        if (way.to)
            out.taken_over[way.name] += sums[i];
        else if (p.kind != PredicateKind::Sensed)
            out.dropped[way.name] += sums[i];
    }
    for (u32 i = 0; i < was.predicate_count; ++i)
        if (const u64 lost = sums[ways_.size() + i]; lost > 0) out.dropped[shown_name(was.predicates[i])] += lost;
    for (u32 i = 0; i < now_.predicate_count; ++i)
        if (const PredicateInfo& p = now_.predicates[i];
            !p.auxiliary && p.column != kNone16 && p.kind != PredicateKind::Action && p.base != i)
            out.derived_anew.emplace_back(p.name);
    return out;
}

}  // namespace meld::sim
