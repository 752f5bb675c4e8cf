#include "compiler/lint/replaced.h"

#include <algorithm>

#include "compiler/lint/contradiction.h"
#include "compiler/lint/linear_form.h"

namespace meld::lint {

using namespace check;

namespace {

class ReplacedSearch {
  public:
    ReplacedSearch(const Program& program, const check::Stratum& stratum) : program_(program), stratum_(stratum) {}

    std::optional<Replaced> run() {
        for (const RuleId id : stratum_.rules) {
            asking_ = &program_.rules[id];
            asked_ = asked(*asking_);
            if (asked_ == nullptr) continue;
            const Predicate& p = program_.predicates[asked_->predicate];
            const bool best = keeps_best(p.aggregate);
            if (!best || p.aggregate_at != 1 || p.needs_all()) continue;
            seen_ = {asked_->predicate};
            between_.clear();
            if (auto found = follow(*asking_)) return found;
        }
        return std::nullopt;
    }

  private:
    // The one fact of the stratum that the rule reads, if it does so at its own catom and immediately.
    const Atom* asked(const Rule& rule) const {
        std::size_t count = 0;
        each_atom(rule.body, [&](const Atom& a, bool) { count += stratum_.contains(a.predicate); });
        if (count != 1 || rule.heads[0].delay.op != Op::Anonymous || rule.heads[0].atom.arguments[0].variable != rule.site) return nullptr;
        for (const Clause& c : rule.body)
            if (c.kind == Clause::Kind::Atom && stratum_.contains(c.atom.predicate))
                return c.atom.arguments[0].variable == rule.site ? &c.atom : nullptr;
        return nullptr;
    }

    // Where the head of this rule leads to.
    std::optional<Replaced> follow(const Rule& rule) {
        const Atom& head = rule.heads[0].atom;
        if (head.predicate == asked_->predicate) {
            const Term& made = head.arguments[1];
            const auto value = number(made);
            const std::optional<Span> failed = value ? fails(*value) : std::nullopt;
            return failed ? std::optional(Replaced{.predicate = head.predicate, .made = made.span, .asked = *failed, .between = between_})
                          : std::nullopt;
        }
        // A fact that competes with others may not be there for long.
        if (program_.predicates[head.predicate].aggregate != Aggregate::None ||
            std::find(seen_.begin(), seen_.end(), head.predicate) != seen_.end())
            return std::nullopt;
        seen_.push_back(head.predicate);
        for (const RuleId id : stratum_.rules) {
            const Rule& next = program_.rules[id];
            const Atom* read = asked(next);
            if (read == nullptr || read->predicate != head.predicate || !may_match(head, *read)) continue;
            between_.push_back({next.heads[0].atom.predicate, head.predicate, read->span});
            if (auto found = follow(next)) return found;
            between_.pop_back();
        }
        return std::nullopt;
    }
    // p(A, 1) is no p(A, 2).
    bool may_match(const Atom& made, const Atom& read) const {
        for (std::size_t i = 1; i < made.arguments.size(); ++i) {
            const Term &a = made.arguments[i], &b = read.arguments[i];
            if (a.op == Op::String && b.op == Op::String && a.text != b.text) return false;
            if (const auto one = number(a), other = number(b); one && other && *one != *other) return false;
        }
        return true;
    }

    std::optional<double> number(const Term& t) const {
        if (t.op == Op::ToFloat) return number(t.operands[0]);
        if (t.op == Op::String || t.type.compound()) return std::nullopt;
        if (t.op != Op::Constant) return literal(t);
        const Constant& c = program_.constants[t.constant];
        if (c.argument || c.computed.valid() || !c.type.numeric()) return std::nullopt;
        return c.type == Type::Float ? c.real : static_cast<double>(c.integer);
    }

    // The test that this value does not pass but a worse one does: where it is.
    std::optional<Span> fails(double value) const {
        const bool greatest = keeps_greatest(program_.predicates[asked_->predicate].aggregate);
        const auto beyond = [&](double limit) { return greatest ? value > limit : value < limit; };
        const Term& argument = asked_->arguments[1];
        if (const auto limit = number(argument)) return beyond(*limit) ? std::optional(argument.span) : std::nullopt;
        if (!argument.is_variable()) return std::nullopt;
        for (const Condition& c : conditions(asking_->body)) {
            if (c.term->op < Op::Equal || c.term->op > Op::GreaterEqual) continue;
            for (const std::size_t side : {0u, 1u}) {
                const Term &tested = c.term->operands[side], &with = c.term->operands[1 - side];
                if (!tested.is_variable() || tested.variable != argument.variable) continue;
                const auto limit = number(with);
                const bool below = side == 0 ? c.term->op == Op::Less || c.term->op == Op::LessEqual
                                             : c.term->op == Op::Greater || c.term->op == Op::GreaterEqual;
                const bool above = side == 0 ? c.term->op == Op::Greater || c.term->op == Op::GreaterEqual
                                             : c.term->op == Op::Less || c.term->op == Op::LessEqual;
                const bool strict = c.term->op == Op::Less || c.term->op == Op::Greater;
                if (limit && (c.term->op == Op::Equal || (greatest ? below : above)) && (beyond(*limit) || (strict && value == *limit)))
                    return c.term->span;
            }
        }
        return std::nullopt;
    }

    const Program& program_;
    const check::Stratum& stratum_;
    const Rule* asking_ = nullptr;
    const Atom* asked_ = nullptr;
    std::vector<PredicateId> seen_;
    std::vector<Replaced::Between> between_;
};

}  // namespace

std::optional<Replaced> replaced_by_itself(const Program& program, const check::Stratum& stratum) {
    return ReplacedSearch(program, stratum).run();
}

}  // namespace meld::lint
