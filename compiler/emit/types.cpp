// Emits the records, the row types with their order, and the working state of one catom.
#include <algorithm>
#include <map>

#include "compiler/emit/emit.h"
#include "compiler/emit/type_table.h"
#include "compiler/emit/writer.h"
#include "compiler/plan/picks.h"

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
        if (i == 0 || members[i].offset != members[i - 1].offset) w.raw(members[i].text);  // Predicates share presence bytes.
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
            out.push_back({s.presence_offset, fmt::format("u8 present_{};", s.presence_offset)});
    }
    return out;
}

}  // namespace

void emit_records(const plan::Plan& plan, Writer& w) {
    for (const plan::ColumnId id : plan.columns.ids()) {
        const plan::Column& c = plan.columns[id];
        if (c.rows) continue;
        w.raw("");
        w.line("// {}, {} byte{} a catom{}", c.name, c.stride, c.stride == 1 ? "" : "s", c.exported ? ", read by neighbours" : "");
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

std::string better(const Predicate& p, Aggregate kept) {
    const std::size_t field = p.aggregate_at;
    const char* sign = keeps_least(kept) ? "<" : ">";
    const std::string a = "a." + field_name(field), b = "b." + field_name(field);
    if (!p.arguments[field].type.compound()) return fmt::format("{} {} {}", a, sign, b);
    return fmt::format("{} {} 0", compared(p.arguments[field].type, a, b), sign);
}

}  // namespace

std::string hashed(const Type& type, const std::string& value) {
    if (type == Type::Int) return fmt::format("bits_of(i64{{{}}})", value);
    if (type == Type::Float) return fmt::format("bits_of({} + 0.0)", value);
    return type.compound() ? fmt::format("hash_list(kTypes, {}, {})", type_symbol(type), value) : fmt::format("bits_of({})", value);
}

namespace {

// How all candidates of a group become one value, if that needs nothing from the catom.
void emit_combine(const plan::Plan& plan, PredicateId id, Writer& w) {
    const Predicate& p = plan.program.predicates[id];
    if (!combines(p.aggregate) || combines_at_catom(p)) return;
    const Type& type = p.arguments[p.aggregate_at].type;
    const bool given = plan.in_pieces();
    if (given) w.raw("static constexpr bool kNamesRule = true;");
    w.open(fmt::format("static void combine(Eval& e, {}const Row* rows, u32 n, Row& out) {{", given ? "u32 rule, " : ""));
    w.line("{};", aggregate_object(p.aggregate, type, type, "", "made"));
    w.line("out.{0} = combine_rows(e, {1}, made, rows, n, [](const Row& row) {{ return row.{0}; }});", field_name(p.aggregate_at),
           given ? "rule" : "kFirstRule");
    w.close();
}

// What tells apart the facts of a round: the last argument, and whether all others are alike.
void emit_alike(const Predicate& p, const std::vector<std::size_t>& arguments, Writer& w) {
    std::string alike;
    for (std::size_t i = 0; i + 1 < arguments.size(); ++i)
        alike += fmt::format("{}a.{name} == b.{name}", i == 0 ? "" : " && ", fmt::arg("name", field_name(arguments[i])));
    const bool compound = std::ranges::any_of(arguments, [&](std::size_t f) { return p.arguments[f].type.compound(); });
    if (compound) return;
    w.line("static constexpr auto kLast = &Row::{};", field_name(arguments.back()));
    if (alike.empty())
        w.raw("static bool alike(const Row&, const Row&) { return true; }");
    else
        w.line("static bool alike(const Row& a, const Row& b) {{ return {}; }}", alike);
}

// What sets that grow in rounds are sorted by: words in the order of the arguments that make the group, if these are ints and catoms.
void emit_words(const Predicate& p, const std::vector<std::size_t>& key, Writer& w) {
    const auto is_word = [&](std::size_t f) { return p.arguments[f].type == Type::Int || p.arguments[f].type == Type::Node; };
    if (key.empty() || !std::ranges::all_of(key, is_word)) return;
    std::string words;
    for (std::size_t i = 0; i < key.size(); ++i) {
        if (i + 1 < key.size()) words += fmt::format("w == {} ? ", i);
        const char* const word = p.arguments[key[i]].type == Type::Int ? "static_cast<u64>(i64{{row.{}}}) ^ u64{{1}} << 63" : "row.{}";
        words += fmt::format(fmt::runtime(word), field_name(key[i])) + (i + 1 < key.size() ? " : " : "");
    }
    w.line("static constexpr u32 kWords = {};", key.size());
    w.line("static u64 word(const Row& row, u32{}) {{ return {}; }}", key.size() > 1 ? " w" : "", words);
    const std::string last = "row." + field_name(key.back());
    w.line("static void set_last(Row& row, u64 word) {{ {0} = static_cast<decltype({0})>({1}); }}", last,
           p.arguments[key.back()].type == Type::Int ? "static_cast<i64>(word ^ u64{1} << 63)" : "word");
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
    const std::optional<Aggregate> picked = plan::picks(plan, id);
    w.line("static constexpr Reduce kReduce = Reduce::{};", info(picked.value_or(p.aggregate)).reduction_name);
    w.line("static constexpr bool kRanked = {}, kLinks = {}, kKeyed = {}, kWaits = {};", s.ranked, links, !fields.key.empty(), s.waits);
    w.line("static constexpr bool kFollowed = {}, kGrows = {};", followed, plan::may_grow(plan, id));
    if ((s.ranked || links || followed) && plan.in_pieces()) w.raw("static constexpr bool kShared = true;");
    if ((s.ranked || links || followed) && !plan.in_pieces()) w.line("static constexpr u16 kPredicate = {};", id.index());
    if (combines(p.aggregate) && !plan.in_pieces()) w.line("static constexpr u32 kFirstRule = {};", first_rule(plan, id));
    const auto signature = [](const std::vector<std::size_t>& f) {
        return f.empty() ? "const Row&, const Row&" : "const Row& a, const Row& b";
    };
    w.line("static int key({}) {{ {} }}", signature(fields.key), chained_compare(p, fields.key));
    if (p.linear() && !fields.key.empty()) emit_alike(p, fields.key, w);
    const bool front = p.front != Aggregate::None;
    const bool ordered = keeps_best(picked.value_or(p.aggregate)) || front;
    w.line("static bool better({}) {{ return {}; }}", signature(ordered ? std::vector{p.aggregate_at} : std::vector<std::size_t>{}),
           !ordered ? "false" : better(p, picked.value_or(front ? p.front : p.aggregate)));
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
    std::string hash = "kGroupHash";
    for (const std::size_t f : group) hash = fmt::format("mix({}, {})", hash, hashed(p.arguments[f].type, "row." + field_name(f)));
    w.line("static u64 hash(const Row&{}) {{ return {}; }}", group.empty() ? "" : " row", hash);
    // Also of predicates that do not grow in rounds: rows that are alike share a type.
    if (!p.linear() && std::ranges::any_of(plan.strata, [](const plan::StratumPlan& one) { return !one.semi_naive.empty(); }))
        emit_words(p, fields.key, w);
    emit_combine(plan, id, w);
    return w.text();
}

}  // namespace

std::map<PredicateId, std::string> emit_predicates(const plan::Plan& plan, Writer& w) {
    std::map<PredicateId, std::string> row_types;
    // Predicates with equal rows share a type, and so the code that is compiled for it.
    std::map<std::string, std::string> known;
    for (const PredicateId id : plan.program.predicates.ids()) {
        if (!has_view(plan, id)) continue;
        const Predicate& p = plan.program.predicates[id];
        const std::string name = predicate_name(plan.program, id) + "_t";
        const std::string signature = fmt::format("{}/{}", name_without_line(p), p.arguments.size());
        const auto [same, fresh] = known.try_emplace(rows_of(plan, id), name);
        row_types[id] = same->second;
        w.raw("");
        if (!fresh) {
            w.line("using {} = {};  // {}", name, same->second, signature);
            continue;
        }
        w.open(fmt::format("struct {} {{  // {}", name, signature));
        w.lines(same->first);
        w.close("};");
    }
    return row_types;
}

void emit_self(const plan::Plan& plan, Writer& w) {
    w.raw("");
    w.raw("// The catom under evaluation: its links, and a working view of each of its predicates, loaded when first used.");
    w.open("struct Self {");
    w.raw("Eval* e;");
    w.raw("const Geometry* g;");
    // Here, because what a rule writes might otherwise be where these are, and they would be read again for every neighbour.
    w.raw("const u8* const* columns;   // SubdomainView::columns");
    w.raw("u32 catom;");
    w.raw("u32 site;");
    w.line("const i32* neighbour;       // {}",
           plan.program.by_links ? "Where the exports of its neighbours are read, by port." : "By port, or -1.");
    w.raw("i32 ports;");
    // Volatile: a bit would be set by an access to one byte, and reading the whole word would have to wait for it.
    const bool linear = !plan.linear_rules.empty();
    w.line("{:<28}// Dirty bits of what linear rules made,", linear ? "volatile u64 raised;" : "u64 raised;");
    w.line("{:<28}// and of what they consumed.", linear ? "volatile u64 lowered;" : "u64 lowered;");
    if (linear) w.raw("u64 fired;                  // Firings of linear rules, in this evaluation.");
    if (!plan.program.functions.empty()) w.raw("u64 calls;                  // Of functions, in this tick.");
    for (const PredicateId id : plan.program.predicates.ids()) {
        if (!has_view(plan, id)) continue;
        const std::string name = predicate_name(plan.program, id);
        w.line("{}<{}_t> {};", plan.program.predicates[id].linear() ? "Bag" : "Relation", name, name);
        if (plan.pulls(id)) w.line("Heard<{0}_t> {0}_heard;", name);
    }
    for (const plan::StratumPlan& s : plan.strata)
        for (const PredicateId id : s.predicates)
            if (s.grows(id)) w.line("Rounds<{0}_t> {0}_rounds;", predicate_name(plan.program, id));
    each_index_member(plan, [&](const std::string& type, const std::string& name) { w.line("Index<{}> {};", type, name); });
    for (const ConstantId id : plan.program.constants.ids()) {
        const Constant& c = plan.program.constants[id];
        if (!computed_once(c)) continue;
        w.open("struct {");
        w.raw("bool known = false;");
        w.line("{} value;", cpp_type(c.type));
        w.close(fmt::format("}} {};", constant_name(plan.program, id)));
    }
    w.raw("bool again;                 // Views have been evaluated before in this evaluation: what changed since is not recorded by row.");
    w.line("bool loaded[{}];", std::max<std::size_t>(1, plan.program.predicates.count()));
    w.close("};");
    w.raw("");
    w.raw("template <class R>");
    w.open("const R& record(const Self& s, u16 column, u32 catom) {");
    w.raw("return reinterpret_cast<const R*>(s.columns[column])[catom];");
    w.close();
    w.open("inline const RowsHead& rows_of(const Self& s, u16 column, u32 catom) {");
    w.raw("return reinterpret_cast<const RowsHead*>(s.columns[column])[catom];");
    w.close();
    w.raw("inline i32 ports_of(const Self& s) { return s.ports; }");
    w.raw("// The port of the neighbour with this id, or -1.");
    w.open("inline i32 port_of(const Self& s, u64 id) {");
    w.raw("for (i32 port = 0; port < ports_of(s); ++port)");
    w.raw("    if (s.neighbour[port] >= 0 && id_of(*s.g, static_cast<u32>(s.neighbour[port])) == id) return port;");
    w.raw("return -1;");
    w.close();
    if (plan.counts) {
        w.open("inline u32 link_count(const Self& s) {");
        w.raw("u32 count = 0;");
        w.raw("for (i32 port = 0; port < ports_of(s); ++port) count += s.neighbour[port] >= 0;");
        w.raw("return count;");
        w.close();
    }
    w.open("inline u32 port_bit(const Self& s, u64 id) {");
    w.raw("const i32 port = port_of(s, id);");
    w.raw("return port < 0 ? 0 : u32{1} << port;");
    w.close();
}

}  // namespace meld::emit
