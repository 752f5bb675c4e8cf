// Makes the instructions of a sieve from the steps of a search, up to the first that it does not know.
#include "runtime/ask/query/sieve_code.h"

#include <algorithm>
#include <map>
#include <utility>

#include "compiler/check/program/types.h"

namespace meld::inspect {

namespace {

using check::Op;
using check::Term;
using check::Type;
using check::VariableId;
using Kind = Instruction::Kind;

class SieveMaker {
  public:
    SieveMaker(const Program& program, const check::Rule& rule, const SubdomainView& view) : program_(program), rule_(rule), view_(view) {}

    SieveCode make(const std::vector<Step>& steps, VariableId start) {
        known_.places[start] = SieveCode::kStart;
        all_of(steps, out_.instructions);
        std::vector<bool> later(out_.registers, false);
        later[SieveCode::kOrigin] = true;
        carry(out_.instructions, later);
        out_.levels = 1 + depth(out_.instructions);
        return std::move(out_);
    }

  private:
    // Registers of variables: their values, and the indices of catoms.
    struct Known {
        std::map<VariableId, Register> values, places;
    };

    // False: one of them is not known; what was made of those before stays.
    bool all_of(const std::vector<Step>& steps, std::vector<Instruction>& code) {
        for (const Step& step : steps) {
            std::vector<Instruction> made;
            const Known before = known_;
            if (!one(step, made)) {
                known_ = before;
                return false;
            }
            std::ranges::move(made, std::back_inserter(code));
        }
        return true;
    }

    bool one(const Step& step, std::vector<Instruction>& code) {
        switch (step.kind) {
            case Step::Kind::Here:
            case Step::Kind::Back:
                return match(step, code);
            case Step::Kind::Test: {
                if (is_comparison(*step.term)) return comparison(*step.term, std::nullopt, code);
                const auto holds = value(*step.term, Type::Bool, code);
                if (holds) code.push_back({.kind = Kind::Keep, .a = *holds});
                return holds.has_value();
            }
            case Step::Kind::Bind: {
                const Type& type = rule_.variables[step.variable].type;
                // A float must be a number there, which is not looked at here.
                if (type == Type::Float && step.term->type == Type::Float && !step.term->is_variable()) return false;
                const auto bound = value(*step.term, type, code);
                if (bound) known_.values[step.variable] = *bound;
                return bound.has_value();
            }
            case Step::Kind::Not:
            case Step::Kind::Aggregate:
                return part(step, code);
            default:
                return false;
        }
    }

    bool part(const Step& step, std::vector<Instruction>& code) {
        const bool aggregate = step.kind == Step::Kind::Aggregate;
        const check::Clause& c = *step.clause;
        if (aggregate && (c.aggregate != check::Aggregate::Count || c.test.op != Op::Anonymous || !counts_ints(c))) return false;
        Instruction made{.kind = aggregate ? Kind::Count : Kind::Not};
        const Known before = known_;
        const bool whole = all_of(step.inner, made.inner);
        known_ = before;
        if (!whole) return false;
        // Which row a row is made from.
        made.b = fresh();
        if (!aggregate) {
            code.push_back(std::move(made));
            return true;
        }
        made.to = fresh();
        const Register count = made.to;
        code.push_back(std::move(made));
        if (!step.known) {
            known_.values[c.variable] = count;
            return true;
        }
        const auto wanted = variable(c.variable, code);
        if (wanted) code.push_back({.kind = Kind::Test, .a = count, .b = *wanted});
        return wanted.has_value();
    }
    bool counts_ints(const check::Clause& c) const { return rule_.variables[c.variable].type == Type::Int; }

    // ---- facts

    bool match(const Step& step, std::vector<Instruction>& code) {
        if (step.source.kind == Source::Kind::World) return is_link(step.source.world) && links(step, code);
        if (step.source.kind != Source::Kind::Stored || step.kind != Step::Kind::Here) return false;
        const auto at = place(step.arguments[0], code);
        if (!at) return false;
        const PredicateInfo& p = program_.module().predicates[step.source.predicate];
        const bool record = p.storage == Storage::Single || p.storage == Storage::Flag;
        if (p.column == kNone16 || (!record && p.storage != Storage::Rows)) return false;
        Instruction read{.kind = record ? Kind::Read : Kind::Rows, .a = *at, .predicate = step.source.predicate};
        if (!record) choose_key(step, p, read, code);
        std::vector<Register> values(p.arity);
        for (u32 i = 0; i < p.arity; ++i)
            if (step.arguments[i + 1].use != Argument::Use::Skip) read.fields.push_back({&p.fields[i], values[i] = fresh()});
        code.push_back(std::move(read));
        for (u32 i = 0; i < p.arity; ++i)
            if (!use(step.arguments[i + 1], values[i], code)) return false;
        return true;
    }

    // If something has to be computed for a fact, that may fail, and then all facts must be looked at.
    void choose_key(const Step& step, const PredicateInfo& p, Instruction& read, std::vector<Instruction>& code) {
        const auto known = [&](const Argument& a) {
            if (a.type.compound() || a.type == Type::Float || a.term->type == Type::Float) return false;
            return a.term->is_variable() ? known_.values.contains(a.term->variable) || known_.places.contains(a.term->variable)
                                         : a.term->op == Op::Int || a.term->op == Op::Bool || a.term->op == Op::Node;
        };
        for (u32 i = 0; i < p.arity; ++i)
            if (const Argument& a = step.arguments[i + 1]; a.use == Argument::Use::Compare && !a.term->operands.empty()) return;
        for (u32 i = 0; i < p.arity; ++i) {
            const Argument& a = step.arguments[i + 1];
            if (a.use != Argument::Use::Compare || !known(a)) continue;
            if (const auto wanted = value(*a.term, code)) read.key.push_back({&p.fields[i], *wanted});
        }
        if (!read.key.empty()) read.lookup = out_.lookups++;
    }

    bool links(const Step& step, std::vector<Instruction>& code) {
        const bool back = step.kind == Step::Kind::Back;
        const Argument& from = step.arguments[back ? 1 : 0];
        const Argument& to = step.arguments[back ? 0 : 1];
        const auto at = place(from, code);
        if (!at) return false;
        Instruction links{.kind = Kind::Links, .to = fresh(), .a = *at, .back = back};
        const Register there = links.to;
        const bool ports = step.arguments.size() > 2 && step.arguments[2].use != Argument::Use::Skip;
        if (ports) links.port = fresh();
        const Register port = links.port.value_or(0);
        code.push_back(std::move(links));
        if (to.use == Argument::Use::Bind) {
            known_.places[to.term->variable] = there;
        } else if (to.use == Argument::Use::Compare) {
            const Register number = fresh();
            code.push_back({.kind = Kind::Number, .to = number, .a = there});
            if (!use(to, number, code)) return false;
        }
        return !ports || use(step.arguments[2], port, code);
    }

    // What an argument does with the value of a fact.
    bool use(const Argument& a, Register value_of_fact, std::vector<Instruction>& code) {
        if (a.use == Argument::Use::Skip) return true;
        if (a.use == Argument::Use::Bind) {
            const VariableId v = a.term->variable;
            const Type& type = v.index() < rule_.variables.count() ? rule_.variables[v].type : a.type;
            known_.values[v] = converted(value_of_fact, a.type, type, code);
            return true;
        }
        if (a.type.compound()) return false;
        const bool real = a.type == Type::Float || a.term->type == Type::Float;
        const auto wanted = value(*a.term, real ? Type::Float : a.type, code);
        if (!wanted) return false;
        const Register there = real ? converted(value_of_fact, a.type, Type::Float, code) : value_of_fact;
        code.push_back({.kind = Kind::Test, .a = there, .b = *wanted, .real = real});
        return true;
    }

    std::optional<Register> place(const Argument& a, std::vector<Instruction>& code) {
        if (a.use != Argument::Use::Compare || !a.term->is_variable()) return std::nullopt;
        const VariableId v = a.term->variable;
        if (const auto found = known_.places.find(v); found != known_.places.end()) return found->second;
        const auto number = known_.values.find(v);
        if (number == known_.values.end()) return std::nullopt;
        const Register found = fresh();
        code.push_back({.kind = Kind::Find, .to = found, .a = number->second});
        known_.places[v] = found;
        return found;
    }

    // ---- terms

    Register fresh() { return out_.registers++; }
    Register fixed(Value v) {
        out_.fixed.push_back({fresh(), v});
        return out_.fixed.back().at;
    }

    std::optional<Register> variable(VariableId v, std::vector<Instruction>& code) {
        if (const auto found = known_.values.find(v); found != known_.values.end()) return found->second;
        const auto at = known_.places.find(v);
        if (at == known_.places.end()) return std::nullopt;
        const Register number = fresh();
        code.push_back({.kind = Kind::Number, .to = number, .a = at->second});
        known_.values[v] = number;
        return number;
    }

    Register converted(Register from, const Type& type, const Type& wanted, std::vector<Instruction>& code) {
        if (type != Type::Int || wanted != Type::Float) return from;
        const Register to = fresh();
        code.push_back({.kind = Kind::Compute, .to = to, .a = from, .op = Op::ToFloat});
        return to;
    }

    std::optional<Register> value(const Term& t, const Type& type, std::vector<Instruction>& code) {
        if (t.type.compound()) return std::nullopt;
        const auto plain = value(t, code);
        if (!plain) return std::nullopt;
        return converted(*plain, t.type, type, code);
    }

    std::optional<Register> value(const Term& t, std::vector<Instruction>& code) {
        switch (t.op) {
            case Op::Variable:
                return variable(t.variable, code);
            case Op::Int:
            case Op::Bool:
            case Op::Node:
                return fixed({.integer = t.integer});
            case Op::Float:
                return fixed({.real = t.real});
            case Op::WorldSize:
                return fixed({.integer = view_.world_catoms});
            case Op::NodeToInt:
                return value(t.operands[0], code);
            case Op::Constant: {
                const check::Constant& c = program_.checked().constants[t.constant];
                if (c.computed.valid() || c.type.compound()) return std::nullopt;
                if (const auto parameter = program_.parameter(t.constant)) return fixed(view_.parameters[*parameter]);
                return fixed(c.type == Type::Float ? Value{.real = c.real} : Value{.integer = c.integer});
            }
            case Op::Not:
                return compute(Op::Not, t, Type::Bool, Type::Bool, code);
            case Op::ToFloat:
                return value(t.operands[0], Type::Float, code);
            case Op::Add:
            case Op::Subtract:
            case Op::Multiply:
            case Op::Min:
            case Op::Max:
                // The least of floats has its own rules for zeros.
                if (t.type != Type::Int && (t.type != Type::Float || t.op == Op::Min || t.op == Op::Max)) return std::nullopt;
                return compute(t.op, t, t.type, t.type, code);
            case Op::And:
            case Op::Or:
                return compute(t.op, t, Type::Bool, Type::Bool, code);
            default:
                if (!is_comparison(t)) return std::nullopt;
                const Register to = fresh();
                if (!comparison(t, to, code)) return std::nullopt;
                return to;
        }
    }

    std::optional<Register> compute(Op op, const Term& t, const Type& of, const Type& type, std::vector<Instruction>& code) {
        const auto a = value(t.operands[0], of, code);
        const auto b = t.operands.size() > 1 ? value(t.operands[1], of, code) : a;
        if (!a || !b) return std::nullopt;
        const Register to = fresh();
        code.push_back({.kind = Kind::Compute, .to = to, .a = *a, .b = *b, .op = op, .real = type == Type::Float});
        return to;
    }

    static bool is_comparison(const Term& t) {
        return t.op == Op::Equal || t.op == Op::NotEqual || t.op == Op::Less || t.op == Op::LessEqual || t.op == Op::Greater ||
               t.op == Op::GreaterEqual;
    }
    // Into a register, or rows go for which it is false.
    bool comparison(const Term& t, std::optional<Register> to, std::vector<Instruction>& code) {
        const Term &l = t.operands[0], &r = t.operands[1];
        const Type common = l.type == Type::Float || r.type == Type::Float ? Type::Float : check::refined(l.type, r.type);
        const auto a = value(l, common, code), b = value(r, common, code);
        if (!a || !b) return false;
        code.push_back(
            {.kind = to ? Kind::Compute : Kind::Test, .to = to.value_or(0), .a = *a, .b = *b, .op = t.op, .real = common == Type::Float});
        return true;
    }

    // ---- what new rows take over

    static bool makes_rows(const Instruction& i) {
        return i.kind == Kind::Rows || i.kind == Kind::Links || i.kind == Kind::Not || i.kind == Kind::Count;
    }
    // From the last to the first: `later` are the registers that are read behind.
    void carry(std::vector<Instruction>& code, std::vector<bool>& later) const {
        for (std::size_t i = code.size(); i-- > 0;) {
            Instruction& at = code[i];
            const auto is_written = [&](Register r) {
                return (writes(at) && r == at.to) || r == at.port ||
                       std::ranges::any_of(at.fields, [&](const auto& f) { return f.to == r; });
            };
            std::vector<bool> needed = later;
            if (!at.inner.empty() || at.kind == Kind::Not || at.kind == Kind::Count) {
                std::vector<bool> within(out_.registers, false);
                within[SieveCode::kOrigin] = within[at.b] = true;
                carry(at.inner, within);
                for (Register r = 0; r < out_.registers; ++r) {
                    if (!within[r] || r == at.b || is_fixed(r)) continue;
                    at.carried.push_back(r);
                    needed[r] = true;
                }
            } else if (makes_rows(at)) {
                for (Register r = 0; r < out_.registers; ++r)
                    if (later[r] && !is_written(r) && !is_fixed(r)) at.carried.push_back(r);
            }
            if (writes(at)) needed[at.to] = false;
            if (at.port) needed[*at.port] = false;
            for (const Instruction::Field& f : at.fields) needed[f.to] = false;
            if (at.kind != Kind::Not && at.kind != Kind::Count) needed[at.a] = true;
            if (at.kind == Kind::Compute || at.kind == Kind::Test) needed[at.b] = true;
            for (const Instruction::Field& f : at.key) needed[f.to] = true;
            later = std::move(needed);
        }
    }
    static bool writes(const Instruction& i) {
        return i.kind == Kind::Find || i.kind == Kind::Number || i.kind == Kind::Links || i.kind == Kind::Compute || i.kind == Kind::Count;
    }
    bool is_fixed(Register r) const {
        return std::ranges::any_of(out_.fixed, [&](const SieveCode::Fixed& f) { return f.at == r; });
    }
    static u32 depth(const std::vector<Instruction>& code) {
        u32 rows = 0, deepest = 0;
        for (const Instruction& i : code) {
            if (!makes_rows(i)) continue;
            if (i.kind == Kind::Not || i.kind == Kind::Count) {
                deepest = std::max(deepest, rows + 1 + depth(i.inner));
            } else {
                deepest = std::max(deepest, ++rows);
            }
        }
        return deepest;
    }

    const Program& program_;
    const check::Rule& rule_;
    const SubdomainView& view_;
    SieveCode out_;
    Known known_;
};

}  // namespace

SieveCode sieve_code(const Program& program, const check::Rule& rule, const std::vector<Step>& steps, VariableId start,
                     const SubdomainView& view) {
    return SieveMaker(program, rule, view).make(steps, start);
}

}  // namespace meld::inspect
