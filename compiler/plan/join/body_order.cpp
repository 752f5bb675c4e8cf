// The order of one body: tests as soon as possible, then the cheapest access.
#include "compiler/plan/join/body_order.h"

#include <algorithm>

namespace meld::plan {

using namespace check;

namespace {

Step test(Term condition) { return {Test{.condition = std::move(condition)}}; }

Term part_of(const Term& value, Op op, const Type& type, std::size_t number = 0) {
    return {.op = op, .type = type, .span = value.span, .integer = static_cast<std::int64_t>(number), .operands = {value}};
}

}  // namespace

Known BodyOrder::start() const {
    Known known;
    if (rule_.site.valid()) known.places.insert(rule_.site);
    return known;
}

std::vector<Step> BodyOrder::order(std::vector<Clause> body, Known& known, Reading reading, const Variables& outside) const {
    std::vector<Step> steps;
    OpenBody open(std::move(body), accesses_, reading, known, outside);
    while (!open.empty()) {
        if (take_ready(open, known, steps)) continue;
        const std::optional<std::size_t> next = open.next_read();
        MELD_CHECK(next.has_value(), "rule {}: no clause of the {} left can be read next", rule_.name, open.left());
        read(open.clause(*next), open.choice(*next, known), reading, known, steps);
        open.close(*next, known);
    }
    return steps;
}

std::vector<Step> BodyOrder::start_changed(std::vector<Clause>& body, std::size_t first, const Variables& outside, Known& known) const {
    MELD_EXPECT(first < body.size() && body[first].kind == Clause::Kind::Atom, "rule {}: clause {} is no atom", rule_.name, first);
    std::vector<Step> steps;
    const Atom changed = body[first].atom;
    body.erase(body.begin() + static_cast<std::ptrdiff_t>(first));
    atom(changed, known, steps);
    Match* match = as<Match>(steps.back());
    MELD_CHECK(match != nullptr, "rule {}: {} has no rows to follow", rule_.name, program_.predicates[changed.predicate].name);
    match->changed = true;
    OpenBody open(std::move(body), accesses_, Reading::Cheapest, known, outside);
    while (take_ready(open, known, steps)) {
    }
    body = std::move(open).rest();
    return steps;
}

// ---- clauses without a read

// One clause that is ready: a test, negation or aggregate all of whose variables are known, or an equality that gives a new one
// its value.
bool BodyOrder::take_ready(OpenBody& body, Known& known, std::vector<Step>& steps) const {
    while (const std::optional<std::size_t> next = body.next_without_read()) {
        const Clause& c = body.clause(*next);
        if (c.kind == Clause::Kind::Test ? !take_test(c.test, known, steps) : !take_nested(c, body, known, steps)) continue;
        body.close(*next, known);
        return true;
    }
    return false;
}

bool BodyOrder::take_test(const Term& condition, Known& known, std::vector<Step>& steps) const {
    if (!known.has(condition)) return bind_equal(condition, known, steps) || take_apart(condition, known, steps);
    steps.push_back(test(condition));
    return true;
}

bool BodyOrder::take_nested(const Clause& c, const OpenBody& body, Known& known, std::vector<Step>& steps) const {
    const Variables shared = body.shared_by(c);
    const bool aggregates = c.kind == Clause::Kind::Aggregate;
    if (!std::ranges::all_of(shared, [&](VariableId v) { return known.has(v) || (aggregates && v == c.variable); })) return false;
    Known inside = known;
    std::vector<Step> inner = order(c.inner, inside, Reading::Cheapest, shared);
    if (!aggregates) {
        steps.push_back({Unless{.steps = std::move(inner)}});
        return true;
    }
    steps.push_back({AggregateOver{.variable = c.variable,
                                   .aggregate = c.aggregate,
                                   .function = c.fold,
                                   .parameter = c.parameter,
                                   .value = c.test,
                                   .steps = std::move(inner)}});
    if (!known.has(c.variable)) known.values.insert(c.variable);
    return true;
}

// X = the value of known variables: X gets it.
bool BodyOrder::bind_equal(const Term& equality, Known& known, std::vector<Step>& steps) const {
    if (equality.op != Op::Equal) return false;
    for (std::size_t side = 0; side < 2; ++side) {
        const Term& target = equality.operands[side];
        const Term& value = equality.operands[1 - side];
        if (!target.is_variable() || known.has(target.variable) || !known.has(value)) continue;
        known.values.insert(target.variable);
        steps.push_back({Set{.variable = target.variable, .value = value}});
        return true;
    }
    return false;
}

// L = [X | Rest] with L known: tests whether L is such a list, then binds X and Rest from it, or compares them if known.
bool BodyOrder::take_apart(const Term& equality, Known& known, std::vector<Step>& steps) const {
    const TakeApart found = taken_apart(equality);
    if (!found || !known.has(*found.value)) return false;
    const Term &value = *found.value, &made = *found.constructor;
    const Type element = value.type.parts.empty() ? Type::Float : value.type.parts[0];
    if (made.op == Op::Cons) {
        Term empty = part_of(value, Op::IsEmpty, Type::Bool);
        steps.push_back(test({.op = Op::Not, .type = Type::Bool, .span = value.span, .operands = {std::move(empty)}}));
    } else if (made.op == Op::List) {
        Term length{.op = Op::Library, .type = Type::Int, .span = value.span, .text = "llength", .operands = {value}};
        Term count{.op = Op::Int, .type = Type::Int, .span = value.span, .integer = static_cast<std::int64_t>(made.operands.size())};
        steps.push_back(test({.op = Op::Equal, .type = Type::Bool, .span = value.span, .operands = {std::move(length), std::move(count)}}));
    }
    for (std::size_t i = 0; i < made.operands.size(); ++i) {
        const Term& part = made.operands[i];
        Term is = made.op == Op::Cons ? part_of(value, i == 0 ? Op::ListHead : Op::ListTail, i == 0 ? element : value.type)
                  : made.op == Op::List || value.type == Type::Vec3 ? part_of(value, Op::Item, element, i)
                                                                    : part_of(value, Op::Item, value.type.parts[i], i);
        if (!part.is_variable() || known.has(part.variable)) {
            steps.push_back(test({.op = Op::Equal, .type = Type::Bool, .span = part.span, .operands = {std::move(is), part}}));
            continue;
        }
        known.values.insert(part.variable);
        steps.push_back({Set{.variable = part.variable, .value = std::move(is)}});
    }
    return true;
}

// ---- the steps of a read

// The steps of one clause: the link to its catom, if that is new, the fact there, and the comparison of its change.
void BodyOrder::read(const Clause& clause, const Choice& why, Reading reading, Known& known, std::vector<Step>& steps) const {
    const std::size_t before = steps.size();
    const std::optional<Access> access = accesses_.access(clause, known);
    if (clause.kind == Clause::Kind::Element)
        elements(clause, known, steps);
    else
        atom(clause.atom, known, steps);
    bool first = true;
    for (std::size_t i = before; i < steps.size(); ++i) {
        Choice* choice = choice_of(steps[i]);
        if (choice == nullptr) continue;
        *choice = first ? why : Choice{.reason = why.reason, .known = why.known};
        const bool is_link = as<EachNeighbour>(steps[i]) != nullptr || as<FindNeighbour>(steps[i]) != nullptr;
        if (is_link && reading == Reading::Cheapest) choice->reason = access->link;
        first = false;
    }
    if (clause.kind != Clause::Kind::Delta) return;
    const Atom& a = clause.atom;
    steps.push_back({ChangeSince{.predicate = a.predicate,
                                 .arguments = {a.arguments.begin() + 1, a.arguments.end()},
                                 .variable = clause.variable,
                                 .compare = clause.compare,
                                 .bound = clause.test}});
}

void BodyOrder::reach(VariableId place, Known& known, std::vector<Step>& steps) const {
    if (known.places.contains(place)) return;
    if (known.values.contains(place))
        steps.push_back({FindNeighbour{.place = place}});
    else
        steps.push_back({EachNeighbour{.place = place}});
    known.places.insert(place);
}

void BodyOrder::atom(const Atom& a, Known& known, std::vector<Step>& steps) const {
    if (accesses_.is_link(a)) return link(a, known, steps);
    const VariableId place = a.arguments[0].variable;
    reach(place, known, steps);
    Match match{.predicate = a.predicate, .place = place, .at_site = place == rule_.site, .read_only = a.read_only};
    match.ranks = std::find(ranked_.begin(), ranked_.end(), a.predicate) != ranked_.end();
    for (std::size_t i = 1; i < a.arguments.size(); ++i) {
        const Term& t = a.arguments[i];
        match.arguments.push_back(t);
        if (t.op == Op::Anonymous) {
            match.uses.push_back(ArgumentUse::Skip);
        } else if (t.is_variable() && !known.has(t.variable)) {
            match.uses.push_back(ArgumentUse::Bind);
            known.values.insert(t.variable);
            if (i == 1 && plan_.of(a.predicate).storage == Storage::PerLink) known.places.insert(t.variable);
        } else {
            match.uses.push_back(ArgumentUse::Compare);
        }
    }
    steps.push_back({std::move(match)});
}

void BodyOrder::elements(const Clause& c, Known& known, std::vector<Step>& steps) const {
    if (!known.has(c.variable)) known.values.insert(c.variable);
    if (c.position.valid()) known.values.insert(c.position);
    steps.push_back({EachElement{.variable = c.variable, .position = c.position, .list = c.test}});
}

// neighbor(A, B, P) seen from the execution site, whichever of the two it is.
void BodyOrder::link(const Atom& a, Known& known, std::vector<Step>& steps) const {
    const bool forward = a.arguments[0].variable == rule_.site;
    const Term& other = a.arguments[forward ? 1 : 0];
    if (other.is_variable() && other.variable == rule_.site) {
        // No catom is its own neighbour.
        steps.push_back(test({.op = Op::Bool, .type = Type::Bool}));
        return;
    }
    if (!other.is_variable()) {
        // A fixed catom or `_`.
        steps.push_back({EachNeighbour{.only = other, .port = port_of(a, forward, known)}});
        return;
    }
    const bool found = known.places.contains(other.variable);
    const bool asks_port = a.arguments.size() > 2 && a.arguments[2].op != Op::Anonymous;
    if (found && !asks_port) return;  // It is a neighbour: nothing to check.
    const bool named = found || known.values.contains(other.variable);
    known.places.insert(other.variable);
    PortUse port = port_of(a, forward, known);
    if (named)
        steps.push_back({FindNeighbour{.place = other.variable, .port = std::move(port)}});
    else
        steps.push_back({EachNeighbour{.place = other.variable, .port = std::move(port)}});
}

PortUse BodyOrder::port_of(const Atom& link, bool forward, Known& known) const {
    PortUse out{.from_other_side = !forward};
    if (link.arguments.size() <= 2) return out;
    const Term& port = link.arguments[2];
    if (port.is_variable() && !known.has(port.variable)) {
        out.bind = port.variable;
        known.values.insert(port.variable);
    } else {
        out.equals = port;
    }
    return out;
}

}  // namespace meld::plan
