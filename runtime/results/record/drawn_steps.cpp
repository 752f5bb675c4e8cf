#include "runtime/results/record/drawn_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <tuple>
#include <utility>

#include "runtime/base/process/liveness.h"
#include "runtime/results/record/joint_table.h"

namespace meld::record {

namespace {

// So many are read at a time: a file that is not as it should be is found out before it fills memory.
constexpr std::uint64_t kDrawnRowsAtOnce = 65536;
// No catom is farther away, in diameters, or larger.
constexpr double kFarthest = 1e12;

}  // namespace

tl::unexpected<Error> DrawnSteps::damaged(std::size_t step, const char* what) const {
    return fail(fmt::format("cannot read {}: in tick {}, {}", recording_.path(), ticks()[step], what),
                "It is damaged, or was written by another version", ExitCode::RecordingRefused);
}

Result<DrawnSteps> DrawnSteps::of(RecordingReader recording) {
    DrawnSteps out(std::move(recording));
    const RecordingReader& reader = out.recording_;
    if (reader.ticks().empty()) return fail(reader.path() + " has no step", "", ExitCode::RecordingRefused);
    // The array of this name, of this shape, if it is none of a predicate.
    const auto find = [&](const char* name, ElementType type, int components, bool texts) -> std::optional<SeriesIndex> {
        if (std::ranges::any_of(reader.predicates(), [&](const DescribedPredicate& p) { return p.name == name; })) return std::nullopt;
        for (const SeriesIndex index : reader.arrays())
            if (const Series& one = reader.series()[index];
                one.name == name && one.type == type && one.components == components && one.texts.empty() != texts)
                return index;
        return std::nullopt;
    };
    const auto colours = find("colour", ElementType::UInt8, 3, false);
    if (!colours)
        return fail(fmt::format("cannot read {}: it has no colours of catoms", reader.path()),
                    "It is damaged, or was written by another version", ExitCode::RecordingRefused);
    out.colours_ = *colours;
    out.diameters_ = find("diameter", ElementType::Float64, 1, false);
    out.cores_ = find(kCore, ElementType::Float64, 4, false);
    out.orientations_ = find(kOrientation, ElementType::Float64, 4, false);
    out.tails_ = find(kTailPosition, ElementType::Float64, 3, false);
    out.turns_ = find(kTurns, ElementType::Float64, 4, false);
    out.labels_ = find("label", ElementType::Int64, 1, true);
    if (!reader.joints()) return out;
    JointColumns columns{};
    constexpr ElementType kInt = ElementType::Int64, kFloat = ElementType::Float64;
    for (const auto& [name, to, type, components] :
         {std::tuple("first", &columns.first, kInt, 1), std::tuple("second", &columns.second, kInt, 1),
          std::tuple("kind", &columns.kind, kInt, 1), std::tuple("fate", &columns.fate, kInt, 1),
          std::tuple("first_anchor", &columns.first_anchor, kFloat, 3), std::tuple("second_anchor", &columns.second_anchor, kFloat, 3),
          std::tuple("axis", &columns.axis, kFloat, 3)}) {
        const auto found = std::ranges::find_if(reader.joints()->columns, [&](SeriesIndex index) {
            const Series& one = reader.series()[index];
            return one.name == name && one.type == type && one.components == components;
        });
        if (found == reader.joints()->columns.end())
            return fail(fmt::format("cannot read {}: its joints have no column '{}'", reader.path(), name),
                        "It is damaged, or was written by another version", ExitCode::RecordingRefused);
        *to = *found;
    }
    out.joints_ = columns;
    return out;
}

template <class Row, class Take>
Result<void> DrawnSteps::each(SeriesIndex series, std::size_t step, std::optional<std::uint64_t> count, const Take& take) {
    const Result<Rows> rows = recording_.rows(series, step);
    if (!rows) return tl::unexpected<Error>(rows.error());
    if (count && rows->count != *count) return damaged(step, "catoms and what is known of them differ in number");
    std::vector<Row> some;
    for (std::uint64_t done = 0; done < rows->count; done += some.size()) {
        liveness::beat();
        some.resize(std::min(kDrawnRowsAtOnce, rows->count - done));
        if (auto read = recording_.read(series, *rows, done, some.size(), some.data()); !read) return read;
        if (auto taken = take(std::span<const Row>(some)); !taken) return taken;
    }
    return {};
}

Result<void> DrawnSteps::read_ids(std::size_t step, Drawn& drawn) {
    return each<std::int64_t>(recording_.ids(), step, {}, [&](std::span<const std::int64_t> ids) -> Result<void> {
        for (const std::int64_t id : ids) {
            if (id < 0 || (!drawn.ids.empty() && static_cast<u64>(id) <= drawn.ids.back()))
                return damaged(step, "the numbers of catoms are out of order");
            drawn.ids.push_back(static_cast<u64>(id));
        }
        return {};
    });
}

template <class Row>
Result<void> DrawnSteps::read_places(SeriesIndex series, std::size_t step, std::size_t count, std::vector<world::Vec3>& places) {
    places.reserve(count);
    return each<Row>(series, step, count, [&](std::span<const Row> rows) -> Result<void> {
        for (const Row& at : rows) {
            if (!std::ranges::all_of(at, [](auto x) { return std::abs(x) < kFarthest; }))
                return damaged(step, "a catom is where none can be");
            places.push_back({at[0], at[1], at[2]});
        }
        return {};
    });
}

Result<void> DrawnSteps::read_positions(std::size_t step, Drawn& drawn) {
    return read_places<std::array<float, 3>>(recording_.points(), step, drawn.ids.size(), drawn.positions);
}

Result<void> DrawnSteps::read_tails(std::size_t step, Drawn& drawn) {
    return tails_ ? read_places<std::array<double, 3>>(*tails_, step, drawn.ids.size(), drawn.tails) : Result<void>();
}

Result<void> DrawnSteps::read_colours(std::size_t step, Drawn& drawn) {
    using Row = std::array<std::uint8_t, 3>;
    drawn.colours.reserve(drawn.ids.size());
    return each<Row>(colours_, step, drawn.ids.size(), [&](std::span<const Row> colours) -> Result<void> {
        for (const auto& [red, green, blue] : colours)
            drawn.colours.push_back(static_cast<std::uint32_t>(red) << 16 | static_cast<std::uint32_t>(green) << 8 | blue);
        return {};
    });
}

Result<void> DrawnSteps::read_diameters(std::size_t step, Drawn& drawn) {
    if (!diameters_) return {};
    drawn.diameters.reserve(drawn.ids.size());
    return each<double>(*diameters_, step, drawn.ids.size(), [&](std::span<const double> diameters) -> Result<void> {
        for (const double diameter : diameters) {
            if (!(diameter > 0 && diameter < kFarthest)) return damaged(step, "a catom has a diameter that cannot be");
            drawn.diameters.push_back(diameter);
        }
        return {};
    });
}

Result<void> DrawnSteps::read_rounded(std::size_t step, Drawn& drawn) {
    if (!cores_ || !orientations_) return {};
    using Row = std::array<double, 4>;
    drawn.rounded.resize(drawn.ids.size());
    std::size_t at = 0;
    const auto cores = [&](std::span<const Row> rows) -> Result<void> {
        for (const Row& row : rows) {
            // Of a compound, the last number is minus its place in the world, from 1.
            const bool compound = row[3] < 0 && row[3] == std::trunc(row[3]);
            if (!std::ranges::all_of(std::span(row).first(3), [](double x) { return x >= 0 && x < kFarthest; }) ||
                !((row[3] >= 0 || compound) && std::abs(row[3]) < kFarthest))
                return damaged(step, "a catom has a shape that cannot be");
            world::RoundedBody& body = drawn.rounded[at++];
            body.core = {row[0], row[1], row[2]}, body.rounding = row[3];
        }
        return {};
    };
    if (auto read = each<Row>(*cores_, step, drawn.ids.size(), cores); !read) return read;
    return read_turns(*orientations_, step, drawn.ids.size(),
                      [&](std::size_t place, const Row& turn) { drawn.rounded[place].turn = turn; });
}

template <class Turned>
Result<void> DrawnSteps::read_turns(SeriesIndex series, std::size_t step, std::size_t count, const Turned& turned) {
    std::size_t at = 0;
    using Row = std::array<double, 4>;
    return each<Row>(series, step, count, [&](std::span<const Row> rows) -> Result<void> {
        for (const Row& row : rows) {
            const double square = row[0] * row[0] + row[1] * row[1] + row[2] * row[2] + row[3] * row[3];
            if (!(std::abs(square - 1) < 0.01)) return damaged(step, "a catom is turned as none can be");
            turned(at++, row);
        }
        return {};
    });
}

Result<void> DrawnSteps::read_joints(std::size_t step, Drawn& drawn) {
    if (!joints_) return {};
    if (turns_) {
        drawn.turns.resize(drawn.ids.size());
        const auto take = [&](std::size_t place, const std::array<double, 4>& turn) { drawn.turns[place] = turn; };
        if (auto read = read_turns(*turns_, step, drawn.ids.size(), take); !read) return read;
    }
    const Result<Rows> rows = recording_.rows(joints_->first, step);
    if (!rows) return tl::unexpected<Error>(rows.error());
    const auto column = [&]<class Row>(SeriesIndex series, std::vector<Row>& to) {
        return each<Row>(series, step, rows->count, [&](std::span<const Row> some) -> Result<void> {
            to.insert(to.end(), some.begin(), some.end());
            return {};
        });
    };
    std::vector<std::int64_t> first, second, kind, fate;
    for (const auto& [series, to] : {std::pair(joints_->first, &first), std::pair(joints_->second, &second),
                                     std::pair(joints_->kind, &kind), std::pair(joints_->fate, &fate)})
        if (auto read = column(series, *to); !read) return read;
    std::vector<world::Vec3> first_anchor, second_anchor, axis;
    for (const auto& [series, to] : {std::pair(joints_->first_anchor, &first_anchor), std::pair(joints_->second_anchor, &second_anchor),
                                     std::pair(joints_->axis, &axis)})
        if (auto read = column(series, *to); !read) return read;
    for (std::size_t i = 0; i < first.size(); ++i) {
        if (fate[i] != static_cast<std::int64_t>(JointFate::Holds)) continue;
        const bool ball = kind[i] == static_cast<std::int64_t>(world::JointLook::Kind::Ball);
        const auto near = [](const world::Vec3& way) { return std::ranges::all_of(way, [](double x) { return std::abs(x) < kFarthest; }); };
        if (kind[i] < 0 || kind[i] > 2 || first[i] < 0 || second[i] < 0 || !near(first_anchor[i]) || !near(second_anchor[i]) ||
            (!ball && !near(axis[i])))
            return damaged(step, "a joint is as none can be");
        drawn.joints.push_back({static_cast<world::JointLook::Kind>(kind[i]), static_cast<u64>(first[i]), static_cast<u64>(second[i]),
                                first_anchor[i], second_anchor[i]});
        if (!ball) drawn.joints.back().axis = axis[i];
    }
    return {};
}

Result<void> DrawnSteps::read_labels(std::size_t step, Drawn& drawn) {
    if (!labels_) return {};
    const Result<const std::vector<std::string>*> texts = recording_.texts(recording_.series()[*labels_].texts);
    if (!texts) return tl::unexpected<Error>(texts.error());
    drawn.labels.reserve(drawn.ids.size());
    return each<std::int64_t>(*labels_, step, drawn.ids.size(), [&](std::span<const std::int64_t> numbers) -> Result<void> {
        for (const std::int64_t number : numbers) {
            if (number < -1 || (number >= 0 && static_cast<u64>(number) >= (*texts)->size()))
                return damaged(step, "a catom has a label that is not there");
            drawn.labels.push_back(number < 0 ? std::string() : (**texts)[static_cast<std::size_t>(number)]);
        }
        return {};
    });
}

Result<void> DrawnSteps::read_lines(std::size_t step, Drawn& drawn) {
    const auto count = static_cast<std::int64_t>(drawn.ids.size());
    // Those that are read at a time are an even number.
    static_assert(kDrawnRowsAtOnce % 2 == 0);
    return each<std::int64_t>(recording_.line_ends(), step, {}, [&](std::span<const std::int64_t> ends) -> Result<void> {
        for (std::size_t i = 0; i + 1 < ends.size(); i += 2) {
            const std::int64_t a = ends[i], b = ends[i + 1];
            if (a < 0 || b < 0 || a >= count || b >= count) return damaged(step, "a line goes to a catom that is not there");
            const std::pair line(static_cast<std::size_t>(a), static_cast<std::size_t>(b));
            if (!drawn.lines.empty() && line <= drawn.lines.back()) return damaged(step, "lines are out of order");
            drawn.lines.push_back(line);
        }
        return {};
    });
}

Result<Drawn> DrawnSteps::drawn(std::size_t step) {
    Drawn out;
    for (const auto& part :
         {&DrawnSteps::read_ids, &DrawnSteps::read_positions, &DrawnSteps::read_colours, &DrawnSteps::read_diameters,
          &DrawnSteps::read_rounded, &DrawnSteps::read_joints, &DrawnSteps::read_tails, &DrawnSteps::read_labels, &DrawnSteps::read_lines})
        if (const auto done = (this->*part)(step, out); !done) return tl::unexpected<Error>(done.error());
    return out;
}

}  // namespace meld::record
