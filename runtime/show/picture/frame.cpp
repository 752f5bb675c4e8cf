#include "runtime/show/picture/frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "runtime/ask/query/query.h"
#include "runtime/base/bytes.h"
#include "runtime/base/terminal/terminal_text.h"
#include "runtime/comm/transport/collective_result.h"
#include "runtime/comm/transport/gather_to_root.h"
#include "runtime/results/facts/sorted_facts.h"
#include "runtime/show/picture/catom_values.h"
#include "runtime/show/picture/palette.h"
#include "runtime/show/picture/stage.h"

namespace meld::picture {

namespace {

using inspect::Table;
using Kind = check::Type::Kind;
using render::Vec;

constexpr std::size_t kMaxCallouts = 200;  // No picture has room for more.
// Links of a graph: more would be a grey surface.
constexpr std::uint64_t kMostLinks = 200'000;
constexpr render::Rgb kFaint = {150, 150, 150};
constexpr render::Rgb kCut = {214, 60, 50};
constexpr float kThin = 0.04F;
// The part of the way between two catoms that an arrow takes.
constexpr float kArrowBegins = 0.12F, kArrowEnds = 0.8F;

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
        : subdomain_(subdomain),
          look_(look),
          speaks_(subdomain.comm.process() == 0),
          drawn_(drawing.drawn(subdomain)),
          stage_(drawn_, subdomain.world, subdomain.ensemble.is_free(), subdomain.tick(), look) {}

    Result<Frame> frame();

  private:
    // What a body says, on process 0. The option is named in errors.
    struct Said {
        Table table = {};
        std::size_t catom = 0;                // The column of the catom that it is about.
        std::optional<std::size_t> end = {};  // Of what a line goes to: a catom, a vec3, or the first of three numbers.
        std::optional<std::size_t> value = {};
        CatomValues::Kind kind = CatomValues::Kind::Holds;
        // The value of a row as people read it; this instead if it has none.
        std::string words(std::size_t row, const std::string& instead) const { return value ? visible(table.plain(row, *value)) : instead; }
    };
    enum class Wants { Catoms, Lines, Values };
    Result<Said> ask(const std::string& body, const char* option, Wants wants);
    // The same; nothing if there is a mistake in it that the look skips. All processes find the same.
    Result<std::optional<Said>> ask_if_right(const std::string& body, const char* option, Wants wants);
    Result<void> choose();
    void keep_exposed(std::vector<bool>& shown) const;
    Result<void> colour();
    Result<void> join(const std::string& body, const char* option, bool arrow);
    Result<void> name();
    Result<void> call_out();
    // Where in the scene the catom of a row is; nothing if it is not shown.
    std::optional<std::size_t> place(const Said& said, std::size_t row, std::size_t column) const {
        return stage_.place(said.table.cell(row, column).catom);
    }
    // The links of a graph between nodes that are shown, also what is left of those that were cut, unless lines are asked for.
    void add_graph();
    void add_stubs(const Vec& a, const Vec& b);
    using Link = std::pair<std::uint64_t, std::uint64_t>;
    std::vector<Link> links_now() const;

    sim::Subdomain& subdomain_;
    const Look& look_;
    const bool speaks_;
    const record::Drawn drawn_;
    Stage stage_;
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
        const std::optional<CatomValues> values = catom_values(columns);
        if (!values) return lacks("a catom", "--only 'leader(A)'");
        said.catom = values->catom;
        said.value = values->value;
        said.kind = values->kind;
        if (wants == Wants::Lines) {
            said.end = end_of(columns, said.catom + 1);
            if (!said.end) return lacks("another catom, a vec3 or the first of three numbers", "--links 'parent(A, B)'");
        }
        if (wants == Wants::Values && !said.value) return lacks("a value", "--labels 'dist(A, D)'");
        return {};
    }();
    if (const auto all = comm::outcome_of_first(subdomain_.comm, fits); !all) return tl::unexpected<Error>(all.error());
    return said;
}

Result<std::optional<Looker::Said>> Looker::ask_if_right(const std::string& body, const char* option, Wants wants) {
    Result<Said> said = ask(body, option, wants);
    if (said) return std::move(*said);
    // Whoever ends a question wants no picture either.
    if (!look_.skips_mistakes || said.error().code == ExitCode::Interrupted) return tl::unexpected<Error>(said.error());
    stage_.frame.mistakes.push_back(said.error());
    return std::nullopt;
}

// Finds out which catoms are shown, and puts them into the scene.
Result<void> Looker::choose() {
    std::vector<bool> shown(drawn_.ids.size(), look_.only.empty());
    for (const auto& [body, option, shows] : {std::tuple(&look_.only, "--only", true), std::tuple(&look_.hide, "--hide", false)}) {
        if (body->empty()) continue;
        const Result<std::optional<Said>> asked = ask_if_right(*body, option, Wants::Catoms);
        if (!asked) return tl::unexpected<Error>(asked.error());
        const std::optional<Said>& said = *asked;
        if (!said && shows) shown.assign(shown.size(), true);
        for (std::size_t row = 0; said && row < said->table.rows(); ++row)
            if (const auto at = drawn_.find(said->table.cell(row, said->catom).catom)) shown[*at] = shows;
    }
    if (look_.exposed) keep_exposed(shown);
    if (look_.cut)
        for (std::size_t i = 0; i < shown.size(); ++i)
            shown[i] = shown[i] && look_.cut->keeps(static_cast<float>(drawn_.positions[i][static_cast<std::size_t>(look_.cut->axis)]));
    stage_.show(shown);
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
    for (const auto& bytes : comm::gather_to_root(subdomain_.comm, mine.take()))
        for (ByteReader in(bytes, "catoms that are exposed"); !in.done();)
            if (const auto at = drawn_.find(in.read<u64>())) exposed[*at] = true;
    for (std::size_t i = 0; i < shown.size(); ++i) shown[i] = shown[i] && exposed[i];
}

Result<void> Looker::colour() {
    if (look_.colour.empty()) return {};
    const Result<std::optional<Said>> asked = ask_if_right(look_.colour, "--colour", Wants::Catoms);
    if (!asked) return tl::unexpected<Error>(asked.error());
    const std::optional<Said>& said = *asked;
    if (!said || !speaks_) return {};
    const Table& table = said->table;
    stage_.frame.coloured_by = said->value ? table.columns()[*said->value].name : look_.colour;
    stage_.frame.whole_numbers = said->kind == CatomValues::Kind::Whole;
    std::vector<bool> has(stage_.frame.scene.places.size());
    for (std::size_t row = 0; row < table.rows(); ++row) {
        const auto at = place(*said, row, said->catom);
        if (!at || has[*at]) continue;
        has[*at] = true;
        if (!said->value) {
            stage_.frame.words.emplace_back(*at, kHolds);
            continue;
        }
        const Value v = table.cell(row, *said->value);
        if (said->kind == CatomValues::Kind::Whole)
            stage_.frame.numbers.emplace_back(*at, static_cast<render::Number>(v.integer));
        else if (said->kind == CatomValues::Kind::Real)
            stage_.frame.numbers.emplace_back(*at, v.real);
        else
            stage_.frame.words.emplace_back(*at, table.text(row, *said->value));
    }
    return {};
}

Result<void> Looker::join(const std::string& body, const char* option, bool arrow) {
    if (body.empty()) return {};
    const Result<std::optional<Said>> asked = ask_if_right(body, option, Wants::Lines);
    if (!asked) return tl::unexpected<Error>(asked.error());
    const std::optional<Said>& said = *asked;
    if (!said || !speaks_) return {};
    render::Scene& scene = stage_.frame.scene;
    const std::vector<Table::Column>& columns = said->table.columns();
    const bool to_catom = columns[*said->end].type.kind == Kind::Node;
    const std::size_t behind = *said->end + (to_catom || columns[*said->end].type.kind == Kind::Vec3 ? 1 : 3);
    const bool counted = columns.back().type.kind == Kind::Int;
    const bool valued = behind < columns.size() && (counted || columns.back().type.kind == Kind::Float);
    if (valued) {
        stage_.frame.lines_coloured_by = columns.back().name;
        stage_.frame.whole_line_numbers = stage_.frame.whole_line_numbers && counted;
    }
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
        if (valued) {
            const Value v = said->table.cell(row, columns.size() - 1);
            stage_.frame.line_numbers.emplace_back(scene.strokes.size(), counted ? static_cast<render::Number>(v.integer) : v.real);
        }
        scene.strokes.push_back({.from = begin, .to = end, .radius = 0.05F, .arrow = arrow});
    }
    return {};
}

Result<void> Looker::name() {
    if (look_.labels.empty()) return {};
    const Result<std::optional<Said>> asked = ask_if_right(look_.labels, "--labels", Wants::Values);
    if (!asked) return tl::unexpected<Error>(asked.error());
    const std::optional<Said>& said = *asked;
    if (!said || !speaks_) return {};
    for (std::size_t row = 0; row < said->table.rows(); ++row)
        if (const auto at = place(*said, row, said->catom))
            stage_.frame.scene.notes.push_back({stage_.frame.scene.places[*at], said->table.text(row, *said->value)});
    return {};
}

Result<void> Looker::call_out() {
    std::vector<render::Note>& callouts = stage_.frame.scene.callouts;
    for (const Callout& callout : look_.callouts) {
        if (callout.catom) {
            stage_.call_out(callout);
            continue;
        }
        const Result<Said> said = ask(callout.body, "--callout", Wants::Catoms);
        if (!said) return tl::unexpected<Error>(said.error());
        const Table& table = said->table;
        std::vector<bool> has(stage_.frame.scene.places.size());
        for (std::size_t row = 0; row < table.rows(); ++row) {
            const auto at = place(*said, row, said->catom);
            if (!at || has[*at]) continue;
            has[*at] = true;
            if (callouts.size() <= kMaxCallouts) callouts.push_back({stage_.frame.scene.places[*at], said->words(row, callout.body)});
        }
    }
    Result<void> fits;
    if (callouts.size() > kMaxCallouts)
        fits = fail(fmt::format("--callout: there are more than {} callouts at tick {}", kMaxCallouts, stage_.frame.tick),
                    "Name fewer catoms, or write --labels");
    return comm::outcome_of_first(subdomain_.comm, fits);
}

// Of a link that was cut, what is left at either end.
void Looker::add_stubs(const Vec& a, const Vec& b) {
    constexpr float kStub = 0.3F;
    for (const auto& [from, to] : {std::pair(a, b), std::pair(b, a)})
        stage_.frame.scene.strokes.push_back({.from = from, .to = from + kStub * (to - from), .colour = kCut, .radius = 1.5F * kThin});
}

void Looker::add_graph() {
    if (!subdomain_.world.is_graph() || !look_.links.empty() || !look_.arrows.empty()) return;
    const graph::Graph& graph = *subdomain_.world.graph;
    if (graph.links() > kMostLinks) return;
    const std::vector<Link> now = links_now();
    if (!speaks_) return;
    const auto at = [&](std::uint64_t id) -> std::optional<Vec> {
        const auto shown = stage_.place(id);
        return shown ? std::optional(stage_.frame.scene.places[*shown]) : std::nullopt;
    };
    for (const auto& [a, b] : now)
        if (const auto here = at(a), there = at(b); here && there)
            stage_.frame.scene.strokes.push_back({.from = *here, .to = *there, .colour = kFaint, .radius = kThin});
    // Where nodes move, a link that is not there was not cut.
    if (subdomain_.world.has_moving_nodes()) return;
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
    for (const auto& bytes : comm::gather_to_root(subdomain_.comm, mine.take()))
        for (ByteReader in(bytes, "links"); !in.done();) {
            const auto less = in.read<std::uint64_t>();
            out.emplace_back(less, in.read<std::uint64_t>());
        }
    std::ranges::sort(out);
    const auto twice = std::ranges::unique(out);
    out.erase(twice.begin(), twice.end());
    return out;
}

Result<Frame> Looker::frame() {
    if (auto done = choose(); !done) return tl::unexpected<Error>(done.error());
    if (auto done = colour(); !done) return tl::unexpected<Error>(done.error());
    stage_.add_drawn();
    add_graph();
    if (auto done = join(look_.links, "--links", false); !done) return tl::unexpected<Error>(done.error());
    if (auto done = join(look_.arrows, "--arrows", true); !done) return tl::unexpected<Error>(done.error());
    if (auto done = name(); !done) return tl::unexpected<Error>(done.error());
    if (auto done = call_out(); !done) return tl::unexpected<Error>(done.error());
    stage_.uncover_lines();
    if (speaks_) stage_.surround();
    return std::move(stage_.frame);
}

}  // namespace

render::Form form_of(world::LatticeKind lattice) {
    switch (lattice) {
        case world::LatticeKind::Square:
            return render::Form::Cube;
        case world::LatticeKind::Hex:
            return render::Form::Hexagon;
        case world::LatticeKind::Cubic:
        case world::LatticeKind::Fcc:
            break;
    }
    return render::Form::Sphere;
}

Result<Frame> look_at(sim::Subdomain& subdomain, record::Drawing& drawing, const Look& look) {
    return Looker(subdomain, drawing, look).frame();
}

Frame look_at(const record::Drawn& drawn, const world::World& world, std::int64_t tick, const Look& look) {
    Stage stage(drawn, world, world.is_free(), tick, look);
    stage.show(std::vector<bool>(drawn.ids.size(), true));
    stage.add_drawn();
    for (const Callout& callout : look.callouts)
        if (callout.catom) stage.call_out(callout);
    stage.uncover_lines();
    stage.surround();
    return std::move(stage.frame);
}

std::optional<render::Legend> colour(std::span<Frame> frames, const Look& look) {
    Palette palette(look);
    for (const Frame& frame : frames) palette.include(frame);
    std::optional<render::Legend> legend = palette.settle();
    for (Frame& frame : frames) palette.apply(frame);
    return legend;
}

}  // namespace meld::picture
