// Emits one function per rule: nested loops over the plan's steps, innermost what the rule makes.
#include <algorithm>
#include <utility>

#include "compiler/emit/writer.h"

namespace meld::emit {

using namespace check;
using plan::ArgumentUse;
using plan::HeadPlan;
using plan::Step;

namespace {

struct Consumed {
    PredicateId predicate;
    std::string position;  // The C++ name of the index into the bag.
};

class RuleEmitter {
  public:
    RuleEmitter(const plan::Plan& plan, const RulePlan& rule, Writer& w)
        : plan_(plan), rule_plan_(rule), w_(w), scope_{plan, plan.program.rules[rule.rule], rule.rule.index()} {
        scope_.places.insert(scope_.rule.home);
    }

    void view() {
        comment();
        w_.open(fmt::format("static void {}(Self& s) {{", rule_function(plan_.program, rule_plan_.rule)));
        const std::size_t outside = w_.depth();
        steps(rule_plan_.steps);
        propose(rule_plan_.heads[0]);
        close_to(outside);
        w_.close();
    }

    // The groups of the head that changed rows of one input can affect.
    void touch(std::size_t number) {
        const HeadPlan& head = rule_plan_.heads[0];
        w_.raw("");
        w_.open(fmt::format("static void {}_touch{}(Self& s, Touched<{}_t>& touched) {{", rule_function(plan_.program, rule_plan_.rule), number,
                            predicate_name(plan_.program, head.predicate)));
        const std::size_t outside = w_.depth();
        steps(rule_plan_.steps);
        w_.line("{} row{{}};", row_type(head.predicate));
        for (std::size_t i = 1; i <= plan::group_arguments(plan_.program.predicates[head.predicate]); ++i)
            w_.line("row.{} = {};", field_name(i), head_value(head.predicate, i, head.arguments[i - 1]));
        w_.raw("touched.add(*s.e, row);");
        close_to(outside);
        w_.close();
    }

    // The rule for one group of the head.
    void group() {
        const HeadPlan& head = rule_plan_.heads[0];
        w_.raw("");
        w_.open(fmt::format("static void {}_group(Self& s, const {}& group) {{", rule_function(plan_.program, rule_plan_.rule), row_type(head.predicate)));
        const std::size_t outside = w_.depth();
        for (std::size_t i = 0; i < rule_plan_.given.size(); ++i) bind(rule_plan_.given[i], fmt::format("group.{}", field_name(i + 1)));
        steps(rule_plan_.steps);
        propose(head);
        close_to(outside);
        w_.close();
    }

    void linear() {
        comment();
        w_.open(fmt::format("static bool {}(Self& s) {{", rule_function(plan_.program, rule_plan_.rule)));
        const std::size_t outside = w_.depth();
        steps(rule_plan_.steps);
        w_.raw("if (s.e->trap != Trap::None) return false;");
        consume();
        freeze();
        heads(rule_plan_.heads);
        for (const PredicateId b : held_) w_.line("s.{}.release(*s.e);", predicate_name(plan_.program, b));
        w_.raw("return true;");
        const bool always = w_.depth() == outside;
        close_to(outside);
        if (!always) w_.raw("return false;");
        w_.close();
    }

  private:
    void comment() {
        w_.raw("");
        w_.line("// {}", scope_.rule.line ? fmt::format("Line {}", scope_.rule.line) : std::string("Made by the compiler"));
        std::string line;
        for (const char c : scope_.rule.text + "\n") {
            if (c != '\n') {
                line += c == '\\' ? '/' : c;  // A backslash at the end of a line would swallow the next one.
                continue;
            }
            w_.line("//     {}", line);
            line.clear();
        }
    }

    // Comprehensions see what there was when the rule was applied, less what has been consumed since: what the rule itself
    // makes joins the bags when it is done, and given facts are read as they were.
    void freeze() {
        std::vector<PredicateId> made, read;
        const auto walk_steps = [&](const auto& self, const std::vector<Step>& all) -> void {
            for (const Step& s : all) {
                self(self, s.inner);
                if (s.kind == Step::Kind::Match && s.at_home) read.push_back(s.predicate);
            }
        };
        const auto walk = [&](const auto& self, const std::vector<HeadPlan>& all) -> void {
            for (const HeadPlan& h : all) {
                if (h.kind == Head::Kind::Fact && h.place == scope_.rule.home) made.push_back(h.predicate);
                walk_steps(walk_steps, h.steps);
                self(self, h.heads);
            }
        };
        walk(walk, rule_plan_.heads);
        std::sort(read.begin(), read.end());
        read.erase(std::unique(read.begin(), read.end()), read.end());
        for (const PredicateId p : read) {
            const std::string name = predicate_name(plan_.program, p);
            if (std::find(made.begin(), made.end(), p) == made.end()) continue;
            w_.line("load_{}(s);", name);
            if (plan_.program.predicates[p].linear()) {
                w_.line("s.{}.hold();", name);
                held_.push_back(p);
            } else {
                w_.line("const auto* const seen_{0} = s.{0}.rows;", name);
                w_.line("const u32 seen_{0}_count = s.{0}.count;", name);
                frozen_.push_back(p);
            }
        }
    }

    void close_to(std::size_t depth) {
        while (w_.depth() > depth) w_.close();
    }
    std::string fresh(const char* stem) { return fmt::format("{}{}", stem, scope_.next++); }

    void steps(const std::vector<Step>& all) {
        for (const Step& s : all) step(s);
    }

    void step(const Step& s) {
        switch (s.kind) {
            case Step::Kind::Neighbours: return neighbours(s);
            case Step::Kind::Locate: return locate(s);
            case Step::Kind::Match: return match(s);
            case Step::Kind::Test: return w_.open(fmt::format("if ({}) {{", term(scope_, s.term)));
            case Step::Kind::Set: return set(s);
            case Step::Kind::Absent: return absent(s);
        }
    }

    void set(const Step& s) {
        const Type type = scope_.rule.variables[s.variable].type;
        const std::string value = term_as(scope_, s.term, type);
        bind(s.variable, type == Type::Float ? fmt::format("checked_real(*s.e, {}, {})", scope_.rule_index, value) : value);
    }

    void bind(VariableId v, const std::string& value) {
        w_.line("const {} {} = {};", cpp_type(scope_.rule.variables[v].type), scope_.local(v), value);
        scope_.values.insert(v);
    }

    // ---- links

    void neighbours(const Step& s) {
        const bool named = s.place.valid();
        const std::string port = named ? scope_.port(s.place) : fresh("port");
        const std::string at = named ? scope_.at(s.place) : fresh("at");
        w_.open(fmt::format("for (i32 {0} = 0; {0} < s.g->ports; ++{0}) {{", port));
        w_.line("if (s.neighbour[{}] < 0) continue;", port);
        if (named) {
            w_.line("[[maybe_unused]] const u32 {} = static_cast<u32>(s.neighbour[{}]);", at, port);
            scope_.places.insert(s.place);
        } else if (s.term.op != Op::Anonymous) {
            w_.line("if (s.g->catom_id[s.neighbour[{}]] != {}) continue;", port, term(scope_, s.term));
        }
        port_use(s, port);
    }

    void locate(const Step& s) {
        const std::string port = scope_.port(s.place);
        if (!scope_.places.contains(s.place)) {
            w_.line("const i32 {} = port_of(s, {});", port, scope_.value(s.place));
            w_.open(fmt::format("if ({} >= 0) {{", port));
            w_.line("[[maybe_unused]] const u32 {} = static_cast<u32>(s.neighbour[{}]);", scope_.at(s.place), port);
            scope_.places.insert(s.place);
        }
        port_use(s, port);
    }

    void port_use(const Step& s, const std::string& port) {
        const std::string number = fmt::format("i64{{{}}}", s.port_from_other_side ? fmt::format("s.g->opposite[{}]", port) : port);
        if (s.port.valid()) bind(s.port, number);
        else if (s.port_compare.op != Op::Anonymous) w_.open(fmt::format("if ({} == {}) {{", number, term(scope_, s.port_compare)));
    }

    // ---- facts

    void match(const Step& s) {
        const Predicate& p = plan_.program.predicates[s.predicate];
        if (p.world != WorldSource::None) return match_world(s, p.world);
        if (s.changed) return match_changed(s);
        if (!s.at_home) return match_remote(s);
        if (p.linear()) return match_bag(s);
        match_home(s);
    }

    // Binds and compares the arguments of a match; value(i) is the C++ text of argument i, counted from 1.
    template <class Value>
    void use(const Step& s, const Value& value) {
        std::string conditions;
        std::vector<std::pair<VariableId, std::string>> binds;
        for (std::size_t i = 1; i <= s.arguments.size(); ++i) {
            const Term& t = s.arguments[i - 1];
            if (s.uses[i - 1] == ArgumentUse::Bind) {
                // The same variable twice in one fact: the second is a comparison with the first.
                bind(t.variable, value(i));
            } else if (s.uses[i - 1] == ArgumentUse::Compare) {
                const Type& type = plan_.program.predicates[s.predicate].arguments[i].type;
                conditions += (conditions.empty() ? "" : " && ") + equal(type, value(i), term_as(scope_, t, type));
            }
        }
        if (!conditions.empty()) w_.open(fmt::format("if ({}) {{", conditions));
    }

    std::string row_type(PredicateId id) const { return predicate_name(plan_.program, id) + "_t::Row"; }

    // Whether all arguments of the group are compared, so that the row can be looked up.
    bool whole_key(const Step& s) const {
        const Predicate& p = plan_.program.predicates[s.predicate];
        const std::size_t end = p.aggregate == Aggregate::None ? p.arguments.size() : p.aggregate_at;
        if (end <= 1) return false;
        for (std::size_t i = 1; i < end; ++i)
            if (s.uses[i - 1] != ArgumentUse::Compare || !same_type(s.arguments[i - 1], p.arguments[i].type)) return false;
        return true;
    }
    static bool same_type(const Term& t, const Type& type) { return t.type == type; }

    // Emits the group row that is looked for; returns its name.
    std::string group_row(const Step& s) {
        const Predicate& p = plan_.program.predicates[s.predicate];
        const std::size_t end = p.aggregate == Aggregate::None ? p.arguments.size() : p.aggregate_at;
        const std::string group = fresh("group");
        w_.line("{} {}{{}};", row_type(s.predicate), group);
        for (std::size_t i = 1; i < end; ++i) w_.line("{}.{} = {};", group, field_name(i), term(scope_, s.arguments[i - 1]));
        return group;
    }

    void match_home(const Step& s) {
        const Stored& stored = plan_.of(s.predicate);
        const std::string name = predicate_name(plan_.program, s.predicate);
        const std::string i = fresh("i"), f = fresh("f");
        const bool frozen = std::find(frozen_.begin(), frozen_.end(), s.predicate) != frozen_.end();
        const std::string rows = frozen ? "seen_" + name : fmt::format("s.{}.rows", name), count = frozen ? "seen_" + name + "_count" : fmt::format("s.{}.count", name);
        if (!frozen) w_.line("load_{}(s);", name);
        if (stored.storage == Storage::Rows && whole_key(s)) {
            const std::string group = group_row(s);
            w_.line("const u32 {} = find_row<{}_t>({}, {}, {});", i, name, rows, count, group);
            w_.open(fmt::format("if ({} < {}) {{", i, count));
        } else {
            w_.open(fmt::format("for (u32 {0} = 0; {0} < {1}; ++{0}) {{", i, count));
        }
        // Rows may be replaced while a comprehension acts: the fact is copied.
        w_.line("[[maybe_unused]] const {} {} = {}[{}];", row_type(s.predicate), f, rows, i);
        if (s.ranks) scope_.ranks.push_back(f + ".rank");
        if (stored.storage == Storage::PerLink) return match_link(s, f);
        use(s, [&](std::size_t k) { return fmt::format("{}.{}", f, field_name(k)); });
    }

    // A PerLink fact names its neighbour by port.
    void match_link(const Step& s, const std::string& f) {
        const Term& other = s.arguments[0];
        Step rest = s;
        rest.uses[0] = ArgumentUse::Skip;
        w_.line("if (s.neighbour[{}.a1] < 0) continue;", f);
        if (s.uses[0] == ArgumentUse::Bind) {
            w_.line("[[maybe_unused]] const i32 {} = static_cast<i32>({}.a1);", scope_.port(other.variable), f);
            w_.line("[[maybe_unused]] const u32 {} = static_cast<u32>(s.neighbour[{}.a1]);", scope_.at(other.variable), f);
            scope_.places.insert(other.variable);
        } else if (s.uses[0] == ArgumentUse::Compare) {
            w_.line("if (s.g->catom_id[s.neighbour[{}.a1]] != {}) continue;", f, term(scope_, other));
        }
        use(rest, [&](std::size_t k) { return fmt::format("{}.{}", f, field_name(k)); });
    }

    void match_remote(const Step& s) {
        const Stored& stored = plan_.of(s.predicate);
        const std::string name = predicate_name(plan_.program, s.predicate);
        const std::string at = scope_.at(s.place), f = fresh("f");
        if (stored.storage == Storage::Rows) {
            const std::string head = fresh("head"), rows = fresh("rows"), i = fresh("i");
            w_.line("const RowsHead& {} = rows_of(s, {}, {});", head, stored.column.index(), at);
            w_.line("const auto* {} = reinterpret_cast<const {}*>({}.data);", rows, row_type(s.predicate), head);
            if (whole_key(s)) {
                const std::string group = group_row(s);
                w_.line("const u32 {} = find_row<{}_t>({}, {}.count, {});", i, name, rows, head, group);
                w_.open(fmt::format("if ({} < {}.count) {{", i, head));
            } else {
                w_.open(fmt::format("for (u32 {0} = 0; {0} < {1}.count; ++{0}) {{", i, head));
            }
            w_.line("[[maybe_unused]] const {}& {} = {}[{}];", row_type(s.predicate), f, rows, i);
            if (s.ranks) scope_.ranks.push_back(f + ".rank");
            return use(s, [&](std::size_t k) { return fmt::format("{}.{}", f, field_name(k)); });
        }
        w_.line("const {0}& {1} = record<{0}>(s, {2}, {3});", record_name(stored.column), f, stored.column.index(), at);
        if (stored.ranked) w_.open(fmt::format("if ({}.{}_rank != kAbsent) {{", f, name));
        else w_.open(fmt::format("if (({}.present_{} & {:#x}u) != 0) {{", f, stored.presence_offset, stored.presence_mask));
        if (s.ranks) scope_.ranks.push_back(fmt::format("{}.{}_rank", f, name));
        use(s, [&](std::size_t k) { return fmt::format("{}.{}_{}", f, name, field_name(k)); });
    }

    // Rows that have changed, as they were and as they are: of a predicate derived here in this evaluation, or since the last.
    void match_changed(const Step& s) {
        const Stored& stored = plan_.of(s.predicate);
        const std::string name = predicate_name(plan_.program, s.predicate);
        const std::string changes = fresh("changes"), i = fresh("i"), f = fresh("f");
        const bool derived = s.at_home && stored.base != s.predicate;
        if (derived) w_.line("load_{}(s);", name);
        w_.open(fmt::format("for (const RowChanges* {0} = {1}; {0} != nullptr; {0} = {0}->next) {{", changes,
                            derived ? fmt::format("own_changes(*s.e, s.{})", name) : fmt::format("s.e->part->changes[{}][{}]", stored.column.index(), scope_.at(s.place))));
        w_.open(fmt::format("for (u32 {0} = 0; {0} < {1}->removed + {1}->added; ++{0}) {{", i, changes));
        w_.line("[[maybe_unused]] const {0}& {1} = rows_in<{0}>({2})[{3}];", row_type(s.predicate), f, changes, i);
        use(s, [&](std::size_t k) { return fmt::format("{}.{}", f, field_name(k)); });
    }

    void match_bag(const Step& s) {
        const std::string name = predicate_name(plan_.program, s.predicate);
        const std::string i = fresh("i"), f = fresh("f");
        w_.line("load_{}(s);", name);
        w_.open(fmt::format("for (u32 {0} = 0; {0} < s.{1}.list.count; ++{0}) {{", i, name));
        std::string taken;
        for (const Consumed& c : consumed_)
            if (c.predicate == s.predicate) taken += fmt::format("{}{} == {}", taken.empty() ? "" : " || ", i, c.position);
        if (!taken.empty()) w_.line("if ({}) continue;", taken);
        w_.line("[[maybe_unused]] const {} {} = s.{}.list.rows[{}];", row_type(s.predicate), f, name, i);
        if (!s.read_only) consumed_.push_back({s.predicate, i});
        use(s, [&](std::size_t k) { return fmt::format("{}.{}", f, field_name(k)); });
    }

    void match_world(const Step& s, WorldSource source) {
        const auto value = [&](const std::string& text) {
            use(s, [&](std::size_t) { return text; });
        };
        switch (source) {
            case WorldSource::NeighborCount: {
                const std::string n = fresh("n");
                w_.line("i64 {} = 0;", n);
                w_.line("for (i32 port = 0; port < s.g->ports; ++port) {} += s.neighbour[port] >= 0;", n);
                return value(n);
            }
            case WorldSource::Vacant: {
                const std::string port = fresh("port");
                w_.open(fmt::format("for (i32 {0} = 0; {0} < s.g->ports; ++{0}) {{", port));
                w_.line("if (s.neighbour[{}] >= 0) continue;", port);
                return value(fmt::format("i64{{{}}}", port));
            }
            case WorldSource::TargetPort: {
                const std::string port = fresh("port");
                w_.open(fmt::format("for (i32 {0} = 0; {0} < s.g->ports; ++{0}) {{", port));
                w_.line("if (!in_target(*s.g, site_towards(*s.g, s.site, {}))) continue;", port);
                return value(fmt::format("i64{{{}}}", port));
            }
            case WorldSource::Target: return w_.open("if (in_target(*s.g, s.site)) {");
            case WorldSource::Id: return value("static_cast<i64>(s.g->catom_id[s.catom])");
            case WorldSource::Tick: return value("s.e->part->now");
            case WorldSource::Cell: return use(s, [&](std::size_t k) { return fmt::format("i64{{cell_coordinate(*s.g, s.site, {})}}", k - 1); });
            case WorldSource::Position: {
                const std::string centre = fresh("centre");
                w_.line("double {}[3];", centre);
                w_.line("s.e->host->position(s.e, {});", centre);
                return use(s, [&](std::size_t k) { return fmt::format("{}[{}]", centre, k - 1); });
            }
            case WorldSource::Neighbor:
            case WorldSource::NeighborPort:
            case WorldSource::None: break;
        }
        MELD_CHECK(false, "rule {}: a link was planned as a match", scope_.rule.name);
    }

    // None of the ways to satisfy the inner steps exists.
    void absent(const Step& s) {
        const Scope before = scope_;
        // It sees all facts, those too that the rule is about to consume.
        const std::vector<Consumed> taken = std::exchange(consumed_, {});
        const std::string found = fresh("found");
        w_.open(fmt::format("const auto {} = [&]() -> bool {{", found));
        const std::size_t outside = w_.depth();
        steps(s.inner);
        w_.raw("return true;");
        const bool always = w_.depth() == outside;
        close_to(outside);
        if (!always) w_.raw("return false;");
        w_.close("};");
        const int next = scope_.next;
        scope_.values = before.values;
        scope_.places = before.places;
        scope_.ranks = before.ranks;
        scope_.next = next;
        consumed_ = taken;
        w_.open(fmt::format("if (!{}()) {{", found));
    }

    // ---- what the rule makes

    std::string head_value(PredicateId id, std::size_t argument, const Term& t) {
        const Predicate& p = plan_.program.predicates[id];
        if (p.aggregate == Aggregate::Count && p.aggregate_at == argument) return "1";
        const Type type = p.arguments[argument].type;
        const std::string value = term_as(scope_, t, type);
        if (type != Type::Float || t.op == Op::Float || t.is_variable()) return value;
        return fmt::format("checked_real(*s.e, {}, {})", scope_.rule_index, value);
    }

    // Emits `Row row;` and its fields.
    void make_row(const HeadPlan& h) {
        const Stored& stored = plan_.of(h.predicate);
        w_.line("{} row{{}};", row_type(h.predicate));
        for (std::size_t i = 1; i <= h.arguments.size(); ++i) {
            if (i == 1 && stored.storage == Storage::PerLink) w_.line("row.a1 = {};", scope_.port(h.arguments[0].variable));
            else w_.line("row.{} = {};", field_name(i), head_value(h.predicate, i, h.arguments[i - 1]));
        }
    }

    void propose(const HeadPlan& h) {
        const std::string name = predicate_name(plan_.program, h.predicate);
        make_row(h);
        if (plan_.of(h.predicate).ranked) {
            std::string ranks;
            for (const std::string& r : scope_.ranks) ranks += (ranks.empty() ? "" : ", ") + r;
            w_.line("row.rank = {};", ranks.empty() ? "0" : "rank_above(" + ranks + ")");
        }
        w_.line("s.{}.propose(*s.e, row);", name);
    }

    void consume() {
        std::vector<PredicateId> bags;
        for (const Consumed& c : consumed_)
            if (std::find(bags.begin(), bags.end(), c.predicate) == bags.end()) bags.push_back(c.predicate);
        for (const PredicateId bag : bags) {
            const std::string name = predicate_name(plan_.program, bag);
            std::string positions;
            int n = 0;
            for (const Consumed& c : consumed_)
                if (c.predicate == bag) {
                    positions += (positions.empty() ? "" : ", ") + c.position;
                    ++n;
                }
            if (n == 1) {
                w_.line("s.{}.remove({});", name, positions);
            } else {
                const std::string list = fresh("positions");
                w_.line("u32 {}[] = {{{}}};", list, positions);
                w_.line("s.{}.remove_all({}, {});", name, list, n);
            }
            raise(bag);
        }
        consumed_.clear();
    }

    void raise(PredicateId id) { w_.line("s.raised |= {};", hex(plan_.columns[plan_.of(id).column].own_dirty)); }

    void heads(const std::vector<HeadPlan>& all) {
        for (const HeadPlan& h : all) {
            w_.open("{");
            if (h.kind == Head::Kind::Comprehension) comprehension(h);
            else fact(h);
            w_.close();
        }
    }

    void fact(const HeadPlan& h) {
        const Predicate& p = plan_.program.predicates[h.predicate];
        if (p.kind == PredicateKind::Action) {
            values(h);
            w_.line("s.e->host->act(s.e, {}, values);", h.predicate.index());
        } else if (h.place != scope_.rule.home) {
            send(h);
        } else {
            const std::string name = predicate_name(plan_.program, h.predicate);
            w_.line("load_{}(s);", name);
            make_row(h);
            if (p.linear()) w_.line("s.{}.add(*s.e, row);", name);
            else w_.open(fmt::format("if (give_base(*s.e, s.{}, row)) {{", name));
            raise(h.predicate);
            if (!p.linear()) w_.close();
        }
    }

    void values(const HeadPlan& h) {
        const Predicate& p = plan_.program.predicates[h.predicate];
        w_.line("Value values[{}];", std::max<std::size_t>(1, h.arguments.size()));
        for (std::size_t i = 1; i <= h.arguments.size(); ++i) {
            w_.line("values[{}].{} = {};", i - 1, value_member(p.arguments[i].type), head_value(h.predicate, i, h.arguments[i - 1]));
        }
    }

    void send(const HeadPlan& h) {
        values(h);
        w_.raw("++s.e->derivations;");
        if (scope_.places.contains(h.place)) {
            w_.line("s.e->host->send(s.e, {}, {}, values);", scope_.at(h.place), h.predicate.index());
            return;
        }
        const std::string port = fresh("port");
        w_.line("const i32 {} = port_of(s, {});", port, scope_.value(h.place));
        w_.line("if ({0} >= 0) s.e->host->send(s.e, static_cast<u32>(s.neighbour[{0}]), {1}, values);", port, h.predicate.index());
        w_.raw("else ++s.e->dropped;");
    }

    bool consumes(const HeadPlan& h) const {
        return std::any_of(h.steps.begin(), h.steps.end(), [&](const Step& s) { return s.kind == Step::Kind::Match && plan_.program.predicates[s.predicate].linear() && !s.read_only; });
    }

    void comprehension(const HeadPlan& h) {
        const Scope before = scope_;
        const std::vector<Consumed> outer = std::move(consumed_);
        consumed_.clear();
        if (!consumes(h)) {
            const std::size_t outside = w_.depth();
            steps(h.steps);
            heads(h.heads);
            close_to(outside);
        } else {
            // Facts are consumed match by match; those made meanwhile are held.
            const std::string one = fresh("one");
            w_.open(fmt::format("const auto {} = [&]() -> bool {{", one));
            const std::size_t outside = w_.depth();
            steps(h.steps);
            consume();
            heads(h.heads);
            w_.raw("return true;");
            close_to(outside);
            w_.raw("return false;");
            w_.close("};");
            w_.line("while (s.e->trap == Trap::None && {}()) {{", one);
            w_.raw("}");
        }
        const int next = scope_.next;
        scope_.values = before.values;
        scope_.places = before.places;
        scope_.next = next;
        consumed_ = outer;
    }

    const plan::Plan& plan_;
    const RulePlan& rule_plan_;
    Writer& w_;
    Scope scope_;
    std::vector<Consumed> consumed_;
    std::vector<PredicateId> held_, frozen_;  // See freeze().
};

}  // namespace

void emit_view_rule(const plan::Plan& plan, const RulePlan& rule, Writer& w) { RuleEmitter(plan, rule, w).view(); }
void emit_deltas(const plan::Plan& plan, const plan::ComponentPlan& c, Writer& w) {
    for (std::size_t i = 0; i < c.deltas.touches.size(); ++i) RuleEmitter(plan, c.deltas.touches[i], w).touch(i);
    for (const RulePlan& r : c.deltas.groups) RuleEmitter(plan, r, w).group();
}
void emit_linear_rule(const plan::Plan& plan, const RulePlan& rule, Writer& w) { RuleEmitter(plan, rule, w).linear(); }

}  // namespace meld::emit
