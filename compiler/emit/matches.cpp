// Emits how facts are matched: at the catom, at a neighbour, in the world, and tests for their absence.
#include <algorithm>
#include <utility>

#include "compiler/emit/rule_emitter.h"

namespace meld::emit {

bool asks_of_neighbours(const Match& s) { return s.uses[0] == ArgumentUse::Skip && s.uses[2] == ArgumentUse::Skip; }

void RuleEmitter::step(const Match& s) {
    const Predicate& p = plan_.program.predicates[s.predicate];
    if (p.world != WorldSource::None) return match_world(s, p.world);
    if (s.changed) return match_changed(s);
    if (!s.at_site) return match_remote(s);
    if (p.linear()) return sweeping_ ? match_in_sweep(s) : single_ ? match_single(s) : match_bag(s);
    match_here(s);
}

void RuleEmitter::match_here(const Match& s) {
    const Stored& stored = plan_.of(s.predicate);
    const std::string name = predicate_name(plan_.program, s.predicate);
    const std::string i = fresh("k"), f = fresh("f");
    const bool frozen = std::find(frozen_.begin(), frozen_.end(), s.predicate) != frozen_.end();
    const std::string rows = frozen ? "seen_" + name : fmt::format("s.{}.rows", name),
                      count = frozen ? "seen_" + name + "_count" : fmt::format("s.{}.count", name);
    if (!frozen) w_.line("load_{}(s);", name);
    const bool grown = grows(s.predicate);
    const bool whole = stored.storage == Storage::Rows && whole_key(s) && !(grown && s.lookup.found());
    if (whole && grown) {
        // A set's facts are nothing but their group.
        const std::string group = group_row(s);
        w_.open(fmt::format("if (s.{}_rounds.sees({}){}) {{", name, group, fits_));
        scope_.last_fact = group;
        return use(s, [&](std::size_t k) { return fmt::format("{}.{}", group, field_name(k)); });
    }
    if (by_all_but_last(s)) {
        each_but_last(s, f);
    } else {
        if (whole) {
            const std::string group = group_row(s);
            w_.line("const u32 {} = find_row<{}_t>({}, {}, {});", i, name, rows, count, group);
            w_.open(fmt::format("if ({} < {}{}) {{", i, count, fits_));
        } else {
            each_row(s, i, rows, count);
        }
        // Rows may be replaced while a comprehension acts, so the fact is copied.
        w_.line("[[maybe_unused]] const {} {} = {}[{}];", row_type(s.predicate), f, rows, i);
    }
    scope_.last_fact = f;
    if (s.ranks) scope_.ranks.push_back(f + ".rank");
    if (stored.storage == Storage::PerLink) return match_link(s, f);
    use(s, [&](std::size_t k) { return fmt::format("{}.{}", f, field_name(k)); });
}

void RuleEmitter::match_link(const Match& s, const std::string& f) {
    MELD_EXPECT(plan_.of(s.predicate).storage == Storage::PerLink && !s.arguments.empty());
    const Term& other = s.arguments[0];
    Match rest = s;
    rest.uses[0] = ArgumentUse::Skip;
    w_.line("if (s.neighbour[{}.a1] < 0) continue;", f);
    if (s.uses[0] == ArgumentUse::Bind) {
        w_.line("[[maybe_unused]] const i32 {} = static_cast<i32>({}.a1);", scope_.port(other.variable), f);
        scope_.places.insert(other.variable);
        w_.line("[[maybe_unused]] const u32 {} = static_cast<u32>(s.neighbour[{}.a1]);", scope_.at(other.variable), f);
    } else if (s.uses[0] == ArgumentUse::Compare) {
        w_.open(fmt::format("if ({}) {{",
                            defined(fmt::format("id_of(*s.g, static_cast<u32>(s.neighbour[{}.a1])) == {}", f, term(scope_, other)),
                                    plan::may_fail(plan_.program, other))));
    }
    use(rest, [&](std::size_t k) { return fmt::format("{}.{}", f, field_name(k)); });
}

void RuleEmitter::match_remote(const Match& s) {
    const Stored& stored = plan_.of(s.predicate);
    const std::string name = predicate_name(plan_.program, s.predicate);
    const std::string at = scope_.at(s.place), f = fresh("f");
    if (stored.storage == Storage::Rows) {
        const std::string head = fresh("head"), rows = fresh("rows"), i = fresh("k");
        w_.line("const RowsHead& {} = rows_of(s, {}, {});", head, stored.column.index(), at);
        w_.line("const auto* {} = reinterpret_cast<const {}*>({}.data);", rows, row_type(s.predicate), head);
        if (whole_key(s)) {
            const std::string group = group_row(s);
            w_.line("const u32 {} = find_row<{}_t>({}, {}.count, {}{});", i, name, rows, head, group, s.predicate == near_ ? ", near" : "");
            w_.open(fmt::format("if ({} < {}.count{}) {{", i, head, fits_));
        } else {
            each_row(s, i, rows, head + ".count");
        }
        w_.line("[[maybe_unused]] const {}& {} = {}[{}];", row_type(s.predicate), f, rows, i);
        if (s.ranks) scope_.ranks.push_back(f + ".rank");
        return use(s, [&](std::size_t k) { return fmt::format("{}.{}", f, field_name(k)); });
    }
    w_.line("const {0}& {1} = record<{0}>(s, {2}, {3});", record_name(stored.column), f, stored.column.index(), at);
    if (stored.ranked)
        w_.open(fmt::format("if ({}.{}_rank != kAbsent) {{", f, name));
    else
        w_.open(fmt::format("if (({}.present_{} & {:#x}u) != 0) {{", f, stored.presence_offset, stored.presence_mask));
    if (s.ranks) scope_.ranks.push_back(fmt::format("{}.{}_rank", f, name));
    use(s, [&](std::size_t k) { return fmt::format("{}.{}_{}", f, name, field_name(k)); });
}

void RuleEmitter::match_changed(const Match& s) {
    const Stored& stored = plan_.of(s.predicate);
    const std::string name = predicate_name(plan_.program, s.predicate);
    const std::string changes = fresh("changes"), i = fresh("k"), f = fresh("f");
    MELD_EXPECT(stored.storage == Storage::Rows, "rule {}: {} has no rows", scope_.rule.name, name);
    if (s.at_site && grows(s.predicate)) {
        if (s.lookup.kind == plan::Lookup::Kind::Alike) return each_kind(s);
        w_.open(fmt::format("for (u32 {0} = s.{1}_rounds.last; {0} < s.{1}.count; ++{0}) {{", i, name));
        w_.line("[[maybe_unused]] const {0}& {1} = s.{2}.rows[{3}];", row_type(s.predicate), f, name, i);
        return use(s, [&](std::size_t k) { return fmt::format("{}.{}", f, field_name(k)); });
    }
    const bool derived = s.at_site && stored.base != s.predicate;
    if (derived) w_.line("load_{}(s);", name);
    w_.open(fmt::format("for (const RowChanges* {0} = {1}; {0} != nullptr; {0} = {0}->next) {{", changes,
                        derived ? fmt::format("own_changes(*s.e, s.{})", name)
                                : fmt::format("s.e->subdomain->changes[{}][{}]", stored.column.index(), scope_.at(s.place))));
    w_.open(fmt::format("for (u32 {0} = 0; {0} < {1}->removed + {1}->added; ++{0}) {{", i, changes));
    w_.line("[[maybe_unused]] const {0}& {1} = rows_in<{0}>({2})[{3}];", row_type(s.predicate), f, changes, i);
    last_changed_ = {f, fmt::format("{} < {}->removed", i, changes)};
    use(s, [&](std::size_t k) { return fmt::format("{}.{}", f, field_name(k)); });
}

// Compares the fact that was matched last with the facts at the end of the previous tick.
void RuleEmitter::step(const plan::ChangeSince& s) {
    const std::string name = predicate_name(plan_.program, s.predicate), row = row_type(s.predicate);
    std::string others = "true", value;
    for (std::size_t i = 1; i <= s.arguments.size(); ++i) {
        const Term& t = s.arguments[i - 1];
        const Type& type = plan_.program.predicates[s.predicate].arguments[i].type;
        if (t.is_variable() && t.variable == s.variable)
            value = fmt::format(fmt::runtime(type == Type::Int ? "i64{{r.{}}}" : "r.{}"), field_name(i));
        else
            others += " && " + equal(plan_.program.predicates[s.predicate].arguments[i].type, "a." + field_name(i), "b." + field_name(i));
    }
    MELD_EXPECT(!value.empty(), "rule {}: no argument of {} changes", scope_.rule.name, name);
    MELD_EXPECT(!scope_.last_fact.empty(), "rule {}: no fact has been matched", scope_.rule.name);
    const std::string change = fresh("change");
    w_.line(
        "const double {0} = change_of(*s.e, s.{1}, {2}, []([[maybe_unused]] const {3}& a, [[maybe_unused]] const {3}& b) {{ return {4}; "
        "}}, [](const {3}& r) {{ return {5}; }});",
        change, name, scope_.last_fact, row, others, value);
    const char* sign = s.compare == Op::Equal          ? "=="
                       : s.compare == Op::NotEqual     ? "!="
                       : s.compare == Op::Less         ? "<"
                       : s.compare == Op::LessEqual    ? "<="
                       : s.compare == Op::GreaterEqual ? ">="
                                                       : ">";
    const std::string condition = fmt::format("{} {} {}", change, sign, term_as(scope_, s.bound, Type::Float));
    w_.open(fmt::format("if ({}) {{", defined(condition, plan::may_fail(plan_.program, s.bound))));
}

void RuleEmitter::step(const plan::EachElement& s) {
    const Type& type = scope_.rule.variables[s.variable].type;
    const std::string list = fresh("list"), i = fresh("k");
    const std::string value = from_word(type, fmt::format("item({}, {})", list, i));
    const bool known = scope_.values.contains(s.variable) || scope_.places.contains(s.variable);
    w_.line("const ListRef {} = {};", list, term(scope_, s.list));
    only_if_defined(plan::may_fail(plan_.program, s.list));
    w_.open(fmt::format("for (u32 {0} = 0; {0} < count_of({1}); ++{0}) {{", i, list));
    if (known)
        w_.open(fmt::format("if ({}) {{", equal(type, value, scope_.value(s.variable))));
    else
        bind(s.variable, value);
    if (s.position.valid()) bind(s.position, fmt::format("i64{{{}}}", i));
}

void RuleEmitter::match_bag(const Match& s) {
    const std::string name = predicate_name(plan_.program, s.predicate);
    const std::string i = fresh("k"), f = fresh("f");
    w_.line("load_{}(s);", name);
    w_.line("s.{}.arrange(*s.e);", name);
    const auto copied = copied_.find(s.predicate);
    const bool is_copied = copied != copied_.end();
    const std::string rows = is_copied ? copied->second.rows : fmt::format("s.{}.list.rows", name);
    const std::string count = is_copied ? copied->second.count : fmt::format("s.{}.list.count", name);
    if (searching_)
        each_in_search(s, i, name);
    else
        each_row(s, i, rows, count);
    claim(s, i);
    w_.line("[[maybe_unused]] const {} {} = {}[{}];", row_type(s.predicate), f, rows, i);
    const std::vector<Argument>& arguments = plan_.program.predicates[s.predicate].arguments;
    for (std::size_t k = 1; k < arguments.size(); ++k)
        if (arguments[k].type.compound() && !is_copied)
            w_.line("fetch_ahead(s.{}.list, {}, &{}::{});", name, i, row_type(s.predicate), field_name(k));
    if (searching_) found_at_.push_back({&s, i});
    use(s, [&](std::size_t k) { return fmt::format("{}.{}", f, field_name(k)); });
}

void RuleEmitter::claim(const Match& s, const std::string& position) {
    if (asking_) return;
    std::string taken;
    const auto exclude = [&](const std::vector<Matched>& before) {
        for (const Matched& m : before)
            if (m.predicate == s.predicate) taken += fmt::format("{}{} == {}", taken.empty() ? "" : " || ", position, m.position);
    };
    exclude(consumed_);
    if (consumes(s)) exclude(kept_);
    if (!taken.empty()) w_.line("if ({}) continue;", taken);
    (consumes(s) ? consumed_ : kept_).push_back({s.predicate, position});
}

// A loop over the places around the catom, or over the one that is known; returns the name of the port.
std::string RuleEmitter::each_place(const Match& s) {
    const std::string port = fresh("port"), ports = plan_.program.by_links ? "places_of(*s.g, s.catom)" : "s.g->ports";
    const Term& known = s.arguments[0];
    if (s.uses[0] == ArgumentUse::Compare && (known.op == Op::Variable || known.op == Op::Int))
        w_.open(fmt::format("for (i32 {0} = port_among({1}, {2}); {0} >= 0; {0} = -1) {{", port, term(scope_, known), ports));
    else
        w_.open(fmt::format("for (i32 {0} = 0; {0} < {1}; ++{0}) {{", port, ports));
    return port;
}

void RuleEmitter::match_world(const Match& s, WorldSource source) {
    const auto value = [&](const std::string& text) { use(s, [&](std::size_t) { return text; }); };
    switch (source) {
        case WorldSource::NeighborCount: {
            if (!plan_.program.by_links) return value("count_neighbours(s.neighbour, s.ports)");
            const std::string n = fresh("n");
            w_.line("i64 {} = 0;", n);
            w_.line("for (i32 port = 0; port < ports_of(s); ++port) {} += s.neighbour[port] >= 0;", n);
            return value(n);
        }
        case WorldSource::Vacant: {
            const std::string port = each_place(s);
            // A link may be cut, but the place behind it is taken. Amoebots have it at one of the places that they touch.
            if (plan_.program.by_links) {
                w_.line("if (s.g->catom_tail != nullptr && {0} < ports_of(s) && s.neighbour[{0}] >= 0) continue;", port);
                w_.line("if (s.g->cell_catom[site_beside(*s.g, s.catom, {})] >= 0) continue;", port);
            } else
                w_.line("if (s.neighbour[{}] >= 0) continue;", port);
            return value(fmt::format("i64{{{}}}", port));
        }
        case WorldSource::TargetPort: {
            const std::string port = each_place(s);
            w_.line("if (!in_target(*s.g, {})) continue;",
                    fmt::format(fmt::runtime(plan_.program.by_links ? "site_beside(*s.g, s.catom, {})" : "site_towards(*s.g, s.site, {})"),
                                port));
            return value(fmt::format("i64{{{}}}", port));
        }
        case WorldSource::Expanded:
            return w_.open("if (is_expanded(*s.g, s.catom)) {");
        case WorldSource::Head:
        case WorldSource::Tail:
            w_.open("if (is_expanded(*s.g, s.catom)) {");
            return value(source == WorldSource::Head ? "i64{head_direction(*s.g, s.catom)}"
                                                     : "i64{(head_direction(*s.g, s.catom) + kDirections / 2) % kDirections}");
        case WorldSource::Port: {
            if (plan_.program.by_links && whether_ && asks_of_neighbours(s)) {
                // Each amoebot that it touches is at the other end of a link.
                const std::string link = fresh("port"), end = fresh("other");
                w_.open(fmt::format("for (i32 {0} = 0; {0} < ports_of(s); ++{0}) {{", link));
                w_.line("const i32 {} = s.neighbour[{}];", end, link);
                w_.line("if ({0} < 0 || s.g->catom_tail == nullptr) continue;", end);
                return use(s, [&](std::size_t k) {
                    return k == 2 ? fmt::format("id_of(*s.g, static_cast<u32>({}))", end)
                                  : fmt::format("i64{{is_expanded(*s.g, static_cast<u32>({})) ? 2 : 1}}", end);
                });
            }
            const std::string port = each_place(s), other = fresh("other");
            w_.line("const i32 {} = s.g->cell_catom[site_beside(*s.g, s.catom, {})];", other, port);
            w_.line("if ({0} < 0 || s.g->catom_tail == nullptr || static_cast<u32>({0}) == s.catom) continue;", other);
            return use(s, [&](std::size_t k) {
                const std::string there = fmt::format("static_cast<u32>({})", other);
                return k == 1   ? fmt::format("i64{{{}}}", port)
                       : k == 2 ? fmt::format("id_of(*s.g, {})", there)
                       : k == 3 ? fmt::format("i64{{port_back(*s.g, s.catom, {}, {})}}", port, there)
                                : fmt::format("i64{{is_expanded(*s.g, {}) ? 2 : 1}}", there);
            });
        }
        case WorldSource::Target:
            return w_.open(fmt::format("if (in_target(*s.g, {})) {{", own_cell()));
        case WorldSource::Id:
            return value("static_cast<i64>(id_of(*s.g, s.catom))");
        case WorldSource::Tick:
            return value("s.e->subdomain->now");
        case WorldSource::Cell:
            return use(s, [&](std::size_t k) { return fmt::format("i64{{cell_coordinate(*s.g, {}, {})}}", own_cell(), k - 1); });
        case WorldSource::Position: {
            const std::string centre = fresh("centre");
            w_.line("double {}[3];", centre);
            w_.line("s.e->host->position(s.e, {});", centre);
            return use(s, [&](std::size_t k) { return fmt::format("{}[{}]", centre, k - 1); });
        }
        case WorldSource::PositionVector: {
            const std::string centre = fresh("centre"), vector = fresh("vector");
            w_.line("double {}[3];", centre);
            w_.line("s.e->host->position(s.e, {});", centre);
            w_.line("const ListRef {0} = make_list(*s.e, Words<3>{{{{word({1}[0]), word({1}[1]), word({1}[2])}}}});", vector, centre);
            return value(vector);
        }
        case WorldSource::Facts: {
            const std::string table = predicate_name(plan_.program, s.predicate), i = fresh("i");
            const Predicate& p = plan_.program.predicates[s.predicate];
            w_.open(fmt::format(
                "for (u32 {0} = first_fact({1}, id_of(*s.g, s.catom)); {0} < {2} && {1}[{0}][0] == id_of(*s.g, s.catom); ++{0}) {{", i,
                table, p.facts.size()));
            return use(s, [&](std::size_t k) { return from_word(p.arguments[k].type, fmt::format("{}[{}][{}]", table, i, k)); });
        }
        case WorldSource::Neighbor:
        case WorldSource::NeighborPort:
        case WorldSource::None:
            break;
    }
    MELD_CHECK(false, "rule {}: a link was planned as a match", scope_.rule.name);
}

// No way to satisfy the steps inside exists.
void RuleEmitter::step(const plan::Unless& s) {
    const Scope before = scope_;
    const std::string found = fresh("found");
    w_.open(fmt::format("const auto {} = [&]() -> bool {{", found));
    const std::size_t outside = w_.depth();
    const bool leaves_out = std::exchange(leaves_out_, false);
    const Match* const searching = std::exchange(searching_, nullptr);
    const bool asking = std::exchange(asking_, true), whether = std::exchange(whether_, true);
    steps(s.steps);
    asking_ = asking;
    whether_ = whether;
    searching_ = searching;
    leaves_out_ = leaves_out;
    w_.raw("return true;");
    const bool always = w_.depth() == outside;
    close_to(outside);
    if (!always) w_.raw("return false;");
    w_.close("};");
    restore(before);
    w_.open(fmt::format("if ({}) {{", defined(fmt::format("!{}()", found), plan::may_fail(plan_.program, s.steps))));
}

}  // namespace meld::emit
