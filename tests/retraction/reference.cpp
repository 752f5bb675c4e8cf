#include "reference.h"

#include <algorithm>
#include <bit>

namespace meld::retraction {

namespace {

using I = std::int64_t;

// All rows of a predicate at a catom, without the catom.
std::vector<Row> rows(const Facts& facts, const std::string& predicate, I id) {
    std::vector<Row> out;
    const auto found = facts.find(predicate);
    if (found == facts.end()) return out;
    for (auto row = found->second.lower_bound(Row{id}); row != found->second.end() && (*row)[0] == id; ++row)
        out.emplace_back(row->begin() + 1, row->end());
    return out;
}
bool holds(const Facts& facts, const std::string& predicate, I id) { return !rows(facts, predicate, id).empty(); }

// Calls visit(a, b) for every catom a and neighbour b.
template <class Visit>
void each_link(const Scene& s, const Visit& visit) {
    for (const auto& [a, others] : s.neighbours)
        for (const I b : others) visit(a, b);
}
template <class Visit>
void each_fact(const Facts& f, const std::string& predicate, const Visit& visit) {
    if (const auto found = f.find(predicate); found != f.end())
        for (const Row& row : found->second) visit(row);
}

void gradient(const Scene& s, const Facts& f, const Derive& derive, const std::string& from, const std::string& to) {
    each_fact(f, from, [&](const Row& r) { derive(to, {r[0], 0}); });
    each_link(s, [&](I a, I b) {
        for (const Row& r : rows(f, to, a)) derive(to, {b, r[0] + 1});
    });
}
void spread(const Scene& s, const Facts& f, const Derive& derive, const std::string& from, const std::string& to) {
    each_fact(f, from, [&](const Row& r) { derive(to, r); });
    each_link(s, [&](I a, I b) {
        for (Row r : rows(f, to, a)) {
            r.insert(r.begin(), b);
            derive(to, r);
        }
    });
}

void weighted(const Scene& s, const Facts& f, const Derive& derive) {
    each_fact(f, "source", [&](const Row& r) { derive("dist", {r[0], 0}); });
    each_link(s, [&](I a, I b) {
        for (const Row& r : rows(f, "dist", a)) {
            for (const Row& w : rows(f, "cost", b)) derive("dist", {b, r[0] + w[0]});
            if (!holds(f, "cost", b)) derive("dist", {b, r[0] + 1});
        }
    });
    each_fact(f, "cost", [&](const Row& r) { derive("priced", {r[0]}); });
}

void widest(const Scene& s, const Facts& f, const Derive& derive) {
    each_fact(f, "source", [&](const Row& r) { derive("widest", r); });
    each_link(s, [&](I a, I b) {
        for (const Row& v : rows(f, "widest", a))
            for (const Row& w : rows(f, "width", b)) derive("widest", {b, std::min(v[0], w[0])});
    });
}

void joins(const Scene& s, const Facts& f, const Derive& derive) {
    each_fact(f, "give-p", [&](const Row& r) { derive("p", r); });
    each_fact(f, "give-q", [&](const Row& r) { derive("q", r); });
    const auto has = [&](const char* predicate, I id) { return holds(f, predicate, id); };
    each_link(s, [&](I a, I b) {
        if (has("p", a) && has("q", a)) derive("p", {b});
        if (has("p", a) && has("red", b)) derive("q", {b});
        if (has("q", b) && has("q", a)) derive("p", {b});
        if (has("s", b) && has("p", a)) derive("q", {b});
    });
    for (const auto& [a, others] : s.neighbours) {
        if (has("p", a) && has("q", a)) derive("s", {a});
        if (has("s", a)) derive("p", {a});
        if (has("s", a) && has("red", a)) derive("q", {a});
    }
}

void keyed(const Scene& s, const Facts& f, const Derive& derive) {
    each_fact(f, "source", [&](const Row& r) {
        derive("dist", {r[0], r[0], 0});
        derive("reach", {r[0], r[0]});
    });
    each_link(s, [&](I a, I b) {
        for (const Row& r : rows(f, "dist", a)) derive("dist", {b, r[0], r[1] + 1});
        for (const Row& r : rows(f, "reach", a)) derive("reach", {b, r[0]});
    });
}

void multihop(const Scene& s, const Facts& f, const Derive& derive) {
    each_link(s, [&](I a, I b) {
        for (const Row& v : rows(f, "mark", b)) derive("sum-near", {a, v[0]});
        for (const I c : s.neighbours.at(b)) {
            for (const Row& v : rows(f, "mark", c)) derive("two", {a, c, v[0]});
            for (const I d : s.neighbours.at(c))
                for (const Row& v : rows(f, "mark", a))
                    for (const Row& w : rows(f, "mark", d))
                        if (a != d && v == w) derive("three", {a});
        }
    });
}

void strata_lost(const Scene& s, const Facts& f, const Derive& derive) {
    for (const auto& [a, others] : s.neighbours) {
        if (!holds(f, "reach", a)) derive("lost", {a});
        if (holds(f, "reach", a) && others.size() < 3) derive("edge", {a});
    }
}
void strata_depth(const Scene& s, const Facts& f, const Derive& derive) {
    each_fact(f, "edge", [&](const Row& r) { derive("depth", {r[0], 0}); });
    each_link(s, [&](I a, I b) {
        if (holds(f, "lost", b)) derive("lost-near", {a, 1});
        for (const Row& r : rows(f, "depth", a))
            if (holds(f, "reach", b)) derive("depth", {b, r[0] + 1});
    });
}

void tree_parent(const Scene& s, const Facts& f, const Derive& derive) {
    each_link(s, [&](I a, I b) {
        for (const Row& d : rows(f, "dist", a))
            for (const Row& e : rows(f, "dist", b))
                if (e[0] == d[0] + 1) derive("parent", {b, a});
    });
}
void tree_total(const Scene& s, const Facts& f, const Derive& derive) {
    each_fact(f, "weight", [&](const Row& r) { derive("total", r); });
    each_link(s, [&](I a, I b) {
        for (const Row& p : rows(f, "parent", b))
            for (const Row& t : rows(f, "total", b))
                if (p[0] == a) derive("total", {a, t[0]});
    });
}

void linear(const Scene& s, const Facts& f, const Derive& derive) {
    spread(s, f, derive, "source", "reach");
    each_fact(f, "mark", [&](const Row& r) { derive("mark", r); });
    each_link(s, [&](I a, I b) {
        if (holds(f, "reach", a) && holds(f, "mark", a) && holds(f, "mark", b)) derive("joined", {b});
    });
}

void mutual(const Scene& s, const Facts& f, const Derive& derive) {
    each_fact(f, "source", [&](const Row& r) { derive("arrive", {r[0], 0}); });
    each_link(s, [&](I a, I b) {
        for (const Row& r : rows(f, "leave", a)) derive("arrive", {b, r[0] + 1});
    });
    each_fact(f, "arrive", [&](const Row& r) {
        for (const Row& w : rows(f, "cost", r[0])) derive("leave", {r[0], r[1] + w[0]});
    });
    each_fact(f, "leave", [&](const Row& r) { derive("arrive", {r[0], r[1] - 3}); });
}

void fronts(const Scene& s, const Facts& f, const Derive& derive) {
    each_fact(f, "source", [&](const Row& r) { derive("price", {r[0], 9}); });
    each_link(s, [&](I a, I b) {
        for (const Row& r : rows(f, "price", a)) {
            derive("known", {b});
            if (r[0] < 12) derive("price", {b, r[0] + 1});
            if (holds(f, "cheap", b)) derive("price", {b, r[0] / 2});
        }
        for (const Row& w : rows(f, "offer", a)) {
            if (holds(f, "known", b)) derive("price", {a, w[0] + 3});
            if (holds(f, "cheap", b) && w[0] > 2) derive("price", {a, w[0]});
        }
    });
    each_fact(f, "price", [&](const Row& r) {
        if (r[1] < 6 && holds(f, "known", r[0])) derive("cheap", {r[0]});
    });
}

void flood(const Scene& s, const Facts& f, const Derive& derive) {
    each_fact(f, "token", [&](const Row& r) { derive("flood", {r[0], r[1], 5}); });
    each_link(s, [&](I a, I b) {
        for (const Row& r : rows(f, "flood", a))
            if (r[1] > 0 && !holds(f, "wall", b)) derive("flood", {b, r[0], r[1] - 1});
    });
    each_fact(f, "flood", [&](const Row& r) { derive("heard", r); });
}

void closure(const Scene& s, const Facts& f, const Derive& derive) {
    each_fact(f, "edge", [&](const Row& r) {
        derive("path", r);
        derive("steps", {r[0], r[1], r[2], 1});
    });
    each_link(s, [&](I a, I b) {
        for (const Row& p : rows(f, "path", a))
            for (const Row& e : rows(f, "edge", b))
                if (p[1] == e[0]) derive("path", {a, p[0], e[1]});
    });
    each_fact(f, "steps", [&](const Row& r) {
        for (const Row& e : rows(f, "edge", r[0]))
            if (r[2] == e[0] && r[3] < 20) derive("steps", {r[0], r[1], e[1], r[3] + 1});
    });
}

void jumps(const Scene& s, const Facts& f, const Derive& derive) {
    each_fact(f, "source", [&](const Row& r) { derive("jump", {r[0], 0}); });
    each_link(s, [&](I a, I b) {
        if (!holds(f, "bridge", b)) return;
        for (const I c : s.neighbours.at(b))
            for (const Row& r : rows(f, "jump", c)) derive("jump", {a, r[0] + 1});
    });
}
void both(const Scene& s, const Facts& f, const Derive& derive) {
    const auto has = [&](const char* predicate, I id) { return holds(f, predicate, id); };
    each_fact(f, "source", [&](const Row& r) {
        if (has("bridge", r[0])) derive("both", {r[0]});
    });
    each_link(s, [&](I a, I b) {
        for (const I c : s.neighbours.at(a))
            if (b != c && has("both", b) && has("both", c)) derive("both", {a});
        for (const I c : s.neighbours.at(b))
            if (has("both", c) && has("both", a) && has("bridge", b)) derive("both", {a});
        for (const Row& d : rows(f, "jump", a))
            if (has("both", b) && d[0] < 2) derive("both", {a});
    });
}

void perlink(const Scene& s, const Facts& f, const Derive& derive) {
    each_fact(f, "source", [&](const Row& r) { derive("dist", {r[0], 0}); });
    each_link(s, [&](I a, I b) {
        for (const Row& r : rows(f, "dist", a)) derive("offer", {a, b, r[0] + 1});
        for (const Row& r : rows(f, "offer", b)) {
            if (r[0] != a) continue;
            derive("dist", {a, r[1]});
            for (const I c : s.neighbours.at(a))
                if (b != c) derive("offer", {a, c, r[1] + 2});
        }
    });
}

// Floats stand in rows as their bits, which are ordered as they are from zero up.
I bits(double value) { return std::bit_cast<I>(value); }
void chiefs(const Scene& s, const Facts& f, const Derive& derive) {
    each_fact(f, "marked", [&](const Row& r) { derive("chief", {r[0], r[0]}); });
    each_link(s, [&](I a, I b) {
        for (const Row& r : rows(f, "chief", a)) derive("chief", {b, r[0]});
    });
}
void lengths(const Scene& s, const Facts& f, const Derive& derive) {
    each_fact(f, "chief", [&](const Row& r) {
        if (r[0] == r[1]) derive("length", {r[0], bits(0.0)});
    });
    each_link(s, [&](I a, I b) {
        for (const Row& r : rows(f, "length", a)) derive("length", {b, bits(std::bit_cast<double>(r[0]) + 0.5)});
        for (const Row& r : rows(f, "chief", a))
            if (rows(f, "chief", b) == std::vector<Row>{r}) derive("same-chief", {a, 1});
    });
}

Rules gradient_rules(const char* from, const char* to) {
    return [=](const Scene& s, const Facts& f, const Derive& d) { gradient(s, f, d, from, to); };
}
Rules spread_rules(const char* from, const char* to) {
    return [=](const Scene& s, const Facts& f, const Derive& d) { spread(s, f, d, from, to); };
}

// The value a group gets from all that was derived for it.
Facts reduce(const std::map<std::string, std::vector<Row>>& derived, const Program& program) {
    Facts out;
    for (const auto& [predicate, list] : derived) {
        const auto aggregate = program.aggregates.find(predicate);
        if (aggregate == program.aggregates.end()) {
            out[predicate].insert(list.begin(), list.end());
            continue;
        }
        std::map<Row, I> groups;
        for (const Row& row : list) {
            const Row key(row.begin(), row.end() - 1);
            const auto [at, first] = groups.emplace(key, row.back());
            if (first) continue;
            if (aggregate->second == "min")
                at->second = std::min(at->second, row.back());
            else if (aggregate->second == "max")
                at->second = std::max(at->second, row.back());
            else
                at->second += row.back();
        }
        for (const auto& [key, value] : groups) {
            Row row = key;
            row.push_back(value);
            out[predicate].insert(row);
        }
    }
    return out;
}

std::vector<Program> make_programs() {
    const Given source{.predicate = "source", .per_mille = 80};
    std::vector<Program> all;
    all.push_back({.name = "hops", .given = {source}, .aggregates = {{"dist", "min"}}, .strata = {gradient_rules("source", "dist")}});
    all.push_back({.name = "weighted",
                   .given = {source, {.predicate = "cost", .arguments = {{0, 5}}, .per_mille = 600}},
                   .aggregates = {{"dist", "min"}},
                   .strata = {weighted}});
    all.push_back({.name = "leader",
                   .given = {{.predicate = "candidate", .arguments = {{0, 99}}, .per_mille = 150}},
                   .aggregates = {{"leader", "max"}},
                   .strata = {spread_rules("candidate", "leader")}});
    all.push_back({.name = "reach", .given = {source}, .aggregates = {}, .strata = {spread_rules("source", "reach")}});
    all.push_back({.name = "widest",
                   .given = {{.predicate = "source", .arguments = {{20, 50}}, .per_mille = 80},
                             {.predicate = "width", .arguments = {{1, 40}}, .per_mille = 850}},
                   .aggregates = {{"widest", "max"}},
                   .strata = {widest}});
    all.push_back({.name = "joins",
                   .given = {{.predicate = "give-p", .per_mille = 250},
                             {.predicate = "give-q", .per_mille = 200},
                             {.predicate = "red", .per_mille = 500}},
                   .aggregates = {},
                   .strata = {joins}});
    all.push_back({.name = "keyed", .given = {source}, .aggregates = {{"dist", "min"}}, .strata = {keyed}});
    all.push_back({.name = "parent",
                   .given = {source},
                   .aggregates = {{"dist", "min"}},
                   .strata = {gradient_rules("source", "dist")},
                   .parent_of = "dist"});
    all.push_back({.name = "multihop",
                   .given = {{.predicate = "mark", .arguments = {{0, 3}}, .per_mille = 250}},
                   .aggregates = {{"sum-near", "sum"}},
                   .strata = {multihop},
                   .loses = false,
                   .waits = false});
    all.push_back({.name = "strata",
                   .given = {source},
                   .aggregates = {{"depth", "min"}, {"lost-near", "count"}},
                   .strata = {spread_rules("source", "reach"), strata_lost, strata_depth}});
    all.push_back({.name = "tree",
                   .given = {source, {.predicate = "weight", .arguments = {{1, 9}}, .per_mille = 700}},
                   .aggregates = {{"dist", "min"}, {"parent", "min"}, {"total", "sum"}},
                   .strata = {gradient_rules("source", "dist"), tree_parent, tree_total}});
    all.push_back({.name = "linear",
                   .given = {source, {.predicate = "token", .per_mille = 80, .linear = true, .becomes = "mark"}},
                   .aggregates = {},
                   .strata = {linear}});
    all.push_back({.name = "mutual",
                   .given = {source, {.predicate = "cost", .arguments = {{3, 6}}, .per_mille = 850}},
                   .aggregates = {{"arrive", "min"}, {"leave", "min"}},
                   .strata = {mutual}});
    all.push_back({.name = "fronts",
                   .given = {source, {.predicate = "offer", .arguments = {{0, 8}}, .per_mille = 500}},
                   .aggregates = {{"price", "min"}},
                   .strata = {fronts}});
    all.push_back({.name = "flood",
                   .given = {{.predicate = "token", .arguments = {{1, 3}}, .per_mille = 80}, {.predicate = "wall", .per_mille = 150}},
                   .aggregates = {{"heard", "max"}},
                   .strata = {flood},
                   .waits = false});
    all.push_back({.name = "closure",
                   .given = {{.predicate = "edge", .arguments = {{0, 4}, {0, 4}}, .per_mille = 700},
                             {.predicate = "edge", .arguments = {{0, 4}, {0, 4}}, .per_mille = 500}},
                   .aggregates = {{"steps", "min"}},
                   .strata = {closure},
                   .loses = false,
                   .waits = false});
    all.push_back({.name = "twolinks",
                   .given = {source, {.predicate = "bridge", .per_mille = 500}},
                   .aggregates = {{"jump", "min"}},
                   .strata = {jumps, both}});
    all.push_back({.name = "perlink", .given = {source}, .aggregates = {{"offer", "min"}, {"dist", "min"}}, .strata = {perlink}});
    all.push_back({.name = "catoms",
                   .given = {{.predicate = "marked", .per_mille = 120}},
                   .aggregates = {{"chief", "max"}, {"length", "min"}, {"same-chief", "count"}},
                   .strata = {chiefs, lengths}});
    return all;
}

}  // namespace

Scene make_scene(const Mirror& mirror, world::LatticeKind kind) {
    const world::Lattice lattice(kind);
    Scene scene{mirror, {}};
    for (const auto& [cell, id] : mirror.at) {
        std::vector<I>& others = scene.neighbours[static_cast<I>(id)];
        for (int port = 0; port < lattice.ports(); ++port)
            if (const auto other = mirror.at.find(lattice.neighbour(cell, port)); other != mirror.at.end())
                others.push_back(static_cast<I>(other->second));
    }
    return scene;
}

const std::vector<Program>& programs() {
    static const std::vector<Program> all = make_programs();
    return all;
}

Facts from_scratch(const Program& program, const Scene& scene) {
    Facts facts = scene.mirror.facts;
    for (const Rules& rules : program.strata) {
        const Facts below = facts;
        for (bool changing = true; changing;) {
            std::map<std::string, std::vector<Row>> derived;
            rules(scene, facts, [&](const std::string& predicate, const Row& row) { derived[predicate].push_back(row); });
            Facts next = below;
            for (auto& [predicate, set] : reduce(derived, program)) next[predicate].insert(set.begin(), set.end());
            changing = next != facts;
            facts = std::move(next);
        }
    }
    std::erase_if(facts, [](const auto& entry) { return entry.second.empty(); });
    return facts;
}

}  // namespace meld::retraction
