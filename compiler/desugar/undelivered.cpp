// Pass `undelivered`. A linear fact for a catom that is no longer a neighbour when it is sent is dropped and counted,
// unless the program declares where it goes instead: with `type linear undelivered-token(node, node To, int).`
//     a(A, X), friend(A, B) -o token(B, X).
// becomes
//     a(A, X), friend(A, B) -o token@out(A, B, X).
//     token@out(A, B, X), neighbor(A, B) -o token(B, X).
//     token@out(A, B, X), not neighbor(A, B) -o undelivered-token(A, B, X).
// Assumes relays: every head is at the rule's own catom or at a neighbour of it. A fact that is handed on comes back at the
// catom where it can go no further; one with a delay waits where it will be, so it is sent at once.
#include <map>

#include "compiler/desugar/desugar.h"
#include "compiler/desugar/made.h"

namespace meld::desugar {

using namespace check;

namespace {

class Undelivered {
  public:
    explicit Undelivered(Program& program) : program_(program) {}

    void run() {
        for (const PredicateId id : program_.predicates.ids()) {
            const Predicate& p = program_.predicates[id];
            if (p.returns.valid()) back_.emplace(p.returns, id);
            if (p.world == WorldSource::Neighbor) neighbor_ = id;
        }
        if (back_.empty()) return;
        for (std::size_t i = 0, end = program_.rules.count(); i < end; ++i) {
            Rule rule = program_.rules[RuleId(i)];
            if (!rule.linear || rule.initial_fact) continue;
            heads(rule, rule.heads);
            program_.rules[RuleId(i)] = std::move(rule);
        }
    }

  private:
    void heads(const Rule& rule, std::vector<Head>& all) {
        for (Head& h : all) {
            heads(rule, h.heads);
            heads(rule, h.others);
            if (h.kind != Head::Kind::Fact || h.atom.arguments[0].variable == rule.site) continue;
            const Predicate& sent = program_.predicates[h.atom.predicate];
            // Relays give it back where it finds no way.
            if (sent.finds_its_way || sent.begins || !back_.contains(sent.carries.valid() ? sent.carries : h.atom.predicate)) continue;
            h.atom.predicate = out(h.atom.predicate);
            h.atom.arguments.insert(h.atom.arguments.begin(), variable_of(rule, rule.site));
        }
    }

    // The auxiliary for what is about to leave for `p`, made with its two rules on first use.
    PredicateId out(PredicateId p) {
        const auto found = out_.find(p);
        if (found != out_.end()) return found->second;
        const Predicate sent = program_.predicates[p];
        MELD_EXPECT(sent.linear() && neighbor_.valid(), "{} is not sent", sent.name);
        Predicate made;
        made.name = sent.name + "@out";
        made.span = sent.span;
        made.kind = PredicateKind::Linear;
        made.auxiliary = true;
        made.arguments.push_back({Type::Node, ""});
        made.arguments.insert(made.arguments.end(), sent.arguments.begin(), sent.arguments.end());
        const PredicateId id = program_.predicates.add(made);

        MadeRule goes(program_, id, made.name);
        goes.rule.linear = goes.rule.arrives = true;
        goes.rule.body.push_back(link(goes.body));
        goes.head(program_, p, 1);
        goes.add_to(program_);

        MadeRule stays(program_, id, made.name + ".back");
        stays.rule.linear = stays.rule.arrives = true;
        Clause none{.kind = Clause::Kind::Not, .span = sent.span};
        none.inner.push_back(link(stays.body));
        stays.rule.body.push_back(std::move(none));
        stays.rule.heads.push_back(returned(stays, p, sent));
        // What the program asks for, as if it said so itself.
        stays.rule.derives = {stays.rule.heads.back().atom.predicate};
        stays.add_to(program_);
        return out_[p] = id;
    }

    Clause link(const Clause& body) const {
        Clause c;
        c.atom.predicate = neighbor_;
        c.atom.span = c.span = body.span;
        c.atom.arguments = {body.atom.arguments[0], body.atom.arguments[1]};
        return c;
    }

    // For a fact that was on its way: its present catom, its target, and its arguments.
    Head returned(const MadeRule& rule, PredicateId p, const Predicate& sent) const {
        Head h{.kind = Head::Kind::Fact, .span = rule.rule.span};
        h.atom.predicate = back_.at(sent.carries.valid() ? sent.carries : p);
        h.atom.span = rule.rule.span;
        const std::vector<Term>& all = rule.body.atom.arguments;
        h.atom.arguments.push_back(all[0]);
        // After our own catom come the catoms that it was to pass; then its target and its arguments.
        for (std::size_t i = 1 + sent.passes; i + sent.behind < all.size(); ++i) h.atom.arguments.push_back(all[i]);
        MELD_ENSURE(h.atom.arguments.size() == program_.predicates[h.atom.predicate].arguments.size(), "{} comes back as {}", sent.name,
                    program_.predicates[h.atom.predicate].signature());
        return h;
    }

    Program& program_;
    PredicateId neighbor_;
    std::map<PredicateId, PredicateId> back_;  // By what was sent.
    std::map<PredicateId, PredicateId> out_;
};

}  // namespace

void return_undelivered(Program& program) { Undelivered(program).run(); }

}  // namespace meld::desugar
