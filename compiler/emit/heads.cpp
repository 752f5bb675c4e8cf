// Emits what a rule produces from its matches: aggregates, facts, messages, actions.
#include <algorithm>
#include <utility>

#include "compiler/emit/rule_emitter.h"

namespace meld::emit {

RuleEmitter::Accumulator RuleEmitter::start_accumulator(Aggregate aggregate, const Type& type, FunctionId function, const Term& parameter) {
    const bool custom = aggregate == Aggregate::Custom;
    MELD_EXPECT(aggregate != Aggregate::None && custom == function.valid(), "rule {}", scope_.rule.name);
    MELD_EXPECT(info(aggregate).result != AggregateInfo::Result::ListOf || type.parts.size() == 1, "rule {}: a list without elements",
                scope_.rule.name);
    Accumulator f{aggregate, fresh("made"), "", type, function, custom && parameter.op != Op::Anonymous};
    if (!custom) {
        const std::string limit = parameter.op == Op::Anonymous ? "" : term(scope_, parameter);
        w_.line("{};", aggregate_object(aggregate, accumulated_type(f), type, limit, f.made));
        f.seen = f.made + ".count";
        return f;
    }
    f.seen = fresh("seen");
    w_.line("{} {}{};", cpp_type(type), f.made, f.initial ? " = " + element(scope_, parameter, type) : "{}");
    w_.line("[[maybe_unused]] u64 {} = 0;", f.seen);
    return f;
}

Type RuleEmitter::accumulated_type(const Accumulator& f) const {
    if (f.aggregate == Aggregate::Custom) return plan_.program.functions[f.function].variables[VariableId(1)].type;
    return info(f.aggregate).result == AggregateInfo::Result::ListOf ? f.type.parts[0] : f.type;
}

void RuleEmitter::accumulate(const Accumulator& f, const std::string& value) {
    if (f.aggregate != Aggregate::Custom) {
        w_.line("{}.add(*s.e, {}, {});", f.made, scope_.site(), value.empty() ? "1" : value);
        return;
    }
    const std::string next = call_with(scope_, f.function, {f.made, value});
    w_.line("{} = {};", f.made, f.initial ? next : fmt::format("{} == 0 ? {} : {}", f.seen, value, next));
    w_.line("++{};", f.seen);
}

std::string RuleEmitter::accumulated(const Accumulator& f) const {
    return f.aggregate == Aggregate::Custom ? f.made : fmt::format("{}.result(*s.e, {})", f.made, scope_.site());
}

void RuleEmitter::step(const plan::AggregateOver& s) {
    const Scope before = scope_;
    const Accumulator f = start_accumulator(s.aggregate, scope_.rule.variables[s.variable].type, s.function, s.parameter);
    w_.open("{");
    const std::size_t outside = w_.depth();
    const bool leaves_out = std::exchange(leaves_out_, false);
    const Match* const searching = std::exchange(searching_, nullptr);
    const bool asking = std::exchange(asking_, true), whether = std::exchange(whether_, false);
    steps(s.steps);
    asking_ = asking;
    whether_ = whether;
    searching_ = searching;
    leaves_out_ = leaves_out;
    accumulate(f, s.value.op == Op::Anonymous ? "" : element(scope_, s.value, accumulated_type(f)));
    close_to(outside);
    w_.close();
    restore(before);
    std::string condition = f.needs_match() ? f.seen + " > 0" : "";
    const bool known = scope_.values.contains(s.variable) || scope_.places.contains(s.variable) || s.variable == scope_.rule.site;
    if (known)
        condition += (condition.empty() ? "" : " && ") + equal(f.type, accumulated(f), scope_.value(s.variable));
    else
        bind(s.variable, accumulated(f));
    if (!condition.empty())
        w_.open(fmt::format("if ({}) {{", defined(condition, true)));
    else
        only_if_defined(true);
}

std::string RuleEmitter::head_value(PredicateId id, std::size_t argument, const Term& t) {
    const Predicate& p = plan_.program.predicates[id];
    if (p.aggregate == Aggregate::Count && p.aggregate_at == argument) return "1";
    const Type type = p.arguments[argument].type;
    const std::string value = term_as(scope_, t, type);
    if (type != Type::Float || t.op == Op::Float || t.is_variable()) return value;
    if (single_ && sweeping_ && id == rule_plan_.sweep.state && std::ranges::find(sums_, argument) != sums_.end())
        return fmt::format("checked_sum(*s.e, {}, {})", scope_.site(), value);
    return fmt::format("checked_real(*s.e, {}, {})", scope_.site(), value);
}

void RuleEmitter::make_row(const MakeFact& h) {
    const Stored& stored = plan_.of(h.predicate);
    MELD_EXPECT(h.arguments.size() == stored.fields.size(), "rule {}: {} arguments for {} fields", scope_.rule.name, h.arguments.size(),
                stored.fields.size());
    w_.line("{} row{{}};", row_type(h.predicate));
    for (std::size_t i = 1; i <= h.arguments.size(); ++i) {
        if (i == 1 && stored.storage == Storage::PerLink)
            w_.line("row.a1 = {};", scope_.port(h.arguments[0].variable));
        else
            w_.line("row.{} = {};", field_name(i), head_value(h.predicate, i, h.arguments[i - 1]));
    }
}

void RuleEmitter::propose(const MakeFact& h) {
    MELD_EXPECT(h.place == scope_.rule.site, "view {} derives a fact elsewhere", scope_.rule.name);
    const std::string name = predicate_name(plan_.program, h.predicate);
    make_row(h);
    if (plan_.of(h.predicate).ranked) {
        std::string ranks;
        for (const std::string& r : scope_.ranks) ranks += (ranks.empty() ? "" : ", ") + r;
        w_.line("row.rank = {};", ranks.empty() ? "0" : "rank_above(" + ranks + ")");
    }
    if (plan_.of(h.predicate).waits) heard_from(h);
    only_if_defined(plan::may_fail(plan_.program, h.arguments));
    w_.line("s.{}{}.propose(*s.e, row);", name, grows(h.predicate) ? "_rounds" : "");
}

void RuleEmitter::heard_from(const MakeFact& h) {
    for (const VariableId v : h.contributors) {
        if (scope_.places.contains(v))
            w_.line("row.from |= u32{{1}} << {};", scope_.port(v));
        else if (scope_.values.contains(v))
            w_.line("row.from |= port_bit(s, {});", scope_.value(v));
    }
}

void RuleEmitter::consume() {
    std::vector<PredicateId> bags;
    for (const Matched& c : consumed_)
        if (std::find(bags.begin(), bags.end(), c.predicate) == bags.end()) bags.push_back(c.predicate);
    for (const PredicateId bag : bags) {
        const std::string name = predicate_name(plan_.program, bag);
        std::string positions;
        int n = 0;
        for (const Matched& c : consumed_)
            if (c.predicate == bag) {
                positions += (positions.empty() ? "" : ", ") + c.position;
                ++n;
            }
        if (n == 1) {
            w_.line("s.{}.remove(*s.e, {});", name, positions);
        } else {
            const std::string list = fresh("positions");
            w_.line("u32 {}[] = {{{}}};", list, positions);
            w_.line("s.{}.remove_all(*s.e, {}, {});", name, list, n);
        }
        if (plan_.counts) w_.line("count_consumed(*s.e, {}, {});", bag.index(), n);
        lower(bag);
    }
    consumed_.clear();
}

void RuleEmitter::heads(const std::vector<HeadPlan>& all) {
    for (const HeadPlan& h : all) head_block(h);
}

void RuleEmitter::head_block(const HeadPlan& h) {
    w_.open("{");
    plan::visit_head(h, [this](const auto& one) { head(one); });
    w_.close();
}

void RuleEmitter::head(const plan::ForAll& h) { comprehension(h, {}, {}); }

void RuleEmitter::head(const plan::AggregateAll& h) {
    MELD_EXPECT(!h.aggregates.empty(), "rule {}: a head aggregates nothing", scope_.rule.name);
    std::vector<Accumulator> made;
    std::string condition;
    for (const HeadAggregate& a : h.aggregates) {
        made.push_back(start_accumulator(a.aggregate, scope_.rule.variables[a.result].type, a.function, a.parameter));
        if (made.back().needs_match()) condition = made.back().seen + " > 0";
    }
    comprehension(h.each, h.aggregates, made);
    const Scope before = scope_;
    w_.open(condition.empty() ? "{" : fmt::format("if ({}) {{", condition));
    for (std::size_t i = 0; i < made.size(); ++i) bind(h.aggregates[i].result, accumulated(made[i]));
    heads(h.results);
    w_.close();
    restore(before);
}

void RuleEmitter::head(const plan::Choose& h) {
    w_.open(fmt::format("if ({}) {{", term(scope_, h.condition)));
    heads(h.heads);
    w_.close();
    w_.open("else {");
    heads(h.others);
    w_.close();
}

void RuleEmitter::head(const plan::With& h) {
    const Scope before = scope_;
    bind(h.variable, term_as(scope_, h.value, scope_.rule.variables[h.variable].type));
    heads(h.heads);
    restore(before);
}

void RuleEmitter::accumulate_match(const std::vector<HeadAggregate>& aggregates, const std::vector<Accumulator>& made) {
    for (std::size_t i = 0; i < made.size(); ++i) {
        const VariableId each = aggregates[i].each;
        if (!each.valid()) {
            accumulate(made[i], "");
            continue;
        }
        Term value;
        value.op = Op::Variable;
        value.type = scope_.rule.variables[each].type;
        value.variable = each;
        accumulate(made[i], term_as(scope_, value, accumulated_type(made[i])));
    }
}

void RuleEmitter::head(const MakeFact& h) {
    const Predicate& p = plan_.program.predicates[h.predicate];
    if (p.kind == PredicateKind::Action) {
        values(h);
        w_.line("s.e->host->act(s.e, {}, values);", h.predicate.index());
        if (plan_.counts) w_.line("count_gained(*s.e, {});", h.predicate.index());
    } else if (h.place != scope_.rule.site) {
        send(h);
    } else if (sweeping_ && h.predicate == rule_plan_.sweep.state) {
        next_state(h);
    } else if (single_) {
        make_row(h);
        w_.line("one.{}.put(*s.e, row);", predicate_name(plan_.program, h.predicate));
    } else {
        const std::string name = predicate_name(plan_.program, h.predicate);
        w_.line("load_{}(s);", name);
        make_row(h);
        if (p.finds_its_way) w_.raw("++s.e->far_facts;");
        if (p.linear())
            w_.line("s.{}.add(*s.e, row);{}", name, plan_.counts ? fmt::format(" count_gained(*s.e, {});", h.predicate.index()) : "");
        else
            w_.open(fmt::format("if (give_base(*s.e, s.{}, row)) {{", name));
        raise(h.predicate);
        if (!p.linear()) w_.close();
    }
}

void RuleEmitter::values(const MakeFact& h) {
    const Predicate& p = plan_.program.predicates[h.predicate];
    w_.line("Value values[{}];", std::max<std::size_t>(1, h.arguments.size()));
    for (std::size_t i = 1; i <= h.arguments.size(); ++i) {
        w_.line("values[{}].{} = {};", i - 1, value_member(p.arguments[i].type), head_value(h.predicate, i, h.arguments[i - 1]));
    }
}

void RuleEmitter::send(const MakeFact& h) {
    MELD_EXPECT(h.place != scope_.rule.site && scope_.rule.linear, "rule {} sends to itself, or is a view", scope_.rule.name);
    if (sent_as_row(h))
        make_row(h);
    else
        values(h);
    w_.raw("++s.e->derivations;");
    if (scope_.places.contains(h.place)) {
        w_.line("{};", send_to(h, scope_.at(h.place)));
        count_sent(h, scope_.port(h.place));
        return;
    }
    if (plan_.program.predicates[h.predicate].begins)
        return w_.line("s.e->host->bear(s.e, {}, {}, values);", scope_.value(h.place), h.predicate.index());
    const bool far = plan_.program.predicates[h.predicate].finds_its_way;
    const std::string port = fresh("port");
    w_.line("const i32 {} = port_of(s, {});", port, scope_.value(h.place));
    w_.open(fmt::format("if ({} >= 0) {{", port));
    w_.line("{};", send_to(h, fmt::format("static_cast<u32>(s.neighbour[{}])", port)));
    if (far) w_.raw("++s.e->far_hops;");
    count_sent(h, port);
    w_.close();
    if (!far) return w_.raw("else ++s.e->dropped;");
    w_.open(fmt::format("else if (s.e->host->send_far(s.e, {}, {}, values)) {{", scope_.value(h.place), h.predicate.index()));
    count_sent(h, "-1");
    w_.close();
}

// Linear facts go as rows, but for those that may need Host::send_far or begin at a new node.
bool RuleEmitter::sent_as_row(const MakeFact& h) const {
    const Predicate& p = plan_.program.predicates[h.predicate];
    return p.linear() && !p.finds_its_way && !p.begins;
}

// The call that sends the fact in `row` or `values` to a catom.
std::string RuleEmitter::send_to(const MakeFact& h, const std::string& to) const {
    const std::size_t predicate = h.predicate.index();
    if (!sent_as_row(h)) return fmt::format("s.e->host->send(s.e, {}, {}, values)", to, predicate);
    if (has_lists(plan_.of(h.predicate))) return fmt::format("s.e->host->send_row(s.e, {}, {}, &row)", to, predicate);
    const auto letter = letters_.find(&h);
    return fmt::format("send_row(*s.e, {}, {}, {}, row{})", to, predicate, plan_.of(h.predicate).column.index(),
                       letter == letters_.end() ? "" : ", " + letter->second);
}

void RuleEmitter::count_sent(const MakeFact& h, const std::string& port) {
    if (!plan_.counts) return;
    const bool as_row = sent_as_row(h);
    const auto word = [&](std::size_t argument) {
        return as_row ? as_word("row." + field_name(argument)) : fmt::format("reinterpret_cast<u64>(values[{}].list)", argument - 1);
    };
    w_.line("count_sent(*s.e, {}, {}, {}, {});", scope_.site(), h.predicate.index(), port, message_bits(plan_, h.predicate, word));
}

bool RuleEmitter::consumes(const plan::ForAll& h) const {
    return std::any_of(h.steps.begin(), h.steps.end(), [&](const Step& s) {
        const Match* m = as<Match>(s);
        return m != nullptr && plan_.program.predicates[m->predicate].linear() && !m->read_only;
    });
}

void RuleEmitter::copy_bags(const plan::ForAll& h) {
    plan::each_head_plan(h.heads, [&](const HeadPlan& head) {
        const std::vector<Step>* const taking = plan::steps_of(head);
        if (taking == nullptr) return;
        for (const Step& taken : *taking) {
            const Match* t = as<Match>(taken);
            const bool read = t != nullptr && consumes(*t) && plan_.program.predicates[t->predicate].linear() &&
                              std::ranges::any_of(h.steps, [&](const Step& s) {
                                  const Match* m = as<Match>(s);
                                  return m != nullptr && m->predicate == t->predicate;
                              });
            if (!read || copied_.contains(t->predicate)) continue;
            const std::string name = predicate_name(plan_.program, t->predicate), row = row_type(t->predicate);
            const Rows copy{fresh("rows"), fresh("count")};
            w_.line("load_{}(s);", name);
            w_.line("s.{}.arrange(*s.e);", name);
            w_.line("const u32 {} = s.{}.list.count;", copy.count, name);
            w_.line("{0}* const {1} = static_cast<{0}*>(scratch(*s.e, u64{{{2}}} * sizeof({0})));", row, copy.rows, copy.count);
            w_.line("for (u32 k = 0; k < {}; ++k) {}[k] = s.{}.list.rows[k];", copy.count, copy.rows, name);
            copied_[t->predicate] = copy;
        }
    });
}

// For the facts of this comprehension; one inside it has its own.
void RuleEmitter::open_letters(const std::vector<HeadPlan>& heads) {
    for (const HeadPlan& h : heads)
        plan::visit_head(
            h,
            [&](const MakeFact& fact) {
                if (fact.alike) w_.line("Letter {};", letters_[&fact] = fresh("letter"));
            },
            [](const plan::ForAll&) {}, [&](const plan::AggregateAll& all) { open_letters(all.results); },
            [&](const plan::Choose& choose) {
                open_letters(choose.heads);
                open_letters(choose.others);
            },
            [&](const plan::With& with) { open_letters(with.heads); });
}

void RuleEmitter::comprehension(const plan::ForAll& h, const std::vector<HeadAggregate>& aggregates, const std::vector<Accumulator>& made) {
    const Scope before = scope_;
    // Its body may match what the rule's body has kept, and even consume it.
    const std::vector<Matched> consumed = std::exchange(consumed_, {}), kept = std::exchange(kept_, {});
    keep_invariants(h.heads);
    if (const MakeFact* fact = aggregates.empty() && !plan_.counts ? plan::to_all_neighbours(h) : nullptr) {
        // What may fail is not computed for nobody.
        const bool may_fail = plan::may_fail(plan_.program, fact->arguments);
        if (may_fail) w_.open("if (any_neighbour(s.neighbour, ports_of(s))) {");
        make_row(*fact);
        const std::string send =
            plan_.pulls(fact->predicate) ? "tell_neighbours" : fmt::format("send_to_neighbours<{}>", !plan_.program.by_links);
        w_.line("{}(*s.e, s.neighbour, ports_of(s), {}, {}, row);", send, fact->predicate.index(),
                plan_.of(fact->predicate).column.index());
        if (may_fail) w_.close();
        restore(before);
        consumed_ = consumed;
        kept_ = kept;
        return;
    }
    open_letters(h.heads);
    if (!consumes(h)) {
        const std::size_t outside = w_.depth();
        copy_bags(h);
        steps(h.steps);
        copied_.clear();
        accumulate_match(aggregates, made);
        heads(h.heads);
        close_to(outside);
    } else {
        // Facts are consumed match by match; those produced in the meantime are held.
        const std::string one = fresh("one");
        w_.open(fmt::format("const auto {} = [&]() -> bool {{", one));
        const std::size_t outside = w_.depth();
        steps(h.steps);
        accumulate_match(aggregates, made);
        consume();
        heads(h.heads);
        w_.raw("return true;");
        close_to(outside);
        w_.raw("return false;");
        w_.close("};");
        w_.line("while (s.e->trap == Trap::None && {}()) {{", one);
        w_.raw("}");
    }
    restore(before);
    consumed_ = consumed;
    kept_ = kept;
}

}  // namespace meld::emit
