#include "runtime/ask/messages/messages.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>

#include "runtime/ask/messages/groups.h"
#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/base/natural_order.h"
#include "runtime/comm/transport/gather_to_root.h"
#include "runtime/engine/tuple/facts.h"

namespace meld::inspect {

namespace {

using One = Messages::One;
using Waiting = Messages::Waiting;

// A fact that neighbours read, as bytes: what names its group, and its value.
struct Row {
    u32 predicate = 0;
    std::string group = {}, value = {};
    u32 rank = kAbsent;
    bool operator<(const Row& other) const { return std::tie(predicate, group) < std::tie(other.predicate, other.group); }
};
using Rows = std::vector<Row>;

std::string as_text(const ByteWriter& bytes) { return {reinterpret_cast<const char*>(bytes.view().data()), bytes.view().size()}; }

// What a catom's neighbours may read, and facts of it as text.
class Exports {
  public:
    Exports(const ModuleInfo& module, const std::vector<Group>& groups) : module_(module), groups_(groups) {
        for (u32 p = 0; p < module.predicate_count; ++p) {
            const u16 column = module.predicates[p].column;
            if (column != kNone16 && module.columns[column].exported) predicates_.push_back(p);
        }
    }

    // By predicate and group.
    Rows of(const sim::Subdomain& subdomain, sim::Catom catom) const {
        Rows rows;
        std::vector<Value> room;
        for (const u32 predicate : predicates_) {
            const PredicateInfo& p = module_.predicates[predicate];
            const auto one = [&](const Value* arguments, u32 rank) {
                ByteWriter group, value;
                for (u32 i = 0; i < p.arity; ++i)
                    tuple::pack(tuple::type_of(module_, p.fields[i]), arguments[i], i < groups_[predicate].arguments ? group : value);
                rows.push_back({predicate, as_text(group), as_text(value), rank});
                return true;
            };
            tuple::each_ranked_fact(module_, subdomain.columns, subdomain.geometry(), predicate, catom, room, one);
        }
        std::sort(rows.begin(), rows.end());
        return rows;
    }
    std::string text(u64 catom, const Row& row) const {
        const PredicateInfo& p = module_.predicates[row.predicate];
        const std::string bytes = row.group + row.value;
        ByteReader in(std::as_bytes(std::span(bytes)), "a fact that neighbours read");
        tuple::Arena lists;
        std::vector<Value> values(p.arity);
        for (u32 i = 0; i < p.arity; ++i) values[i] = tuple::unpack(tuple::type_of(module_, p.fields[i]), in, lists);
        return tuple::print_fact(module_, p, catom, values.data());
    }
    // What neighbours are told, if these were the rows before and now: as modules count it (runtime/module/kernel/counts.h).
    std::vector<One> told(u64 catom, const Rows& before, const Rows& now) const {
        std::vector<One> out;
        const auto tell = [&](One::Is is, const Row& row, const Row* was) {
            out.push_back({.from = catom,
                           .is = is,
                           .predicate = row.predicate,
                           .fact = text(catom, row),
                           .was = was != nullptr ? text(catom, *was) : "",
                           .rank = row.rank});
        };
        auto a = before.begin();
        auto b = now.begin();
        while (a != before.end() || b != now.end()) {
            const bool gone = b == now.end() || (a != before.end() && *a < *b);
            const bool here = !gone && (a == before.end() || *b < *a);
            if (gone)
                tell(One::Is::Went, *a, nullptr);
            else if (here)
                tell(One::Is::Came, *b, nullptr);
            else if (groups_[b->predicate].has_value && a->value != b->value)
                tell(One::Is::Changed, *b, &*a);
            else if (a->rank != b->rank)
                tell(One::Is::Ranked, *b, nullptr);
            if (!here) ++a;
            if (!gone) ++b;
        }
        return out;
    }

  private:
    const ModuleInfo& module_;
    const std::vector<Group>& groups_;
    std::vector<u32> predicates_;
};

using ById = std::map<u64, Rows>;

ById rows_here(sim::Subdomain& subdomain, const Exports& exports) {
    subdomain.refresh();
    ById rows;
    for (sim::Catom c = 0; c < subdomain.ensemble.index_count(); ++c)
        if (subdomain.owned(c))
            if (Rows of_catom = exports.of(subdomain, c); !of_catom.empty()) rows.emplace(subdomain.ensemble.id(c), std::move(of_catom));
    return rows;
}

// Catoms that have gone to another process take along what they had.
void follow_migrants(ById& rows, sim::Subdomain& now) {
    if (now.alone()) return;
    ByteWriter mine;
    for (auto at = rows.begin(); at != rows.end();) {
        const std::optional<sim::Catom> catom = now.ensemble.find(at->first);
        if (catom && now.owned(*catom)) {
            ++at;
            continue;
        }
        mine.write(at->first);
        mine.write_count(at->second.size());
        for (const Row& row : at->second) {
            mine.write(row.predicate);
            mine.write(row.rank);
            mine.write_string(row.group);
            mine.write_string(row.value);
        }
        at = rows.erase(at);
    }
    for (const auto& bytes : now.comm.allgather_any(mine.view()))
        for (ByteReader in(bytes, "what catoms had before they migrated"); !in.done();) {
            const u64 id = in.read<u64>();
            Rows of_catom(in.read_count(1));
            for (Row& row : of_catom) {
                row.predicate = in.read<u32>();
                row.rank = in.read<u32>();
                row.group = in.read_string();
                row.value = in.read_string();
            }
            const std::optional<sim::Catom> catom = now.ensemble.find(id);
            if (catom && now.owned(*catom)) rows.emplace(id, std::move(of_catom));
        }
}

// The share of one process, from the rows before the tick and the state after it.
class Collector {
  public:
    Collector(const Exports& exports, sim::Subdomain& now, const MessagesAsked& asked)
        : exports_(exports), now_(now), module_(now.module), asked_(asked), counts_(module_.predicate_count, 0) {}

    void look(const ById& before) {
        const Geometry& g = now_.geometry();
        static const Rows none;
        now_.each_evaluated([&](u32 catom, u64) {
            if (!now_.owned(catom)) return;
            const u64 id = id_of(g, catom);
            const auto was = before.find(id);
            for (const One& one : exports_.told(id, was == before.end() ? none : was->second, exports_.of(now_, catom)))
                each_link(g, catom, [&](i32, u32 other) { add(one, id_of(g, other)); });
        });
        using Sent = std::tuple<u32, u64, u16, const Value*>;
        const auto sent = [](const eval::Message& m) { return Sent{m.to, m.from, m.predicate, m.arguments}; };
        std::multiset<Sent> by_modules;
        for (const eval::Message& m : now_.sent_by_modules()) by_modules.insert(sent(m));
        const eval::Sent all = now_.sent();
        for (const eval::Message& m : all.messages) {
            const auto module = by_modules.find(sent(m));
            One one{.from = m.from, .is = module == by_modules.end() ? One::Is::Sent : One::Is::Module, .predicate = m.predicate};
            if (module != by_modules.end()) by_modules.erase(module);
            one.fact = text(m.predicate, id_of(g, m.to), m.arguments, one.due);
            add(one, id_of(g, m.to));
        }
        for (const eval::FarMessage& m : now_.sent_far()) {
            One one{.from = m.from, .is = One::Is::Sent, .predicate = m.predicate};
            one.fact = text(m.predicate, m.to, m.arguments, one.due);
            add(one, m.to);
        }
        for (u32 p = 0; p < module_.predicate_count; ++p)
            if (delayed(p)) look_at_waiting(p);
    }
    // On process 0.
    Messages gather() {
        cut(shown_);
        cut(waiting_);
        ByteWriter mine;
        pack(mine);
        Messages all{.tick = now_.tick(), .catom = asked_.catom};
        std::vector<u64> counts(module_.predicate_count, 0);
        shown_.clear();
        waiting_.clear();
        for (const auto& bytes : comm::gather_to_root(now_.comm, mine.take())) {
            ByteReader in(bytes, "messages of a process");
            unpack(in, counts, all);
        }
        cut(shown_);
        cut(waiting_);
        for (u32 p = 0; p < counts.size(); ++p) {
            all.count += counts[p];
            const PredicateInfo& info = module_.predicates[p];
            if (counts[p] > 0) all.predicates.push_back({fmt::format("{}/{}", info.name, info.arity + 1), p, info.auxiliary, counts[p]});
        }
        all.count += all.modules;
        all.shown = std::move(shown_);
        all.waiting = std::move(waiting_);
        return all;
    }

  private:
    // p@later(A, X, Due): a fact of p that a rule has made for a later tick.
    bool delayed(u32 predicate) const {
        return module_.predicates[predicate].auxiliary && std::string_view(module_.predicates[predicate].name).ends_with("@later");
    }
    std::string text(u32 predicate, u64 catom, const Value* arguments, std::optional<std::int64_t>& due) const {
        if (!delayed(predicate)) return tuple::print_fact(module_, module_.predicates[predicate], catom, arguments);
        PredicateInfo p = module_.predicates[predicate];
        const std::string name(std::string_view(p.name).substr(0, std::string_view(p.name).rfind('@')));
        p.name = name.c_str();
        due = arguments[--p.arity].integer;
        return tuple::print_fact(module_, p, catom, arguments);
    }
    void look_at_waiting(u32 predicate) {
        for (sim::Catom c = 0; c < now_.ensemble.index_count(); ++c) {
            if (!now_.owned(c)) continue;
            const u64 id = now_.ensemble.id(c);
            if (asked_.catom && *asked_.catom != id) continue;
            tuple::each_fact(module_, now_.columns, now_.geometry(), predicate, c, [&](const Value* arguments) {
                std::optional<std::int64_t> due;
                std::string fact = text(predicate, id, arguments, due);
                ++waiting_count_;
                keep(waiting_, {id, std::move(fact), due.value_or(0)});
            });
        }
    }
    void add(const One& one, u64 to) {
        if (asked_.catom && *asked_.catom != one.from && *asked_.catom != to) return;
        ++(one.is == One::Is::Module ? modules_ : counts_[one.predicate]);
        in_ += asked_.catom == to;
        out_ += asked_.catom == one.from;
        One over_link = one;
        over_link.to = to;
        keep(shown_, std::move(over_link));
    }
    // The first of them are found before there are many more.
    template <class Item>
    void keep(std::vector<Item>& all, Item item) {
        if (all.size() > kFew && all.size() / 2 > asked_.most) cut(all);
        all.push_back(std::move(item));
    }
    static bool earlier(const One& a, const One& b) {
        if (a.from != b.from) return a.from < b.from;
        // Facts of one predicate together, as it stands in the program.
        if (a.predicate != b.predicate) return a.predicate < b.predicate;
        if (a.fact != b.fact) return natural_less(a.fact, b.fact);
        return std::tie(a.to, a.is, a.was) < std::tie(b.to, b.is, b.was);
    }
    static bool earlier(const Waiting& a, const Waiting& b) {
        if (a.catom != b.catom) return a.catom < b.catom;
        return a.tick != b.tick ? a.tick < b.tick : natural_less(a.fact, b.fact);
    }
    template <class Item>
    void cut(std::vector<Item>& all) const {
        std::ranges::stable_sort(all, [](const Item& a, const Item& b) { return earlier(a, b); });
        if (all.size() > asked_.most) all.resize(static_cast<std::size_t>(asked_.most));
    }

    void pack(ByteWriter& out) const {
        for (const u64 count : counts_) out.write(count);
        for (const u64 count : {in_, out_, modules_, waiting_count_}) out.write(count);
        out.write_count(shown_.size());
        for (const One& one : shown_) {
            out.write(one.from);
            out.write(one.to);
            out.write(one.is);
            out.write(one.predicate);
            out.write(one.rank);
            out.write(one.due.has_value());
            out.write(one.due.value_or(0));
            out.write_string(one.fact);
            out.write_string(one.was);
        }
        out.write_count(waiting_.size());
        for (const Waiting& one : waiting_) {
            out.write(one.catom);
            out.write(one.tick);
            out.write_string(one.fact);
        }
    }
    void unpack(ByteReader& in, std::vector<u64>& counts, Messages& all) {
        for (u64& count : counts) count += in.read<u64>();
        for (u64* const count : {&all.incoming, &all.outgoing, &all.modules, &all.waiting_count}) *count += in.read<u64>();
        for (std::size_t left = in.read_count(1); left > 0; --left) {
            One& one = shown_.emplace_back();
            one.from = in.read<u64>();
            one.to = in.read<u64>();
            one.is = in.read<One::Is>();
            one.predicate = in.read<u32>();
            one.rank = in.read<u32>();
            const bool delays = in.read<bool>();
            const auto due = in.read<std::int64_t>();
            if (delays) one.due = due;
            one.fact = in.read_string();
            one.was = in.read_string();
        }
        for (std::size_t left = in.read_count(1); left > 0; --left) {
            Waiting& one = waiting_.emplace_back();
            one.catom = in.read<u64>();
            one.tick = in.read<std::int64_t>();
            one.fact = in.read_string();
        }
    }

    static constexpr u64 kFew = 10'000;
    const Exports& exports_;
    sim::Subdomain& now_;
    const ModuleInfo& module_;
    const MessagesAsked& asked_;
    std::vector<u64> counts_;
    u64 in_ = 0, out_ = 0, modules_ = 0, waiting_count_ = 0;
    std::vector<One> shown_;
    std::vector<Waiting> waiting_;
};

Result<void> exists(sim::Subdomain& subdomain, u64 id) {
    const std::optional<sim::Catom> catom = subdomain.ensemble.find(id);
    const std::byte mine{catom && subdomain.owned(*catom)};
    const std::vector<std::byte> all = subdomain.comm.allgather({&mine, 1});
    if (std::ranges::find(all, std::byte{1}) != all.end()) return {};
    return fail(fmt::format("there is no catom @{} in tick {}", id, subdomain.tick()));
}

}  // namespace

Result<Messages> messages(timeline::Timeline& timeline, const MessagesAsked& asked) {
    sim::Subdomain& present = timeline.simulation().subdomain();
    const std::int64_t tick = timeline.tick();
    if (asked.catom)
        if (auto there = exists(present, *asked.catom); !there) return tl::unexpected<Error>(there.error());
    if (tick == 0) return Messages{.tick = 0, .catom = asked.catom};
    if (tick == timeline.first_tick())
        return fail(
            fmt::format("what crossed the links in tick {} is not known: this is a checkpoint of it, and what came before is not in it",
                        tick),
            fmt::format("Ask in tick {} or later", tick + 1));
    const Result<std::vector<Group>> groups = groups_of(present.module);
    if (!groups) return tl::unexpected<Error>(groups.error());
    const Exports exports(present.module, *groups);
    ById before;
    Messages all;
    const Result<void> walked = timeline.walk(tick - 1, tick, [&](sim::Simulation& simulation) -> Result<bool> {
        sim::Subdomain& subdomain = simulation.subdomain();
        if (subdomain.tick() < tick) {
            before = rows_here(subdomain, exports);
            return true;
        }
        subdomain.refresh();
        follow_migrants(before, subdomain);
        Collector collector(exports, subdomain, asked);
        collector.look(before);
        all = collector.gather();
        return false;
    });
    if (!walked) return tl::unexpected<Error>(walked.error());
    MELD_CHECK(present.comm.process() != 0 || all.tick == tick, "tick {} was not reached again", tick);
    return all;
}

}  // namespace meld::inspect
