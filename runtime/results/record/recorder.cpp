#include "runtime/results/record/recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <span>
#include <utility>

#include "runtime/base/bytes.h"
#include "runtime/base/did_you_mean.h"
#include "runtime/base/process/liveness.h"
#include "runtime/comm/transport/collective_result.h"
#include "runtime/results/record/drawing.h"
#include "runtime/results/record/state_digest.h"

namespace meld::record {

Recorder::Recorder(std::string path, int every, std::vector<std::string> predicates, RecordingInfo info, Loaded loaded)
    : path_(std::move(path)), every_(every), wanted_(std::move(predicates)), info_(std::move(info)), loaded_(loaded) {}

// A name stands for all predicates that have it; where there are several, the arrays of each have the number of its arguments in their
// names.
Result<void> Recorder::add_predicates(const sim::Subdomain& subdomain) {
    const ModuleInfo& module = subdomain.module;
    std::map<std::string_view, std::vector<u32>> stored;
    std::vector<std::string_view> known;
    for (u32 i = 0; i < module.predicate_count; ++i) {
        const PredicateInfo& p = module.predicates[i];
        if (!p.auxiliary && p.column != kNone16) stored[p.name].push_back(i);
    }
    for (const auto& [name, predicates] : stored) known.push_back(name);
    for (const std::string& name : wanted_) {
        const auto found = stored.find(name);
        if (found == stored.end()) return fail("the program stores no predicate '" + name + "' to record", did_you_mean(name, known));
        if (std::ranges::any_of(recorded_, [&](const RecordedPredicate& r) { return r.predicate() == found->second.front(); })) continue;
        for (const u32 predicate : found->second)
            recorded_.emplace_back(module, predicate,
                                   found->second.size() == 1 ? name : fmt::format("{}.{}", name, module.predicates[predicate].arity + 1));
    }
    return {};
}

Result<void> Recorder::prepare(sim::Subdomain& subdomain) {
    if (auto added = add_predicates(subdomain); !added) return added;
    marks_.start(subdomain.program_actions);
    info_.lines = marks_.lines();
    std::string descriptions;
    for (const RecordedPredicate& r : recorded_) {
        const std::string& name = r.name();
        if (name == "id" || name == "colour" || (name == "label" && marks_.labels()) || (name == "diameter" && subdomain.has_diameters()) ||
            (name == kTailPosition && subdomain.ensemble.has_amoebots()) || (name == "load" && load_))
            return fail("a recording has an array '" + name + "' already, so it cannot have one of the predicate",
                        "Derive a predicate of another name from it");
        descriptions += (descriptions.empty() ? "" : ", ") + r.description();
    }
    info_.predicates = "[" + descriptions + "]";
    if (counts_)
        for (const auto& [name, value] : counts_()) info_.counts.push_back(name);
    return {};
}

Result<void> Recorder::start(sim::Subdomain& subdomain) {
    if (auto prepared = prepare(subdomain); !prepared) return prepared;
    return begin(subdomain);
}

Result<void> Recorder::begin(sim::Subdomain& subdomain) {
    Result<void> begun;
    if (subdomain.comm.process() == 0) begun = keep(Recording::create(path_, info_));
    if (const auto all = comm::outcome_of_first(subdomain.comm, begun); !all) return all;
    subdomain.refresh();
    return write(subdomain);
}

Result<void> Recorder::keep(Result<Recording> file) {
    if (!file) return tl::unexpected(file.error());
    file_.emplace(std::move(*file));
    return {};
}

Result<void> Recorder::resume(sim::Subdomain& subdomain) { return prepare(subdomain); }

Result<void> Recorder::secure(sim::Subdomain& subdomain) {
    return comm::outcome_of_first(subdomain.comm, file_ ? file_->secure() : Result<void>());
}

void Recorder::save_rest(const sim::Subdomain&, ByteWriter& out) const {
    out.write(file_.has_value());
    marks_.save(file_.has_value(), out);
    if (!file_) return;
    out.write(last_step_);
    out.write(steps_);
    file_->save(out);
}

Result<void> Recorder::load_rest(sim::Subdomain& subdomain, ByteReader& in) {
    const bool wrote = in.read<bool>(), writes = subdomain.comm.process() == 0;
    Marks others;
    (writes ? marks_ : others).load(wrote, in);
    if (!wrote) return {};
    if (loaded_ == Loaded::Begins) {
        in.read_bytes(in.left());
        return {};
    }
    last_step_ = in.read<std::int64_t>();
    steps_ = in.read<std::uint64_t>();
    if (writes) return keep(Recording::reopen(path_, info_, in));
    in.read_bytes(in.left());
    return {};
}

Result<void> Recorder::resumed(sim::Subdomain& subdomain) { return loaded_ == Loaded::Begins ? begin(subdomain) : Result<void>(); }

Result<void> Recorder::after(sim::Subdomain& subdomain) {
    marks_.collect(subdomain);
    if (subdomain.tick() % every_ != 0) return {};
    return write(subdomain);
}

void Recorder::finish(sim::Subdomain& subdomain) {
    if (last_step_ != subdomain.tick() && !subdomain.status().half_way()) ending_ = write(subdomain);
    Result<void> closed;
    if (file_ && counts_) file_->count(counts_());
    if (file_) closed = file_->close();
    closed = comm::outcome_of_first(subdomain.comm, closed);
    if (ending_) ending_ = closed;
    outcome_ = fmt::format("recorded {} steps in {}", steps_, path_);
}

namespace {

struct RecordedRow {
    u64 id;
    world::Vec3 position, tail;
    double diameter;
};

}  // namespace

// A step as its columns.
struct Recorder::Step {
    std::vector<u64> ids;
    std::vector<world::Vec3> positions, tails;
    std::vector<double> diameters;
    std::vector<std::uint8_t> colours;
    std::vector<std::string> labels;
};

// What this process's catoms have drawn; then its catoms, each with its position and values.
std::vector<std::byte> Recorder::pack(sim::Subdomain& subdomain) {
    ByteWriter out;
    out.reserve(subdomain.ensemble.owned_count() * sizeof(RecordedRow));
    marks_.send(out);
    if (load_) load_->send(subdomain, out);
    for (sim::Catom c = 0; c < subdomain.ensemble.index_count(); ++c) {
        liveness::beat();
        if (!subdomain.owned(c)) continue;
        out.write(
            RecordedRow{subdomain.ensemble.id(c), subdomain.ensemble.position(c), tail_position(subdomain, c), subdomain.diameter(c)});
        if (load_) out.write(LoadMap::here(subdomain, c));
        for (const RecordedPredicate& r : recorded_) r.pack(subdomain, c, out);
    }
    return out.take();
}

// Sorts the rows of all processes into columns, in the order of ids.
void Recorder::read_rows(const std::vector<std::vector<std::byte>>& all, Step& step) {
    // The bytes of each row, and where they start in those of their process.
    struct Packed {
        u64 id;
        std::size_t part, at;
        auto operator<=>(const Packed&) const = default;
    };
    std::vector<Packed> rows;
    std::size_t most = 0;
    for (const auto& part : all) most += part.size() / sizeof(RecordedRow);
    rows.reserve(most);
    marks_.begin_step();
    if (load_) load_->begin_step();
    for (std::size_t part = 0; part < all.size(); ++part) {
        ByteReader in(all[part], "a step of a recording");
        marks_.receive(in);
        if (load_) load_->receive(in);
        while (!in.done()) {
            liveness::beat();
            const std::size_t at = all[part].size() - in.left();
            rows.push_back({in.read<RecordedRow>().id, part, at});
            if (load_) in.read<LoadMap::Load>();
            for (const RecordedPredicate& r : recorded_) r.skip(in);
        }
    }
    std::sort(rows.begin(), rows.end());
    for (RecordedPredicate& r : recorded_) r.begin_step();
    step.ids.reserve(rows.size());
    step.positions.reserve(rows.size());
    step.diameters.reserve(rows.size());
    step.colours.reserve(3 * rows.size());
    for (const auto& [id, part, at] : rows) {
        liveness::beat();
        const std::span<const std::byte> bytes = all[part];
        ByteReader in(bytes.subspan(at), "a row of a recording");
        const auto row = in.read<RecordedRow>();
        step.ids.push_back(id);
        if (load_) load_->add(id, in.read<LoadMap::Load>());
        step.positions.push_back(row.position);
        step.tails.push_back(row.tail);
        step.diameters.push_back(row.diameter);
        for (const int shift : {16, 8, 0}) step.colours.push_back(static_cast<std::uint8_t>(marks_.colour(id) >> shift));
        if (marks_.labels()) step.labels.push_back(marks_.label(id));
        for (RecordedPredicate& r : recorded_) r.unpack(id, in);
    }
}

// Lines between catoms that both exist, by their indices.
std::vector<RecordedLine> Recorder::lines_between(const std::vector<u64>& ids) {
    std::vector<RecordedLine> lines;
    const auto place = [&](u64 id) {
        const auto found = std::lower_bound(ids.begin(), ids.end(), id);
        return found == ids.end() || *found != id ? -1 : found - ids.begin();
    };
    for (const auto& [from, to] : marks_.drawn()) {
        const RecordedLine line = {place(from), place(to)};
        if (line[0] >= 0 && line[1] >= 0) lines.push_back(line);
    }
    return lines;
}

Result<void> Recorder::write_step(sim::Subdomain& subdomain, const Digest& state, const std::vector<std::vector<std::byte>>& all) {
    Step step;
    read_rows(all, step);
    std::vector<RecordedArray> arrays{{"colour", RecordedArray::UInt8, step.colours.data(), 3}};
    if (subdomain.has_diameters()) arrays.push_back({"diameter", RecordedArray::Float64, step.diameters.data(), 1});
    if (subdomain.ensemble.has_amoebots()) arrays.push_back({kTailPosition, RecordedArray::Float64, step.tails.data(), 3});
    if (marks_.labels()) arrays.push_back({"label", RecordedArray::Text, step.labels.data(), 1});
    if (load_) load_->list(arrays);
    std::vector<RecordedTable> tables;
    for (const RecordedPredicate& r : recorded_) r.list(arrays, tables);
    return file_->step(static_cast<double>(subdomain.tick()), step.positions, step.ids, arrays, lines_between(step.ids), tables, state);
}

// Process 0 gets all data and writes them.
Result<void> Recorder::write(sim::Subdomain& subdomain) {
    last_step_ = subdomain.tick();
    const Digest state = state_digest(subdomain);
    std::vector<std::byte> mine = pack(subdomain);
    std::vector<comm::Packet> packets;
    std::vector<std::vector<std::byte>> all;
    if (subdomain.comm.process() == 0)
        all.push_back(std::move(mine));
    else if (!mine.empty())
        packets.push_back({0, std::move(mine)});
    if (!subdomain.alone())
        for (comm::Packet& p : subdomain.comm.exchange(std::move(packets))) all.push_back(std::move(p.bytes));
    Result<void> done;
    if (file_) {
        done = write_step(subdomain, state, all);
        if (done) ++steps_;
    }
    return comm::outcome_of_first(subdomain.comm, done);
}

}  // namespace meld::record
