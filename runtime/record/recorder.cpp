#include "runtime/record/recorder.h"

#include <fmt/format.h>

#include <algorithm>

#include "runtime/base/nearest.h"
#include "runtime/sim/bytes.h"
#include "runtime/tuple/facts.h"

namespace meld::record {

using sim::put;
using sim::take_value;

Recorder::Recorder(std::string path, int every, std::vector<std::string> predicates, RecordingInfo info)
    : path_(std::move(path)), every_(every), wanted_(std::move(predicates)), info_(std::move(info)) {}

Result<void> Recorder::start(sim::PartState& part) {
    std::vector<std::string_view> known;
    for (u32 i = 0; i < part.module.predicate_count; ++i)
        if (!part.module.predicates[i].auxiliary && part.module.predicates[i].column != kNone16) known.emplace_back(part.module.predicates[i].name);
    for (const std::string& name : wanted_) {
        bool found = false;
        for (u32 i = 0; i < part.module.predicate_count; ++i) {
            const PredicateInfo& p = part.module.predicates[i];
            if (name != p.name || p.auxiliary || p.column == kNone16) continue;
            found = true;
            recorded_.push_back({i, name, p.arity > 0 && p.fields[0].type == ValueType::Float});
            break;
        }
        if (!found) return fail("the program stores no predicate '" + name + "' to record", did_you_mean(name, known));
    }
    set_color_ = tuple::find_predicate(part.module, "setColor", 3);
    std::vector<std::byte> outcome;
    Error error;
    if (part.comm.part() == 0) {
        Result<Recording> file = Recording::create(path_, info_);
        if (file) file_.emplace(std::move(*file));
        else error = file.error();
    }
    put(outcome, file_.has_value());
    const std::vector<std::byte> all = part.comm.allgather(outcome);
    const std::byte* at = all.data();
    if (!take_value<bool>(at)) return tl::unexpected<Error>(part.comm.part() == 0 ? error : Error{"cannot write " + path_, ""});
    part.refresh();
    return write(part);
}

// The colours asked for in this tick.
void Recorder::colour(sim::PartState& part) {
    if (!set_color_) return;
    for (const eval::Action& a : part.actions()) {
        if (a.predicate != *set_color_) continue;
        std::uint32_t rgb = 0;
        for (u32 i = 0; i < 3; ++i) rgb = rgb << 8 | static_cast<std::uint32_t>(std::clamp<i64>(a.arguments[i].integer, 0, 255));
        colours_[part.ensemble.id(a.catom)] = rgb;
    }
}

Result<void> Recorder::after(sim::PartState& part) {
    colour(part);
    if (part.abi.now % every_ != 0) return {};
    return write(part);
}

void Recorder::finish(sim::PartState& part) {
    Result<void> done;
    if (last_step_ != part.abi.now) done = write(part);
    if (!file_) return;
    const Result<void> closed = file_->close();
    if (!done || !closed) outcome_ = "the recording is incomplete: " + (!done ? done : closed).error().message();
    else outcome_ = fmt::format("recorded {} steps in {}", steps_, path_);
}

// Part 0 gets every catom's position, colour and values, and writes them in the order of ids.
Result<void> Recorder::write(sim::PartState& part) {
    last_step_ = part.abi.now;
    struct Row {
        u64 id;
        world::Vec3 position;
        std::uint32_t rgb;
    };
    std::vector<std::byte> mine;
    for (sim::Catom c = 0; c < part.ensemble.index_count(); ++c) {
        if (!part.owned(c)) continue;
        const auto colour = colours_.find(part.ensemble.id(c));
        put(mine, Row{part.ensemble.id(c), part.ensemble.position(c), colour == colours_.end() ? 0xb0b0b0u : colour->second});
        for (const Recorded& r : recorded_) {
            Value value{};
            bool first = true;
            // -1 says that there is no such fact; a predicate without arguments is 1 or 0.
            if (part.module.predicates[r.predicate].arity > 0) {
                if (r.real) value.real = -1;
                else value.integer = -1;
            }
            tuple::each_fact(part.module, part.columns, part.abi.geometry, r.predicate, c, [&](const Value* v) {
                if (first && part.module.predicates[r.predicate].arity > 0) value = v[0];
                else if (first) value.integer = 1;
                first = false;
            });
            put(mine, value);
        }
    }
    std::vector<comm::Packet> packets;
    std::vector<std::vector<std::byte>> all;
    if (part.comm.part() == 0) all.push_back(std::move(mine));
    else if (!mine.empty()) packets.push_back({0, std::move(mine)});
    if (!part.alone())
        for (comm::Packet& p : part.comm.exchange(std::move(packets))) all.push_back(std::move(p.bytes));
    Error error;
    bool fine = true;
    if (file_) {
        const std::size_t stride = sizeof(Row) + recorded_.size() * sizeof(Value);
        std::vector<const std::byte*> rows;
        for (const auto& bytes : all)
            for (std::size_t at = 0; at < bytes.size(); at += stride) rows.push_back(bytes.data() + at);
        const auto id_of = [](const std::byte* row) { return take_value<u64>(row); };
        std::sort(rows.begin(), rows.end(), [&](const std::byte* a, const std::byte* b) { return id_of(a) < id_of(b); });
        std::vector<std::array<double, 3>> positions;
        std::vector<u64> ids;
        std::vector<std::uint8_t> colours;
        std::vector<std::vector<Value>> values(recorded_.size());
        for (const std::byte* at : rows) {
            const auto row = take_value<Row>(at);
            ids.push_back(row.id);
            positions.push_back(row.position);
            for (const int shift : {16, 8, 0}) colours.push_back(static_cast<std::uint8_t>(row.rgb >> shift));
            for (auto& column : values) column.push_back(take_value<Value>(at));
        }
        std::vector<RecordedArray> arrays{{"colour", RecordedArray::UInt8, colours.data(), 3}};
        for (std::size_t i = 0; i < recorded_.size(); ++i)
            arrays.push_back({recorded_[i].name, recorded_[i].real ? RecordedArray::Float64 : RecordedArray::Int64, values[i].data(), 1});
        const Result<void> done = file_->step(static_cast<double>(part.abi.now), positions, ids, arrays);
        fine = done.has_value();
        if (!fine) error = done.error();
        else ++steps_;
    }
    std::vector<std::byte> outcome;
    put(outcome, fine);
    const std::vector<std::byte> told = part.comm.allgather(outcome);
    const std::byte* at = told.data();
    if (!take_value<bool>(at)) return tl::unexpected<Error>(file_ ? error : Error{"cannot write " + path_, "", ExitCode::LimitHit});
    return {};
}

}  // namespace meld::record
