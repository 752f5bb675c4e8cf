#include "runtime/ask/debug/facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <string_view>
#include <utility>

#include "runtime/ask/facts/catom.h"
#include "runtime/base/bytes.h"
#include "runtime/base/did_you_mean.h"
#include "runtime/base/natural_order.h"
#include "runtime/comm/transport/gather_to_root.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/results/facts/fact_tables.h"
#include "runtime/results/facts/sorted_facts.h"

namespace meld::debug {

namespace {

using record::FactTable;
using CatomsById = std::vector<std::pair<u64, sim::Catom>>;

std::string fact_line(const ModuleInfo& module, u32 predicate, u64 id, const std::vector<Value>& arguments) {
    return tuple::print_fact(module, module.predicates[predicate], id, arguments.data()) + ".";
}

// The numbers of all processes, in their order.
std::vector<u64> gather_number(u64 mine, comm::Communicator& comm) {
    ByteWriter out;
    out.write(mine);
    const std::vector<std::byte> all = comm.allgather(out.view());
    std::vector<u64> numbers;
    for (ByteReader in(all, "numbers of processes"); !in.done();) numbers.push_back(in.read<u64>());
    return numbers;
}

u64 sum_of_all(u64 mine, comm::Communicator& comm) {
    const std::vector<u64> all = gather_number(mine, comm);
    return std::accumulate(all.begin(), all.end(), u64{0});
}

Result<std::vector<FactTable>> tables_named(const ModuleInfo& module, const std::string& name) {
    std::vector<FactTable> all = record::fact_tables(module), found;
    if (name.empty()) return all;
    std::vector<std::string_view> known;
    for (const FactTable& table : all) {
        known.emplace_back(module.predicates[table.predicate].name);
        if (table.name == name || known.back() == name) found.push_back(table);
    }
    if (!found.empty()) return found;
    const auto near = nearest_name(name, known);
    return fail(fmt::format("the program has no facts named '{}'", name), near ? fmt::format("Did you mean '{}'?", *near) : "");
}

// The facts of one table.
struct Rows {
    u64 count = 0;
    std::vector<std::pair<u64, std::string>> lines;  // With the catom; by that and by arguments.
};

Rows rows_of(const sim::Subdomain& subdomain, const CatomsById& catoms, const FactTable& table, u64 most_lines) {
    Rows out;
    for (const auto& [id, catom] : catoms)
        for (const std::vector<Value>& fact : record::sorted_facts(subdomain, table.predicate, catom))
            if (++out.count <= most_lines) out.lines.emplace_back(id, fact_line(subdomain.module, table.predicate, id, fact));
    return out;
}

// The rows of all processes, on process 0; a catom's are all of one process.
Rows gather_rows(Rows mine, sim::Subdomain& subdomain) {
    if (subdomain.alone()) return mine;
    const bool first = subdomain.comm.process() == 0;
    ByteWriter out;
    out.write(mine.count);
    for (const auto& [id, line] : mine.lines) {
        out.write(id);
        out.write_string(line);
    }
    std::vector<comm::Packet> packets;
    if (!first) packets.push_back({0, out.take()});
    for (const comm::Packet& packet : subdomain.comm.exchange(std::move(packets))) {
        ByteReader in(packet.bytes, "facts of a process");
        mine.count += in.read<u64>();
        while (!in.done()) {
            const u64 id = in.read<u64>();
            mine.lines.emplace_back(id, in.read_string());
        }
    }
    std::ranges::stable_sort(mine.lines, {}, &std::pair<u64, std::string>::first);
    return mine;
}

using Lines = std::vector<std::string>;

// The lines of one table in two states of a run, before and now.
struct TwoStates {
    Lines before, now;
};

// Those of the catoms that this process compares: catoms may have gone from one process to another.
TwoStates divide(const std::array<Rows, 2>& mine, comm::Communicator& comm) {
    const auto processes = static_cast<u64>(comm.processes());
    const auto self = static_cast<u64>(comm.process());
    TwoStates out;
    std::map<u64, ByteWriter> to;
    for (std::size_t state : {0u, 1u})
        for (const auto& [id, line] : mine[state].lines) {
            if (id % processes == self) {
                (state == 0 ? out.before : out.now).push_back(line);
                continue;
            }
            ByteWriter& writer = to[id % processes];
            writer.write(static_cast<std::uint8_t>(state));
            writer.write_string(line);
        }
    if (processes > 1) {
        std::vector<comm::Packet> packets;
        for (auto& [process, writer] : to) packets.push_back({static_cast<int>(process), writer.take()});
        for (const comm::Packet& packet : comm.exchange(std::move(packets)))
            for (ByteReader in(packet.bytes, "facts of two states"); !in.done();) {
                Lines& lines = in.read<std::uint8_t>() == 0 ? out.before : out.now;
                lines.push_back(in.read_string());
            }
    }
    std::ranges::sort(out.before);
    std::ranges::sort(out.now);
    return out;
}

Lines only_in_first(const Lines& a, const Lines& b) {
    Lines only;
    std::ranges::set_difference(a, b, std::back_inserter(only));
    return only;
}

// The first so many facts of all processes, on process 0.
Lines gather_first(Lines mine, u64 most, comm::Communicator& comm) {
    const auto cut = [&](Lines& lines) {
        std::ranges::sort(lines, natural_less);
        if (lines.size() > most) lines.resize(static_cast<std::size_t>(most));
    };
    cut(mine);
    if (comm.processes() == 1) return mine;
    ByteWriter out;
    for (const std::string& line : mine) out.write_string(line);
    Lines all;
    for (const auto& bytes : comm::gather_to_root(comm, out.take()))
        for (ByteReader in(bytes, "facts that have changed"); !in.done();) all.push_back(in.read_string());
    cut(all);
    return all;
}

// Adds as many as there is room for, without their full stops.
void add_lines(const Lines& more, u64 most, Lines& lines) {
    for (const std::string& line : more)
        if (lines.size() < most) lines.push_back(line.substr(0, line.size() - 1));
}

}  // namespace

bool catom_exists(sim::Subdomain& subdomain, std::uint64_t id) {
    const std::optional<sim::Catom> catom = subdomain.ensemble.find(id);
    return sum_of_all(catom && subdomain.owned(*catom) ? 1 : 0, subdomain.comm) > 0;
}

Result<FactsFound> find_facts(sim::Subdomain& subdomain, const WhichFacts& which) {
    const Result<std::vector<FactTable>> tables = tables_named(subdomain.module, which.name);
    if (!tables) return tl::unexpected<Error>(tables.error());
    subdomain.refresh();
    CatomsById catoms;
    if (which.catom) {
        const std::optional<sim::Catom> catom = subdomain.ensemble.find(*which.catom);
        if (catom && subdomain.owned(*catom)) catoms.emplace_back(*which.catom, *catom);
        if (!catom_exists(subdomain, *which.catom))
            return fail(fmt::format("there is no catom @{} in tick {}", *which.catom, subdomain.tick()));
    } else {
        catoms = record::catoms_by_id(subdomain);
    }
    FactsFound found{.tick = subdomain.tick()};
    if (which.catom && which.name.empty()) found.catom = inspect::find_catom(subdomain, *which.catom);
    for (const FactTable& table : *tables) {
        Rows rows = gather_rows(rows_of(subdomain, catoms, table, which.most_lines), subdomain);
        if (subdomain.comm.process() != 0) continue;
        found.count += rows.count;
        for (auto& [id, line] : rows.lines)
            if (found.lines.size() < which.most_lines) found.lines.push_back(std::move(line));
    }
    return found;
}

ChangedFacts find_changed_facts(sim::Subdomain& before, sim::Subdomain& now, u64 most_lines) {
    before.refresh();
    now.refresh();
    const CatomsById catoms_before = record::catoms_by_id(before), catoms_now = record::catoms_by_id(now);
    ChangedFacts out;
    constexpr u64 kAll = ~u64{0};
    for (const FactTable& table : record::fact_tables(now.module)) {
        const TwoStates here = divide({rows_of(before, catoms_before, table, kAll), rows_of(now, catoms_now, table, kAll)}, now.comm);
        Lines come = only_in_first(here.now, here.before), gone = only_in_first(here.before, here.now);
        Changes::Predicate changed{
            .name = table.name, .come = sum_of_all(come.size(), now.comm), .gone = sum_of_all(gone.size(), now.comm)};
        if (changed.come == 0 && changed.gone == 0) continue;
        out.predicates.push_back(std::move(changed));
        if (most_lines == 0) continue;
        add_lines(gather_first(std::move(gone), most_lines, now.comm), most_lines, out.gone);
        add_lines(gather_first(std::move(come), most_lines, now.comm), most_lines, out.come);
    }
    if (out.gone.size() + out.come.size() > most_lines) out.come.resize(static_cast<std::size_t>(most_lines - out.gone.size()));
    return out;
}

std::vector<Changes::Predicate> find_changes(sim::Subdomain& before, sim::Subdomain& now) {
    return find_changed_facts(before, now, 0).predicates;
}

}  // namespace meld::debug
