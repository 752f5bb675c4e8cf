#include "compiler/lint/growth.h"

#include <algorithm>
#include <map>
#include <optional>

#include "compiler/check/program/improvement.h"
#include "compiler/check/program/library.h"
#include "compiler/lint/linear_form.h"

namespace meld::lint {

using namespace check;

namespace {

// Functions that call functions: deeper ones are not looked into.
constexpr int kMaxDepth = 8;

// A value that is computed from others, and how it changes from one round to the next.
struct Made {
    const Term* from = nullptr;                        // The sum, product or list.
    std::map<VariableId, const Term*> arguments = {};  // In the body of a function: what its parameters are.
    Growing::How how = Growing::How::Number;
};

class GrowthSearch {
  public:
    GrowthSearch(const Program& program, const Stratum& stratum) : program_(program), stratum_(stratum) {}

    std::vector<Growing> run() {
        for (const RuleId id : stratum_.rules) {
            rule_ = &program_.rules[id];
            const Atom& head = rule_->heads[0].atom;
            for (std::size_t i = 1; i < head.arguments.size(); ++i)
                if (grows(head, i)) found_.push_back({head.predicate, i, head.arguments[i].span, made_.how});
        }
        return std::move(found_);
    }

  private:
    bool grows(const Atom& head, std::size_t i) {
        const Predicate& p = program_.predicates[head.predicate];
        if (p.aggregate == Aggregate::First || (p.aggregate != Aggregate::None && i > p.aggregate_at)) return false;
        made_ = {};
        if (!makes(head.arguments[i], {}, 0)) return false;
        const Term& t = *made_.from;
        const bool worse = (keeps_least(p.aggregate) && t.op == Op::Add) || (keeps_greatest(p.aggregate) && t.op == Op::Subtract);
        if (worse && i == p.aggregate_at) return false;
        bool from_stratum = false, bounded = false;
        each_source(t, [&](VariableId v) {
            const Atom* source = read(v);
            from_stratum = from_stratum || source != nullptr;
            bounded = bounded || (source != nullptr && ends(*source, v));
        });
        return from_stratum && !bounded;
    }

    // Whether the term is a value that differs from all it is computed from; notes how.
    bool makes(const Term& t, const std::map<VariableId, const Term*>& arguments, int depth) {
        if (depth > kMaxDepth) return false;
        switch (t.op) {
            case Op::Add:
            case Op::Subtract:
            case Op::Multiply:
            case Op::Power:
                made_ = {&t, arguments, Growing::How::Number};
                return true;
            case Op::Append:
            case Op::Cons:
                made_ = {&t, arguments, Growing::How::Longer};
                return true;
            case Op::Library: {
                const LibraryFunction* f = library_function(t.text, t.operands.size());
                if (f == nullptr || (f->cpp != "append" && f->cpp != "add_last" && f->cpp != "join")) return false;
                made_ = {&t, arguments, Growing::How::Longer};
                return true;
            }
            case Op::ToFloat:
                return makes(t.operands[0], arguments, depth);
            case Op::Variable: {
                if (const auto argument = arguments.find(t.variable); argument != arguments.end())
                    return argument->second != nullptr && makes(*argument->second, {}, depth + 1);
                const Term* is = arguments.empty() ? definition(t.variable) : nullptr;
                return is != nullptr && makes(*is, {}, depth + 1);
            }
            case Op::Call: {
                const Function& f = program_.functions[t.function];
                if (!arguments.empty() || f.external || f.parameter_count != t.operands.size()) return false;
                std::map<VariableId, const Term*> given;
                for (std::size_t i = 0; i < t.operands.size(); ++i) given[VariableId(i)] = &t.operands[i];
                return !given.empty() && makes(f.body, given, depth + 1);
            }
            default:
                return false;
        }
    }
    // X + 1, where the body says Y = X + 1.
    const Term* definition(VariableId v) const {
        for (const Clause& c : rule_->body) {
            if (c.kind == Clause::Kind::Atom && std::any_of(c.atom.arguments.begin(), c.atom.arguments.end(),
                                                            [&](const Term& t) { return t.is_variable() && t.variable == v; }))
                return nullptr;
            if (c.kind != Clause::Kind::Test || c.test.op != Op::Equal) continue;
            for (const std::size_t side : {0u, 1u})
                if (c.test.operands[side].is_variable() && c.test.operands[side].variable == v && !c.test.operands[1 - side].is_variable())
                    return &c.test.operands[1 - side];
        }
        return nullptr;
    }
    // The rule's variables in the term, through the parameters of a function.
    template <class Visit>
    void each_source(const Term& t, const Visit& visit) const {
        each_variable(t, [&](VariableId v) {
            if (made_.arguments.empty()) return visit(v);
            if (const auto given = made_.arguments.find(v); given != made_.arguments.end()) each_variable(*given->second, visit);
        });
    }
    const Atom* read(VariableId v) const {
        for (const Clause& c : rule_->body)
            if (c.kind == Clause::Kind::Atom && stratum_.contains(c.atom.predicate) && mentions(c.atom, v)) return &c.atom;
        return nullptr;
    }
    static bool mentions(const Atom& a, VariableId v) {
        return std::any_of(a.arguments.begin(), a.arguments.end(), [&](const Term& t) { return t.is_variable() && t.variable == v; });
    }

    // Whether something else in the body ends the growth of this value.
    bool ends(const Atom& source, VariableId v) const {
        if (rule_->variables[v].type == Type::Node) return false;
        for (const Clause& c : rule_->body) {
            if (&c.atom == &source) continue;
            if (c.kind == Clause::Kind::Atom) {
                if (!stratum_.contains(c.atom.predicate) && mentions(c.atom, v)) return true;
                continue;
            }
            bool asks = false;
            each_variable(c, [&](VariableId w) { asks = asks || w == v; });
            const bool defines = c.kind == Clause::Kind::Test && c.test.op == Op::Equal;
            if (asks && !defines && c.kind != Clause::Kind::Test) return true;
            if (asks && !defines && made_.how == Growing::How::Longer) return true;
        }
        if (made_.how == Growing::How::Longer) return false;
        const std::optional<Aggregate> way = direction();
        const Improvement next(program_, *rule_, source, v, way.value_or(Aggregate::Max));
        return way ? next.first_lost() != nullptr : compared(v);
    }
    // Whether N grows or falls, if it does so by a literal.
    std::optional<Aggregate> direction() const {
        const Term& t = *made_.from;
        if (t.op != Op::Add && t.op != Op::Subtract) return std::nullopt;
        const auto right = literal(t.operands[1]);
        const auto step = right ? right : t.op == Op::Add ? literal(t.operands[0]) : std::nullopt;
        if (!step || !made_.arguments.empty()) return std::nullopt;
        return (*step >= 0) == (t.op == Op::Add) ? Aggregate::Max : Aggregate::Min;
    }
    bool compared(VariableId v) const {
        return std::any_of(rule_->body.begin(), rule_->body.end(), [&](const Clause& c) {
            bool asks = false;
            each_variable(c, [&](VariableId w) { asks = asks || w == v; });
            return asks && c.kind == Clause::Kind::Test && c.test.op != Op::Equal;
        });
    }

    const Program& program_;
    const Stratum& stratum_;
    const Rule* rule_ = nullptr;
    Made made_;
    std::vector<Growing> found_;
};

}  // namespace

std::vector<Growing> growing_arguments(const Program& program, const Stratum& stratum) { return GrowthSearch(program, stratum).run(); }

}  // namespace meld::lint
