#include "runtime/results/record/appearance.h"

#include <algorithm>
#include <iterator>
#include <string_view>
#include <tuple>
#include <utility>

#include "runtime/base/assert.h"
#include "runtime/base/bytes.h"
#include "runtime/engine/tuple/facts.h"
#include "runtime/engine/tuple/values.h"
#include "runtime/module/abi/actions.h"

namespace meld::record {

namespace {

constexpr std::uint32_t kGrey = 0xb0b0b0;
const std::string kNoLabel;

// Red, orange, yellow, green, aqua, blue, white, purple, pink: the colours of setColor2, repeated.
std::uint32_t numbered_colour(i64 number) {
    static constexpr std::uint32_t colours[] = {0xff0000, 0xff8000, 0xffff00, 0x00c000, 0x00ffff, 0x0000ff, 0xffffff, 0x8000ff, 0xff60c0};
    constexpr i64 count = std::size(colours);
    return colours[static_cast<std::size_t>((number % count + count) % count)];
}

std::uint32_t mixed_colour(const Value* arguments) {
    std::uint32_t rgb = 0;
    for (u32 i = 0; i < 3; ++i) rgb = rgb << 8 | static_cast<std::uint32_t>(std::clamp<i64>(arguments[i].integer, 0, 255));
    return rgb;
}

}  // namespace

void Appearance::start(const tuple::ProgramActions& actions) {
    labels_set_ = actions.uses(ActionKind::SetLabel);
    lines_drawn_ = actions.uses(ActionKind::DrawLine);
}

void Appearance::collect(sim::Subdomain& subdomain) {
    // Passing lines are those of the last tick before a step.
    std::erase_if(new_lines_, [](const Line& line) { return line.passing; });
    const i64 now = subdomain.tick();
    for (const eval::Action& a : subdomain.actions()) {
        const ActionKind kind = subdomain.kind_of(a);
        if (info(kind).performer != ActionInfo::Performer::Recording) continue;
        const u64 id = subdomain.ensemble.id(a.catom);
        switch (kind) {
            case ActionKind::SetColorNumber:
                new_colours_[id] = {now, numbered_colour(a.arguments[0].integer)};
                break;
            case ActionKind::SetColor:
            case ActionKind::SetColorAndOpacity:
                new_colours_[id] = {now, mixed_colour(a.arguments)};
                break;
            case ActionKind::SetLabel:
                new_labels_[id] = {now, std::string(tuple::bytes_of(a.arguments[0].list))};
                break;
            case ActionKind::DrawLine:
                new_lines_.push_back({now, id, a.arguments[0].catom, subdomain.module.predicates[a.predicate].repeats});
                break;
            default:
                MELD_CHECK(false, "recordings do not carry out {}", info(kind).word);
        }
    }
}

void Appearance::write(const Colours& colours, ByteWriter& out) {
    out.write_count(colours.size());
    for (const auto& [id, colour] : colours) {
        out.write(id);
        out.write(colour.tick);
        out.write(colour.rgb);
    }
}

void Appearance::write(const Labels& labels, ByteWriter& out) {
    out.write_count(labels.size());
    for (const auto& [id, label] : labels) {
        out.write(id);
        out.write(label.tick);
        out.write_string(label.text);
    }
}

void Appearance::read(Colours& colours, ByteReader& in) {
    for (auto left = in.read_count(sizeof(u32)); left > 0; --left) {
        news_.push_back(in.read<u64>());
        Colour& known = colours[news_.back()];
        const auto tick = in.read<i64>();
        const auto rgb = in.read<std::uint32_t>();
        if (tick >= known.tick) known = {tick, rgb};
    }
}

void Appearance::read(Labels& labels, ByteReader& in) {
    for (auto left = in.read_count(sizeof(u32)); left > 0; --left) {
        news_.push_back(in.read<u64>());
        Label& known = labels[news_.back()];
        const auto tick = in.read<i64>();
        std::string text = in.read_string();
        if (tick >= known.tick) known = {tick, std::move(text)};
    }
}

void Appearance::write_new(ByteWriter& out) const {
    write(new_colours_, out);
    write(new_labels_, out);
    out.write_count(new_lines_.size());
    for (const Line& line : new_lines_) out.write(line);
}

void Appearance::send(ByteWriter& out) {
    write_new(out);
    new_colours_.clear();
    new_labels_.clear();
    new_lines_.clear();
}

void Appearance::begin_step() {
    received_.clear();
    news_.clear();
}

void Appearance::receive(ByteReader& in) {
    const std::size_t before = news_.size();
    read(colours_, in);
    read(labels_, in);
    if (news_.size() > before) ++changes_;
    for (auto left = in.read_count(sizeof(u32)); left > 0; --left) received_.push_back(in.read<Line>());
}

void Appearance::save(bool writes, ByteWriter& out) const {
    write_new(out);
    if (!writes) return;
    write(colours_, out);
    write(labels_, out);
    out.write_count(lines_.size());
    for (const auto& [from, to] : lines_) {
        out.write(from);
        out.write(to);
    }
}

void Appearance::load(bool wrote, ByteReader& in) {
    read(new_colours_, in);
    read(new_labels_, in);
    for (auto left = in.read_count(sizeof(u32)); left > 0; --left) new_lines_.push_back(in.read<Line>());
    if (!wrote) return;
    read(colours_, in);
    read(labels_, in);
    for (auto left = in.read_count(sizeof(u32)); left > 0; --left) {
        const u64 from = in.read<u64>();
        lines_.emplace(from, in.read<u64>());
    }
}

std::uint32_t Appearance::colour(u64 id) const {
    const auto found = colours_.find(id);
    return found == colours_.end() ? kGrey : found->second.rgb;
}

const std::string& Appearance::label(u64 id) const {
    const auto found = labels_.find(id);
    return found == labels_.end() ? kNoLabel : found->second.text;
}

std::vector<std::pair<u64, u64>> Appearance::drawn() {
    // Within one tick, requests that remove lines come before those that draw them.
    std::sort(received_.begin(), received_.end(), [](const Line& a, const Line& b) {
        return std::tuple(a.tick, a.from, a.from != a.to, a.to) < std::tuple(b.tick, b.from, b.from != b.to, b.to);
    });
    std::set<std::pair<u64, u64>> passing;
    for (const Line& line : received_) {
        if (line.from != line.to)
            (line.passing ? passing : lines_).emplace(line.from, line.to);
        else
            lines_.erase(lines_.lower_bound({line.from, 0}), lines_.upper_bound({line.from, ~u64{0}}));
    }
    received_.clear();
    passing.insert(lines_.begin(), lines_.end());
    return {passing.begin(), passing.end()};
}

}  // namespace meld::record
