#include "runtime/ask/watch/watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "compiler/front/body.h"
#include "runtime/ask/query/order.h"
#include "runtime/ask/query/solver.h"
#include "runtime/base/did_you_mean.h"
#include "runtime/comm/transport/packets.h"
#include "runtime/engine/tuple/value_text.h"
#include "runtime/module/abi/storage_abi.h"

namespace meld::inspect {

using check::Clause;
using check::VariableId;

namespace {

bool over_links(const std::vector<Step>& steps) {
    return std::ranges::all_of(steps, [](const Step& step) {
        return step.kind != Step::Kind::Each && step.kind != Step::Kind::Indexed && over_links(step.inner);
    });
}

std::string_view as_text(std::span<const std::byte> bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

}  // namespace

Watch::Watch(Program program, front::WatchRule rule) : program_(std::move(program)), rule_(std::move(rule)) {}

Result<std::unique_ptr<Watch>> Watch::make(const ModuleInfo& module, front::WatchRule rule) {
    Result<Program> program = Program::read(module, rule.asked);
    if (!program) return tl::unexpected<Error>(program.error());
    if (auto can = program->can_ask(program->question().body); !can) return tl::unexpected<Error>(can.error());
    std::unique_ptr<Watch> watch(new Watch(std::move(*program), std::move(rule)));
    watch->find_starts();
    if (auto found = watch->find_columns(); !found) return tl::unexpected<Error>(found.error());
    return watch;
}

// ---- what the body reads, and where

void Watch::find_starts() {
    const check::Rule& question = program_.question();
    columns_read_.resize(program_.module().column_count);
    reasons_ = kDirtyBorn | kDirtyLinks;
    Distances near;
    anywhere_ = true;
    for (const Clause& c : question.body) {
        anywhere_ = anywhere_ && c.kind != Clause::Kind::Atom;
        if (c.kind == Clause::Kind::Atom)
            for (const check::Term& t : c.atom.arguments)
                if (t.is_variable()) near[t.variable] = 0;
    }
    look(question.body, near, false);
    links_only_ = !starts_.empty() && !anywhere_ && std::ranges::all_of(starts_, [&](VariableId s) { return follows_links(s); });
}

// A change at a catom within a part of the body matters if links of that part join it to one outside: those that there are, for a link that
// is new or gone has changed at both its ends. `near` says how many links a variable is away from those outside.
void Watch::look(const std::vector<Clause>& clauses, Distances near, bool inside) {
    for (bool changed = inside; changed;) {
        changed = false;
        for (const Clause& c : clauses) {
            if (c.kind != Clause::Kind::Atom) continue;
            const Source& source = program_.source(c.atom.predicate);
            const check::Term &from = c.atom.arguments[0], *to = c.atom.arguments.size() > 1 ? &c.atom.arguments[1] : nullptr;
            if (source.kind != Source::Kind::World || !is_link(source.world) || !from.is_variable() || !to->is_variable()) continue;
            for (const auto& [a, b] : {std::pair(from.variable, to->variable), std::pair(to->variable, from.variable)})
                if (near.contains(a)) changed = near.emplace(b, near[a] + 1).second || changed;
        }
    }
    for (const Clause& c : clauses) {
        look(c.inner, near, true);
        if (c.kind != Clause::Kind::Atom) continue;
        note_reads(c.atom);
        const check::Term& catom = c.atom.arguments[0];
        const auto found = catom.is_variable() ? near.find(catom.variable) : near.end();
        if (found == near.end()) {
            anywhere_ = true;
        } else if (found->second > 0) {
            reach_ = std::max(reach_, found->second);
        } else if (std::ranges::find(starts_, catom.variable) == starts_.end()) {
            starts_.push_back(catom.variable);
        }
    }
}

void Watch::note_reads(const check::Atom& atom) {
    const Source& source = program_.source(atom.predicate);
    const check::Predicate& predicate = program_.checked().predicates[atom.predicate];
    reads_ticks_ = reads_ticks_ || (source.kind == Source::Kind::World && source.world == WorldSource::Tick);
    reads_places_ = reads_places_ || (source.kind == Source::Kind::World && (info(source.world).wakes & kDirtyPlace) != 0);
    reads_linear_ = reads_linear_ || predicate.kind == check::PredicateKind::Linear;
    reads_actions_ = reads_actions_ || source.kind == Source::Kind::Actions;
    if (source.kind == Source::Kind::World) {
        reads_private_ = reads_private_ || !is_link(source.world);
    } else if (source.kind == Source::Kind::Stored) {
        const u16 column = program_.module().predicates[source.predicate].column;
        if (column == kNone16) return;
        const ColumnInfo& info = program_.module().columns[column];
        reads_private_ = reads_private_ || !info.exported;
        columns_read_[column] = info.exported;
        reasons_ |= info.own_dirty;
    }
}

std::vector<u32> Watch::looked_for() const {
    std::vector<u32> predicates;
    if (!links_only_) add_stored(program_.question().body, predicates);
    return predicates;
}

void Watch::add_stored(const std::vector<Clause>& clauses, std::vector<u32>& predicates) const {
    for (const Clause& c : clauses) {
        add_stored(c.inner, predicates);
        if (c.kind != Clause::Kind::Atom) continue;
        const Source& source = program_.source(c.atom.predicate);
        if (source.kind != Source::Kind::Stored || program_.module().predicates[source.predicate].column == kNone16) continue;
        if (std::ranges::find(predicates, source.predicate) == predicates.end()) predicates.push_back(source.predicate);
    }
}

bool Watch::follows_links(VariableId start) const {
    const check::Rule& question = program_.question();
    Bound bound(question.variables.count());
    bound[start.index()] = true;
    return over_links(order(program_, question, question.body, bound, false));
}

Result<void> Watch::find_columns() {
    const check::Rule& question = program_.question();
    columns_ = front::answers(question);
    answers_ = columns_.size();
    std::vector<std::string_view> names;
    for (const VariableId v : columns_) names.push_back(question.variables[v].name);
    if (rule_.shown.empty())
        for (std::size_t i = 0; i < names.size(); ++i) shown_.push_back(i);
    for (const std::string& name : rule_.shown) {
        const auto found = std::ranges::find(names, name);
        if (found == names.end())
            return fail(
                fmt::format("{}: the body gives '{}' no value, and the head of its watch tells it: {}", rule_.asked.file, name, rule_.body),
                names.empty() ? "Leave it out" : did_you_mean(name, names));
        shown_.push_back(static_cast<std::size_t>(found - names.begin()));
    }
    for (const VariableId start : starts_) {
        const auto found = std::ranges::find(columns_, start);
        start_columns_.push_back(static_cast<std::size_t>(found - columns_.begin()));
        if (found == columns_.end()) columns_.push_back(start);
    }
    for (const VariableId v : columns_) types_.number(question.variables[v].type);
    for (const VariableId v : columns_) column_types_.push_back(types_.of(question.variables[v].type));
    return {};
}

// ---- the search

// Ascending.
std::vector<u32> Watch::starts_of(sim::Subdomain& subdomain, const Changes& changes) const {
    std::vector<u32> catoms;
    if (whole_) {
        for (sim::Catom c = 0; c < subdomain.ensemble.index_count(); ++c)
            if (subdomain.owned(c)) catoms.push_back(c);
        return catoms;
    }
    const bool all = reads_private_ || reads_linear_ || reads_actions_;
    subdomain.each_evaluated([&](u32 catom, u64 reasons) {
        if (all || (reasons & reasons_) != 0) catoms.push_back(catom);
    });
    if (!all) subdomain.add_changed(columns_read_, catoms);
    if (reads_linear_ && subdomain.totals.tick.messages > 0) subdomain.agenda().each([&](u32 catom, u64) { catoms.push_back(catom); });
    // Nodes that rules have made are there, and are evaluated in the next tick.
    if (subdomain.totals.nodes_made > 0)
        subdomain.agenda().each([&](u32 catom, u64 reasons) {
            if ((reasons & kDirtyBorn) != 0) catoms.push_back(catom);
        });
    if (reads_actions_) catoms.insert(catoms.end(), changes.had_asked.begin(), changes.had_asked.end());
    // Some may have gone to another process.
    std::erase_if(catoms, [&](u32 catom) { return !subdomain.owned(catom); });
    for (std::size_t i = 0; i < reach_; ++i) add_neighbours(subdomain, catoms);
    if (!std::ranges::is_sorted(catoms)) std::ranges::sort(catoms);
    const auto again = std::ranges::unique(catoms);
    catoms.erase(again.begin(), again.end());
    return catoms;
}

// Every process calls it.
void Watch::add_neighbours(sim::Subdomain& subdomain, std::vector<u32>& catoms) const {
    std::vector<ByteWriter> to_others(static_cast<std::size_t>(subdomain.comm.processes()));
    for (std::size_t i = 0, before = catoms.size(); i < before; ++i)
        subdomain.each_neighbour(catoms[i], [&](u32 other) {
            if (subdomain.owned(other))
                catoms.push_back(other);
            else
                to_others[static_cast<std::size_t>(subdomain.owner_of(other))].write(subdomain.ensemble.id(other));
        });
    std::ranges::sort(catoms);
    const auto again = std::ranges::unique(catoms);
    catoms.erase(again.begin(), again.end());
    if (subdomain.alone()) return;
    for (const comm::Packet& packet : subdomain.comm.exchange(comm::take_packets(to_others)))
        for (ByteReader in(packet.bytes, "catoms next to changes"); !in.done();) {
            const auto found = subdomain.ensemble.find(in.read<u64>());
            if (found && subdomain.owned(*found)) catoms.push_back(*found);
        }
}

void Watch::begin(sim::Subdomain& subdomain, const Changes& changes, bool least) {
    const check::Rule& question = program_.question();
    if (!terms_) terms_.emplace(program_, subdomain.view());
    if (sieves_.empty())
        for (const VariableId start : starts_) sieves_.emplace_back(program_, question, start, subdomain);
    least_ = least;
    lists_ = tuple::Arena();
    failures_ = 0;
    pending_.assign(starts_.size(), {});
    const bool all = changes.everything || may_always_change(subdomain);
    whole_ = anywhere_ || all || (changes.mostly && !links_only_);
    from_.clear();
    // Over links, each process looks from its own catoms; else the first looks at everything.
    pending_whole_ = whole_ && !links_only_ && subdomain.comm.process() == 0;
    if (whole_ && !links_only_) return;
    std::vector<u32> from = starts_of(subdomain, changes);
    for (std::size_t i = 0; i < (whole_ ? 1 : starts_.size()); ++i) pending_[i] = sieves_[i].pass(from);
    if (!whole_ && !least_) from_ = std::move(from);
}

void Watch::note(const Values& values) {
    Way way;
    for (std::size_t i = 0; i < columns_.size(); ++i)
        way.values.push_back(tuple::normal(column_types_[i].kind(), values[columns_[i].index()]));
    ByteWriter key;
    for (std::size_t i = 0; i < columns_.size(); ++i) tuple::pack(column_types_[i], way.values[i], key);
    way.key = as_text(key.view());
    of_one_.push_back(std::move(way));
}

// What was found from a catom holds if nothing was lacking; else the search from there begins again when that has come.
Result<void> Watch::go_on(SharedFacts& facts) {
    Solver solver(program_, facts, *terms_);
    const check::Rule& question = program_.question();
    const SearchOptions patient{.patient = true};
    const auto found = [&](const Solution& solution) { return note(solution.values), true; };
    u64 failures = terms_->scratch.failures();
    const auto keep = [&] {
        const bool lacked = facts.lacked();
        const u64 before = std::exchange(failures, terms_->scratch.failures());
        if (!lacked) failures_ += failures - before;
        for (Way& way : of_one_) {
            if (lacked || (!least_ && !keys_.insert(way.key).second)) continue;
            way.values = unpack(std::as_bytes(std::span(way.key)));
            if (!least_ || ways_.empty())
                ways_.push_back(std::move(way));
            else if (compare(way.values, ways_[0].values) < 0)
                ways_[0] = std::move(way);
        }
        of_one_.clear();
        return !lacked;
    };
    if (std::exchange(pending_whole_, false)) {
        if (auto done = solver.search(question, question.body, {}, {}, found, patient); !done) return done;
        pending_whole_ = !keep();
    }
    for (std::size_t i = 0; i < starts_.size(); ++i) {
        const std::vector<u64> catoms = std::exchange(pending_[i], {});
        if (catoms.empty()) continue;
        const auto done = [&](std::size_t at) {
            if (!keep()) pending_[i].push_back(catoms[at]);
            return true;
        };
        if (auto searched = solver.search_from(question, question.body, starts_[i], catoms, found, done, patient); !searched)
            return searched;
    }
    return {};
}

// ---- what was found, on its way to the first process

void Watch::found(const sim::Subdomain& subdomain, ByteWriter& out) {
    out.write(whole_);
    out.write(failures_);
    out.write_count(from_.size());
    for (const u32 catom : from_) out.write(subdomain.ensemble.id(catom));
    out.write_count(ways_.size());
    for (const Way& way : ways_) {
        out.write_string(way.key);
        out.write_string(text_of(way.values));
    }
    ways_.clear();
    keys_.clear();
    from_.clear();
}

void Watch::add(ByteReader& in, Found& all) {
    all.whole = in.read<bool>() || all.whole;
    all.failures += in.read<u64>();
    for (auto left = in.read_count(sizeof(u64)); left > 0; --left) all.from.push_back(in.read<u64>());
    for (auto left = in.read_count(sizeof(u32)); left > 0; --left) {
        std::string key = in.read_string();
        std::string text = in.read_string();
        all.ways.push_back(way_of(std::move(key), std::move(text)));
    }
}

Watch::Way Watch::way_of(std::string key, std::string text) {
    std::vector<Value> values = unpack(std::as_bytes(std::span(key)));
    return {std::move(values), std::move(key), std::move(text)};
}

void Watch::finish(Found& all) const {
    std::ranges::sort(all.ways, [&](const Way& a, const Way& b) { return before(a, b); });
    const auto again = std::ranges::unique(all.ways, {}, &Way::key);
    all.ways.erase(again.begin(), again.end());
    std::ranges::sort(all.from);
}

std::vector<u64> Watch::catoms_of(const Way& way) const {
    std::vector<u64> catoms;
    for (const std::size_t column : start_columns_) catoms.push_back(way.values[column].catom);
    return catoms;
}

// The clause of the body's first fact.
const Clause* Watch::first_fact() const {
    const std::vector<Clause>& body = program_.question().body;
    const auto first = std::ranges::find(body, Clause::Kind::Atom, &Clause::kind);
    return first == body.end() ? nullptr : &*first;
}

std::optional<u64> Watch::home_of(const Way& way) {
    const Clause* const first = first_fact();
    if (first == nullptr) return std::nullopt;
    const check::Term& catom = first->atom.arguments[0];
    if (catom.is_variable())
        if (const auto found = std::ranges::find(columns_, catom.variable); found != columns_.end())
            return way.values[static_cast<std::size_t>(found - columns_.begin())].catom;
    if (!terms_) return std::nullopt;
    Values none(program_.question().variables.count());
    return terms_->value(catom, none).catom;
}

Watch::Told Watch::told(const Way& way) const {
    const Clause* const first = first_fact();
    Told told;
    for (std::size_t i = 0; i < answers_; ++i) {
        if (first != nullptr && first->atom.arguments[0].is_variable() && first->atom.arguments[0].variable == columns_[i]) continue;
        told.emplace_back(program_.question().variables[columns_[i]].name, tuple::print_value(column_types_[i], way.values[i]));
    }
    return told;
}

int Watch::compare(const std::vector<Value>& a, const std::vector<Value>& b) const {
    for (std::size_t i = 0; i < columns_.size(); ++i)
        if (const int c = tuple::compare(column_types_[i], a[i], b[i])) return c;
    return 0;
}

std::string Watch::text_of(const std::vector<Value>& values) const {
    std::string text;
    for (const std::size_t column : shown_)
        text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", program_.question().variables[columns_[column]].name,
                            tuple::print_value(column_types_[column], values[column]));
    return text;
}

std::vector<Value> Watch::unpack(std::span<const std::byte> key) {
    ByteReader in(key, "the values of a watch");
    std::vector<Value> values;
    for (const tuple::Type type : column_types_) values.push_back(tuple::unpack(type, in, lists_));
    return values;
}

}  // namespace meld::inspect
