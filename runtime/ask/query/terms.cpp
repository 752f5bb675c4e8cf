#include "runtime/ask/query/terms.h"

#include "runtime/ask/query/values.h"

#include <bit>
#include <utility>

#include "compiler/check/program/arithmetic.h"
#include "compiler/check/program/library.h"
#include "compiler/check/program/op_info.h"
#include "compiler/check/program/types.h"
#include "runtime/ask/query/library.h"
#include "runtime/base/assert.h"
#include "runtime/module/kernel/library.h"

namespace meld::inspect {

using namespace check;
using check::Type;

namespace {

// Terms are walked by recursion, on a stack that usually has 8 MB.
constexpr std::ptrdiff_t kMostStack_bytes = 4 << 20;

u64 word_of(Value v) { return v.catom; }

[[noreturn]] void has_no_value(const Term& t) {
    MELD_CHECK(false, "a question computes a term without a value, {}", static_cast<int>(t.op));
}

}  // namespace

bool Terms::equal(const Type& type, Value a, Value b) {
    if (type.kind == Type::Kind::Float) return a.real == b.real;
    if (!type.compound()) return a.catom == b.catom;
    if (a.list == b.list) return true;
    const u16 number = types.number(type);
    return compare_lists(types.table(), number, a.list, b.list) == 0;
}

Value Terms::value_as(const Term& term, const Type& type, Values& variables) { return converted(value(term, variables), term.type, type); }

Value Terms::element(const Term& term, const Type& type, Values& variables) {
    const Value v = value_as(term, type, variables);
    return type.kind == Type::Kind::Float ? make_value(checked_real(scratch, 0, v.real)) : v;
}

Value Terms::value(const Term& t, Values& variables) {
    switch (info(t.op).family) {
        case OpInfo::Family::Leaf:
            return leaf(t, variables);
        case OpInfo::Family::Compound:
            return compound(t, variables);
        case OpInfo::Family::Control:
            return control(t, variables);
        case OpInfo::Family::Call:
            return t.op == Op::Call ? call(t, variables) : library(t, variables);
        case OpInfo::Family::Run:
            return asked_of_run(t, variables);
        case OpInfo::Family::Number:
            return number(t, variables);
        case OpInfo::Family::Arithmetic:
            return arithmetic(t, variables);
        case OpInfo::Family::Comparison:
            return make_value(comparison(t, variables));
    }
    has_no_value(t);
}

Value Terms::leaf(const Term& t, Values& variables) {
    switch (t.op) {
        case Op::Variable:
            return variables[t.variable.index()];
        case Op::Int:
        case Op::Bool:
        case Op::Node:
            return make_value(t.integer);
        case Op::Float:
            return make_value(t.real);
        case Op::Constant:
            return constant(t);
        default:
            has_no_value(t);
    }
}

Value Terms::compound(const Term& t, Values& variables) {
    const auto operand = [&](std::size_t i) { return value(t.operands[i], variables).list; };
    switch (t.op) {
        case Op::String:
            return make_value(make_text(scratch, t.text.data(), t.text.size()));
        case Op::Cons: {
            const u64 head = word_of(element(t.operands[0], t.type.parts[0], variables));
            return make_value(cons(scratch, head, operand(1)));
        }
        case Op::ListHead:
            return std::bit_cast<Value>(item(operand(0), 0));
        case Op::ListTail:
            return make_value(meld::tail(scratch, operand(0)));
        case Op::IsEmpty:
            return make_value(count_of(operand(0)) == 0);
        case Op::Item:
            return std::bit_cast<Value>(item(operand(0), static_cast<u32>(t.integer)));
        case Op::Append: {
            const ListRef a = operand(0), b = operand(1);
            return make_value(t.type == Type::String ? join_text(scratch, a, b) : meld::append(scratch, a, b));
        }
        default:
            return make(t, variables);
    }
}

Value Terms::control(const Term& t, Values& variables) {
    if (t.op == Op::Let) {
        const std::size_t v = t.variable.index();
        if (v >= variables.size()) variables.resize(v + 1);
        variables[v] = value(t.operands[0], variables);
        return value(t.operands[1], variables);
    }
    const bool first = value(t.operands[0], variables).integer != 0;
    if (t.op == Op::Not) return make_value(!first);
    if (t.op == Op::If) return value_as(t.operands[first ? 1 : 2], t.type, variables);
    const bool decided = first == (t.op == Op::Or);
    return decided ? make_value(first) : value(t.operands[1], variables);
}

Value Terms::call(const Term& t, Values& variables) {
    const check::Function& f = program_.checked().functions[t.function];
    std::vector<Value> arguments;
    for (std::size_t i = 0; i < t.operands.size(); ++i)
        arguments.push_back(value_as(t.operands[i], f.variables[VariableId(i)].type, variables));
    return call(t.function, std::move(arguments));
}

Value Terms::asked_of_run(const Term& t, Values& variables) {
    if (t.op == Op::WorldSize) return make_value(view_.world_catoms);
    if (t.op == Op::Now) return make_value(view_.now);
    if (t.op == Op::Ticks) return make_value(ticks_of(scratch, value(t.operands[0], variables).real));
    has_no_value(t);
}

Value Terms::number(const Term& t, Values& variables) {
    const auto operand = [&] { return value(t.operands[0], variables); };
    const bool real = t.type == Type::Float;
    switch (t.op) {
        case Op::Negate:
            if (t.type == Type::Vec3) return make_value(library::vector_scale(scratch, 0, operand().list, -1.0));
            return real ? make_value(-operand().real) : make_value(checked_subtract(scratch, 0, 0, operand().integer));
        case Op::ToFloat:
            return t.operands[0].type == Type::Float ? operand() : make_value(static_cast<double>(operand().integer));
        case Op::Min:
        case Op::Max: {
            const Value a = value_as(t.operands[0], t.type, variables), b = value_as(t.operands[1], t.type, variables);
            const bool least = t.op == Op::Min;
            if (real) return make_value(least ? least_of(a.real, b.real) : greatest_of(a.real, b.real));
            return make_value(least ? least_of(a.integer, b.integer) : greatest_of(a.integer, b.integer));
        }
        case Op::Abs:
            return real ? make_value(__builtin_fabs(operand().real)) : make_value(checked_abs(scratch, 0, operand().integer));
        case Op::Truncate:
            return make_value(checked_truncate(scratch, 0, operand().real));
        case Op::Sqrt:
            return make_value(__builtin_sqrt(operand().real));
        default:
            return operand();  // Op::NodeToInt
    }
}

Value Terms::constant(const Term& t) {
    const check::Constant& c = program_.checked().constants[t.constant];
    if (c.computed.valid()) return call(c.computed, {});
    if (const std::optional<u32> parameter = program_.parameter(t.constant)) return view_.parameters[*parameter];
    if (c.type == Type::String) return make_value(make_text(scratch, c.text.data(), c.text.size()));
    Values none;
    if (c.type.compound()) return value(c.value, none);
    return c.type == Type::Float ? make_value(c.real) : make_value(c.integer);
}

Value Terms::make(const Term& t, Values& variables) {
    if (t.operands.empty()) return make_value(ListRef{});
    std::vector<u64> words;
    for (std::size_t i = 0; i < t.operands.size(); ++i) {
        const Type& part = t.type == Type::Vec3 ? Type::Float : t.type.parts[t.op == Op::List ? 0 : i];
        words.push_back(word_of(element(t.operands[i], part, variables)));
    }
    u64* const items = new_items(scratch, words.size());
    std::copy(words.begin(), words.end(), items);
    const ListRef list = list_over(scratch, items, words.size());
    if (t.type.kind != Type::Kind::Set) return make_value(list);
    const u16 part = types.number(t.type.parts[0]);
    return make_value(list_to_set(scratch, 0, types.table(), part, list));
}

Value Terms::arithmetic(const Term& t, Values& variables) {
    if (t.type == Type::Vec3) {
        const ListRef a = value(t.operands[0], variables).list;
        const bool vectors = t.operands[1].type == Type::Vec3;
        const Value b = value_as(t.operands[1], vectors ? Type::Vec3 : Type::Float, variables);
        switch (t.op) {
            case Op::Add:
                return make_value(library::vector_add(scratch, 0, a, b.list));
            case Op::Subtract:
                return make_value(library::vector_subtract(scratch, 0, a, b.list));
            case Op::Multiply:
                return make_value(library::vector_scale(scratch, 0, a, b.real));
            default:
                return make_value(library::vector_divide(scratch, 0, a, b.real));
        }
    }
    const Value a = value_as(t.operands[0], t.type, variables), b = value_as(t.operands[1], t.type, variables);
    if (t.type == Type::Float) {
        switch (t.op) {
            case Op::Add:
                return make_value(a.real + b.real);
            case Op::Subtract:
                return make_value(a.real - b.real);
            case Op::Multiply:
                return make_value(a.real * b.real);
            case Op::Divide:
                return make_value(checked_divide(scratch, 0, a.real, b.real));
            case Op::Modulo:
                return make_value(checked_modulo(scratch, 0, a.real, b.real));
            default:
                return make_value(__builtin_pow(a.real, b.real));
        }
    }
    switch (t.op) {
        case Op::Add:
            return make_value(checked_add(scratch, 0, a.integer, b.integer));
        case Op::Subtract:
            return make_value(checked_subtract(scratch, 0, a.integer, b.integer));
        case Op::Multiply:
            return make_value(checked_multiply(scratch, 0, a.integer, b.integer));
        case Op::Divide:
            return make_value(checked_divide(scratch, 0, a.integer, b.integer));
        case Op::Modulo:
            return make_value(checked_modulo(scratch, 0, a.integer, b.integer));
        default:
            return make_value(checked_power(scratch, 0, a.integer, b.integer));
    }
}

bool Terms::comparison(const Term& t, Values& variables) {
    const Term &l = t.operands[0], &r = t.operands[1];
    if (l.type.compound() || r.type.compound()) {
        const Type common = refined(l.type, r.type);
        const Value a = value_as(l, common, variables), b = value_as(r, common, variables);
        return holds(t.op, compare_lists(types.table(), types.number(common), a.list, b.list), 0);
    }
    // Of one word: nothing is copied for each row of a question.
    const bool real = l.type.kind == Type::Kind::Float || r.type.kind == Type::Kind::Float;
    const Type& common = real ? Type::Float : l.type.kind == Type::Kind::Error ? r.type : l.type;
    const Value a = value_as(l, common, variables), b = value_as(r, common, variables);
    if (real) return holds(t.op, a.real, b.real);
    return common.kind == Type::Kind::Node ? holds(t.op, a.catom, b.catom) : holds(t.op, a.integer, b.integer);
}

Value Terms::library(const Term& t, Values& variables) {
    const LibraryFunction* const f = library_function(t.text, t.operands.size());
    MELD_CHECK(f != nullptr && f->op == Op::Library, "the library has no {}", t.text);
    LibraryBindings bindings;
    for (std::size_t i = 0; i < t.operands.size(); ++i) match(f->parameters[i], t.operands[i].type, bindings);
    match(f->result, t.type, bindings);
    std::vector<Value> arguments;
    for (std::size_t i = 0; i < t.operands.size(); ++i)
        arguments.push_back(value_as(t.operands[i], substitute(f->parameters[i], bindings), variables));
    const LibraryCall compute = library_call(f->cpp, bindings.contains('N') && bindings['N'] == Type::Float);
    MELD_CHECK(compute != nullptr, "a question cannot call {}", f->name);
    const u16 type = f->compares ? types.number(bindings['T']) : u16{0};
    return compute(scratch, types.table(), type, arguments.data());
}

Value Terms::call(FunctionId id, std::vector<Value> arguments) {
    const check::Function& f = program_.checked().functions[id];
    MELD_CHECK(!f.external, "a question cannot call {}", f.name);
    MELD_EXPECT(arguments.size() == f.parameter_count, "{} of {} arguments", arguments.size(), f.parameter_count);
    arguments.resize(f.variables.count());
    if (scratch.depth == 0) calls_ = 0;
    const u32 depth = scratch.depth;
    const Scratch::Mark mark = scratch.mark();
    static thread_local const char* base = nullptr;
    if (depth == 0) base = static_cast<const char*>(__builtin_frame_address(0));
    ++scratch.depth;
    const std::ptrdiff_t used = base - static_cast<const char*>(__builtin_frame_address(0));
    if (used > kMostStack_bytes) trap(scratch, Trap::TooDeep, 0, i64{depth});
    const Value result = run(id, arguments);
    scratch.depth = depth;
    // Nothing can refer to what was made for a single word.
    if (!f.result.compound()) scratch.release(mark);
    return result;
}

// The branches of the body to the end; a function that ends by calling itself starts again instead, which counts as a call.
Value Terms::run(FunctionId id, Values& frame) {
    const check::Function& f = program_.checked().functions[id];
    const auto allowed = [&] {
        if (scratch.depth > kMaxOpenCalls) trap(scratch, Trap::TooDeep, 0, i64{scratch.depth} - 1);
        const u64 most = view_.max_growing_derivations;
        if (++calls_ / kCallsPerDerivation > most) trap(scratch, Trap::TooManyDerivations, 0, static_cast<i64>(most));
        return scratch.trap == Trap::None;
    };
    if (!allowed()) return {};
    for (const Term* t = &f.body;;) {
        if (t->op == Op::If) {
            t = &t->operands[value(t->operands[0], frame).integer != 0 ? 1 : 2];
        } else if (t->op == Op::Let) {
            frame[t->variable.index()] = value_as(t->operands[0], f.variables[t->variable].type, frame);
            t = &t->operands[1];
        } else if ((t->op == Op::And || t->op == Op::Or) && f.result == Type::Bool) {
            const bool first = value(t->operands[0], frame).integer != 0;
            if (first == (t->op == Op::Or)) return make_value(first);
            t = &t->operands[1];
        } else if (t->op == Op::Call && t->function == id && t->type == f.result) {
            Values next;
            for (std::size_t i = 0; i < f.parameter_count; ++i)
                next.push_back(value_as(t->operands[i], f.variables[VariableId(i)].type, frame));
            std::copy(next.begin(), next.end(), frame.begin());
            ++scratch.depth;
            if (!allowed()) return {};
            t = &f.body;
        } else {
            return value_as(*t, f.result, frame);
        }
        if (scratch.trap != Trap::None) return {};
    }
}

}  // namespace meld::inspect
