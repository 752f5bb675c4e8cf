// Emits the tables by which the runtime knows a module's predicates, columns, parameters and rules.
#include <xxhash.h>

#include <optional>
#include <set>

#include "compiler/emit/emit.h"
#include "compiler/emit/type_table.h"
#include "compiler/emit/writer.h"

namespace meld::emit {

using namespace check;

namespace {

const char* kind_name(PredicateKind k) {
    switch (k) {
        case PredicateKind::Persistent:
            return "Persistent";
        case PredicateKind::Linear:
            return "Linear";
        case PredicateKind::Action:
            return "Action";
        case PredicateKind::Sensed:
            return "Sensed";
    }
    return "";
}
const char* abi_storage(Storage s) {
    switch (s) {
        case Storage::Flag:
            return "Flag";
        case Storage::Single:
            return "Single";
        case Storage::PerLink:
            return "PerLink";
        case Storage::Rows:
            return "Rows";
        default:
            return "World";
    }
}

void emit_fields(const plan::Plan& plan, const TypeTable& types, Writer& w) {
    for (const PredicateId id : plan.program.predicates.ids()) {
        const Predicate& p = plan.program.predicates[id];
        const Stored& s = plan.of(id);
        if (p.arguments.size() < 2) continue;
        w.open(fmt::format("static constexpr FieldInfo kFields{}[] = {{", id.index()));
        for (std::size_t i = 1; i < p.arguments.size(); ++i) {
            const plan::Field field = s.fields.empty() ? plan::Field{} : s.fields[i - 1];
            w.line("{{{}, ValueType::{}, {}, {}, {}}},", quoted(p.arguments[i].name), value_type(p.arguments[i].type), field.bytes,
                   field.offset, types.number(p.arguments[i].type));
        }
        w.close("};");
    }
}

// The predicates in the bodies of rules, including those of comprehensions and aggregates in heads.
std::set<PredicateId> predicates_read(const check::Program& program) {
    std::set<PredicateId> read;
    const auto note = [&](const check::Atom& atom, bool) { read.insert(atom.predicate); };
    for (const check::Rule& rule : program.rules) {
        check::each_atom(rule.body, note);
        check::each_head(rule.heads, [&](const check::Head& head) { check::each_atom(head.body, note); });
    }
    return read;
}

// by_turn: a predicate that is PredicateInfo::by_turn, which does not change how facts are stored.
void emit_predicate_table(const plan::Plan& plan, const char* storage, std::optional<PredicateId> by_turn, Writer& w) {
    const std::set<PredicateId> read = predicates_read(plan.program);
    w.open(fmt::format("{} PredicateInfo kPredicates[] = {{", storage));
    for (const PredicateId id : plan.program.predicates.ids()) {
        const Predicate& p = plan.program.predicates[id];
        const Stored& s = plan.of(id);
        const bool stored = s.column.valid();
        w.line("{{{}, PredicateKind::{}, Storage::{}, {}, {}, {}, {}, {}, {}, {}, {}, {:#x}, {}, {}{}}},", quoted(p.name),
               kind_name(p.kind), abi_storage(s.storage), p.auxiliary || !s.used, p.repeats, p.arguments.size() - 1,
               p.arguments.size() > 1 ? fmt::format("kFields{}", id.index()) : "nullptr",
               stored ? fmt::format("{}", s.column.index()) : "kNone16", s.base.valid() ? fmt::format("{}", s.base.index()) : "kNone16",
               s.ranked ? fmt::format("{}u", s.rank_offset) : "kNone32", s.presence_offset, s.presence_mask, read.contains(id), p.route,
               by_turn == id ? ", true" : "");
    }
    w.close("};");
}

// A record without facts: ranks absent, everything else zero.
void emit_initial(const plan::Plan& plan, plan::ColumnId id, Writer& w) {
    std::vector<unsigned> bytes(plan.columns[id].stride, 0);
    bool any = false;
    for (const PredicateId p : plan.columns[id].predicates) {
        const Stored& s = plan.of(p);
        if (!s.ranked) continue;
        any = true;
        for (std::uint32_t i = 0; i < 4; ++i) bytes[s.rank_offset + i] = 255;
    }
    if (!any) return;
    std::string text;
    for (const unsigned b : bytes) text += fmt::format("{},", b);
    w.line("static constexpr u8 kInitial{}[] = {{{}}};", id.index(), text);
}

bool has_initial(const plan::Plan& plan, plan::ColumnId id) {
    if (plan.columns[id].rows) return false;
    for (const PredicateId p : plan.columns[id].predicates)
        if (plan.of(p).ranked) return true;
    return false;
}

// The offsets of the words of a column that point to lists.
struct Lists {
    std::string offsets, types;
    std::size_t count = 0;
};
Lists lists_of(const plan::Plan& plan, plan::ColumnId id, const TypeTable& types) {
    Lists out;
    for (const PredicateId p : plan.columns[id].predicates) {
        const Stored& s = plan.of(p);
        const std::uint32_t places = s.storage == Storage::PerLink ? kMaxPorts : 1;
        for (const plan::Field& f : s.fields) {
            if (!f.type.compound()) continue;
            for (std::uint32_t port = 0; port < places; ++port) {
                out.offsets += fmt::format("{}{}", out.count ? ", " : "", f.offset + port * f.bytes);
                out.types += fmt::format("{}{}", out.count ? ", " : "", types.number(f.type));
                ++out.count;
            }
        }
    }
    return out;
}

// The linear predicates of which some rule sends facts.
std::set<PredicateId> sent_facts(const plan::Plan& plan) {
    std::set<PredicateId> sent;
    for (const RulePlan& r : plan.linear_rules)
        plan::each_head_plan(r.heads, [&](const plan::HeadPlan& h) {
            const auto* fact = plan::as<plan::MakeFact>(h);
            if (fact != nullptr && fact->place != plan.program.rules[r.rule].site) sent.insert(fact->predicate);
        });
    return sent;
}

void emit_column_table(const plan::Plan& plan, const TypeTable& types, const char* storage, Writer& w) {
    for (const plan::ColumnId id : plan.columns.ids()) {
        if (has_initial(plan, id)) emit_initial(plan, id, w);
        const Lists lists = lists_of(plan, id, types);
        if (lists.count == 0) continue;
        w.line("static constexpr u32 kLists{}[] = {{{}}};", id.index(), lists.offsets);
        w.line("static constexpr u16 kListTypes{}[] = {{{}}};", id.index(), lists.types);
    }
    const auto compare_groups = [&](const plan::Column& c) {
        const std::string name = predicate_name(plan.program, c.predicates[0]);
        return fmt::format(
            "[](const void* a, const void* b) {{ return {0}_t::key(*static_cast<const {0}_t::Row*>(a), *static_cast<const "
            "{0}_t::Row*>(b)); }}",
            name);
    };
    const std::set<PredicateId> sent = sent_facts(plan);
    w.open(fmt::format("{} ColumnInfo kColumns[] = {{", storage));
    for (const plan::ColumnId id : plan.columns.ids()) {
        const plan::Column& c = plan.columns[id];
        const std::size_t lists = lists_of(plan, id, types).count;
        const bool linear = c.rows && plan.program.predicates[c.predicates[0]].linear();
        w.line("{{{}, {}, {}, {}, {}, {}, {}, {}, {}, {}, {}, {}, {}{}}},", quoted(c.name), c.rows, c.exported, c.stride, c.row_bytes,
               hex(c.own_dirty), hex(c.reader_dirty), has_initial(plan, id) ? fmt::format("kInitial{}", id.index()) : "nullptr", lists,
               lists > 0 ? fmt::format("kLists{0}, kListTypes{0}", id.index()) : "nullptr, nullptr",
               c.follows_rows ? compare_groups(c) : "nullptr", linear ? compare_groups(c) : "nullptr",
               linear ? fmt::format("arrange_rows<{}_t, {}>", predicate_name(plan.program, c.predicates[0]),
                                    sent.contains(c.predicates[0]) && lists == 0 && c.row_bytes <= kShortRow)
                      : "nullptr",
               offers_of(plan, id).empty() ? "" : ", " + concerned_function(id));
    }
    if (plan.columns.empty()) w.raw("{\"\", false, false, 0, 0, 0, 0, nullptr, 0, nullptr, nullptr, nullptr, nullptr, nullptr},");
    w.close("};");
}

// The value of a constant, with the lists it points to declared before it.
std::string constant_value(const Constant& c, int& lists, Writer& w) {
    if (c.computed.valid()) return "{.integer = 0}";
    if (c.type.compound() && !c.argument) {
        Term value = c.value;
        if (c.type == Type::String) value = Term{.op = Op::String, .type = Type::String, .text = c.text};
        return fmt::format("{{.list = {}}}", static_list(value, lists, w));
    }
    if (c.type.compound()) return "{.list = nullptr}";
    if (c.type == Type::Float) return fmt::format("{{.real = {:#.17g}}}", c.real);
    if (c.type == Type::Node) return fmt::format("{{.catom = {}ull}}", static_cast<std::uint64_t>(c.integer));
    return c.integer == INT64_MIN ? "{.integer = -__INT64_MAX__ - 1}" : fmt::format("{{.integer = {}ll}}", c.integer);
}

void emit_parameter_table(const plan::Plan& plan, const TypeTable& types, Writer& w) {
    std::string rows;
    int lists = 0;
    // Parameters of the prelude, and those that the run computes, have no name: they cannot be set.
    for (const Constant& c : plan.program.constants)
        rows += fmt::format("    {{{}, ValueType::{}, {}, {}, {}}},\n", quoted(c.prelude || c.computed.valid() ? "" : c.name),
                            value_type(c.type), constant_value(c, lists, w), types.number(c.type), c.argument);
    w.open(fmt::format("{} const ParameterInfo kParameters[] = {{", plan.in_pieces() ? "extern" : "static"));
    if (!rows.empty()) w.block(rows);
    if (plan.program.constants.empty()) w.raw("{\"\", ValueType::Int, {.integer = 0}, 0, false},");
    w.close("};");
}

// The catom that a rule names as its execution site; for a table of facts, the last one.
std::optional<std::uint64_t> named_catom(const Program& program, const Rule& r, const std::vector<Clause>& body) {
    std::optional<std::uint64_t> named;
    for (const Clause& c : body) {
        if (c.kind == Clause::Kind::Atom && program.predicates[c.atom.predicate].world == WorldSource::Facts)
            named = static_cast<std::uint64_t>(program.predicates[c.atom.predicate].facts.back().catom);
        if (c.kind != Clause::Kind::Test || c.test.op != Op::Equal) continue;
        const auto& sides = c.test.operands;
        for (const std::size_t i : {std::size_t{0}, std::size_t{1}})
            if (sides[i].is_variable() && sides[i].variable == r.site && sides[1 - i].op == Op::Node)
                named = static_cast<std::uint64_t>(sides[1 - i].integer);
    }
    if (r.initial_fact && !named)
        for (const Head& h : r.heads)
            if (h.kind == Head::Kind::Comprehension) return named_catom(program, r, h.body);
    return named;
}

// The predicates that a rule reads at neighbours.
std::set<PredicateId> reads_there(const Program& program, const Rule& rule) {
    std::set<PredicateId> read;
    const auto note = [&](const check::Atom& atom, bool) {
        const Predicate& p = program.predicates[atom.predicate];
        const bool elsewhere = !atom.arguments.empty() && atom.arguments[0].is_variable() && atom.arguments[0].variable != rule.site;
        if (p.world == WorldSource::None && elsewhere) read.insert(atom.predicate);
    };
    check::each_atom(rule.body, note);
    check::each_head(rule.heads, [&](const check::Head& head) { check::each_atom(head.body, note); });
    return read;
}

void emit_rule_table(const plan::Plan& plan, Writer& w) {
    for (const RuleId id : plan.program.rules.ids()) {
        std::string heads;
        for (const PredicateId p : plan.program.rules[id].derives) heads += fmt::format("{}{}", heads.empty() ? "" : ", ", p.index());
        if (!heads.empty()) w.line("static constexpr u16 kHeads{}[] = {{{}}};", id.index(), heads);
        std::string there;
        for (const PredicateId p : reads_there(plan.program, plan.program.rules[id])) there += fmt::format("{}, ", p.index());
        if (!there.empty()) w.line("static constexpr u16 kReadsThere{}[] = {{{}}};", id.index(), there);
    }
    w.open("static constexpr RuleInfo kRules[] = {");
    for (const RuleId id : plan.program.rules.ids()) {
        const check::Rule& r = plan.program.rules[id];
        const std::optional<std::uint64_t> named = named_catom(plan.program, r, r.body);
        const std::size_t there = reads_there(plan.program, r).size();
        w.line("{{{}, {}, {}, {}, {}, {}, {}, {}, {}, {}}},", quoted(r.name), quoted(r.text), r.line, quoted(r.file), r.derives.size(),
               r.derives.empty() ? "nullptr" : fmt::format("kHeads{}", id.index()), named ? fmt::format("{}ull", *named) : "kEverywhere",
               r.linear, there, there == 0 ? "nullptr" : fmt::format("kReadsThere{}", id.index()));
    }
    if (plan.program.rules.empty()) w.raw("{\"\", \"\", 0, \"\", 0, nullptr, kEverywhere, false, 0, nullptr},");
    w.close("};");
}

// The nodes that the text names anywhere.
std::set<std::uint64_t> named_nodes(const Program& program) {
    std::set<std::uint64_t> nodes;
    const auto name = [&](std::int64_t node) { nodes.insert(static_cast<std::uint64_t>(node)); };
    const auto note = [&](const Term& whole) {
        check::each_subterm(whole, [&](const Term& t) {
            if (t.op == Op::Node) name(t.integer);
        });
    };
    for (const Rule& r : program.rules) check::each_term(r, note);
    for (const Predicate& p : program.predicates)
        for (const Fact& f : p.facts) {
            name(f.catom);
            for (const Term& argument : f.arguments) note(argument);
        }
    for (const check::Constant& c : program.constants) note(c.value);
    for (const check::Function& f : program.functions) note(f.body);
    return nodes;
}

// The routes that the text gives to a catom that it names: edge(@0, @3).
void emit_link_table(const plan::Plan& plan, Writer& w) {
    std::string rows;
    std::size_t count = 0;
    const auto link = [&](const Rule& r, PredicateId route, std::uint64_t from, const Term& to, std::uint32_t line) {
        if (to.op != Op::Node) return;
        rows += fmt::format("    {{{}, {}ull, {}ull, {}, {}}},\n", route.index(), from, static_cast<std::uint64_t>(to.integer), line,
                            quoted(r.file));
        ++count;
    };
    const auto visit = [&](const Rule& r, const Head& h, const std::vector<Clause>& body) {
        if (h.kind != Head::Kind::Fact || h.delay.op != Op::Anonymous || !plan.program.predicates[h.atom.predicate].route) return;
        for (const Clause& c : body)
            if (c.kind == Clause::Kind::Atom && plan.program.predicates[c.atom.predicate].world == WorldSource::Facts)
                for (const Fact& f : plan.program.predicates[c.atom.predicate].facts)
                    link(r, h.atom.predicate, static_cast<std::uint64_t>(f.catom), f.arguments[0], f.line);
        if (const auto from = named_catom(plan.program, r, body)) link(r, h.atom.predicate, *from, h.atom.arguments[1], r.line);
    };
    const auto names_catom = [](const Clause& c) {
        return c.kind == Clause::Kind::Test && c.test.op == Op::Equal &&
               std::ranges::any_of(c.test.operands, [](const Term& side) { return side.op == Op::Node; });
    };
    for (const Rule& r : plan.program.rules)
        for (const Head& h : r.heads) {
            // Facts that stand together, separated by commas, name the catoms of all of them.
            if (r.body.size() <= 1 || std::ranges::all_of(r.body, names_catom)) visit(r, h, r.body);
            // Linear facts in a row are one comprehension (gather.cpp).
            if (r.initial_fact && h.kind == Head::Kind::Comprehension && h.heads.size() == 1) visit(r, h.heads[0], h.body);
        }
    w.line("static constexpr u32 kLinkCount = {};", count);
    w.open("static constexpr LinkInfo kLinks[] = {");
    w.raw(rows.empty() ? "{0, 0, 0, 0, \"\"}," : rows);
    w.close("};");
}

bool sends(const plan::Plan& plan) {
    bool any = false;
    for (const auto* rules : {&plan.linear_rules, &plan.initial_facts})
        for (const RulePlan& r : *rules)
            plan::each_head_plan(r.heads, [&](const plan::HeadPlan& h) {
                const plan::MakeFact* fact = plan::as<plan::MakeFact>(h);
                if (fact == nullptr || plan.program.predicates[fact->predicate].kind == PredicateKind::Action) return;
                any = any || fact->place != plan.program.rules[r.rule].site;
            });
    return any;
}

// The compiler names its predicates by lines, after an @: a state is for a program whose lines have moved, too.
std::string without_lines(const std::string& text) {
    std::string out;
    for (const char c : text) {
        const bool in_number = std::isdigit(static_cast<unsigned char>(c)) && !out.empty() && out.back() == '@';
        if (!in_number) out += c;
    }
    return out;
}

}  // namespace

std::uint64_t schema_hash(const plan::Plan& plan) {
    Writer w;
    const TypeTable types(plan);
    types.emit(w);
    emit_fields(plan, types, w);
    // The same in pieces.
    constexpr const char* kStorage = "static constexpr";
    emit_predicate_table(plan, kStorage, std::nullopt, w);
    emit_column_table(plan, types, kStorage, w);
    const std::string text = without_lines(w.text());
    return XXH3_64bits(text.data(), text.size());
}

namespace {

// What other parts of a module in pieces define, and the numbers of its rules, which they use.
void declare_tables(const plan::Plan& plan, Writer& w) {
    w.raw("extern const PredicateInfo kPredicates[];");
    w.raw("extern const ColumnInfo kColumns[];");
    w.raw("extern const ParameterInfo kParameters[];");
    w.raw("void evaluate(Eval* e, const u32* catoms, const u64* dirty, u32 count);");
    for (const RuleId id : plan.program.rules.ids()) w.line("extern const u32 {} = {};", rule_number(plan, id), id.index());
}

}  // namespace

void emit_types(const plan::Plan& plan, Writer& w) {
    w.raw("");
    TypeTable(plan).emit(w);
}

void emit_schema(const plan::Plan& plan, Writer& w) {
    w.part("schema");
    w.raw("");
    const TypeTable types(plan);
    if (plan.in_pieces()) declare_concerned(plan, w);
    emit_fields(plan, types, w);
    emit_predicate_table(plan, shared_table(plan), fact_by_turn(plan), w);
    emit_column_table(plan, types, shared_table(plan), w);
    emit_parameter_table(plan, types, w);
    w.part(kTablesPart);
    if (plan.in_pieces()) declare_tables(plan, w);
    emit_rule_table(plan, w);
    emit_link_table(plan, w);
    const auto waits = [](const plan::Plan& all) {
        return std::ranges::any_of(all.stored, [](const plan::Stored& s) { return s.used && s.waits; });
    };
    const auto finds_ways = [](const plan::Plan& all) { return std::ranges::any_of(all.program.predicates, &Predicate::finds_its_way); };
    const auto makes_nodes = [](const plan::Plan& all) { return std::ranges::any_of(all.program.predicates, &Predicate::begins); };
    const auto& p = plan.program;
    w.raw("");
    w.open("static constexpr SourceInfo kSources[] = {");
    for (const check::Program::Source& source : p.sources) w.line("{{{}, {}}},", quoted(source.path), quoted(source.text));
    w.close("};");
    std::string includes;
    for (const std::optional<std::uint32_t>& source : p.includes) includes += source ? std::to_string(*source) + ", " : "kNone32, ";
    w.line("static constexpr u32 kIncludes[] = {{{}kNone32}};", includes);
    std::string broadcasts;
    std::size_t broadcast_count = 0;
    for (const PredicateId id : plan.pulled) {
        if (!plan.pulls(id)) continue;
        broadcasts += fmt::format("{}, ", plan.of(id).column.index());
        ++broadcast_count;
    }
    if (broadcast_count > 0) w.line("static constexpr u16 kBroadcasts[] = {{{}}};", broadcasts);
    const std::set<std::uint64_t> named = named_nodes(p);
    w.line("static constexpr u64 kNamedNodes[] = {{{}0}};", named.empty() ? "" : fmt::format("{}, ", fmt::join(named, ", ")));
    w.raw("");
    w.open("static constexpr ModuleInfo kModule = {");
    w.line("kAbiVersion, {}, {}, {}, kSources, {}, {}, kIncludes,", hex(schema_hash(plan)), quoted(p.name), p.sources.size(), p.programs,
           p.includes.size());
    w.line(
        "{}, kTypes, {}, kPredicates, {}, kColumns, {}, kParameters, {}, kRules, kLinkCount, kLinks, {}, kNamedNodes, {}, "
        "evaluate, {}, {}, {}, {}, {}, {}, {}, {}, {}, {}, {}",
        types.count(), p.predicates.count(), plan.columns.count(), p.constants.count(), p.rules.count(), named.size(), plan.reads_tick,
        plan.counts, plan.places, sends(plan), p.by_links, waits(plan), p.worlds == check::Worlds::Graphs, finds_ways(plan),
        makes_nodes(plan), plan.idle_births, p.own_graph, broadcast_count == 0 ? "" : fmt::format("{}, kBroadcasts,", broadcast_count));
    w.close("};");
}

}  // namespace meld::emit
