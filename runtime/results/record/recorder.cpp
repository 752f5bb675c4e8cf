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
    appearance_.start(subdomain.program_actions);
    info_.lines = appearance_.lines();
    std::string descriptions;
    for (const RecordedPredicate& r : recorded_) descriptions += (descriptions.empty() ? "" : ", ") + r.description();
    info_.predicates = "[" + descriptions + "]";
    if (counts_)
        for (const auto& [name, value] : counts_()) info_.counts.push_back(name);
    return {};
}

Result<void> Recorder::find_looks(const sim::Subdomain& subdomain) {
    has_tails_ = subdomain.ensemble.has_amoebots();
    has_diameters_ = subdomain.has_diameters();
    has_rounded_ = subdomain.has_rounded();
    has_turns_ = subdomain.has_turns();
    has_joints_ = subdomain.has_joints();
    for (const RecordedPredicate& r : recorded_) {
        const std::string& name = r.name();
        if (name == "id" || name == "colour" || (name == "label" && appearance_.labels()) || (name == "diameter" && has_diameters_) ||
            (name == kTailPosition && has_tails_) || ((name == kCore || name == kOrientation) && has_rounded_) || (name == "load" && load_))
            return fail("a recording has an array '" + name + "' already, so it cannot have one of the predicate",
                        "Derive a predicate of another name from it");
    }
    return {};
}

Result<void> Recorder::start(sim::Subdomain& subdomain) {
    if (auto prepared = prepare(subdomain); !prepared) return prepared;
    if (auto found = find_looks(subdomain); !found) return found;
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
    appearance_.save(file_.has_value(), out);
    if (!file_) return;
    out.write(last_step_);
    out.write(steps_);
    joints_.save(out);
    file_->save(out);
}

Result<void> Recorder::load_rest(sim::Subdomain& subdomain, ByteReader& in) {
    const bool wrote = in.read<bool>(), writes = subdomain.comm.process() == 0;
    Appearance others;
    (writes ? appearance_ : others).load(wrote, in);
    if (!wrote) return {};
    if (loaded_ == Loaded::Begins) {
        in.read_bytes(in.left());
        return {};
    }
    last_step_ = in.read<std::int64_t>();
    steps_ = in.read<std::uint64_t>();
    joints_.load(in);
    if (writes) return keep(Recording::reopen(path_, info_, in));
    in.read_bytes(in.left());
    return {};
}

Result<void> Recorder::resumed(sim::Subdomain& subdomain) {
    if (auto found = find_looks(subdomain); !found) return found;
    return loaded_ == Loaded::Begins ? begin(subdomain) : Result<void>();
}

Result<void> Recorder::after(sim::Subdomain& subdomain) {
    appearance_.collect(subdomain);
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

std::array<double, 4> core_of(const world::RoundedBody& body) { return {body.core[0], body.core[1], body.core[2], body.rounding}; }

constexpr u64 kNobody = ~u64{0};
// If more than one catom of so many has changed, tables of facts are made anew.
constexpr std::size_t kFew = 4;

}  // namespace

// On one process of several, of those that may have changed. Returns whether all were there in the last step.
bool Recorder::note_ids(const sim::Subdomain& subdomain) {
    if (!changed_.empty()) recorded_ids_.resize(std::max<std::size_t>(recorded_ids_.size(), changed_.back() + std::size_t{1}), kNobody);
    bool same = true;
    for (const sim::Catom c : changed_) {
        const bool here = c < subdomain.ensemble.index_count() && subdomain.owned(c);
        const u64 id = here ? subdomain.ensemble.id(c) : kNobody;
        same = std::exchange(recorded_ids_[c], id) == id && same;
    }
    return same;
}

void Recorder::note_turns(const sim::Subdomain& subdomain) {
    recorded_turns_.resize(subdomain.ensemble.index_count());
    const std::size_t touched = changed_.size();
    for (sim::Catom c = 0; c < subdomain.ensemble.index_count(); ++c) {
        if (!subdomain.owned(c)) continue;
        const std::array<double, 4> turn = subdomain.rounded(c).turn;
        if (std::exchange(recorded_turns_[c], turn) != turn) changed_.push_back(c);
    }
    if (changed_.size() == touched) return;
    std::ranges::sort(changed_);
    const auto twice = std::ranges::unique(changed_);
    changed_.erase(twice.begin(), twice.end());
}

bool Recorder::find_changes(sim::Subdomain& subdomain) {
    if (touched_ == nullptr) {
        touched_ = &subdomain.follow();
        changed_.reserve(subdomain.ensemble.index_count());
    }
    changed_.clear();
    touched_->take([&](sim::Catom c) { changed_.push_back(c); });
    if (has_turns_) note_turns(subdomain);
    const bool same = subdomain.alone() ? follows_ && own_are_as_before(subdomain) : note_ids(subdomain) && follows_;
    const bool few = changed_.size() <= subdomain.ensemble.owned_count() / kFew ||
                     std::ranges::none_of(recorded_, [](const RecordedPredicate& r) { return r.has_table(); });
    // What catoms did in a step is another number in each.
    const std::byte mine{same && few && !load_};
    if (subdomain.alone()) return mine != std::byte{0};
    return std::ranges::all_of(subdomain.comm.allgather({&mine, 1}), [](std::byte each) { return each != std::byte{0}; });
}

Recorder::RecordedRow Recorder::row_of(const sim::Subdomain& subdomain, sim::Catom catom) {
    const world::Vec3 position = subdomain.ensemble.position(catom);
    return {subdomain.ensemble.id(catom), narrow(position), subdomain.ensemble.has_amoebots() ? tail_position(subdomain, catom) : position,
            subdomain.diameter(catom), subdomain.rounded(catom)};
}

void Recorder::pack_appearance(const sim::Subdomain& subdomain, ByteWriter& out) {
    appearance_.send(out);
    if (load_) load_->send(subdomain, out);
}

void Recorder::pack_facts(sim::Subdomain& subdomain, sim::Catom catom, ByteWriter& out) const {
    if (load_) out.write(LoadMap::here(subdomain, catom));
    for (const RecordedPredicate& r : recorded_) r.pack(subdomain, catom, out);
}

// What this process's catoms have drawn; then its catoms, or those among them that may have changed, each with its position and values.
std::vector<std::byte> Recorder::pack(sim::Subdomain& subdomain, bool whole) {
    ByteWriter out;
    out.reserve((whole ? subdomain.ensemble.owned_count() : changed_.size()) * sizeof(RecordedRow));
    pack_appearance(subdomain, out);
    const auto one = [&](sim::Catom c) {
        liveness::beat();
        if (!subdomain.owned(c)) return;
        out.write(row_of(subdomain, c));
        pack_facts(subdomain, c, out);
    };
    if (whole)
        for (sim::Catom c = 0; c < subdomain.ensemble.index_count(); ++c) one(c);
    else
        for (const sim::Catom c : changed_)
            if (c < subdomain.ensemble.index_count()) one(c);
    return out.take();
}

namespace {

// Calls visit(id, row, rest of the bytes) for the rows of all processes, in the order of ids. What stands before them is read first.
template <class Row, class Before, class Skip, class Visit>
void each_row(const std::vector<std::vector<std::byte>>& all, const Before& before, const Skip& skip, const Visit& visit) {
    // The bytes of each row, and where they start in those of their process.
    struct Packed {
        u64 id;
        std::size_t part, at;
        auto operator<=>(const Packed&) const = default;
    };
    std::vector<Packed> rows;
    std::size_t most = 0;
    for (const auto& part : all) most += part.size() / sizeof(Row);
    rows.reserve(most);
    for (std::size_t part = 0; part < all.size(); ++part) {
        ByteReader in(all[part], "a step of a recording");
        before(in);
        while (!in.done()) {
            liveness::beat();
            const std::size_t at = all[part].size() - in.left();
            rows.push_back({in.read<Row>().id, part, at});
            skip(in);
        }
    }
    std::sort(rows.begin(), rows.end());
    for (const auto& [id, part, at] : rows) {
        liveness::beat();
        const std::span<const std::byte> bytes = all[part];
        ByteReader in(bytes.subspan(at), "a row of a recording");
        const auto row = in.read<Row>();
        visit(row, in);
    }
}

}  // namespace

// In memory that is there already.
void Recorder::begin_rows(std::size_t most) {
    appearance_.begin_step();
    if (load_) load_->begin_step();
    step_.updated = false;
    const auto begin = [](auto& column, std::size_t size) {
        column.clear();
        column.reserve(size);
    };
    begin(step_.ids, most);
    begin(step_.positions, most);
    begin(step_.tails, has_tails_ ? most : 0);
    begin(step_.diameters, has_diameters_ ? most : 0);
    begin(step_.cores, has_rounded_ ? most : 0);
    begin(step_.orientations, has_turns_ ? most : 0);
    begin(step_.colours, 3 * most);
    begin(step_.labels, appearance_.labels() ? most : 0);
    for (RecordedPredicate& r : recorded_) r.begin_step(most);
}

void Recorder::read_appearance(ByteReader& in) {
    appearance_.receive(in);
    if (load_) load_->receive(in);
}

void Recorder::add_rounded(const world::RoundedBody& body) {
    if (has_rounded_) step_.cores.push_back(core_of(body));
    step_.orientations.push_back(body.turn);
}

void Recorder::replace_rounded(u64 row, const world::RoundedBody& body) {
    if (has_rounded_) replace(step_.cores, row, core_of(body), step_.changed_cores);
    replace(step_.orientations, row, body.turn, step_.changed_orientations);
}

void Recorder::add_row(const RecordedRow& row, ByteReader& facts) {
    step_.ids.push_back(row.id);
    if (load_) load_->add(row.id, facts.read<LoadMap::Load>());
    step_.positions.push_back(row.position);
    if (has_tails_) step_.tails.push_back(row.tail);
    if (has_diameters_) step_.diameters.push_back(row.diameter);
    if (has_turns_) add_rounded(row.rounded);
    const std::uint32_t colour = appearance_.colour(row.id);
    for (const int shift : {16, 8, 0}) step_.colours.push_back(static_cast<std::uint8_t>(colour >> shift));
    if (appearance_.labels()) step_.labels.push_back(appearance_.label(row.id));
    for (RecordedPredicate& r : recorded_) r.unpack(row.id, facts);
}

// Sorts the rows of all processes into columns, in the order of ids.
void Recorder::read_rows(const std::vector<std::vector<std::byte>>& all) {
    std::size_t most = 0;
    for (const auto& part : all) most += part.size() / sizeof(RecordedRow);
    begin_rows(most);
    const auto skip = [&](ByteReader& in) {
        if (load_) in.read<LoadMap::Load>();
        for (const RecordedPredicate& r : recorded_) r.skip(in);
    };
    each_row<RecordedRow>(
        all, [&](ByteReader& in) { read_appearance(in); }, skip, [&](const RecordedRow& row, ByteReader& in) { add_row(row, in); });
}

void Recorder::begin_update() {
    appearance_.begin_step();
    step_.updated = true;
    for (std::vector<u64>* rows : {&step_.moved, &step_.changed_tails, &step_.changed_diameters, &step_.changed_cores,
                                   &step_.changed_orientations, &step_.changed_colours, &step_.changed_labels})
        rows->clear();
    for (RecordedPredicate& r : recorded_) r.begin_update();
}

u64 Recorder::find_row(u64 id) const {
    const auto found = std::ranges::lower_bound(step_.ids, id);
    MELD_CHECK(found != step_.ids.end() && *found == id, "catom @{} is not in the step before", id);
    return static_cast<u64>(found - step_.ids.begin());
}

// Of the same catoms as the last step.
void Recorder::update_rows(const std::vector<std::vector<std::byte>>& all) {
    begin_update();
    const auto skip = [&](ByteReader& in) {
        for (const RecordedPredicate& r : recorded_) r.skip(in);
    };
    each_row<RecordedRow>(
        all, [&](ByteReader& in) { appearance_.receive(in); }, skip,
        [&](const RecordedRow& row, ByteReader& in) {
            const u64 at = row_with(row.id);
            replace(step_.positions, at, row.position, step_.moved);
            if (has_tails_) replace(step_.tails, at, row.tail, step_.changed_tails);
            if (has_diameters_) replace(step_.diameters, at, row.diameter, step_.changed_diameters);
            if (has_turns_) replace_rounded(at, row.rounded);
            for (RecordedPredicate& r : recorded_) r.update(at, row.id, in);
        });
    end_update();
}

void Recorder::end_update() {
    for (RecordedPredicate& r : recorded_) r.end_update();
    update_appearance();
}

// The catoms that have drawn something since.
void Recorder::update_appearance() {
    for (const u64 id : appearance_.news()) {
        const auto found = std::lower_bound(step_.ids.begin(), step_.ids.end(), id);
        if (found == step_.ids.end() || *found != id) continue;
        const auto at = static_cast<std::size_t>(found - step_.ids.begin());
        bool other = false;
        for (std::size_t i = 0; i < 3; ++i) {
            const auto part = static_cast<std::uint8_t>(appearance_.colour(id) >> (16 - 8 * i));
            other = std::exchange(step_.colours[3 * at + i], part) != part || other;
        }
        if (other) step_.changed_colours.push_back(at);
        if (!appearance_.labels() || step_.labels[at] == appearance_.label(id)) continue;
        step_.labels[at] = appearance_.label(id);
        step_.changed_labels.push_back(at);
    }
    std::ranges::sort(step_.changed_colours);
    std::ranges::sort(step_.changed_labels);
}

// Lines between catoms that both exist, by their indices.
std::vector<RecordedLine> Recorder::lines_between(std::span<const u64> ids) {
    std::vector<RecordedLine> lines;
    const auto place = [&](u64 id) {
        const auto found = std::lower_bound(ids.begin(), ids.end(), id);
        return found == ids.end() || *found != id ? -1 : found - ids.begin();
    };
    for (const auto& [from, to] : appearance_.drawn()) {
        const RecordedLine line = {place(from), place(to)};
        if (line[0] >= 0 && line[1] >= 0) lines.push_back(line);
    }
    return lines;
}

Result<void> Recorder::write_step(const sim::Subdomain& subdomain, const Digest& state, std::span<const world::JointLook> joints) {
    const auto column = [&](const char* name, RecordedArray::Type type, const void* data, int components, const std::vector<u64>& changed) {
        return RecordedArray{.name = name,
                             .type = type,
                             .data = data,
                             .components = components,
                             .same = step_.updated && changed.empty(),
                             .changed = step_.updated ? &changed : nullptr};
    };
    std::vector<RecordedArray> arrays{column("colour", RecordedArray::UInt8, step_.colours.data(), 3, step_.changed_colours)};
    if (has_diameters_) arrays.push_back(column("diameter", RecordedArray::Float64, step_.diameters.data(), 1, step_.changed_diameters));
    if (has_rounded_) arrays.push_back(column(kCore, RecordedArray::Float64, step_.cores.data(), 4, step_.changed_cores));
    if (has_turns_)
        arrays.push_back(
            column(has_rounded_ ? kOrientation : kTurns, RecordedArray::Float64, step_.orientations.data(), 4, step_.changed_orientations));
    if (has_tails_) arrays.push_back(column(kTailPosition, RecordedArray::Float64, step_.tails.data(), 3, step_.changed_tails));
    if (appearance_.labels()) arrays.push_back(column("label", RecordedArray::Text, step_.labels.data(), 1, step_.changed_labels));
    if (load_) load_->list(arrays);
    std::vector<RecordedTable> tables;
    for (const RecordedPredicate& r : recorded_) r.list(arrays, tables);
    if (has_joints_) {
        joints_.note(joints, step_.ids);
        tables.push_back(joints_.table());
    }
    return file_->step(
        static_cast<double>(subdomain.tick()), step_.positions, step_.ids, arrays, lines_between(step_.ids), tables, state,
        {.ids = step_.updated, .positions = step_.updated && step_.moved.empty(), .moved = step_.updated ? &step_.moved : nullptr});
}

std::vector<std::vector<std::byte>> Recorder::gather(sim::Subdomain& subdomain, bool whole) {
    std::vector<std::byte> mine = pack(subdomain, whole);
    std::vector<comm::Packet> packets;
    std::vector<std::vector<std::byte>> all;
    if (subdomain.comm.process() == 0)
        all.push_back(std::move(mine));
    else if (!mine.empty())
        packets.push_back({0, std::move(mine)});
    if (!subdomain.alone())
        for (comm::Packet& p : subdomain.comm.exchange(std::move(packets))) all.push_back(std::move(p.bytes));
    return all;
}

// Process 0 gets all data, or what may have changed since the last step, and writes them.
Result<void> Recorder::write(sim::Subdomain& subdomain) {
    last_step_ = subdomain.tick();
    const Digest state = digest_.of(subdomain);
    const bool whole = !find_changes(subdomain);
    if (subdomain.alone()) {
        if (whole)
            read_own_rows(subdomain);
        else
            update_own_rows(subdomain);
    } else if (const std::vector<std::vector<std::byte>> all = gather(subdomain, whole); file_) {
        if (whole)
            read_rows(all);
        else
            update_rows(all);
    }
    const std::vector<world::JointLook> joints = all_joints(subdomain);
    Result<void> done;
    if (file_) {
        done = write_step(subdomain, state, joints);
        if (done) ++steps_;
    }
    done = comm::outcome_of_first(subdomain.comm, done);
    // What there was no space for is not what the next step can refer to.
    follows_ = done.has_value();
    return done;
}

}  // namespace meld::record
