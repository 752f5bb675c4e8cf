// Emits the records, the row types with their order, and the working state of one catom.
#include <algorithm>
#include <map>

#include "compiler/emit/emit.h"
#include "compiler/emit/type_table.h"
#include "compiler/emit/writer.h"

namespace meld::emit {

using namespace check;

namespace {

// The type of a field in storage: an int may be narrow.
std::string stored_type(const plan::Field& f) { return f.type == Type::Int ? fmt::format("i{}", 8 * f.bytes) : cpp_type(f.type); }

// A member of a record or row, placed by the layout; members are declared in the order of their offsets.
struct Member {
    std::uint32_t offset;
    std::string text;
};

void emit_members(std::vector<Member> members, Writer& w) {
    std::sort(members.begin(), members.end(), [](const Member& a, const Member& b) { return a.offset < b.offset; });
    for (std::size_t i = 0; i < members.size(); ++i)
        if (i == 0 || members[i].offset != members[i - 1].offset) w.raw(members[i].text);  // Predicates share presence words.
}

std::vector<Member> record_members(const plan::Plan& plan, const plan::Column& c) {
    std::vector<Member> out;
    for (const PredicateId id : c.predicates) {
        const Stored& s = plan.of(id);
        const std::string name = predicate_name(plan.program, id);
        const bool per_link = s.storage == Storage::PerLink;
        for (std::size_t i = per_link ? 1 : 0; i < s.fields.size(); ++i)
            out.push_back({s.fields[i].offset, fmt::format("{} {}_{}{};", stored_type(s.fields[i]), name, field_name(i + 1),
                                                           per_link ? fmt::format("[{}]", kMaxPorts) : "")});
        if (s.ranked)
            out.push_back({s.rank_offset, fmt::format("u32 {}_rank;", name)});
        else if (per_link)
            out.push_back({s.presence_offset, fmt::format("u32 {}_ports;", name)});
        else
            out.push_back({s.presence_offset, fmt::format("u32 present_{};", s.presence_offset)});
    }
    return out;
}

}  // namespace

void emit_records(const plan::Plan& plan, Writer& w) {
    for (const plan::ColumnId id : plan.columns.ids()) {
        const plan::Column& c = plan.columns[id];
        if (c.rows) continue;
        w.raw("");
        w.line("// {}, {} bytes a catom{}", c.name, c.stride, c.exported ? ", read by neighbours" : "");
        w.open(fmt::format("struct {} {{", record_name(id)));
        emit_members(record_members(plan, c), w);
        w.close("};");
        w.line("static_assert(sizeof({}) == {});", record_name(id), c.stride);
    }
}

namespace {

// The parts of a predicate's row that make the group, the value, and the payload. PerLink rows name the port.
struct RowShape {
    std::vector<std::size_t> key, value, ride;  // Arguments, counted from 1.
};

RowShape shape(const Predicate& p) {
    RowShape out;
    const bool aggregated = p.aggregate != Aggregate::None;
    for (std::size_t i = 1; i < p.arguments.size(); ++i) {
        if (!aggregated || i < p.aggregate_at)
            out.key.push_back(i);
        else if (i == p.aggregate_at)
            out.value.push_back(i);
        else
            out.ride.push_back(i);
    }
    return out;
}

std::string chained_compare(const Predicate& p, const std::vector<std::size_t>& fields) {
    std::string text;
    for (const std::size_t f : fields)
        text += fmt::format("if (const int c = {}) return c; ", compared(p.arguments[f].type, "a." + field_name(f), "b." + field_name(f)));
    return text + "return 0;";
}

std::string better(const Predicate& p, std::size_t field) {
    const char* sign = keeps_least(p.aggregate) || keeps_least(p.front) ? "<" : ">";
    const std::string a = "a." + field_name(field), b = "b." + field_name(field);
    if (!p.arguments[field].type.compound()) return fmt::format("{} {} {}", a, sign, b);
    return fmt::format("{} {} 0", compared(p.arguments[field].type, a, b), sign);
}

std::string hashed(const Type& type, const std::string& value) {
    if (type == Type::Int) return fmt::format("bits_of(i64{{{}}})", value);
    return type.compound() ? fmt::format("hash_list(kTypes, {}, {})", type_symbol(type), value) : fmt::format("bits_of({})", value);
}

// How all candidates of a group become one value, if that needs nothing from the catom.
void emit_combine(const Predicate& p, Writer& w) {
    if (!combines(p.aggregate) || combines_at_catom(p)) return;
    const Type& type = p.arguments[p.aggregate_at].type;
    w.open("static void combine(Eval& e, const Row* rows, u32 n, Row& out) {");
    w.line("{};", aggregate_object(p.aggregate, type, type, "", "made"));
    w.line("out.{0} = combine_rows(e, kFirstRule, made, rows, n, [](const Row& row) {{ return row.{0}; }});", field_name(p.aggregate_at));
    w.close();
}

// The first rule that derives the predicate, which a trap names.
std::uint32_t first_rule(const plan::Plan& plan, PredicateId id) {
    for (const RuleId r : plan.program.rules.ids())
        for (const Head& h : plan.program.rules[r].heads)
            if (h.kind == Head::Kind::Fact && h.atom.predicate == id) return static_cast<std::uint32_t>(r.index());
    return 0;
}

// The members of the struct that describes a predicate's rows.
std::string rows_of(const plan::Plan& plan, PredicateId id) {
    const Predicate& p = plan.program.predicates[id];
    const Stored& s = plan.of(id);
    const RowShape fields = shape(p);
    const bool followed = s.column.valid() && plan.columns[s.column].follows_rows;
    bool links = false;
    for (const plan::StratumPlan& stratum : plan.strata)
        for (const PredicateId member : stratum.predicates)
            if (member == id) links = stratum.links;

    Writer w;
    w.open("struct Row {");
    std::vector<Member> members;
    for (std::size_t i = 0; i < s.fields.size(); ++i) {
        const bool port = s.storage == Storage::PerLink && i == 0;
        // Without a layout of rows of its own, the order of declaration serves.
        const std::uint32_t at = s.storage == Storage::Rows ? s.fields[i].offset : static_cast<std::uint32_t>(i);
        members.push_back({at, fmt::format("{} {};", port ? "i64" : stored_type(s.fields[i]), field_name(i + 1))});
    }
    if (s.ranked) members.push_back({s.storage == Storage::Rows ? s.rank_offset : 1000, "u32 rank;"});
    if (s.waits) members.push_back({s.storage == Storage::Rows ? s.from_offset : 1001, "u32 from;"});
    if (members.empty()) members.push_back({0, "u8 unit;"});
    emit_members(std::move(members), w);
    w.close("};");
    if (s.storage == Storage::Rows) w.line("static_assert(sizeof(Row) == {});", plan.columns[s.column].row_bytes);
    w.line("static constexpr Reduce kReduce = Reduce::{};", info(p.aggregate).reduction_name);
    w.line("static constexpr bool kRanked = {}, kLinks = {}, kKeyed = {}, kWaits = {};", s.ranked, links, !fields.key.empty(), s.waits);
    w.line("static constexpr bool kFollowed = {};", followed);
    if (s.ranked || links || followed) w.line("static constexpr u16 kPredicate = {};", id.index());
    if (combines(p.aggregate)) w.line("static constexpr u32 kFirstRule = {};", first_rule(plan, id));
    const auto signature = [](const std::vector<std::size_t>& f) {
        return f.empty() ? "const Row&, const Row&" : "const Row& a, const Row& b";
    };
    w.line("static int key({}) {{ {} }}", signature(fields.key), chained_compare(p, fields.key));
    const bool front = p.front != Aggregate::None;
    const bool ordered = keeps_best(p.aggregate) || front;
    w.line("static bool better({}) {{ return {}; }}", signature(ordered ? std::vector{p.aggregate_at} : std::vector<std::size_t>{}),
           !ordered ? "false" : better(p, p.aggregate_at));
    std::vector<std::size_t> rest = fields.value;
    rest.insert(rest.end(), fields.ride.begin(), fields.ride.end());
    // The tick since which a group holds is not part of its value: the existing row stays.
    if (p.aggregate == Aggregate::Since) rest.clear();
    std::string same = "true", first;
    for (const std::size_t f : rest)
        same = (same == "true" ? "" : same + " && ") + equal(p.arguments[f].type, "a." + field_name(f), "b." + field_name(f));
    w.line("static bool same({}) {{ return {}; }}", signature(rest), same);
    w.line("static int rest({}) {{ {} }}", signature(rest), chained_compare(p, rest));
    w.line("static bool before(const Row& a, const Row& b) {{ return rest(a, b) < 0; }}");
    // The rows of a front are also distinguished by their values; the group is the same.
    std::vector<std::size_t> group = fields.key;
    if (front) {
        group.resize(p.aggregate_at - 1);
        w.line("static int group({}) {{ {} }}", signature(group), chained_compare(p, group));
    }
    std::string hash = "0x9e37ull";
    for (const std::size_t f : group) hash = fmt::format("mix({}, {})", hash, hashed(p.arguments[f].type, "row." + field_name(f)));
    w.line("static u64 hash(const Row&{}) {{ return {}; }}", group.empty() ? "" : " row", hash);
    emit_combine(p, w);
    return w.text();
}

}  // namespace

void emit_predicates(const plan::Plan& plan, Writer& w) {
    // Predicates with equal rows share a type, and so the code that is compiled for it.
    std::map<std::string, std::string> known;
    for (const PredicateId id : plan.program.predicates.ids()) {
        if (!has_view(plan, id)) continue;
        const std::string name = predicate_name(plan.program, id) + "_t", signature = plan.program.predicates[id].signature();
        const auto [same, fresh] = known.try_emplace(rows_of(plan, id), name);
        w.raw("");
        if (!fresh) {
            w.line("using {} = {};  // {}", name, same->second, signature);
            continue;
        }
        w.open(fmt::format("struct {} {{  // {}", name, signature));
        w.lines(same->first);
        w.close("};");
    }
}

void emit_self(const plan::Plan& plan, Writer& w) {
    w.raw("");
    w.raw("// The catom under evaluation: its links, and a working view of each of its predicates, loaded when first used.");
    w.open("struct Self {");
    w.raw("Eval* e;");
    w.raw("const Geometry* g;");
    w.raw("u32 catom;");
    w.raw("u32 site;");
    w.raw("i32 neighbour[kMaxPorts];");
    w.raw("u64 raised;                 // Dirty bits of what linear rules made,");
    w.raw("u64 lowered;                // and of what they consumed.");
    if (!plan.program.functions.empty()) w.raw("u64 calls;                  // Of functions, in this tick.");
    for (const PredicateId id : plan.program.predicates.ids()) {
        if (!has_view(plan, id)) continue;
        const std::string name = predicate_name(plan.program, id);
        w.line("{}<{}_t> {};", plan.program.predicates[id].linear() ? "Bag" : "Relation", name, name);
    }
    w.raw("bool again;                 // Views have been evaluated before in this evaluation: what changed since is not recorded by row.");
    w.line("bool loaded[{}];", std::max<std::size_t>(1, plan.program.predicates.count()));
    w.line("bool active[{}];", std::max<std::size_t>(1, plan.linear_rules.size()));
    w.close("};");
    w.raw("");
    w.raw("template <class R>");
    w.open("const R& record(const Self& s, u16 column, u32 catom) {");
    w.raw("return reinterpret_cast<const R*>(s.e->subdomain->columns[column])[catom];");
    w.close();
    w.open("inline const RowsHead& rows_of(const Self& s, u16 column, u32 catom) {");
    w.raw("return reinterpret_cast<const RowsHead*>(s.e->subdomain->columns[column])[catom];");
    w.close();
    w.raw("// The port of the neighbour with this id, or -1.");
    w.open("inline i32 port_of(const Self& s, u64 id) {");
    w.raw("for (i32 port = 0; port < s.g->ports; ++port)");
    w.raw("    if (s.neighbour[port] >= 0 && s.g->catom_id[s.neighbour[port]] == id) return port;");
    w.raw("return -1;");
    w.close();
    w.open("inline u32 port_bit(const Self& s, u64 id) {");
    w.raw("const i32 port = port_of(s, id);");
    w.raw("return port < 0 ? 0 : u32{1} << port;");
    w.close();
}

namespace {

std::string presence(const Stored& s, const std::string& record, const std::string& name) {
    if (s.ranked) return fmt::format("{}.{}_rank != kAbsent", record, name);
    return fmt::format("({}.present_{} & {:#x}u) != 0", record, s.presence_offset, s.presence_mask);
}

void emit_load(const plan::Plan& plan, PredicateId id, Writer& w) {
    const Stored& s = plan.of(id);
    const std::string name = predicate_name(plan.program, id);
    const std::string view = "s." + name;
    const std::uint32_t rule = first_rule(plan, id);
    w.raw("");
    w.open(fmt::format("MELD_STEP static void open_{}(Self& s) {{", name));
    w.line("s.loaded[{}] = true;", id.index());
    if (s.storage == Storage::Rows) {
        w.line("const RowsHead& head = rows_of(s, {}, s.catom);", s.column.index());
        if (plan.program.predicates[id].linear())
            w.line("{}.open(*s.e, reinterpret_cast<const {}_t::Row*>(head.data), head.count, {});", view, name, rule);
        else
            w.line("{}.open(reinterpret_cast<const {}_t::Row*>(head.data), head.count, {});", view, name, rule);
    } else {
        w.line("const {0}& r = record<{0}>(s, {1}, s.catom);", record_name(s.column), s.column.index());
        if (s.storage == Storage::PerLink) {
            w.line("auto* rows = static_cast<{}_t::Row*>(scratch(*s.e, kMaxPorts * sizeof({}_t::Row)));", name, name);
            w.raw("u32 n = 0;");
            w.open(fmt::format("for (u32 port = 0; port < {}; ++port) {{", kMaxPorts));
            w.line("if ((r.{}_ports >> port & 1) == 0) continue;", name);
            w.raw("rows[n].a1 = port;");
            for (std::size_t i = 1; i < s.fields.size(); ++i) w.line("rows[n].{1} = r.{0}_{1}[port];", name, field_name(i + 1));
            w.raw("++n;");
            w.close();
            w.line("{}.open(rows, n, {});", view, rule);
        } else {
            w.open(fmt::format("if ({}) {{", presence(s, "r", name)));
            for (std::size_t i = 0; i < s.fields.size(); ++i) w.line("{0}.single.{2} = r.{1}_{2};", view, name, field_name(i + 1));
            if (s.ranked)
                w.line("{}.single.rank = r.{}_rank;", view, name);
            else if (s.fields.empty())
                w.line("{}.single.unit = 0;", view);
            w.line("{0}.open(&{0}.single, 1, {1});", view, rule);
            w.close();
            w.open("else {");
            w.line("{}.open(nullptr, 0, {});", view, rule);
            w.close();
        }
    }
    w.close();
    w.open(fmt::format("inline void load_{}(Self& s) {{", name));
    w.line("if (!s.loaded[{}]) open_{}(s);", id.index(), name);
    w.close();
}

void emit_store(const plan::Plan& plan, PredicateId id, Writer& w) {
    const Stored& s = plan.of(id);
    const std::string name = predicate_name(plan.program, id);
    w.open(fmt::format("if (s.loaded[{}] && s.{}.changed) {{", id.index(), name));
    w.raw("changed = true;");
    if (s.storage == Storage::PerLink) {
        w.line("r.{}_ports = 0;", name);
        w.open(fmt::format("for (u32 i = 0; i < s.{}.count; ++i) {{", name));
        w.line("const auto& row = s.{}.rows[i];", name);
        w.line("r.{}_ports |= 1u << row.a1;", name);
        for (std::size_t i = 1; i < s.fields.size(); ++i) w.line("r.{0}_{1}[row.a1] = row.{1};", name, field_name(i + 1));
        w.close();
    } else {
        const std::string clear = s.ranked ? fmt::format("r.{}_rank = kAbsent;", name)
                                           : fmt::format("r.present_{} &= ~{:#x}u;", s.presence_offset, s.presence_mask);
        const std::string set = s.ranked ? fmt::format("r.{0}_rank = s.{0}.rows[0].rank;", name)
                                         : fmt::format("r.present_{} |= {:#x}u;", s.presence_offset, s.presence_mask);
        w.open(fmt::format("if (s.{}.count == 0) {{", name));
        w.raw(clear);
        // Absent values are zero, so that equal states have equal bytes.
        for (std::size_t i = 0; i < s.fields.size(); ++i) w.line("r.{}_{} = {{}};", name, field_name(i + 1));
        w.close();
        w.open("else {");
        w.raw(set);
        for (std::size_t i = 0; i < s.fields.size(); ++i) w.line("r.{0}_{1} = s.{0}.rows[0].{1};", name, field_name(i + 1));
        w.close();
    }
    w.close();
}

// Whether the runtime must count what the column's records point to.
bool has_lists(const plan::Plan& plan, plan::ColumnId column) {
    for (const PredicateId id : plan.columns[column].predicates)
        for (const plan::Field& f : plan.of(id).fields)
            if (f.type.compound()) return true;
    return false;
}

}  // namespace

void emit_load_and_save(const plan::Plan& plan, Writer& w) {
    for (const PredicateId id : plan.program.predicates.ids())
        if (has_view(plan, id)) emit_load(plan, id, w);
    w.raw("");
    w.raw("// Writes what has changed back: exported columns at the end of the tick, the others now.");
    w.open("MELD_STEP static void save(Self& s) {");
    for (const plan::ColumnId column : plan.columns.ids()) {
        const plan::Column& c = plan.columns[column];
        if (c.rows) {
            const std::string name = predicate_name(plan.program, c.predicates[0]);
            const bool linear = plan.program.predicates[c.predicates[0]].linear();
            const std::string list = linear ? "s." + name + ".list" : "s." + name;
            if (c.follows_rows && c.exported) {
                w.line("if (s.loaded[{0}] && s.{1}.changed) s.e->host->change_rows(s.e, {2}, own_changes(*s.e, s.{1}));",
                       c.predicates[0].index(), name, column.index());
                continue;
            }
            w.line("if (s.loaded[{0}] && s.{1}.changed) s.e->host->assign_rows(s.e, {2}, {3}.rows, {3}.count);", c.predicates[0].index(),
                   name, column.index(), list);
            continue;
        }
        std::string any;
        for (const PredicateId id : c.predicates) any += fmt::format("{}s.loaded[{}]", any.empty() ? "" : " || ", id.index());
        w.open(fmt::format("if ({}) {{", any));
        w.line("{0} r = record<{0}>(s, {1}, s.catom);", record_name(column), column.index());
        w.raw("bool changed = false;");
        for (const PredicateId id : c.predicates) emit_store(plan, id, w);
        if (c.exported || has_lists(plan, column))
            w.line("if (changed) s.e->host->export_record(s.e, {}, &r);", column.index());
        else
            w.line("if (changed) reinterpret_cast<{}*>(s.e->subdomain->columns[{}])[s.catom] = r;", record_name(column), column.index());
        w.close();
    }
    w.close();
}

}  // namespace meld::emit
