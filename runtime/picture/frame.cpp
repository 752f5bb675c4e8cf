#include "runtime/picture/frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "runtime/base/bytes.h"
#include "runtime/base/visible.h"
#include "runtime/comm/at_first.h"
#include "runtime/comm/outcome.h"
#include "runtime/inspect/query.h"
#include "runtime/picture/obstacles.h"
#include "runtime/picture/palette.h"
#include "runtime/record/sorted_facts.h"

namespace meld::picture {

namespace {

using inspect::Table;
using Kind = check::Type::Kind;
using render::Vec;

constexpr float kAbove = 0.62F;            // In the plane, lines are so much above the middles of catoms.
constexpr std::size_t kMaxCallouts = 200;  // No picture has room for more.
constexpr float kSmall = 0.5F;             // In space, catoms are so much smaller where there are lines.
// Links of a graph: more would be a grey surface.
constexpr std::uint64_t kMostLinks = 200'000;
constexpr render::Rgb kFaint = {150, 150, 150};
constexpr render::Rgb kCut = {214, 60, 50};
constexpr float kThin = 0.04F;
// The part of the way between two catoms that an arrow takes.
constexpr float kArrowBegins = 0.12F, kArrowEnds = 0.8F;

Vec vec(const world::Vec3& at) { return {static_cast<float>(at[0]), static_cast<float>(at[1]), static_cast<float>(at[2])}; }

render::Rgb rgb(std::uint32_t c) {
    return {static_cast<std::uint8_t>(c >> 16), static_cast<std::uint8_t>(c >> 8), static_cast<std::uint8_t>(c)};
}

// Of a lattice that fills space, from a catom to each of its neighbours.
std::vector<Vec> ways_of(const sim::Subdomain& subdomain) {
    const world::Lattice& lattice = subdomain.lattice;
    std::vector<Vec> out;
    if (subdomain.ensemble.is_free() || lattice.flat()) return out;
    const world::Cell middle = {0, 0, 0};
    for (int port = 0; port < lattice.ports(); ++port) out.push_back(vec(lattice.position(lattice.neighbour(middle, port))));
    return out;
}

// The first column that says where a line ends: another catom, a vec3, or else three numbers side by side.
std::optional<std::size_t> end_of(const std::vector<Table::Column>& columns, std::size_t from) {
    const auto is = [&](std::size_t i, auto... kinds) { return i < columns.size() && ((columns[i].type.kind == kinds) || ...); };
    for (std::size_t i = from; i < columns.size(); ++i)
        if (is(i, Kind::Node, Kind::Vec3)) return i;
    for (std::size_t i = from; i < columns.size(); ++i)
        if (is(i, Kind::Int, Kind::Float) && is(i + 1, Kind::Int, Kind::Float) && is(i + 2, Kind::Int, Kind::Float)) return i;
    return std::nullopt;
}

// A vec3, or three numbers in columns side by side.
Vec way_of(const Table& table, std::size_t row, std::size_t column) {
    Vec out;
    for (std::size_t i = 0; i < 3; ++i) {
        const auto axis = static_cast<Eigen::Index>(i);
        if (table.columns()[column].type.kind == Kind::Vec3)
            out[axis] = static_cast<float>(tuple::item(table.cell(row, column).list, i).real);
        else if (table.columns()[column + i].type.kind == Kind::Int)
            out[axis] = static_cast<float>(table.cell(row, column + i).integer);
        else
            out[axis] = static_cast<float>(table.cell(row, column + i).real);
    }
    return out;
}

// Asks the bodies of a look, one after the other, and puts what they say into a frame.
class Looker {
  public:
    Looker(sim::Subdomain& subdomain, record::Drawing& drawing, const Look& look)
        : subdomain_(subdomain), look_(look), speaks_(subdomain.comm.process() == 0), drawn_(drawing.drawn(subdomain)) {}

    Result<Frame> frame();

  private:
    // What a body says, on process 0. The option is named in errors.
    struct Said {
        Table table = {};
        std::size_t catom = 0;                // The column of the catom that it is about.
        std::optional<std::size_t> end = {};  // Of what a line goes to: a catom, a vec3, or the first of three numbers.
        std::optional<std::size_t> value = {};
        // The value of a row as people read it; this instead if it has none.
        std::string words(std::size_t row, const std::string& instead) const { return value ? visible(table.plain(row, *value)) : instead; }
    };
    enum class Wants { Catoms, Lines, Values };
    Result<Said> ask(const std::string& body, const char* option, Wants wants);
    Result<void> choose();
    void keep_exposed(std::vector<bool>& shown) const;
    Result<void> colour();
    Result<void> join(const std::string& body, const char* option, bool arrow);
    Result<void> name();
    Result<void> call_out();
    // Where in the scene the catom of a row is; nothing if it is not shown.
    std::optional<std::size_t> place(const Said& said, std::size_t row, std::size_t column) const {
        const auto at = drawn_.find(said.table.cell(row, column).catom);
        if (!at || places_[*at] < 0) return std::nullopt;
        return static_cast<std::size_t>(places_[*at]);
    }
    void add_drawn();
    // The links of a graph between nodes that are shown, also what is left of those that were cut, unless lines are asked for.
    void add_graph();
    void add_stubs(const Vec& a, const Vec& b);
    using Link = std::pair<std::uint64_t, std::uint64_t>;
    std::vector<Link> links_now() const;
    // Lines go between the middles of catoms, where nobody would see them.
    void uncover_lines();

    sim::Subdomain& subdomain_;
    const Look& look_;
    const bool speaks_;
    const record::Drawn drawn_;
    std::vector<std::ptrdiff_t> places_;  // Of catoms in the scene, as in drawn_; -1: not shown.
    Frame frame_;
};

Result<Looker::Said> Looker::ask(const std::string& body, const char* option, Wants wants) {
    Result<Table> table = inspect::query(subdomain_, body);
    if (!table) {
        Error error = table.error();
        if (!error.problem.empty()) error.problem = fmt::format("{}: {}", option, error.problem);
        return tl::unexpected<Error>(error);
    }
    Said said{.table = std::move(*table)};
    const auto fits = [&]() -> Result<void> {
        if (!speaks_) return {};
        const std::vector<Table::Column>& columns = said.table.columns();
        const auto lacks = [&](const char* what, const char* example) {
            return fail(fmt::format("{}: no variable is {} in `{}`", option, what, body), fmt::format("Write it as in {}", example));
        };
        const auto catom = std::ranges::find(columns, Kind::Node, [](const Table::Column& column) { return column.type.kind; });
        said.catom = static_cast<std::size_t>(catom - columns.begin());
        if (catom == columns.end()) return lacks("a catom", "--only 'leader(A)'");
        if (wants == Wants::Lines) {
            said.end = end_of(columns, said.catom + 1);
            if (!said.end) return lacks("another catom, a vec3 or the first of three numbers", "--links 'parent(A, B)'");
        }
        if (columns.size() > 1) said.value = said.catom + 1 == columns.size() ? columns.size() - 2 : columns.size() - 1;
        if (wants == Wants::Values && !said.value) return lacks("a value", "--labels 'dist(A, D)'");
        return {};
    }();
    if (const auto all = comm::outcome_of_first(subdomain_.comm, fits); !all) return tl::unexpected<Error>(all.error());
    return said;
}

// Finds out which catoms are shown, and puts them into the scene.
Result<void> Looker::choose() {
    std::vector<bool> shown(drawn_.ids.size(), look_.only.empty());
    for (const auto& [body, option, shows] : {std::tuple(&look_.only, "--only", true), std::tuple(&look_.hide, "--hide", false)}) {
        if (body->empty()) continue;
        const Result<Said> said = ask(*body, option, Wants::Catoms);
        if (!said) return tl::unexpected<Error>(said.error());
        for (std::size_t row = 0; row < said->table.rows(); ++row)
            if (const auto at = drawn_.find(said->table.cell(row, said->catom).catom)) shown[*at] = shows;
    }
    if (look_.exposed) keep_exposed(shown);
    if (look_.cut)
        for (std::size_t i = 0; i < shown.size(); ++i)
            shown[i] = shown[i] && look_.cut->keeps(static_cast<float>(drawn_.positions[i][static_cast<std::size_t>(look_.cut->axis)]));
    render::Scene& scene = frame_.scene;
    places_.assign(drawn_.ids.size(), -1);
    for (std::size_t i = 0; i < drawn_.ids.size(); ++i) {
        if (!shown[i]) continue;
        places_[i] = static_cast<std::ptrdiff_t>(scene.places.size());
        scene.places.push_back(vec(drawn_.positions[i]));
        frame_.ids.push_back(drawn_.ids[i]);
        scene.colours.push_back(rgb(drawn_.colours[i]));
        if (!drawn_.diameters.empty()) scene.diameters.push_back(static_cast<float>(drawn_.diameters[i]));
    }
    return {};
}

void Looker::keep_exposed(std::vector<bool>& shown) const {
    if (subdomain_.ensemble.is_free()) return;
    ByteWriter mine;
    for (const auto& [id, catom] : record::catoms_by_id(subdomain_)) {
        int neighbours = 0;
        subdomain_.each_neighbour(catom, [&](world::Catom) { ++neighbours; });
        if (neighbours < subdomain_.lattice.ports()) mine.write(id);
    }
    std::vector<bool> exposed(shown.size());
    for (const auto& bytes : comm::at_first(subdomain_.comm, mine.take()))
        for (ByteReader in(bytes, "catoms that are exposed"); !in.done();)
            if (const auto at = drawn_.find(in.read<u64>())) exposed[*at] = true;
    for (std::size_t i = 0; i < shown.size(); ++i) shown[i] = shown[i] && exposed[i];
}

Result<void> Looker::colour() {
    if (look_.colour.empty()) return {};
    const Result<Said> said = ask(look_.colour, "--colour", Wants::Catoms);
    if (!said) return tl::unexpected<Error>(said.error());
    if (!speaks_) return {};
    const Table& table = said->table;
    const Kind kind = said->value ? table.columns()[*said->value].type.kind : Kind::Error;
    frame_.coloured_by = said->value ? table.columns()[*said->value].name : look_.colour;
    frame_.whole_numbers = kind == Kind::Int;
    std::vector<bool> has(frame_.scene.places.size());
    for (std::size_t row = 0; row < table.rows(); ++row) {
        const auto at = place(*said, row, said->catom);
        if (!at || has[*at]) continue;
        has[*at] = true;
        if (!said->value) {
            frame_.words.emplace_back(*at, kHolds);
            continue;
        }
        const Value v = table.cell(row, *said->value);
        if (kind == Kind::Int)
            frame_.numbers.emplace_back(*at, static_cast<double>(v.integer));
        else if (kind == Kind::Float)
            frame_.numbers.emplace_back(*at, v.real);
        else
            frame_.words.emplace_back(*at, table.text(row, *said->value));
    }
    return {};
}

Result<void> Looker::join(const std::string& body, const char* option, bool arrow) {
    if (body.empty()) return {};
    const Result<Said> said = ask(body, option, Wants::Lines);
    if (!said) return tl::unexpected<Error>(said.error());
    if (!speaks_) return {};
    render::Scene& scene = frame_.scene;
    const bool to_catom = said->table.columns()[*said->end].type.kind == Kind::Node;
    for (std::size_t row = 0; row < said->table.rows(); ++row) {
        const auto from = place(*said, row, said->catom);
        if (!from) continue;
        Vec begin = scene.places[*from], end = begin;
        if (to_catom) {
            const auto to = place(*said, row, *said->end);
            if (!to) continue;
            const Vec way = scene.places[*to] - begin;
            end = begin + (arrow ? kArrowEnds : 1) * way;
            if (arrow) begin += kArrowBegins * way;
        } else {
            end += way_of(said->table, row, *said->end);
        }
        scene.strokes.push_back({.from = begin, .to = end, .radius = 0.05F, .arrow = arrow});
    }
    return {};
}

Result<void> Looker::name() {
    if (look_.labels.empty()) return {};
    const Result<Said> said = ask(look_.labels, "--labels", Wants::Values);
    if (!said) return tl::unexpected<Error>(said.error());
    if (!speaks_) return {};
    for (std::size_t row = 0; row < said->table.rows(); ++row)
        if (const auto at = place(*said, row, said->catom))
            frame_.scene.notes.push_back({frame_.scene.places[*at], said->table.text(row, *said->value)});
    return {};
}

Result<void> Looker::call_out() {
    std::vector<render::Note>& callouts = frame_.scene.callouts;
    for (const Callout& callout : look_.callouts) {
        if (callout.catom) {
            const auto at = drawn_.find(*callout.catom);
            if (!at)
                frame_.missing.push_back(*callout.catom);
            else if (places_[*at] >= 0)
                callouts.push_back({frame_.scene.places[static_cast<std::size_t>(places_[*at])], callout.text});
            continue;
        }
        const Result<Said> said = ask(callout.body, "--callout", Wants::Catoms);
        if (!said) return tl::unexpected<Error>(said.error());
        const Table& table = said->table;
        std::vector<bool> has(frame_.scene.places.size());
        for (std::size_t row = 0; row < table.rows(); ++row) {
            const auto at = place(*said, row, said->catom);
            if (!at || has[*at]) continue;
            has[*at] = true;
            if (callouts.size() <= kMaxCallouts) callouts.push_back({frame_.scene.places[*at], said->words(row, callout.body)});
        }
    }
    Result<void> fits;
    if (callouts.size() > kMaxCallouts)
        fits = fail(fmt::format("--callout: there are more than {} callouts at tick {}", kMaxCallouts, frame_.tick),
                    "Name fewer catoms, or write --labels");
    return comm::outcome_of_first(subdomain_.comm, fits);
}

// What catoms have drawn themselves: labels and lines.
void Looker::add_drawn() {
    render::Scene& scene = frame_.scene;
    for (std::size_t i = 0; i < drawn_.labels.size(); ++i)
        if (places_[i] >= 0 && !drawn_.labels[i].empty() && look_.labels.empty())
            scene.notes.push_back({scene.places[static_cast<std::size_t>(places_[i])], drawn_.labels[i]});
    for (const auto& [from, to] : drawn_.lines)
        if (places_[from] >= 0 && places_[to] >= 0)
            scene.strokes.push_back({.from = vec(drawn_.positions[from]), .to = vec(drawn_.positions[to])});
}

// Of a link that was cut, what is left at either end.
void Looker::add_stubs(const Vec& a, const Vec& b) {
    constexpr float kStub = 0.3F;
    for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)})
        frame_.scene.strokes.push_back({.from = from, .to = from + kStub * (to - from), .colour = kCut, .radius = 1.5F * kThin});
}

void Looker::add_graph() {
    if (!subdomain_.world.is_graph() || !look_.links.empty() || !look_.arrows.empty()) return;
    const graph::Graph& graph = *subdomain_.world.graph;
    if (graph.links() > kMostLinks) return;
    const std::vector<Link> now = links_now();
    if (!speaks_) return;
    const auto at = [&](std::uint64_t id) -> std::optional<Vec> {
        const auto drawn = drawn_.find(id);
        if (!drawn || places_[*drawn] < 0) return std::nullopt;
        return frame_.scene.places[static_cast<std::size_t>(places_[*drawn])];
    };
    for (const auto& [a, b] : now)
        if (const auto here = at(a), there = at(b); here && there)
            frame_.scene.strokes.push_back({.from = *here, .to = *there, .colour = kFaint, .radius = kThin});
    for (graph::Node node = 0; node < graph.nodes(); ++node)
        for (const graph::Node other : graph.neighbours(node)) {
            if (other < node || std::ranges::binary_search(now, Link(std::minmax(graph.id(node), graph.id(other))))) continue;
            if (const auto here = at(graph.id(node)), there = at(graph.id(other)); here && there) add_stubs(*here, *there);
        }
}

// The links that there are, by the numbers of their catoms, the smaller one first; on process 0. Every process calls it.
std::vector<Looker::Link> Looker::links_now() const {
    ByteWriter mine;
    const world::Ensemble& ensemble = subdomain_.ensemble;
    for (sim::Catom c = 0; c < ensemble.index_count(); ++c) {
        if (!subdomain_.owned(c)) continue;
        subdomain_.each_neighbour(c, [&](sim::Catom other) {
            mine.write(std::min(ensemble.id(c), ensemble.id(other)));
            mine.write(std::max(ensemble.id(c), ensemble.id(other)));
        });
    }
    std::vector<Link> out;
    for (const auto& bytes : comm::at_first(subdomain_.comm, mine.take()))
        for (ByteReader in(bytes, "links"); !in.done();) {
            const auto less = in.read<std::uint64_t>();
            out.emplace_back(less, in.read<std::uint64_t>());
        }
    std::ranges::sort(out);
    const auto twice = std::ranges::unique(out);
    out.erase(twice.begin(), twice.end());
    return out;
}

void Looker::uncover_lines() {
    render::Scene& scene = frame_.scene;
    const bool flat = subdomain_.lattice.flat() && !subdomain_.ensemble.is_free();
    if (flat)
        for (render::Stroke& stroke : scene.strokes)
            for (Vec* end : {&stroke.from, &stroke.to}) end->z() += kAbove;
    const float size = look_.size.value_or(flat || scene.strokes.empty() ? 1 : kSmall);
    if (size == 1) return;
    if (scene.diameters.empty()) scene.diameters.assign(scene.places.size(), 1);
    for (float& diameter : scene.diameters) diameter *= size;
}

Result<Frame> Looker::frame() {
    frame_.tick = subdomain_.tick();
    frame_.catoms = drawn_.ids.size();
    frame_.scene.form = look_.form.value_or(subdomain_.ensemble.is_free() ? render::Form::Sphere : form_of(subdomain_.lattice.kind()));
    frame_.scene.ways = ways_of(subdomain_);
    if (auto done = choose(); !done) return tl::unexpected<Error>(done.error());
    if (auto done = colour(); !done) return tl::unexpected<Error>(done.error());
    add_drawn();
    add_graph();
    if (auto done = join(look_.links, "--links", false); !done) return tl::unexpected<Error>(done.error());
    if (auto done = join(look_.arrows, "--arrows", true); !done) return tl::unexpected<Error>(done.error());
    if (auto done = name(); !done) return tl::unexpected<Error>(done.error());
    if (auto done = call_out(); !done) return tl::unexpected<Error>(done.error());
    uncover_lines();
    render::Scene& scene = frame_.scene;
    if (speaks_) add_obstacles(subdomain_.world, scene);
    if (look_.ground && !scene.places.empty()) {
        float lowest = std::numeric_limits<float>::infinity();
        for (std::size_t i = 0; i < scene.places.size(); ++i) lowest = std::min(lowest, scene.places[i].z() - scene.diameter(i) / 2);
        scene.ground = lowest;
    }
    return std::move(frame_);
}

}  // namespace

render::Form form_of(world::LatticeKind lattice) {
    switch (lattice) {
        case world::LatticeKind::Square:
            return render::Form::Cube;
        case world::LatticeKind::Hex:
            return render::Form::Hexagon;
        default:
            return render::Form::Sphere;
    }
}

Result<Frame> look_at(sim::Subdomain& subdomain, record::Drawing& drawing, const Look& look) {
    return Looker(subdomain, drawing, look).frame();
}

std::optional<render::Legend> colour(std::span<Frame> frames, const Look& look) {
    Palette palette(look);
    for (const Frame& frame : frames) palette.include(frame);
    std::optional<render::Legend> legend = palette.settle();
    for (Frame& frame : frames) palette.apply(frame);
    return legend;
}

}  // namespace meld::picture
