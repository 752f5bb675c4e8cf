#include "runtime/record/recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <span>
#include <utility>

#include "runtime/base/bytes.h"
#include "runtime/base/nearest.h"
#include "runtime/comm/outcome.h"
#include "runtime/tuple/facts.h"
#include "runtime/tuple/value_text.h"

namespace meld::record {

Recorder::Recorder(std::string path, int every, std::vector<std::string> predicates, RecordingInfo info)
    : path_(std::move(path)), every_(every), wanted_(std::move(predicates)), info_(std::move(info)) {}

Result<void> Recorder::start(sim::Subdomain& part) {
    std::vector<std::string_view> known;
    for (u32 i = 0; i < part.module.predicate_count; ++i)
        if (!part.module.predicates[i].auxiliary && part.module.predicates[i].column != kNone16)
            known.emplace_back(part.module.predicates[i].name);
    for (const std::string& name : wanted_) {
        bool found = false;
        for (u32 i = 0; i < part.module.predicate_count; ++i) {
            const PredicateInfo& p = part.module.predicates[i];
            if (name != p.name || p.auxiliary || p.column == kNone16) continue;
            found = true;
            const ValueType type = p.arity > 0 ? p.fields[0].type : ValueType::Int;
            recorded_.push_back({i, name,
                                 type == ValueType::Float    ? As::Real
                                 : type == ValueType::Vec3   ? As::Vector
                                 : type >= ValueType::String ? As::Text
                                                             : As::Integer});
            break;
        }
        if (!found) return fail("the program stores no predicate '" + name + "' to record", did_you_mean(name, known));
    }
    marks_.start(part.program_actions);
    info_.lines = marks_.lines();
    for (const Recorded& r : recorded_)
        if (r.name == "id" || r.name == "colour" || (r.name == "label" && marks_.labels()) ||
            (r.name == "diameter" && part.has_diameters()))
            return fail("a recording has an array '" + r.name + "' already, so it cannot have one of the predicate",
                        "Derive a predicate of another name from it");
    Result<void> begun;
    if (part.comm.process() == 0) {
        Result<Recording> file = Recording::create(path_, info_);
        if (file)
            file_.emplace(std::move(*file));
        else
            begun = tl::unexpected(file.error());
    }
    if (const auto all = comm::outcome_of_first(part.comm, begun); !all) return all;
    part.refresh();
    return write(part);
}

Result<void> Recorder::after(sim::Subdomain& part) {
    marks_.collect(part);
    if (part.tick() % every_ != 0) return {};
    return write(part);
}

void Recorder::finish(sim::Subdomain& part) {
    if (last_step_ != part.tick() && !part.status().half_way()) ending_ = write(part);
    Result<void> closed;
    if (file_) closed = file_->close();
    closed = comm::outcome_of_first(part.comm, closed);
    if (ending_) ending_ = closed;
    outcome_ = fmt::format("recorded {} steps in {}", steps_, path_);
}

namespace {

struct Row {
    u64 id;
    world::Vec3 position;
    double diameter;
};

}  // namespace

// A step as its columns.
struct Recorder::Step {
    std::vector<u64> ids;
    std::vector<world::Vec3> positions;
    std::vector<double> diameters;
    std::vector<std::uint8_t> colours;
    std::vector<std::string> labels;
    std::vector<std::vector<u64>> numbers;  // By recorded predicate, as words.
    std::vector<std::vector<std::string>> texts;
};

// What the first fact of the predicate has as its first argument. Where there is no such fact a number is -1, a vector is
// not a number, a text is empty; a predicate without arguments is 1 or 0.
void Recorder::put_value(sim::Subdomain& part, const Recorded& recorded, sim::Catom catom, ByteWriter& out) const {
    const PredicateInfo& p = part.module.predicates[recorded.predicate];
    const bool plain = p.arity == 0;
    bool found = false;
    Value first{};
    tuple::each_fact(part.module, part.columns, part.geometry(), recorded.predicate, catom, [&](const Value* v) {
        if (!found && !plain) first = v[0];
        found = true;
    });
    switch (recorded.as) {
        case As::Integer:
            if (plain)
                first.integer = found ? 1 : 0;
            else if (!found)
                first.integer = -1;
            return out.write(first);
        case As::Real:
            if (!found) first.real = -1;
            return out.write(first);
        case As::Vector:
            for (std::size_t i = 0; i < 3; ++i)
                out.write(i < tuple::length(first.list) ? tuple::item(first.list, i).real : std::numeric_limits<double>::quiet_NaN());
            return;
        case As::Text:
            out.write_string(found ? tuple::print_value(tuple::type_of(part.module, p.fields[0]), first) : "");
    }
}

// What this process's catoms have drawn; then its catoms, each with its position and values.
std::vector<std::byte> Recorder::pack(sim::Subdomain& part) {
    ByteWriter out;
    marks_.send(out);
    for (sim::Catom c = 0; c < part.ensemble.index_count(); ++c) {
        if (!part.owned(c)) continue;
        out.write(Row{part.ensemble.id(c), part.ensemble.position(c), part.diameter(c)});
        for (const Recorded& r : recorded_) put_value(part, r, c, out);
    }
    return out.take();
}

// The rows of all processes into columns, in the order of ids.
void Recorder::read_rows(const std::vector<std::vector<std::byte>>& all, Step& step) {
    // The bytes of each row, and where in their process's they start.
    struct Packed {
        u64 id;
        std::size_t part, at;
        auto operator<=>(const Packed&) const = default;
    };
    std::vector<Packed> rows;
    marks_.begin_step();
    for (std::size_t part = 0; part < all.size(); ++part) {
        ByteReader in(all[part], "a step of a recording");
        marks_.receive(in);
        while (!in.done()) {
            const std::size_t at = all[part].size() - in.left();
            rows.push_back({in.read<Row>().id, part, at});
            for (const Recorded& r : recorded_) {
                if (r.as == As::Text)
                    in.read_block();
                else
                    in.read_bytes((r.as == As::Vector ? 3 : 1) * sizeof(double));
            }
        }
    }
    std::sort(rows.begin(), rows.end());
    step.numbers.resize(recorded_.size());
    step.texts.resize(recorded_.size());
    for (const auto& [id, part, at] : rows) {
        const std::span<const std::byte> bytes = all[part];
        ByteReader in(bytes.subspan(at), "a row of a recording");
        const auto row = in.read<Row>();
        step.ids.push_back(id);
        step.positions.push_back(row.position);
        step.diameters.push_back(row.diameter);
        for (const int shift : {16, 8, 0}) step.colours.push_back(static_cast<std::uint8_t>(marks_.colour(id) >> shift));
        if (marks_.labels()) step.labels.push_back(marks_.label(id));
        for (std::size_t i = 0; i < recorded_.size(); ++i) {
            if (recorded_[i].as == As::Text)
                step.texts[i].push_back(in.read_string());
            else
                for (int k = recorded_[i].as == As::Vector ? 3 : 1; k > 0; --k) step.numbers[i].push_back(in.read<u64>());
        }
    }
}

// Lines between catoms that are both there, by their places.
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

Result<void> Recorder::write_step(sim::Subdomain& part, const std::vector<std::vector<std::byte>>& all) {
    Step step;
    read_rows(all, step);
    std::vector<RecordedArray> arrays{{"colour", RecordedArray::UInt8, step.colours.data(), 3}};
    if (part.has_diameters()) arrays.push_back({"diameter", RecordedArray::Float64, step.diameters.data(), 1});
    if (marks_.labels()) arrays.push_back({"label", RecordedArray::Text, step.labels.data(), 1});
    for (std::size_t i = 0; i < recorded_.size(); ++i) {
        const Recorded& r = recorded_[i];
        if (r.as == As::Text)
            arrays.push_back({r.name, RecordedArray::Text, step.texts[i].data(), 1});
        else
            arrays.push_back({r.name, r.as == As::Integer ? RecordedArray::Int64 : RecordedArray::Float64, step.numbers[i].data(),
                              r.as == As::Vector ? 3 : 1});
    }
    return file_->step(static_cast<double>(part.tick()), step.positions, step.ids, arrays, lines_between(step.ids));
}

// Process 0 gets everything and writes it.
Result<void> Recorder::write(sim::Subdomain& part) {
    last_step_ = part.tick();
    std::vector<std::byte> mine = pack(part);
    std::vector<comm::Packet> packets;
    std::vector<std::vector<std::byte>> all;
    if (part.comm.process() == 0)
        all.push_back(std::move(mine));
    else if (!mine.empty())
        packets.push_back({0, std::move(mine)});
    if (!part.alone())
        for (comm::Packet& p : part.comm.exchange(std::move(packets))) all.push_back(std::move(p.bytes));
    Result<void> done;
    if (file_) {
        done = write_step(part, all);
        if (done) ++steps_;
    }
    return comm::outcome_of_first(part.comm, done);
}

}  // namespace meld::record
