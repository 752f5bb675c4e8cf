// Writes recordings for check_recording.py: "layout FILE" a small one with every special case, "endless FILE" one that goes on
// until it is killed, "N FILE" one of N steps whose catoms become more; the last two say after each step that it is in the file.
// With "many-N" instead of N the catoms are 70,000, of which few change in a step.
// "N FILE STATE S" writes such a one and notes in STATE what is saved of it after S steps; then it ends without closing it, or with
// "N FILE STATE S closed" after that. "N FILE STATE" goes on with it from there and closes it.
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <numeric>
#include <string>
#include <string_view>

#include "runtime/base/files/standard_streams.h"
#include "runtime/results/record/recording.h"

namespace {

using namespace meld;
using namespace meld::record;

constexpr std::int64_t kStepsWithoutForce = 5;

struct Ensemble {
    std::vector<RecordedPosition> positions;
    std::vector<std::uint64_t> ids;
    std::vector<std::int64_t> distances;
    std::vector<double> forces;
    std::vector<std::uint8_t> awake;
    std::vector<std::string> labels;
    // A table with no, one or two facts of each catom, in turn.
    std::vector<std::uint64_t> catoms;
    std::vector<std::int64_t> products;
    std::vector<double> places;
    std::vector<std::string> names;

    // Everything is a function of the count and the shift, which check_recording.py knows too.
    Ensemble(std::size_t count, std::int64_t shift) {
        for (std::size_t i = 0; i < count; ++i) {
            const auto n = static_cast<std::int64_t>(i);
            const auto x = static_cast<double>(n + shift);
            positions.push_back(narrow({x, 2 * x, -x}));
            ids.push_back(10 * i);
            distances.push_back(n * n - shift);
            forces.insert(forces.end(), {0.5 * x, x, 1.5 * x});
            awake.push_back(static_cast<std::uint8_t>((n + shift) % 2));
            labels.push_back((n + shift) % 3 == 0 ? "" : "[" + std::to_string(n + shift) + ", \xC3\xA9]");
            for (std::int64_t k = 0; k < (n + shift) % 3; ++k) {
                catoms.push_back(10 * i);
                products.push_back(k * n - shift);
                places.insert(places.end(), {x, 0.1 * x, static_cast<double>(k)});
                names.push_back("\"" + std::to_string(n + shift) + "\"");
            }
        }
    }

    RecordedArray distance() const { return {"dist", RecordedArray::Int64, distances.data(), 1}; }
    RecordedArray force() const { return {"force", RecordedArray::Float64, forces.data(), 3}; }
    RecordedArray label() const { return {"label", RecordedArray::Text, labels.data(), 1}; }
    RecordedTable table() const {
        return {.name = "many",
                .rows = catoms.size(),
                .columns = {{.name = "catom", .data = catoms.data()},
                            {.name = "Product", .data = products.data()},
                            {.name = "Place", .type = RecordedArray::Float64, .data = places.data(), .components = 3},
                            {.name = "Name", .type = RecordedArray::Text, .data = names.data(), .texts = "many.Name"}}};
    }
    RecordedArray wakefulness() const { return {"awake", RecordedArray::UInt8, awake.data(), 1}; }
};

// A table of more than a chunk, in which one fact differs from step to step: the chunks without it are copied.
struct Steady {
    std::vector<std::int64_t> rows = std::vector<std::int64_t>(1500), values;

    explicit Steady(std::int64_t shift) {
        std::iota(rows.begin(), rows.end(), 0);
        values = rows;
        values[static_cast<std::size_t>(shift) % rows.size()] = -1;
    }
    RecordedTable table() const {
        return {.name = "steady",
                .rows = rows.size(),
                .columns = {{.name = "catom", .data = rows.data()}, {.name = "Value", .data = values.data()}}};
    }
};

template <class T>
T expect(Result<T> result) {
    if (result) return std::move(*result);
    std::fprintf(stderr, "%s\n", result.error().message().c_str());
    std::exit(static_cast<int>(result.error().code));
}
void expect(const Result<void>& result) {
    if (result) return;
    std::fprintf(stderr, "%s\n", result.error().message().c_str());
    std::exit(static_cast<int>(result.error().code));
}

void write_layout(const char* path) {
    const RecordingInfo info = {.program = "dist(A, 0) :- source(A). \xE2\x9F\xB6",
                                .world = "lattice = \"fcc\"",
                                .seed = 0xfedcba9876543210u,
                                .arguments = {"run", "a file.meld"},
                                .lattice = "fcc",
                                .radius = 0.5e-3,
                                .lines = true};
    Recording recording = expect(Recording::create(path, info));
    const auto step = [&](double time, const Ensemble& e, std::vector<RecordedArray> arrays, const std::vector<RecordedLine>& lines = {}) {
        arrays.push_back(e.label());
        const RecordedTable table = e.table();
        expect(recording.step(time, e.positions, e.ids, arrays, lines, {&table, 1}));
    };
    const std::vector<RecordedLine> angle = {{0, 1}, {1, 2}}, fan = {{29, 0}, {29, 1}, {29, 2}};
    const Ensemble first(100, 0), moved(100, 1), fewer(30, 2), nobody(0, 0), big(200000, 3);
    Ensemble nearly = big;
    nearly.distances[70000] = 5;
    nearly.awake[199999] = 2;
    nearly.forces[3 * 131072] = 0.25;
    step(0, first, {first.distance(), first.wakefulness()});
    step(0.5, first, {first.distance(), first.wakefulness()}, angle);                      // Only lines are new.
    step(1, moved, {first.distance(), moved.wakefulness()}, angle);                        // All but one changed.
    step(1.5, fewer, {fewer.distance(), fewer.wakefulness(), fewer.force()}, fan);         // Fewer catoms, a new array.
    step(2, nobody, {nobody.distance(), nobody.wakefulness(), nobody.force()});            // All are gone.
    step(2.5, big, {big.distance(), big.wakefulness(), big.force()}, angle);               // More than a chunk.
    step(2.75, nearly, {nearly.distance(), nearly.wakefulness(), nearly.force()}, angle);  // Each array has changed in one chunk.
    step(3, first, {first.distance()});                                                    // Two arrays are missing.
    expect(recording.close());
}

// Many catoms, of which few change in most steps; check_changes.py knows all of it too.
struct Many {
    static constexpr std::size_t kCount = 70000;
    std::vector<RecordedPosition> positions;
    std::vector<std::uint64_t> ids;
    std::vector<std::int64_t> distances;
    std::vector<double> forces;
    std::vector<std::uint8_t> awake;
    std::vector<std::string> labels = std::vector<std::string>(kCount);

    Many() {
        for (std::size_t i = 0; i < kCount; ++i) {
            const auto x = static_cast<double>(i);
            positions.push_back(narrow({x, 2 * x, -x}));
            ids.push_back(10 * i);
            distances.push_back(static_cast<std::int64_t>(i));
            forces.insert(forces.end(), {0.5 * x, x, 1.5 * x});
            awake.push_back(static_cast<std::uint8_t>(i % 2));
        }
    }
    void change(std::int64_t step) {
        if (step == 0 || step % 6 == 3) return;
        const auto at = [&](std::size_t factor) { return factor * static_cast<std::size_t>(step) % kCount; };
        const auto s = static_cast<double>(step);
        distances[at(7919)] = -step;
        distances[at(31)] = -2 * step;
        if (step % 2 == 1) positions[at(13)] = narrow({s, s, s});
        labels[at(5)] = "step " + std::to_string(step % 4);
        awake[at(3)] = static_cast<std::uint8_t>(2 + step % 3);
        for (std::size_t k = 0; k < 3; ++k) forces[3 * at(17) + k] = s * static_cast<double>(k + 1);
        // More than a quarter.
        for (std::size_t i = 0; i < kCount / 3 && step % 9 == 5; ++i) distances[i] = static_cast<std::int64_t>(i) + step;
    }
};

// The rows in which two columns differ.
template <class Column>
std::vector<std::uint64_t> differences(const Column& before, const Column& now, std::size_t width = 1) {
    std::vector<std::uint64_t> rows;
    for (std::size_t row = 0; row < Many::kCount; ++row)
        if (!std::equal(now.begin() + static_cast<std::ptrdiff_t>(row * width),
                        now.begin() + static_cast<std::ptrdiff_t>((row + 1) * width),
                        before.begin() + static_cast<std::ptrdiff_t>(row * width)))
            rows.push_back(row);
    return rows;
}

// Straight to the system, where write_log.cpp sees it.
void say(std::int64_t steps) {
    const std::string line = std::to_string(steps) + "\n";
    if (write(STDOUT_FILENO, line.data(), line.size()) != static_cast<ssize_t>(line.size())) std::exit(1);
}

void write_endless(const char* path) {
    Recording recording = expect(Recording::create(path, {}));
    for (std::int64_t shift = 0;; ++shift) {
        const Ensemble ensemble(1000, shift);
        const RecordedArray arrays[] = {ensemble.distance(), ensemble.wakefulness(), ensemble.label()};
        const RecordedTable table = ensemble.table();
        expect(recording.step(static_cast<double>(shift), ensemble.positions, ensemble.ids, arrays, {}, {&table, 1}));
        say(shift + 1);
    }
}

// An array comes late, texts become more, and so do the parts, with more and more rows in the chunks that they share.
void write_steps(Recording& recording, std::int64_t first, std::int64_t end) {
    const Ensemble nobody(0, 0);
    for (std::int64_t shift = first; shift < end; ++shift) {
        const Ensemble ensemble(static_cast<std::size_t>(20 + 30 * (shift / 2)), shift);
        std::vector<RecordedArray> arrays = {ensemble.distance(), ensemble.label()};
        if (shift >= kStepsWithoutForce) arrays.push_back(ensemble.force());
        const std::vector<RecordedLine> lines(static_cast<std::size_t>(shift % 3), {0, 1});
        // The first facts come after the table.
        const Steady steady(shift);
        const RecordedTable tables[] = {(shift == 0 ? nobody : ensemble).table(), steady.table()};
        expect(recording.step(static_cast<double>(shift), ensemble.positions, ensemble.ids, arrays, lines, tables));
        say(shift + 1);
    }
}

// In some steps it says what has changed, and in the others the recording finds out.
void write_many_steps(Recording& recording, std::int64_t first, std::int64_t end) {
    Many many;
    for (std::int64_t step = 1; step < first; ++step) many.change(step);
    for (std::int64_t step = first; step < end; ++step) {
        const Many before = many;
        many.change(step);
        const std::vector<std::uint64_t> moved = differences(before.positions, many.positions),
                                         distances = differences(before.distances, many.distances),
                                         forces = differences(before.forces, many.forces, 3), awake = differences(before.awake, many.awake),
                                         labels = differences(before.labels, many.labels);
        std::vector<RecordedArray> arrays = {{"dist", RecordedArray::Int64, many.distances.data(), 1},
                                             {"force", RecordedArray::Float64, many.forces.data(), 3},
                                             {"awake", RecordedArray::UInt8, many.awake.data(), 1},
                                             {"label", RecordedArray::Text, many.labels.data(), 1}};
        RecordedSame same;
        if (step > first && step % 2 == 0) {
            same = {.ids = true, .positions = moved.empty(), .moved = &moved};
            const std::vector<std::uint64_t>* const changed[] = {&distances, &forces, &awake, &labels};
            for (std::size_t i = 0; i < arrays.size(); ++i) {
                arrays[i].same = changed[i]->empty();
                arrays[i].changed = changed[i];
            }
        }
        const std::vector<RecordedLine> lines(static_cast<std::size_t>(step % 3), {0, 1});
        const Steady steady(step);
        const RecordedTable table = steady.table();
        expect(recording.step(static_cast<double>(step), many.positions, many.ids, arrays, lines, {&table, 1}, {}, same));
        say(step + 1);
    }
}

// What is to be done with a recording of so many steps: see the top.
void write_some(std::int64_t steps, const std::vector<std::string>& words, void (*write)(Recording&, std::int64_t, std::int64_t)) {
    const std::string& path = words[0];
    RecordingInfo info;
    info.lines = true;
    if (words.size() == 2) {
        std::ifstream in(words[1], std::ios::binary);
        const std::string text(std::istreambuf_iterator<char>(in), {});
        ByteReader saved(std::as_bytes(std::span(text)), "the saved state", ByteReader::Origin::Outside);
        const auto first = saved.read<std::int64_t>();
        Recording recording = expect(Recording::reopen(path, info, saved));
        write(recording, first, steps);
        return expect(recording.close());
    }
    Recording recording = expect(Recording::create(path, info));
    const std::int64_t first = words.size() > 2 ? std::stoll(words[2]) : steps;
    write(recording, 0, first);
    if (words.size() > 2) {
        ByteWriter saved;
        saved.reserve(1024);
        saved.write(first);
        recording.save(saved);
        std::ofstream(words[1], std::ios::binary).write(reinterpret_cast<const char*>(saved.view().data()), std::ssize(saved.view()));
    }
    write(recording, first, steps);
    if (words.size() == 3) std::_Exit(0);
    expect(recording.close());
}

}  // namespace

int main(int argc, char** argv) {
    prepare_standard_streams();
    if (argc < 3) return 2;
    if (std::string_view(argv[1]) == "layout") write_layout(argv[2]);
    if (std::string_view(argv[1]) == "endless") write_endless(argv[2]);
    constexpr std::string_view many = "many-";
    const bool is_many = std::string_view(argv[1]).starts_with(many);
    if (const int steps = std::atoi(argv[1] + (is_many ? many.size() : 0)); steps > 0)
        write_some(steps, {argv + 2, argv + argc}, is_many ? write_many_steps : write_steps);
    return 0;
}
