// Emits evaluate(), which runs a catom to its local fixpoint: its strata, its linear rules, and its actions.
#include <algorithm>
#include <bit>

#include "compiler/emit/marks.h"
#include "compiler/emit/writer.h"

namespace meld::emit {

using namespace check;

namespace {

// An action is carried out if it newly holds at the end of the tick; a repeating one in every tick in which it holds.
void emit_actions(const plan::Plan& plan, Writer& w) {
    w.raw("");
    w.open("MELD_STEP static void act(Self& s) {");
    w.raw("(void)s;");
    for (const PredicateId id : plan.program.predicates.ids()) {
        const Predicate& p = plan.program.predicates[id];
        if (p.kind != PredicateKind::Action || !has_view(plan, id)) continue;
        const std::string name = predicate_name(plan.program, id);
        if (p.repeats) w.line("load_{}(s);", name);
        w.open(fmt::format("if (s.loaded[{}]) {{", id.index()));
        w.open(fmt::format("for (u32 i = 0; i < s.{}.count; ++i) {{", name));
        w.line("[[maybe_unused]] const {}_t::Row& row = s.{}.rows[i];", name, name);
        if (!p.repeats) w.line("if (find_row<{0}_t>(s.{0}.origin, s.{0}.origin_count, row) < s.{0}.origin_count) continue;", name);
        w.line("Value values[{}];", std::max<std::size_t>(1, p.arguments.size() - 1));
        for (std::size_t i = 1; i < p.arguments.size(); ++i)
            w.line("values[{}].{} = row.{};", i - 1, value_member(p.arguments[i].type), field_name(i));
        w.line("s.e->host->act(s.e, {}, values);", id.index());
        if (plan.counts) w.line("count_gained(*s.e, {});", id.index());
        w.close();
        if (p.repeats) w.line("if (s.{}.count > 0) s.e->host->wake(s.e, s.e->subdomain->now + 1, kDirtyTick);", name);
        w.close();
    }
    w.close();
}

// Fires the i-th linear rule, if something it reads has changed since it was last tried. Each rule has a call of its own instead of a
// place in a table, so that the functions of short modules are inlined. `fixed`: as fixed_marks().
void emit_try(const plan::Plan& plan, std::size_t i, bool fixed, const std::string& call, const std::string& stop, Writer& w) {
    const RulePlan& r = plan.linear_rules[i];
    w.open(fmt::format("if (active[{}] >> {} & 1) {{", i / 64, i % 64));
    w.line("e.rule = {};", rule_number(plan, r.rule));
    if (plan.places) w.line("note_place(e, {});", rule_number(plan, r.rule));
    w.line("fired = {}{};", rule_function(plan, r.rule), call);
    if (const std::optional<Marks> marks = fixed ? marks_of(plan, r) : std::nullopt) {
        for (std::size_t word = 0; word * 64 < plan.linear_rules.size(); ++word) {
            std::uint64_t woken = 0;
            for (std::size_t k = word * 64; k < std::min(plan.linear_rules.size(), (word + 1) * 64); ++k)
                if (wakes(*marks, plan.linear_rules[k])) woken |= std::uint64_t{1} << (k % 64);
            if (woken != 0) w.line("if (fired) active[{}] |= {};", word, hex(woken));
        }
    }
    w.line("if (fired || e.trap != Trap::None{}) break;", stop);
    w.line("active[{}] &= ~(u64{{1}} << {});", i / 64, i % 64);
    w.close();
}

void emit_views(const plan::Plan& plan, Writer& w) {
    for (std::size_t i = 0; i < plan.strata.size(); ++i)
        w.line("if (todo & {}) todo |= evaluate_{}(s{});", hex(plan.strata[i].inputs), i,
               plan.strata[i].deltas.inputs != 0 ? ", todo" : "");
}

// So many rules are found by a table.
constexpr std::size_t kRulesByTable = 6;

// For each bit of `bits` the rules that wait for it.
void emit_woken(const plan::Plan& plan, const std::string& table, const std::string& bits, std::uint64_t RulePlan::* of, Writer& w) {
    const std::size_t words = words_of_rules(plan);
    std::uint64_t all = 0;
    for (const RulePlan& r : plan.linear_rules) all |= r.*of;
    if (all == 0) return;
    w.line("// For each bit of {} the rules that it wakes.", bits);
    const auto rows = static_cast<std::uint32_t>(std::bit_width(all));
    w.open(fmt::format("static constexpr u64 {}[{}][{}] = {{", table, rows, words));
    for (std::uint32_t bit = 0; bit < rows; ++bit) {
        std::vector<std::uint64_t> woken(words, 0);
        for (std::size_t i = 0; i < plan.linear_rules.size(); ++i)
            if ((plan.linear_rules[i].*of >> bit & 1) != 0) woken[i / 64] |= std::uint64_t{1} << (i % 64);
        std::string row;
        for (const std::uint64_t rules : woken) row += fmt::format("{}{}", row.empty() ? "" : ", ", hex(rules));
        w.line("{{{}}},", row);
    }
    w.close("};");
    w.open(fmt::format("for (u64 left = {} & {}; left != 0; left &= left - 1) {{", bits, hex(all)));
    w.line("const auto& woken = {}[__builtin_ctzll(left)];", table);
    for (std::size_t i = 0; i < words; ++i) w.line("active[{0}] |= woken[{0}];", i);
    w.close();
}

// Which rules are to be tried, by what has changed. `consumed`: facts may have been consumed since that was asked last.
void emit_active(const plan::Plan& plan, bool consumed, Writer& w) {
    if (consumed && plan.linear_rules.size() >= kRulesByTable) {
        emit_woken(plan, "kWoken", "todo", &RulePlan::inputs, w);
        emit_woken(plan, "kWokenByAbsence", "lowered", &RulePlan::absent, w);
        return;
    }
    for (std::size_t i = 0; i < plan.linear_rules.size(); ++i) {
        const RulePlan& r = plan.linear_rules[i];
        const std::string absent = !consumed || r.absent == 0 ? "" : fmt::format(" | (lowered & {})", hex(r.absent));
        w.line("active[{}] |= ((todo & {}){}) != 0 ? u64{{1}} << {} : 0;", i / 64, hex(r.inputs), absent, i % 64);
    }
}

// The linear rules in order, each firing followed by the views.
void emit_firings(const plan::Plan& plan, bool fixed, Writer& w) {
    w.open("for (;;) {");
    emit_views(plan, w);
    if (plan::may_fail(plan)) w.raw("if (e.undefined != 0) [[unlikely]] stop_where(e, [&](u32 failed) { return would_read(s, failed); });");
    if (!fixed) {
        w.raw("const u64 lowered = s.lowered;");
        w.raw("s.lowered = 0;");
        emit_active(plan, true, w);
    }
    w.raw("bool fired = false;");
    w.open("do {");
    emit_tries(plan, fixed, "(s)", "", w);
    w.close("} while (false);");
    w.raw("if (!fired || e.trap != Trap::None) break;");
    w.raw("if (++s.fired > e.subdomain->max_derivations)");
    w.raw("    return trap(e, Trap::TooManyDerivations, e.rule, static_cast<i64>(e.subdomain->max_derivations));");
    if (!fixed) {
        w.raw("todo = s.raised;");
        w.raw("s.raised = 0;");
    }
    w.raw("s.again = true;");
    w.close();
}

// What has been told where it is not in a column is stored with the rest, if it is not consumed.
void emit_load_heard(const plan::Plan& plan, const std::vector<PredicateId>& except, Writer& w) {
    for (const PredicateId p : plan.pulled)
        if (plan.pulls(p) && std::ranges::find(except, p) == except.end())
            w.line("if (s.{0}_heard.come) load_{0}(s);", predicate_name(plan.program, p));
}

// The facts of such predicates that the catom begins with.
void emit_hear(const plan::Plan& plan, Writer& w) {
    for (const PredicateId p : plan.pulled) {
        if (!plan.pulls(p)) continue;
        const std::string name = predicate_name(plan.program, p);
        const plan::ColumnId column = plan.of(p).column;
        w.line(
            "hear<{0}_t, {1}>(e, s.{0}_heard, rows_of(s, {2}, s.catom), (todo & {3}) != 0 ? e.subdomain->broadcasts[{2}].heard : nullptr,",
            name, plan.columns[column].row_bytes <= kShortRow, column.index(), hex(plan.columns[column].own_dirty));
        w.raw("    s.neighbour, s.ports);");
    }
}

// Whether nothing is left to do for a catom whose facts were variables: they have been written back.
bool only_singles(const plan::Plan& plan) {
    return plan.strata.empty() && !plan.reads_tick && !plan.places && !plan.counts && !plan::may_fail(plan) &&
           std::ranges::all_of(plan.pulled, [&](PredicateId p) {
               return !plan.pulls(p) || std::ranges::find(plan.singles.messages, p) != plan.singles.messages.end();
           });
}

void emit_linear_rules(const plan::Plan& plan, Writer& w) {
    const bool fixed = fixed_marks(plan);
    w.line("u64 active[{}] = {{}};", words_of_rules(plan));
    w.raw("s.fired = 0;");
    if (fixed) emit_active(plan, false, w);
    if (plan.singles.apply()) {
        // Initial facts are in lists.
        w.open(fmt::format("if ({}e.tells_firings || !evaluate_singles(s, active)) {{",
                           plan.initial_facts.empty() ? "" : "(todo & kDirtyBorn) != 0 || "));
        w.raw("evaluate_lists(s, active);");
        w.close();
        if (only_singles(plan)) {
            w.open("else {");
            w.raw("if (e.trap == Trap::None) e.rule = kNone32;");
            w.raw("return;");
            w.close();
        }
        emit_load_heard(plan, plan.singles.messages, w);
    } else {
        emit_load_heard(plan, {}, w);
        emit_firings(plan, fixed, w);
    }
}

// Where facts may be variables, the code for lists of them is out of the way.
void emit_lists(const plan::Plan& plan, Writer& w) {
    if (!plan.singles.apply()) return;
    w.raw("");
    w.open(fmt::format("[[gnu::noinline]] static void evaluate_lists(Self& s, u64 (&active)[{}]) {{", words_of_rules(plan)));
    w.raw("Eval& e = *s.e;");
    emit_load_heard(plan, {}, w);
    emit_firings(plan, true, w);
    w.close();
}

// Whether the program is one of amoebots that are activated.
bool activates(const plan::Plan& plan) { return plan::activated_fact(plan).has_value(); }

// Whose turn it is has the fact, which lies nowhere.
void emit_turn(const plan::Plan& plan, Writer& w) {
    const std::optional<PredicateId> id = fact_by_turn(plan);
    if (!id) return;
    const std::string name = predicate_name(plan.program, *id);
    w.open("if ((todo & kDirtyTurn) != 0) {");
    w.line("todo |= {};", hex(plan.columns[plan.of(*id).column].own_dirty));
    w.line("load_{}(s);", name);
    w.line("s.{0}.insert(e, {0}_t::Row{{}});", name);
    w.close();
}

// When all is stored: who keeps the fact.
void emit_still_activated(const plan::Plan& plan, Writer& w) {
    if (const std::optional<PredicateId> id = fact_by_turn(plan))
        w.line("if ((e.dirty & kDirtyTurn) != 0 && s.{}.list.count > 0) e.still_activated[e.still_count++] = s.catom;",
               predicate_name(plan.program, *id));
}

void emit_catom(const plan::Plan& plan, Writer& w) {
    w.raw("");
    w.raw("// One catom to its local fixpoint: views by strata, then linear rules in order, each firing followed by the views.");
    w.open("static void evaluate_catom(Self& s, u64 todo) {");
    w.raw("Eval& e = *s.e;");
    if (plan.program.by_links) {
        w.raw("s.neighbour = s.g->link_read + s.g->link_first[s.catom];");
        // Amoebots have no links at ports that lead nowhere, and their compasses are in the cache.
        w.line("s.ports = {}static_cast<i32>(s.g->link_ports[s.catom]);",
               activates(plan) ? "s.g->catom_tail != nullptr ? places_of(*s.g, s.catom) : " : "");
    } else {
        w.raw("s.site = s.g->catom_site[s.catom];");
    }
    w.raw("for (bool& loaded : s.loaded) loaded = false;");
    each_index_member(plan, [&](const std::string&, const std::string& name) { w.line("s.{}.reset();", name); });
    w.raw("s.raised = s.lowered = 0;");
    w.raw("s.again = false;");
    emit_hear(plan, w);
    emit_turn(plan, w);
    if (!plan.initial_facts.empty()) {
        w.open("if (todo & kDirtyBorn && id_of(*s.g, s.catom) >= e.subdomain->first_unborn) {");
        for (const RulePlan& r : plan.initial_facts) w.line("{} {}(s);", now_at(plan, r), rule_function(plan, r.rule));
        w.raw("todo |= s.raised;");
        w.raw("s.raised = 0;");
        w.close();
    }
    if (plan.linear_rules.empty())
        emit_views(plan, w);
    else
        emit_linear_rules(plan, w);
    if (plan::may_fail(plan)) w.raw("if (e.undefined != 0) [[unlikely]] stop_where(e, would_act);");
    w.raw("if (e.trap != Trap::None) return;");
    w.raw("e.rule = kNone32;");
    if (plan.places) w.raw("note_place(e, kPlaceOther);");
    w.raw("act(s);");
    if (plan.reads_tick) w.raw("e.host->wake(&e, e.subdomain->now + 1, kDirtyTick);");
    w.raw("save(s);");
    emit_still_activated(plan, w);
    if (plan.counts) w.raw("end_counts(e);");
    w.close();
}

// The columns that a look ahead asks for: more are rarely read by one evaluation.
constexpr std::size_t kFetched = 4;

// Linear facts that have arrived lie in the order of their senders.
void emit_arrived_ahead(const plan::Plan& plan, const std::string& catom, const std::string& todo, Writer& w) {
    std::size_t fetched = 0;
    for (const PredicateId id : plan.program.predicates.ids()) {
        const plan::Stored& stored = plan.of(id);
        if (!plan.program.predicates[id].linear() || stored.storage != plan::Storage::Rows || fetched == kFetched) continue;
        ++fetched;
        const std::uint64_t dirty = plan.columns[stored.column].own_dirty;
        w.line("if (({} & {}) != 0) __builtin_prefetch(rows_of(s, {}, {}).data);", todo, hex(dirty), stored.column.index(), catom);
    }
}

// In the links form, what is read of a catom and then of its neighbours is asked for some catoms ahead. far: its links have been asked for
// already.
void emit_links_ahead(const plan::Plan& plan, bool far, Writer& w) {
    w.raw("");
    w.raw("// Asks the processor for the links of a catom that is evaluated soon, and for what has changed at their ends.");
    w.open("inline void look_ahead(const Self& s, const u32* catoms, const u64* dirty, u32 left) {");
    w.raw("const Geometry& g = *s.g;");
    if (!far) {
        w.open("if (left > 8) {");
        w.raw("__builtin_prefetch(g.link_first + catoms[8]);");
        w.raw("__builtin_prefetch(g.link_ports + catoms[8]);");
        w.close();
        w.raw("if (left > 4) __builtin_prefetch(g.link_read + g.link_first[catoms[4]]);");
    }
    w.raw("if (left <= 2) return;");
    w.raw("[[maybe_unused]] const i32* const ends = g.link_read + g.link_first[catoms[2]];");
    if (std::ranges::any_of(plan.columns.ids(), [&](plan::ColumnId c) { return plan.columns[c].exported; }))
        w.line("const u32 ports = {}g.link_ports[catoms[2]];",
               far ? "g.catom_tail != nullptr ? static_cast<u32>(places_of(g, catoms[2])) : " : "");
    std::size_t fetched = 0;
    for (const plan::ColumnId column : plan.columns.ids()) {
        const plan::Column& c = plan.columns[column];
        if (!c.exported || fetched == kFetched) continue;
        ++fetched;
        w.open(fmt::format("if ((dirty[2] & {}) != 0) {{", hex(c.reader_dirty)));
        w.line("const u8* const entries = s.columns[{}];", column.index());
        w.line("for (u32 port = 0; port < ports; ++port) __builtin_prefetch(entries + i64{{ends[port]}} * {});", c.stride);
        w.close();
    }
    emit_arrived_ahead(plan, "catoms[2]", "dirty[2]", w);
    w.close();
}

// The heads of rows of linear facts that are given to the catom, or that its rules make of one that is.
void emit_heads_ahead(const plan::Plan& plan, Writer& w) {
    std::uint64_t linear = 0;
    const auto in_rows = [&](PredicateId id) { return plan.program.predicates[id].linear() && plan.of(id).storage == plan::Storage::Rows; };
    const auto makes = [&](const RulePlan& r, PredicateId id) {
        const auto& made = plan.program.rules[r.rule].derives;
        return std::ranges::find(made, id) != made.end();
    };
    const auto own_dirty = [&](PredicateId id) { return plan.columns[plan.of(id).column].own_dirty; };
    for (const PredicateId id : plan.program.predicates.ids())
        if (in_rows(id)) linear |= own_dirty(id);
    for (const PredicateId id : plan.program.predicates.ids()) {
        if (!in_rows(id)) continue;
        std::uint64_t when = own_dirty(id);
        for (const RulePlan& r : plan.linear_rules) {
            if (used_up(plan, id)) break;
            const std::uint64_t of = r.inputs & linear;
            if (std::has_single_bit(of) && makes(r, id)) when |= of;
        }
        // Nobody reads the row of a fact that a turn gives.
        const std::optional<PredicateId> turn = fact_by_turn(plan);
        if (turn && turn != id && (when & own_dirty(*turn)) != 0) when |= kDirtyTurn;
        w.line("if ((todo & {}) != 0) __builtin_prefetch(&rows_of(s, {}, catom), 1);", hex(when), plan.of(id).column.index());
    }
}

// Which amoebots look at the cells around them, beyond the places where their links are.
struct LooksAround {
    bool all = false, expanded = false;
};

void note_looks(const plan::Plan& plan, const std::vector<plan::Step>& steps, bool whether, bool expanded, LooksAround& looks) {
    const auto source = [&](const plan::Match& m) { return plan.program.predicates[m.predicate].world; };
    for (const plan::Step& step : steps)
        if (const auto* m = plan::as<plan::Match>(step)) {
            const WorldSource s = source(*m);
            expanded = expanded || s == WorldSource::Expanded || s == WorldSource::Head || s == WorldSource::Tail;
        }
    for (const plan::Step& step : steps) {
        if (const auto* inner = plan::inner_steps(step)) note_looks(plan, *inner, plan::as<plan::Unless>(step) != nullptr, expanded, looks);
        const auto* m = plan::as<plan::Match>(step);
        if (m == nullptr) continue;
        const bool known = !m->uses.empty() && m->uses[0] == plan::ArgumentUse::Compare;
        const WorldSource s = source(*m);
        const bool looks_here = s == WorldSource::Port     ? !(whether && asks_of_neighbours(*m))
                                : s == WorldSource::Vacant ? !known
                                                           : s == WorldSource::TargetPort;
        if (looks_here) (expanded ? looks.expanded : looks.all) = true;
    }
}

LooksAround looks_around(const plan::Plan& plan) {
    LooksAround looks;
    const auto note = [&](const RulePlan& r) {
        note_looks(plan, r.steps, false, false, looks);
        for (const RulePlan& branch : r.branches) note_looks(plan, branch.steps, false, false, looks);
    };
    for (const plan::StratumPlan& stratum : plan.strata) std::ranges::for_each(stratum.rules, note);
    std::ranges::for_each(plan.linear_rules, note);
    return looks;
}

// Amoebots that are activated together are far apart in memory, and sense the cells around them: all of this is asked for beforehand, also
// for the first of a block.
void emit_amoebots_ahead(const plan::Plan& plan, Writer& w) {
    const LooksAround looks = looks_around(plan);
    w.raw("");
    w.raw("// Asks for where the links of an amoebot are that comes after some others, then for the links, and then for who is there.");
    w.open("inline void look_far_ahead(const Self& s, u32 catom, [[maybe_unused]] u64 todo) {");
    w.raw("const Geometry& g = *s.g;");
    w.raw("__builtin_prefetch(g.link_first + catom);");
    w.raw("if (g.catom_tail == nullptr) return;");
    w.raw("__builtin_prefetch(g.catom_compass + catom);");
    if (looks.all) w.raw("__builtin_prefetch(g.catom_site + catom);");
    emit_heads_ahead(plan, w);
    w.close();
    w.raw("");
    w.open("inline void look_at_cells(const Self& s, u32 catom) {");
    w.raw("const Geometry& g = *s.g;");
    w.raw("const i32* const ends = g.link_read + g.link_first[catom];");
    w.raw("__builtin_prefetch(ends);");
    w.raw("__builtin_prefetch(ends + kDirections - 1);");
    w.raw("if (!is_expanded(g, catom)) return;");
    w.raw("__builtin_prefetch(ends + 2 * kDirections - 1);");
    w.raw("__builtin_prefetch(g.catom_tail + catom);");
    w.raw("__builtin_prefetch(g.catom_site + catom);");
    w.close();
    w.raw("");
    w.open("inline void look_at_neighbours(const Self& s, u32 catom) {");
    w.raw("const Geometry& g = *s.g;");
    w.raw("if (g.catom_tail == nullptr) return;");
    w.raw("const i32* const ends = g.link_read + g.link_first[catom];");
    w.raw("const i32 ports = places_of(g, catom);");
    w.raw("i32 least = 0;");
    w.open("for (i32 port = 0; port < ports; ++port) {");
    w.raw("least |= ends[port];");
    w.raw("__builtin_prefetch(g.catom_compass + ends[port]);");
    w.close();
    w.raw("// Whether a cell is empty is asked only where there is no link.");
    w.raw("if (least < 0) __builtin_prefetch(g.catom_site + catom);");
    if (looks.all || looks.expanded) {
        if (!looks.all) w.raw("if (!is_expanded(g, catom)) return;");
        w.raw("for (i32 port = 0; port < ports; ++port) __builtin_prefetch(g.catom_site + ends[port]);");
        w.raw("const u64 site = g.catom_site[catom], row = u64{1} << g.cell_bits[0];");
        w.raw("for (u64 line = 0; line < 3; ++line) __builtin_prefetch(g.cell_catom + (site + line * row - row));");
        w.raw("__builtin_prefetch(g.brick_neighbours + (site >> kBrickCellBits) * kBrickNeighbours + kBrickCentre);");
    }
    w.close();
}

// On a lattice neighbours are found some catoms ahead, so that what is read there has come from memory by then.
void emit_look_ahead(const plan::Plan& plan, Writer& w) {
    w.raw("");
    w.raw("// Finds the neighbours of a catom that is evaluated soon, and asks the processor for what has changed there.");
    w.open("inline void look_ahead(const Self& s, u32 catom, [[maybe_unused]] u64 todo, i32* neighbour) {");
    w.raw("const u32 site = s.g->catom_site[catom];");
    const auto first = std::ranges::find_if(plan.pulled, [&](PredicateId p) { return plan.pulls(p); });
    const auto heard = [&](PredicateId p) { return fmt::format("s.e->subdomain->broadcasts[{}].heard", plan.of(p).column.index()); };
    const auto told = [&](PredicateId p) { return fmt::format("(todo & {}) != 0", hex(plan.columns[plan.of(p).column].own_dirty)); };
    if (first != plan.pulled.end()) {
        w.line("const u8* const heard = {} ? {} : nullptr;", told(*first), heard(*first));
        w.line("if (heard != nullptr) find_and_ask_for_heard<{}_t>(*s.g, site, neighbour, s.ports, heard);",
               predicate_name(plan.program, *first));
        w.raw("else");
        w.raw("    for (i32 port = 0; port < s.ports; ++port) neighbour[port] = catom_towards(*s.g, site, port);");
    } else {
        w.raw("for (i32 port = 0; port < s.ports; ++port) neighbour[port] = catom_towards(*s.g, site, port);");
    }
    std::size_t fetched = 0;
    for (const plan::ColumnId column : plan.columns.ids()) {
        const plan::Column& c = plan.columns[column];
        if (!c.exported || fetched == kFetched) continue;
        ++fetched;
        w.open(fmt::format("if ((todo & {}) != 0) {{", hex(c.reader_dirty)));
        w.line("const u8* const entries = s.columns[{}];", column.index());
        w.line("for (i32 port = 0; port < s.ports; ++port) __builtin_prefetch(entries + i64{{neighbour[port]}} * {});", c.stride);
        if (c.follows_rows) w.line("__builtin_prefetch(entries + u64{{catom}} * {});", c.stride);
        w.close();
    }
    emit_arrived_ahead(plan, "catom", "todo", w);
    for (const PredicateId p : plan.pulled)
        if (plan.pulls(p) && p != *first)
            w.line("if ({}) ask_for_heard<{}_t>({}, neighbour, s.ports);", told(p), predicate_name(plan.program, p), heard(p));
    w.close();
}

bool follows_rows(const plan::Plan& plan) {
    return std::ranges::any_of(plan.columns.ids(), [&](plan::ColumnId c) { return plan.columns[c].follows_rows; });
}

// In a module in pieces: what other parts define.
void declare_called(const plan::Plan& plan, Writer& w) {
    w.raw("");
    for (std::size_t i = 0; i < plan.strata.size(); ++i)
        w.line("u64 evaluate_{}(Self& s{});", i, plan.strata[i].deltas.inputs != 0 ? ", u64 todo" : "");
    for (const auto* rules : {&plan.initial_facts, &plan.linear_rules})
        for (const RulePlan& r : *rules) w.line("bool {}(Self& s);", rule_function(plan, r.rule));
}

// The same as emit_look_closer(), which would be long for many columns: a table of them.
void emit_look_closer_by_table(const plan::Plan& plan, Writer& w) {
    w.raw("");
    w.raw("// As for few columns: asks for the rows that have changed at the neighbours of a catom that is evaluated soon.");
    w.open("inline void look_closer(const Self& s, u32 catom, u64 todo, const i32* neighbour) {");
    w.raw("struct Followed {");
    w.raw("    u64 dirty;");
    w.raw("    u16 column;");
    w.raw("    u32 row_bytes;");
    w.raw("};");
    w.open("static constexpr Followed kFollowed[] = {");
    for (const plan::ColumnId column : plan.columns.ids())
        if (const plan::Column& c = plan.columns[column]; c.follows_rows)
            w.line("{{{}, {}, {}}},", hex(c.reader_dirty), column.index(), c.row_bytes);
    w.close("};");
    w.open("for (const Followed& c : kFollowed) {");
    w.raw("if ((todo & c.dirty) == 0) continue;");
    w.raw("const RowChanges* const* const changes = s.e->subdomain->changes[c.column];");
    w.raw("for (i32 port = 0; port < s.ports; ++port)");
    w.raw("    if (neighbour[port] >= 0) __builtin_prefetch(changes[neighbour[port]]);");
    w.raw("ask_for_halves(rows_of(s, c.column, catom), c.row_bytes);");
    w.close();
    w.close();
}

// For delta rules: once the heads of rows are there, what they lead to.
void emit_look_closer(const plan::Plan& plan, Writer& w) {
    w.raw("");
    w.raw(
        "// For a catom that is evaluated after the next: asks for the rows that have changed at its neighbours, and for those of its own");
    w.raw("// among which they will be looked for.");
    w.open("inline void look_closer(const Self& s, u32 catom, u64 todo, const i32* neighbour) {");
    for (const plan::ColumnId column : plan.columns.ids()) {
        const plan::Column& c = plan.columns[column];
        if (!c.follows_rows) continue;
        w.open(fmt::format("if ((todo & {}) != 0) {{", hex(c.reader_dirty)));
        w.line("const RowChanges* const* const changes = s.e->subdomain->changes[{}];", column.index());
        w.raw("for (i32 port = 0; port < s.ports; ++port)");
        w.raw("    if (neighbour[port] >= 0) __builtin_prefetch(changes[neighbour[port]]);");
        w.line("ask_for_halves(rows_of(s, {}, catom), {});", column.index(), c.row_bytes);
        w.close();
    }
    w.close();
}

}  // namespace

void emit_tries(const plan::Plan& plan, bool fixed, const std::string& call, const std::string& stop, Writer& w) {
    for (std::size_t i = 0; i < plan.linear_rules.size(); ++i) emit_try(plan, i, fixed, call, stop, w);
}

void emit_evaluate(const plan::Plan& plan, Writer& w) {
    if (plan.in_pieces()) declare_called(plan, w);
    emit_actions(plan, w);
    emit_lists(plan, w);
    emit_catom(plan, w);
    const bool ahead = !plan.program.by_links;
    const bool closer = ahead && follows_rows(plan);
    const bool far = activates(plan);
    if (ahead)
        emit_look_ahead(plan, w);
    else
        emit_links_ahead(plan, far, w);
    if (far) emit_amoebots_ahead(plan, w);
    if (closer) (plan.in_pieces() ? emit_look_closer_by_table : emit_look_closer)(plan, w);
    w.raw("");
    w.open(fmt::format("{}void evaluate(Eval* e, const u32* catoms, const u64* dirty, u32 count) {{", shared(plan)));
    w.raw("Self s;");
    w.raw("s.e = e;");
    w.raw("s.g = &e->subdomain->geometry;");
    w.raw("s.columns = e->subdomain->columns;");
    if (ahead) {
        w.raw("s.ports = s.g->ports;");
        w.raw("constexpr u32 kAhead = 4;");
        w.raw("i32 ahead[kAhead][kNeighbourRoom] = {};");
        w.raw("for (u32 i = 0; i < kAhead && i < count; ++i) look_ahead(s, catoms[i], dirty[i], ahead[i]);");
    }
    if (far) {
        w.raw("constexpr u32 kFar = 12, kCells = 8, kNeighbours = 4;");
        w.raw("for (u32 i = 0; i < kFar && i < count; ++i) look_far_ahead(s, catoms[i], dirty[i]);");
        w.raw("for (u32 i = 0; i < kCells && i < count; ++i) look_at_cells(s, catoms[i]);");
        w.raw("for (u32 i = 0; i < kNeighbours && i < count; ++i) look_at_neighbours(s, catoms[i]);");
    }
    w.open("for (u32 i = 0; i < count && e->trap == Trap::None; ++i) {");
    w.raw("e->catom = s.catom = catoms[i];");
    w.raw("e->dirty = dirty[i];");
    w.raw("e->arena = e->arena_start;");
    w.raw("e->draws = e->depth = 0;");
    if (plan::may_fail(plan)) {
        w.raw("e->undefined = 0;");
        w.raw("if (e->subdomain->undefined) [[unlikely]] e->host->undefined(e);");
    }
    if (!plan.program.functions.empty()) w.raw("s.calls = 0;");
    if (far) {
        w.raw("if (i + kFar < count) look_far_ahead(s, catoms[i + kFar], dirty[i + kFar]);");
        w.raw("if (i + kCells < count) look_at_cells(s, catoms[i + kCells]);");
        w.raw("if (i + kNeighbours < count) look_at_neighbours(s, catoms[i + kNeighbours]);");
    }
    if (!ahead) w.raw("look_ahead(s, catoms + i, dirty + i, count - i);");
    if (ahead) w.raw("s.neighbour = ahead[i % kAhead];");
    if (closer) w.raw("if (i + 2 < count) look_closer(s, catoms[i + 2], dirty[i + 2], ahead[(i + 2) % kAhead]);");
    w.raw("evaluate_catom(s, dirty[i]);");
    if (ahead) w.raw("if (i + kAhead < count) look_ahead(s, catoms[i + kAhead], dirty[i + kAhead], ahead[i % kAhead]);");
    w.close();
    w.close();
}

}  // namespace meld::emit
