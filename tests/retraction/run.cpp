#include "run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "changes.h"
#include "runtime/comm/transport/communicator.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/results/record/state_digest.h"
#include "runtime/sim/core/tick.h"
#include "runtime/world/ensemble/target.h"

namespace meld::retraction {

namespace {

// More than any case of this size needs by far.
constexpr int kPatience = 2000;

// The facts of this process's catoms, of predicates that users see.
void collect(sim::Subdomain& subdomain, Facts& out) {
    for (u32 p = 0; p < subdomain.module.predicate_count; ++p) {
        const PredicateInfo& info = subdomain.module.predicates[p];
        if (info.auxiliary || info.column == kNone16 || info.kind != PredicateKind::Persistent) continue;
        for (sim::Catom c = 0; c < subdomain.ensemble.index_count(); ++c) {
            if (!subdomain.owned(c)) continue;
            tuple::each_fact(subdomain.module, subdomain.columns, subdomain.geometry(), p, c, [&](const Value* v) {
                Row row{static_cast<std::int64_t>(subdomain.ensemble.id(c))};
                for (u32 i = 0; i < info.arity; ++i) row.push_back(v[i].integer);
                out[info.name].insert(row);
            });
        }
    }
}

// All words that an owned catom's columns hold, ranks among them, and its tombstones that still matter.
Digest deep_digest(sim::Subdomain& subdomain) {
    Digest digest;
    for (sim::Catom c = 0; c < subdomain.ensemble.index_count(); ++c) {
        if (!subdomain.owned(c)) continue;
        std::uint64_t hash = subdomain.ensemble.id(c);
        for (u32 p = 0; p < subdomain.module.predicate_count; ++p) {
            const PredicateInfo& info = subdomain.module.predicates[p];
            if (info.rank_offset == kNone32) continue;
            const auto rank = [&](const u8* at) {
                u32 word = 0;
                std::memcpy(&word, at + info.rank_offset, sizeof word);
                hash = hash_combine(hash, word);
            };
            if (info.storage != Storage::Rows) {
                rank(subdomain.columns.entry(info.column, c));
                continue;
            }
            const RowsHead& head = subdomain.columns.rows(info.column, c);
            for (u32 r = 0; r < head.count; ++r) rank(head.data + std::size_t{r} * subdomain.module.columns[info.column].row_bytes);
        }
        digest.add(hash);
        for (const auto& l : subdomain.tombstones().of(c))
            digest.add(hash_combine(hash_combine(hash_combine(hash, l.key), l.least_rank), static_cast<u64>(l.time) + l.predicate));
    }
    std::vector<std::byte> bytes(sizeof digest);
    std::memcpy(bytes.data(), &digest, sizeof digest);
    const std::vector<std::byte> all = subdomain.comm.allgather(bytes);
    Digest sum;
    for (std::size_t at = 0; at < all.size(); at += sizeof digest) {
        Digest one;
        std::memcpy(&one, all.data() + at, sizeof one);
        sum.combine(one);
    }
    return sum;
}

// Takes the neighbour out of rows that carry one, and says what is wrong with it.
std::string check_parents(Facts& facts, const std::string& predicate, const Scene& scene) {
    std::set<Row> plain;
    std::map<std::int64_t, std::int64_t> value;
    for (const Row& row : facts[predicate]) value[row[0]] = row[1];
    for (const Row& row : facts[predicate]) {
        plain.insert(Row(row.begin(), row.end() - 1));
        const std::int64_t id = row[0], via = row.back();
        const auto found = scene.neighbours.find(id);
        const std::vector<std::int64_t> others = found == scene.neighbours.end() ? std::vector<std::int64_t>{} : found->second;
        const bool is_root = row[1] == 0 && via == id;
        const bool is_child =
            std::find(others.begin(), others.end(), via) != others.end() && value.contains(via) && value[via] == row[1] - 1;
        if (!is_root && !is_child) return fmt::format("@{} has {} {} by way of @{}\n", id, predicate, row[1], via);
    }
    facts[predicate] = plain;
    if (plain.empty()) facts.erase(predicate);
    return "";
}

std::string print_row(const std::string& predicate, const Row& row) {
    std::string text = predicate + "(@" + std::to_string(row[0]);
    for (std::size_t i = 1; i < row.size(); ++i) text += fmt::format(", {}", row[i]);
    return text + ")";
}

std::string difference(const Facts& expected, const Facts& found) {
    std::string text;
    const auto missing = [&](const Facts& from, const Facts& in, const char* what) {
        for (const auto& [predicate, rows] : from)
            for (const Row& row : rows) {
                const auto there = in.find(predicate);
                if (there == in.end() || !there->second.contains(row)) text += fmt::format("  {} {}\n", what, print_row(predicate, row));
            }
    };
    missing(expected, found, "missing:");
    missing(found, expected, "should not hold:");
    return text;
}

std::uint64_t lost_between(const Facts& before, const Facts& after) {
    std::uint64_t count = 0;
    for (const auto& [predicate, rows] : before)
        for (const Row& row : rows) count += !after.contains(predicate) || !after.at(predicate).contains(row);
    return count;
}

// What the processes of a run share: each writes its own facts, process 0 compares.
struct Shared {
    const Case& c;
    const Program& program;
    const ModuleInfo& module;
    const std::vector<Facts>& expected;
    const Setting& setting;
    const world::World& world;
    const world::Target& target;
    const Change* lost;
    std::vector<Facts> facts;  // By process.
    Facts before = {};         // At the end of the last burst.
    Mirror mirror;             // Process 0's.
    Outcome outcome = {};
};

void compare(Shared& s, std::size_t burst) {
    Facts found;
    for (const Facts& mine : s.facts)
        for (const auto& [predicate, rows] : mine) found[predicate].insert(rows.begin(), rows.end());
    if (!s.program.parent_of.empty()) s.outcome.trouble = check_parents(found, s.program.parent_of, make_scene(s.mirror, s.c.lattice));
    s.outcome.trouble += difference(s.expected[burst], found);
    if (!s.outcome.trouble.empty()) s.outcome.trouble = fmt::format("after burst {}:\n{}", burst, s.outcome.trouble);
    for (const auto& [predicate, rows] : found) s.outcome.compared += rows.size();
    s.outcome.retractions += lost_between(s.before, found);
    s.before = std::move(found);
}

// One burst to quiescence; false: it never came.
bool settle(sim::Subdomain& subdomain, sim::Tick& tick, Changes& changes, Shared& s, std::size_t burst, record::RunningDigest& running) {
    const bool speaks = subdomain.comm.process() == 0;
    changes.begin_burst(burst, subdomain.tick());
    for (int patience = kPatience; patience > 0; --patience) {
        tick.begin();
        static_cast<void>(changes.step(subdomain));
        if (s.setting.no_quarantine) tick.set_latency(0);
        const sim::Totals& totals = tick.end();
        const Digest state = running.of(subdomain);
        if (const Result<void> same = running.check(subdomain); !same) {
            if (speaks) s.outcome.trouble = same.error().message();
            return false;
        }
        const Digest deep = s.setting.deep ? deep_digest(subdomain) : Digest{};
        if (speaks) {
            s.outcome.states.push_back(state);
            if (s.setting.deep) s.outcome.states.push_back(deep);
            s.outcome.derivations += totals.tick.derivations;
            s.outcome.tombstones = std::max<std::uint64_t>(s.outcome.tombstones, subdomain.tombstones().count());
            s.outcome.exchanges += totals.sent_bytes > 0;
            s.outcome.quarantines += totals.waiting && !totals.awake;
            if (totals.failure.trap != Trap::None) s.outcome.trouble = eval::describe(subdomain.module, totals.failure);
        }
        if (totals.failure.trap != Trap::None) return true;
        if (changes.done() && !totals.awake && !totals.waiting) return true;
    }
    if (speaks) s.outcome.trouble = fmt::format("never quiet after burst {}", burst);
    return false;
}

void run_process(comm::Communicator& comm, Shared& s) {
    sim::Subdomain subdomain(s.module, s.world, s.target, comm, s.setting.threads);
    if (const auto done = subdomain.populate(); !done) throw std::runtime_error(done.error().message());
    sim::Tick tick(subdomain);
    record::RunningDigest running;
    Changes changes(s.c, s.program.given);
    changes.lose(s.lost);
    const bool speaks = comm.process() == 0;
    for (std::size_t burst = 0; burst < s.c.bursts.size(); ++burst) {
        const bool quiet = settle(subdomain, tick, changes, s, burst, running);
        Facts& mine = s.facts[static_cast<std::size_t>(comm.process())];
        mine.clear();
        collect(subdomain, mine);
        comm.barrier();
        if (speaks) {
            for (const Change& change : s.c.bursts[burst]) s.mirror.apply(change);
            if (quiet && s.outcome.trouble.empty() && !s.setting.deep) compare(s, burst);
        }
        comm.barrier();
        if (!s.outcome.trouble.empty()) break;
    }
}

const Change* last_change(const Case& c, const Program& program) {
    Mirror mirror(c, program.given);
    const Change* last = nullptr;
    for (const auto& burst : c.bursts)
        for (const Change& change : burst)
            if (mirror.apply(change)) last = &change;
    return last;
}

}  // namespace

std::vector<Facts> expectations(const Case& c, const Program& program) {
    std::vector<Facts> all;
    Mirror mirror(c, program.given);
    for (const auto& burst : c.bursts) {
        for (const Change& change : burst) mirror.apply(change);
        all.push_back(from_scratch(program, make_scene(mirror, c.lattice)));
    }
    return all;
}

Outcome run(const Case& c, const Program& program, const ModuleInfo& module, const std::vector<Facts>& expected, const Setting& setting) {
    world::World world;
    world.lattice = c.lattice;
    world.cells = c.cells;
    const Result<world::Target> target = world::Target::make(world, world::Lattice(c.lattice));
    if (!target) throw std::runtime_error(target.error().message());
    Shared shared{.c = c,
                  .program = program,
                  .module = module,
                  .expected = expected,
                  .setting = setting,
                  .world = world,
                  .target = *target,
                  .lost = setting.lose_last_change ? last_change(c, program) : nullptr,
                  .facts = std::vector<Facts>(static_cast<std::size_t>(setting.processes)),
                  .mirror = Mirror(c, program.given)};
    if (setting.processes == 1) {
        const auto comm = comm::make_single();
        run_process(*comm, shared);
    } else {
        comm::run_threads_as_processes(setting.processes, [&](comm::Communicator& comm) { run_process(comm, shared); });
    }
    return std::move(shared.outcome);
}

Case shrink(Case c, const std::function<bool(const Case&)>& in_trouble) {
    int attempts = 2000;
    const auto attempt = [&](Case smaller) {
        if (--attempts < 0 || !in_trouble(smaller)) return false;
        c = std::move(smaller);
        return true;
    };
    for (bool smaller = true; smaller && attempts > 0;) {
        smaller = false;
        for (std::size_t b = c.bursts.size(); b-- > 0;) {
            for (std::size_t i = c.bursts[b].size(); i-- > 0;) {
                Case less = c;
                less.bursts[b].erase(less.bursts[b].begin() + static_cast<std::ptrdiff_t>(i));
                smaller = attempt(std::move(less)) || smaller;
            }
            Case less = c;
            less.bursts.erase(less.bursts.begin() + static_cast<std::ptrdiff_t>(b));
            if (!less.bursts.empty()) smaller = attempt(std::move(less)) || smaller;
        }
        for (std::size_t i = c.cells.size(); i-- > 0 && c.cells.size() > 1;) {
            Case less = c;
            less.cells.erase(less.cells.begin() + static_cast<std::ptrdiff_t>(i));
            smaller = attempt(std::move(less)) || smaller;
        }
    }
    return c;
}

}  // namespace meld::retraction
