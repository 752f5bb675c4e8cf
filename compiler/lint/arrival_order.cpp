// Two kinds of messages of one link whose order decides what happens, though those that arrive in one tick have none:
//     marker(A, B), open(A, B, S) -o under-way(A, B, S).
//     payment(A, B, X), open(A, B, S) -o open(A, B, S + X).
// A message is a linear fact that rules send to another catom with the sender in an argument. One kind changes for good what is known of
// the link, a fact with both catoms in it; a rule that takes the other kind depends on it. Rules that take messages by a number, which a
// fact of the link tells them, have their order.
#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "compiler/lint/lint.h"

namespace meld::lint {

using namespace check;
using diagnostics::Kind;

namespace {

// A rule that takes a message, and the catom it comes from.
struct Taking {
    const Rule* rule = nullptr;
    const Atom* message = nullptr;
    VariableId from;
};

bool mentions(const Atom& atom, VariableId v) {
    return std::any_of(atom.arguments.begin() + 1, atom.arguments.end(), [&](const Term& t) { return t.is_variable() && t.variable == v; });
}

class ArrivalOrder {
  public:
    ArrivalOrder(const Program& program, diagnostics::Reporter& report) : program_(program), report_(report) {}

    void run() {
        for (const Rule& rule : program_.rules)
            if (rule.linear && !rule.initial_fact) find_senders(rule);
        std::vector<Taking> all;
        for (const Rule& rule : program_.rules)
            if (rule.linear && !rule.initial_fact) find_taking(rule, all);
        std::set<std::pair<PredicateId, PredicateId>> warned;
        for (const Taking& first : all)
            for (const Taking& second : all) {
                const auto [less, greater] = std::minmax(first.message->predicate, second.message->predicate);
                if (less == greater || warned.contains({less, greater}) || numbered(first, second)) continue;
                const Atom* changed = decides(first, second, all);
                if (changed == nullptr) continue;
                warned.insert({less, greater});
                warn(first, second, *changed);
            }
    }

  private:
    void find_senders(const Rule& rule) {
        each_head(rule.heads, [&](const Head& h) {
            if (h.kind != Head::Kind::Fact || !program_.predicates[h.atom.predicate].linear()) return;
            if (h.atom.arguments[0].variable == rule.site) return;
            for (std::size_t i = 1; i < h.atom.arguments.size(); ++i)
                if (h.atom.arguments[i].is_variable() && h.atom.arguments[i].variable == rule.site) senders_[h.atom.predicate].insert(i);
        });
    }
    void find_taking(const Rule& rule, std::vector<Taking>& all) const {
        for (const Clause& c : rule.body) {
            if (c.kind != Clause::Kind::Atom || c.atom.read_only) continue;
            const auto sender = senders_.find(c.atom.predicate);
            if (sender == senders_.end()) continue;
            for (const std::size_t i : sender->second)
                if (c.atom.arguments[i].is_variable() && c.atom.arguments[i].variable != rule.site)
                    all.push_back({&rule, &c.atom, c.atom.arguments[i].variable});
        }
    }

    // Whether a fact is about the link that the message came over.
    static bool of_link(const Taking& t, const Atom& a) {
        return &a != t.message && a.arguments[0].variable == t.rule->site && mentions(a, t.from);
    }
    // A fact of the link in a body; negated ones only if asked for.
    static const Atom* in_body(const Taking& t, PredicateId p, bool negated) {
        const Atom* found = nullptr;
        each_atom(t.rule->body, [&](const Atom& a, bool negative) {
            if (a.predicate == p && negative == negated && of_link(t, a)) found = &a;
        });
        return found;
    }
    static const Atom* in_heads(const Taking& t, PredicateId p) {
        const Atom* found = nullptr;
        each_head(t.rule->heads, [&](const Head& h) {
            if (h.kind == Head::Kind::Fact && h.atom.predicate == p && of_link(t, h.atom)) found = &h.atom;
        });
        return found;
    }

    // The linear facts of the link that share an int with the message.
    std::set<PredicateId> counters(const Taking& t) const {
        std::set<PredicateId> found;
        each_atom(t.rule->body, [&](const Atom& a, bool negative) {
            if (negative || !program_.predicates[a.predicate].linear() || !of_link(t, a)) return;
            for (const Term& number : t.message->arguments)
                if (number.is_variable() && number.type == Type::Int && mentions(a, number.variable)) found.insert(a.predicate);
        });
        return found;
    }
    bool numbered(const Taking& first, const Taking& second) const {
        const std::set<PredicateId> one = counters(first), other = counters(second);
        return std::ranges::any_of(one, [&](PredicateId p) { return other.contains(p); });
    }

    // The fact of the link that taking `first` changes for good, and on which taking `second` depends.
    const Atom* decides(const Taking& first, const Taking& second, const std::vector<Taking>& all) const {
        for (const PredicateId p : program_.predicates.ids()) {
            const Predicate& predicate = program_.predicates[p];
            if (senders_.contains(p) || predicate.world != WorldSource::None) continue;
            const Atom *taken = predicate.linear() ? in_body(first, p, false) : nullptr, *made = in_heads(first, p);
            const bool asks = in_body(second, p, true) != nullptr, reads = in_body(second, p, false) != nullptr;
            if (taken != nullptr && !taken->read_only && made == nullptr && (asks || (reads && keeps(second, p)))) return taken;
            // A linear fact that one message makes and the other uses up is a question, or the state between two steps.
            const bool decided = reads && !predicate.linear() && goes_without(second, p, all);
            if (made != nullptr && taken == nullptr && (asks || decided)) return made;
        }
        return nullptr;
    }
    // Of two rules that both use the fact up, the first to come has it, as it should be of two answers to one question.
    static bool keeps(const Taking& t, PredicateId p) {
        const Atom* read = in_body(t, p, false);
        return in_heads(t, p) != nullptr || (read != nullptr && read->read_only);
    }
    // Whether such a message is also taken where the fact is not there; otherwise it waits for it.
    static bool goes_without(const Taking& t, PredicateId p, const std::vector<Taking>& all) {
        return std::ranges::any_of(all, [&](const Taking& other) {
            return other.rule != t.rule && other.message->predicate == t.message->predicate && in_body(other, p, false) == nullptr;
        });
    }

    void warn(const Taking& first, const Taking& second, const Atom& changed) {
        const auto name = [&](const Atom& a) { return "`" + program_.predicates[a.predicate].name + "`"; };
        auto& d = report_.add(Kind::ArrivalOrder, first.message->span,
                              fmt::format("{} and {} may arrive over one link in one tick, and then have no order", name(*first.message),
                                          name(*second.message)));
        d.labels = {{changed.span, fmt::format("this changes what is known of the link")},
                    {second.message->span, fmt::format("what becomes of {} depends on {}", name(*second.message), name(changed))}};
        d.help = "number what is sent over a link, and take it by its number, or send both kinds by the library `fifo`";
    }

    const Program& program_;
    diagnostics::Reporter& report_;
    std::map<PredicateId, std::set<std::size_t>> senders_;  // Of messages: the arguments that name the sender.
};

}  // namespace

void warn_of_arrival_order(const Program& program, diagnostics::Reporter& report) { ArrivalOrder(program, report).run(); }

}  // namespace meld::lint
