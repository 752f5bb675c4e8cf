// Emits how the working state of one catom is read from its records and written back.
#include <algorithm>

#include "compiler/emit/writer.h"

namespace meld::emit {

using namespace check;

std::string first_rule(const plan::Plan& plan, PredicateId id) {
    for (const RuleId r : plan.program.rules.ids())
        for (const Head& h : plan.program.rules[r].heads)
            if (h.kind == Head::Kind::Fact && h.atom.predicate == id) return rule_number(plan, r);
    return "0";
}

bool used_up(const plan::Plan& plan, PredicateId id) {
    if (!plan.program.predicates[id].linear() || plan.of(id).storage != Storage::Rows) return false;
    return std::ranges::any_of(plan.linear_rules, [&](const RulePlan& r) {
        const Rule& rule = plan.program.rules[r.rule];
        if (!r.heads.empty() || !r.branches.empty() || r.steps.size() != 1 || rule.select != Select::None) return false;
        const auto* m = plan::as<plan::Match>(r.steps[0]);
        if (m == nullptr || m->predicate != id || !m->at_site || m->read_only || rule.body.size() != 1) return false;
        return std::ranges::all_of(m->uses, [](plan::ArgumentUse use) { return use == plan::ArgumentUse::Skip; });
    });
}

std::optional<PredicateId> fact_by_turn(const plan::Plan& plan) { return plan.singles.apply() ? std::nullopt : plan::activated_fact(plan); }

namespace {

// For what a catom is evaluated, if it may hold facts of a predicate that is used up.
std::string may_hold(const plan::Plan& plan, plan::ColumnId column) {
    return fmt::format("(s.e->dirty & (kDirtyBorn | {})) != 0", hex(plan.columns[column].own_dirty));
}

std::string presence(const Stored& s, const std::string& record, const std::string& name) {
    if (s.ranked) return fmt::format("{}.{}_rank != kAbsent", record, name);
    return fmt::format("({}.present_{} & {:#x}u) != 0", record, s.presence_offset, s.presence_mask);
}

void emit_load_once(PredicateId id, const std::string& name, Writer& w) {
    w.open(fmt::format("inline void load_{}(Self& s) {{", name));
    w.line("if (!s.loaded[{}]) open_{}(s);", id.index(), name);
    w.close();
}

void emit_load(const plan::Plan& plan, PredicateId id, Writer& w) {
    const Stored& s = plan.of(id);
    const std::string name = predicate_name(plan.program, id);
    const std::string view = "s." + name;
    const std::string rule = first_rule(plan, id);
    w.raw("");
    const std::string open = fmt::format("MELD_STEP {}void open_{}(Self& s)", shared(plan), name);
    if (plan.in_pieces()) {
        w.raw(open + ";");
        emit_load_once(id, name, w);
        w.part(part_of(plan, id));
    }
    w.open(open + " {");
    w.line("s.loaded[{}] = true;", id.index());
    if (plan.in_pieces() && !plan.program.predicates[id].linear()) w.line("set_number({}.predicate, {});", view, id.index());
    if (plan.pulls(id)) {
        w.line("{0}.open({0}_heard.rows, {0}_heard.count, {1});", view, rule);
        w.line("{0}.changed = {0}_heard.come;", view);
    } else if (s.storage == Storage::Rows) {
        if (used_up(plan, id)) {
            w.line("// There are none but new ones.");
            w.line("if (!({})) return {}.open(nullptr, 0, {});", may_hold(plan, s.column), view, rule);
        }
        w.line("const RowsHead& head = rows_of(s, {}, s.catom);", s.column.index());
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
    if (plan.in_pieces())
        w.part("");
    else
        emit_load_once(id, name, w);
}

// In a module with counters, if a view of the predicate has changed.
void emit_count(const plan::Plan& plan, PredicateId id, const std::string& condition, Writer& w) {
    if (!plan.counts) return;
    const std::string name = predicate_name(plan.program, id);
    const std::string bits = message_bits(plan, id, [](std::size_t i) { return as_word("row." + field_name(i)); });
    w.line("{4}{5}count_changes(*s.e, s.{0}, {1}, {2}, []([[maybe_unused]] const {0}_t::Row& row) {{ return {3}; }});", name, id.index(),
           plan.of(id).exported ? "link_count(s)" : "0", bits, condition, condition.empty() ? "" : " ");
}

void emit_store(const plan::Plan& plan, PredicateId id, Writer& w) {
    const Stored& s = plan.of(id);
    const std::string name = predicate_name(plan.program, id);
    w.open(fmt::format("if (s.loaded[{}] && s.{}.changed) {{", id.index(), name));
    w.raw("changed = true;");
    emit_count(plan, id, "", w);
    if (s.storage == Storage::PerLink) {
        w.line("r.{}_ports = 0;", name);
        w.open(fmt::format("for (u32 i = 0; i < s.{}.count; ++i) {{", name));
        w.line("const auto& row = s.{}.rows[i];", name);
        w.line("r.{}_ports |= 1u << row.a1;", name);
        for (std::size_t i = 1; i < s.fields.size(); ++i) w.line("r.{0}_{1}[row.a1] = row.{1};", name, field_name(i + 1));
        w.close();
    } else {
        const std::string clear =
            s.ranked ? fmt::format("r.{}_rank = kAbsent;", name)
                     : fmt::format("r.present_{0} = static_cast<u8>(r.present_{0} & ~{1:#x}u);", s.presence_offset, s.presence_mask);
        const std::string set =
            s.ranked ? fmt::format("r.{0}_rank = s.{0}.rows[0].rank;", name)
                     : fmt::format("r.present_{0} = static_cast<u8>(r.present_{0} | {1:#x}u);", s.presence_offset, s.presence_mask);
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
bool column_has_lists(const plan::Plan& plan, plan::ColumnId column) {
    return std::ranges::any_of(plan.columns[column].predicates, [&](PredicateId id) { return has_lists(plan.of(id)); });
}

}  // namespace

std::string message_bits(const plan::Plan& plan, PredicateId id, const std::function<std::string(std::size_t)>& word) {
    // Whether the fact has come or gone.
    std::uint64_t known = 1;
    std::string more;
    const Stored& s = plan.of(id);
    for (std::size_t i = 1; i <= s.fields.size(); ++i) {
        const plan::Field& f = s.fields[i - 1];
        if (f.type.compound())
            more += fmt::format(" + value_bits(kTypes, {}, {})", type_symbol(f.type), word(i));
        else
            known += f.type == Type::Bool ? 1 : f.type == Type::Int ? 8 * f.bytes : 64;
    }
    if (s.ranked) known += 8 * kRankBytes;
    return fmt::format("u64{{{}}}{}", known, more);
}

void emit_load_and_save(const plan::Plan& plan, Writer& w) {
    for (const PredicateId id : plan.program.predicates.ids())
        if (has_view(plan, id)) emit_load(plan, id, w);
    w.part(kMainPart);
    w.raw("");
    w.raw("// Writes what has changed back: exported columns at the end of the tick, the others now.");
    w.open("MELD_STEP static void save(Self& s) {");
    for (const plan::ColumnId column : plan.columns.ids()) {
        const plan::Column& c = plan.columns[column];
        if (c.rows) {
            const std::string name = predicate_name(plan.program, c.predicates[0]);
            const bool linear = plan.program.predicates[c.predicates[0]].linear();
            const std::string list = linear ? "s." + name + ".list" : "s." + name;
            std::string changed = fmt::format("if (s.loaded[{}] && s.{}.changed)", c.predicates[0].index(), name);
            if (used_up(plan, c.predicates[0]))
                changed.insert(changed.size() - 1, fmt::format(" && (s.{}.list.count > 0 || {})", name, may_hold(plan, column)));
            if (!linear) emit_count(plan, c.predicates[0], changed, w);
            if (linear) w.line("{} s.{}.arrange(*s.e);", changed, name);
            if (c.follows_rows && c.exported)
                w.line("{} s.e->host->change_rows(s.e, {}, own_changes(*s.e, s.{}));", changed, column.index(), name);
            else if (linear && !column_has_lists(plan, column))
                w.line("{} store_rows(*s.e, {}, {});", changed, column.index(), list);
            else
                w.line("{0} s.e->host->assign_rows(s.e, {1}, {2}.rows, {2}.count);", changed, column.index(), list);
            continue;
        }
        std::string any;
        for (const PredicateId id : c.predicates) any += fmt::format("{}s.loaded[{}]", any.empty() ? "" : " || ", id.index());
        w.open(fmt::format("if ({}) {{", any));
        w.line("{0} r = record<{0}>(s, {1}, s.catom);", record_name(column), column.index());
        w.raw("bool changed = false;");
        for (const PredicateId id : c.predicates) emit_store(plan, id, w);
        if (c.exported || column_has_lists(plan, column))
            w.line("if (changed) s.e->host->export_record(s.e, {}, &r);", column.index());
        else
            w.line("if (changed) reinterpret_cast<{}*>(s.e->subdomain->columns[{}])[s.catom] = r;", record_name(column), column.index());
        w.close();
    }
    w.close();
    w.part("");
}

}  // namespace meld::emit
