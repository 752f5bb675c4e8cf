#include "compiler/check/analysis/fronts.h"

#include <algorithm>
#include <set>
#include <utility>

#include "compiler/check/program/improvement.h"
#include "compiler/check/program/values_read.h"

namespace meld::check {

namespace {

class Search {
  public:
    Search(const Program& program, const Stratum& stratum) : program_(program), stratum_(stratum) {}

    std::optional<NotMonotone> not_monotone() {
        if (run() != Fronts::Impossible || !asked_ || !breaks_) return std::nullopt;
        return NotMonotone{asked_->predicate, asked_->span, *breaks_};
    }

    Fronts run() {
        find_copies();
        bool any = false;
        for (const PredicateId p : stratum_.predicates) {
            const Predicate& predicate = program_.predicates[p];
            any = any || best(predicate);
            monotone_ = monotone_ && (best(predicate) || predicate.aggregate == Aggregate::None) && !predicate.needs_all();
        }
        if (!any) return Fronts::NotNeeded;
        for (const RuleId id : stratum_.rules) {
            const Rule& rule = program_.rules[id];
            monotone_ = monotone_ && rule.heads[0].kind == Head::Kind::Fact && rule.heads[0].delay.op == Op::Anonymous;
            for (const Clause& c : rule.body)
                if (c.kind == Clause::Kind::Atom && stratum_.contains(c.atom.predicate)) read(rule, c.atom);
        }
        // A value that is only shifted improves through itself without end, or never, unless something stops it.
        const bool risk = asks_ || improves_ || (shifts_ && stops_);
        return !risk ? Fronts::NotNeeded : monotone_ ? Fronts::Needed : Fronts::Impossible;
    }

  private:
    static bool best(const Predicate& p) { return keeps_best(p.aggregate); }

    // Sets of the stratum that hold values, and where: seen(B, P) :- neighbor(A, B), price(A, P).
    void find_copies() {
        for (bool found = true; found;) {
            found = false;
            for (const RuleId id : stratum_.rules) {
                const Rule& rule = program_.rules[id];
                const Atom& head = rule.heads[0].atom;
                if (program_.predicates[head.predicate].aggregate != Aggregate::None) continue;
                for (const Clause& c : rule.body) {
                    if (c.kind != Clause::Kind::Atom || !stratum_.contains(c.atom.predicate)) continue;
                    for (std::size_t i = 1; i < c.atom.arguments.size(); ++i) {
                        if (!c.atom.arguments[i].is_variable() || !holds_value(c.atom.predicate, i)) continue;
                        for (std::size_t k = 1; k < head.arguments.size(); ++k)
                            if (computed_from(rule, head.arguments[k], c.atom.arguments[i].variable) &&
                                copies_.emplace(head.predicate, k).second)
                                found = true;
                    }
                }
            }
        }
    }
    bool holds_value(PredicateId p, std::size_t argument) const {
        const Predicate& predicate = program_.predicates[p];
        return best(predicate) ? argument == predicate.aggregate_at : copies_.contains({p, argument});
    }

    void read(const Rule& rule, const Atom& atom) {
        const Predicate& p = program_.predicates[atom.predicate];
        if (!best(p)) {
            for (std::size_t i = 1; i < atom.arguments.size(); ++i)
                if (atom.arguments[i].op == Op::Anonymous && holds_value(atom.predicate, i)) ask(atom);
            return;
        }
        const ValueRead how = value_read(program_, rule, atom);
        if (how.kind == ValueRead::Kind::Exists) ask(atom);
        for (std::size_t i = p.aggregate_at + 1; i < atom.arguments.size(); ++i) {
            const Term& payload = atom.arguments[i];
            // The payload belongs only to the best value.
            if (payload.op != Op::Anonymous && (!payload.is_variable() || uses(rule, payload.variable) > 1)) monotone_ = false;
        }
        const Term& value = atom.arguments[p.aggregate_at];
        if (value.op == Op::Anonymous) {
            asks_ = true;
            return;
        }
        if (!value.is_variable()) {
            asks_ = true;
            monotone_ = false;
            return;
        }
        const Improvement improvement(program_, rule, atom, value.variable, p.aggregate);
        const bool keeps = improvement.keeps_body();
        monotone_ = monotone_ && keeps;
        if (!keeps || (how.kind == ValueRead::Kind::Used && improvement.bounded())) breaks(atom.span, !keeps);
        bool carried = false;
        const Head& made = rule.heads[0];
        const Predicate& head = program_.predicates[made.atom.predicate];
        for (std::size_t i = 0; i < made.atom.arguments.size(); ++i) {
            const Term& argument = made.atom.arguments[i];
            const Course course = improvement.course(argument);
            if (course == Course::Constant) continue;
            if (!best(head) || i != head.aggregate_at) {
                monotone_ = false;
                if (head.aggregate == Aggregate::None) breaks(argument.span, true);
                continue;
            }
            carried = true;
            monotone_ = monotone_ && course == (head.aggregate == p.aggregate ? Course::Same : Course::Opposite);
            const bool worse = head.aggregate == p.aggregate && improvement.worse(argument);
            const bool shifted = head.aggregate == p.aggregate && improvement.shifted(argument);
            improves_ = improves_ || (!worse && !shifted);
            shifts_ = shifts_ || (!worse && shifted);
            stops_ = stops_ || !shifted;
        }
        asks_ = asks_ || !carried;
    }

    void ask(const Atom& atom) {
        if (!asked_) asked_ = &atom;
    }
    // Not monotone at all, or only something that keeps existence from being separated from the values.
    void breaks(Span where, bool alone) {
        if (!breaks_ || (alone && !breaks_alone_)) breaks_ = where;
        breaks_alone_ = breaks_alone_ || alone;
    }

    const Program& program_;
    const Stratum& stratum_;
    std::set<std::pair<PredicateId, std::size_t>> copies_;
    const Atom* asked_ = nullptr;
    std::optional<Span> breaks_;
    bool breaks_alone_ = false;
    bool monotone_ = true;
    bool asks_ = false;      // Some rule reads a value, but its head does not follow from the value,
    bool improves_ = false;  // or it derives a value that may be better,
    bool shifts_ = false;    // possibly by an amount,
    bool stops_ = false;     // and some rule bounds values that improve by amounts.
};

}  // namespace

Fronts fronts_of(const Program& program, const Stratum& stratum) { return Search(program, stratum).run(); }

std::optional<NotMonotone> not_monotone(const Program& program, const Stratum& stratum) { return Search(program, stratum).not_monotone(); }

}  // namespace meld::check
