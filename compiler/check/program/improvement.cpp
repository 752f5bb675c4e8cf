#include "compiler/check/program/improvement.h"

#include <algorithm>

namespace meld::check {

namespace {

// Functions that call functions: deeper ones are not looked into.
constexpr int kMaxCalls = 8;

Course opposite(Course c) { return c == Course::Same ? Course::Opposite : c == Course::Opposite ? Course::Same : c; }
// For an expression that follows both.
Course both(Course a, Course b) {
    if (a == Course::Constant) return b;
    if (b == Course::Constant || a == b) return a;
    return Course::Unknown;
}

std::optional<double> literal(const Term& t) {
    if (t.op == Op::Int) return static_cast<double>(t.integer);
    if (t.op == Op::Float) return t.real;
    if (t.op == Op::Negate)
        if (const auto of = literal(t.operands[0])) return -*of;
    return std::nullopt;
}

}  // namespace

Improvement::Improvement(const Program& program, const Rule& rule, const Atom& atom, VariableId value, Aggregate best)
    : program_(program), rule_(rule), atom_(atom), value_(value), least_(keeps_least(best)) {
    courses_[value] = Course::Same;
    find_definitions();
}

// Y = X + 1, if no fact gives Y.
void Improvement::find_definitions() {
    for (bool found = true; found;) {
        found = false;
        for (const Clause& c : rule_.body) {
            if (c.kind != Clause::Kind::Test || c.test.op != Op::Equal ||
                std::find(definitions_.begin(), definitions_.end(), &c) != definitions_.end())
                continue;
            for (const std::size_t side : {0u, 1u}) {
                const Term &target = c.test.operands[side], &is = c.test.operands[1 - side];
                if (!target.is_variable() || courses_.contains(target.variable) || bound_by_fact(target.variable) || !mentions(is))
                    continue;
                courses_[target.variable] = course(is);
                defined_[target.variable] = &is;
                definitions_.push_back(&c);
                found = true;
                break;
            }
        }
    }
}

bool Improvement::bound_by_fact(VariableId v) const {
    return v == rule_.site || std::any_of(rule_.body.begin(), rule_.body.end(), [&](const Clause& c) {
               if (c.kind == Clause::Kind::Test || c.kind == Clause::Kind::Not) return false;
               if (c.kind != Clause::Kind::Atom) return c.variable == v;
               return std::any_of(c.atom.arguments.begin(), c.atom.arguments.end(),
                                  [&](const Term& t) { return t.is_variable() && t.variable == v; });
           });
}

bool Improvement::mentions(const Term& t) const {
    bool found = false;
    each_variable(t, [&](VariableId v) { found = found || courses_.contains(v); });
    return found;
}

Course Improvement::course(const Term& t, const Courses& known) const {
    const auto of = [&](std::size_t i) { return course(t.operands[i], known); };
    switch (t.op) {
        case Op::Variable: {
            const auto found = known.find(t.variable);
            return found == known.end() ? Course::Constant : found->second;
        }
        case Op::Negate:
            return opposite(of(0));
        case Op::ToFloat:
        case Op::Truncate:
        case Op::Sqrt:
            return of(0);
        case Op::Add:
        case Op::Min:
        case Op::Max:
            return both(of(0), of(1));
        case Op::Subtract:
            return both(of(0), opposite(of(1)));
        case Op::Multiply:
        case Op::Divide:
            return multiplied(t, known);
        case Op::If:
            return of(0) == Course::Constant ? both(of(1), of(2)) : Course::Unknown;
        case Op::Call:
            return call(t, known);
        default:
            break;
    }
    const bool constant =
        std::all_of(t.operands.begin(), t.operands.end(), [&](const Term& o) { return course(o, known) == Course::Constant; });
    return constant ? Course::Constant : Course::Unknown;
}

// By a number whose sign is known.
Course Improvement::multiplied(const Term& t, const Courses& known) const {
    const Course left = course(t.operands[0], known), right = course(t.operands[1], known);
    if (left == Course::Constant && right == Course::Constant) return Course::Constant;
    const bool by_right = right == Course::Constant;
    if (!by_right && (left != Course::Constant || t.op == Op::Divide)) return Course::Unknown;
    const auto by = literal(t.operands[by_right ? 1 : 0]);
    if (!by) return Course::Unknown;
    return *by >= 0 ? (by_right ? left : right) : opposite(by_right ? left : right);
}

// A function follows its arguments as its body follows its parameters.
Course Improvement::call(const Term& t, const Courses& known) const {
    Courses parameters;
    bool constant = true;
    for (std::size_t i = 0; i < t.operands.size(); ++i) {
        const Course c = course(t.operands[i], known);
        constant = constant && c == Course::Constant;
        parameters[VariableId(i)] = c;
    }
    if (constant) return Course::Constant;
    thread_local int depth = 0;
    if (depth >= kMaxCalls || !t.function.valid()) return Course::Unknown;
    ++depth;
    const Course result = course(program_.functions[t.function].body, parameters);
    --depth;
    return result;
}

bool Improvement::keeps(const Term& test) const {
    if (course(test) == Course::Constant) return true;
    if (test.op == Op::And || test.op == Op::Or) return keeps(test.operands[0]) && keeps(test.operands[1]);
    if (test.op < Op::Less || test.op > Op::GreaterEqual) return false;
    const bool less = test.op == Op::Less || test.op == Op::LessEqual;
    const Course low = course(test.operands[less ? 0 : 1]), high = course(test.operands[less ? 1 : 0]);
    // A value that must stay low may follow a falling one, and a value that must stay high a rising one.
    const Course falls = least_ ? Course::Same : Course::Opposite;
    return (low == Course::Constant || low == falls) && (high == Course::Constant || high == opposite(falls));
}

bool Improvement::keeps_body() const {
    for (const Clause& c : rule_.body) {
        if (std::find(definitions_.begin(), definitions_.end(), &c) != definitions_.end()) continue;
        if (c.kind == Clause::Kind::Test) {
            if (!keeps(c.test)) return false;
            continue;
        }
        std::size_t uses = 0;
        each_variable(c, [&](VariableId v) { uses += courses_.contains(v); });
        if (uses > (c.kind == Clause::Kind::Atom && &c.atom == &atom_ ? 1u : 0u)) return false;
    }
    return true;
}

const Term* Improvement::first_lost() const {
    for (const Clause& c : rule_.body) {
        if (c.kind != Clause::Kind::Test || std::find(definitions_.begin(), definitions_.end(), &c) != definitions_.end()) continue;
        // ~(X > 3) is X <= 3.
        const Term& inside = c.test.op == Op::Not ? c.test.operands[0] : c.test;
        if (inside.op < Op::Less || inside.op > Op::GreaterEqual || &inside == &c.test) {
            if (!keeps(c.test)) return &c.test;
            continue;
        }
        Term without = inside;
        without.op = inside.op == Op::Less        ? Op::GreaterEqual
                     : inside.op == Op::LessEqual ? Op::Greater
                     : inside.op == Op::Greater   ? Op::LessEqual
                                                  : Op::Less;
        if (!keeps(without)) return &c.test;
    }
    return nullptr;
}

bool Improvement::bounded() const {
    return std::any_of(rule_.body.begin(), rule_.body.end(), [&](const Clause& c) {
        return c.kind == Clause::Kind::Test && mentions(c.test) &&
               std::find(definitions_.begin(), definitions_.end(), &c) == definitions_.end();
    });
}

bool Improvement::at_least_zero(const Term& t, bool at_most) const {
    if (const auto number = literal(t)) return at_most ? *number <= 0 : *number >= 0;
    switch (t.op) {
        case Op::Constant: {
            const double value = program_.constants[t.constant].real;
            return at_most ? value <= 0 : value >= 0;
        }
        case Op::Negate:
            return at_least_zero(t.operands[0], !at_most);
        case Op::Abs:
        case Op::Sqrt:
            return !at_most;
        case Op::ToFloat:
            return at_least_zero(t.operands[0], at_most);
        case Op::Add:
            return at_least_zero(t.operands[0], at_most) && at_least_zero(t.operands[1], at_most);
        case Op::Variable:
            for (const Clause& c : rule_.body) {
                if (c.kind != Clause::Kind::Test || c.test.op != Op::Equal || bound_by_fact(t.variable)) continue;
                for (const std::size_t side : {0u, 1u}) {
                    const Term &target = c.test.operands[side], &is = c.test.operands[1 - side];
                    if (target.is_variable() && target.variable == t.variable && !is.is_variable()) return at_least_zero(is, at_most);
                }
            }
            return false;
        default:
            return false;
    }
}

bool Improvement::moves(const Term& t, Course way) const {
    if (t.op == Op::Not) return moves(t.operands[0], opposite(way));
    if (t.op == Op::And || t.op == Op::Or) {
        const Term &left = t.operands[0], &right = t.operands[1];
        return (moves(left, way) && (!mentions(right) || moves(right, way))) || (!mentions(left) && moves(right, way));
    }
    if (const auto is = t.is_variable() ? defined_.find(t.variable) : defined_.end(); is != defined_.end()) return moves(*is->second, way);
    return course(t) == way;
}

bool Improvement::worse(const Term& t) const {
    switch (t.op) {
        case Op::Variable: {
            if (t.variable == value_) return true;
            const auto is = defined_.find(t.variable);
            return is != defined_.end() && worse(*is->second);
        }
        case Op::ToFloat:
            return worse(t.operands[0]);
        case Op::Add:
            return (worse(t.operands[0]) && at_least_zero(t.operands[1], !least_)) ||
                   (worse(t.operands[1]) && at_least_zero(t.operands[0], !least_));
        case Op::Subtract:
            return worse(t.operands[0]) && at_least_zero(t.operands[1], least_);
        case Op::Max:
        case Op::Min: {
            const bool either = (t.op == Op::Max) == least_;
            const bool left = worse(t.operands[0]), right = worse(t.operands[1]);
            return either ? left || right : left && right;
        }
        default:
            return false;
    }
}

bool Improvement::shifted(const Term& t) const {
    switch (t.op) {
        case Op::Variable: {
            if (t.variable == value_) return true;
            const auto is = defined_.find(t.variable);
            return is != defined_.end() && shifted(*is->second);
        }
        case Op::ToFloat:
            return shifted(t.operands[0]);
        case Op::Add:
            return (shifted(t.operands[0]) && !mentions(t.operands[1])) || (shifted(t.operands[1]) && !mentions(t.operands[0]));
        case Op::Subtract:
            return shifted(t.operands[0]) && !mentions(t.operands[1]);
        default:
            return false;
    }
}

}  // namespace meld::check
