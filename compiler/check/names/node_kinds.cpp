// Before type names are expanded: kinds of nodes. `node leaf.` declares a kind, and a node is of it if it stands where a leaf is wanted, in
// a fact of the text or in a rule, itself, in a list or in a constant. A fact of the text for every node, idle(L), of a predicate of leaves
// is one for every leaf:
//     node leaf.  type idle(leaf).  type next(leaf, leaf).     next(@1, @2).  idle(L).
// becomes
//     type leaf@kind(node).     leaf@kind(@1).  leaf@kind(@2).  idle(L) :- leaf@kind(L).
// A named node of two kinds is an error; rules may give nodes several. Nodes that rules make are of the kinds of the facts with which they
// begin. Where the text uses no node as one of a kind, the world has the nodes, and all are of all kinds.
#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "compiler/check/check.h"

namespace meld::check {

using diagnostics::Kind;

namespace {

class NodeKinds {
  public:
    NodeKinds(syntax::Tree& tree, diagnostics::Reporter& report) : tree_(tree), report_(report) {}

    bool run() {
        for (const syntax::Item& item : tree_.items) {
            if (const auto* kind = std::get_if<syntax::NodeKind>(&item)) kinds_.insert(kind->name.text);
            if (const auto* alias = std::get_if<syntax::Alias>(&item)) aliases_.emplace(alias->name.text, &alias->type);
            if (const auto* d = std::get_if<syntax::Declaration>(&item)) declared_.emplace(std::pair(d->name.text, d->arguments.size()), d);
            if (const auto* c = std::get_if<syntax::Constant>(&item)) constants_.emplace(c->name.text, c);
        }
        if (kinds_.empty()) return false;
        for (syntax::Item& item : tree_.items)
            if (auto* rule = std::get_if<syntax::Rule>(&item)) {
                Known known;
                clauses(rule->body, known);
                heads(rule->head, known);
                if (!is_axiom(*rule)) continue;
                for (const syntax::HeadItem& h : rule->head)
                    if (const std::optional<std::string> kind = open_at(h)) wanted_.insert(*kind);
            }
        if (nodes_.empty()) return true;
        for (const Birth& birth : births_) begin(birth);
        for (std::size_t i = 0; i < tree_.items.size(); ++i)
            if (auto* rule = std::get_if<syntax::Rule>(&tree_.items[i]); rule != nullptr && is_axiom(*rule)) guard(*rule, i);
        declare();
        return true;
    }

  private:
    struct Use {
        std::string kind;
        Span span;
    };
    using Known = std::map<std::string, std::set<std::string>>;  // The kinds of the variables of a rule, by name.
    struct Birth {
        syntax::Exists* made;
        Known known;
    };

    // The kind that a type names, if it is one.
    std::optional<std::string> kind_of(const syntax::Type& type) const {
        const syntax::Type* t = &type;
        for (std::size_t steps = 0; steps <= aliases_.size() && t->arguments.empty(); ++steps) {
            if (kinds_.contains(t->name)) return t->name;
            const auto alias = aliases_.find(t->name);
            if (alias == aliases_.end()) return std::nullopt;
            t = alias->second;
        }
        return std::nullopt;
    }
    // A name for a type with parts, such as `type list leaf tree.`
    const syntax::Type& meant(const syntax::Type& type) const {
        const syntax::Type* t = &type;
        for (std::size_t steps = 0; steps <= aliases_.size() && t->arguments.empty(); ++steps) {
            const auto alias = aliases_.find(t->name);
            if (alias == aliases_.end()) break;
            t = alias->second;
        }
        return *t;
    }

    void named(std::int64_t node, const std::string& kind, Span span) {
        const auto [at, fresh] = nodes_.emplace(node, Use{kind, span});
        if (fresh || at->second.kind == kind) return;
        auto& d =
            report_.add(Kind::TypeMismatch, span, fmt::format("`@{}` is a `{}` here, and a `{}` elsewhere", node, kind, at->second.kind));
        d.labels = {{at->second.span, fmt::format("a `{}` here", at->second.kind)}};
        d.help = "the text names a node as one kind only; where any node will do, declare the argument as `node`";
    }

    void value(const syntax::Expr& e, const syntax::Type& type, Known& known) {
        if (const std::optional<std::string> kind = kind_of(type)) {
            if (const auto* node = std::get_if<syntax::CatomLiteral>(&e.node)) named(node->id, *kind, e.span);
            if (const auto* variable = std::get_if<syntax::Variable>(&e.node)) known[variable->name].insert(*kind);
        }
        if (const auto* choice = std::get_if<syntax::Conditional>(&e.node)) {
            value(*choice->then_value, type, known);
            value(*choice->else_value, type, known);
        }
        if (const auto* named = std::get_if<syntax::Call>(&e.node); named != nullptr && !named->parentheses) {
            const auto constant = constants_.find(named->name);
            if (constant == constants_.end() || !inside_.insert(named->name).second) return;
            if (constant->second->value != nullptr) value(*constant->second->value, type, known);
            inside_.erase(named->name);
        }
        const syntax::Type& whole = meant(type);
        const auto* list = std::get_if<syntax::ListValue>(&e.node);
        if (list != nullptr && whole.arguments.size() == 1) {
            for (const syntax::ExprPtr& element : list->elements) value(*element, whole.arguments[0], known);
            if (list->rest != nullptr) value(*list->rest, whole, known);
        }
        const auto* record = std::get_if<syntax::StructValue>(&e.node);
        const auto* tuple = std::get_if<syntax::TupleValue>(&e.node);
        if (record == nullptr && tuple == nullptr) return;
        const std::vector<syntax::ExprPtr>& fields = record != nullptr ? record->fields : tuple->fields;
        for (std::size_t i = 0; i < fields.size() && fields.size() == whole.arguments.size(); ++i)
            value(*fields[i], whole.arguments[i], known);
    }

    const syntax::Declaration* declaration_of(const syntax::Atom& a) const {
        const auto found = declared_.find({a.name.text, a.arguments.size()});
        return found == declared_.end() ? nullptr : found->second;
    }
    void atom(const syntax::Atom& a, Known& known) {
        const syntax::Declaration* d = declaration_of(a);
        for (std::size_t i = 0; d != nullptr && i < a.arguments.size(); ++i) {
            const std::string& aggregate = d->arguments[i].aggregate;
            // What is counted has any type.
            if (aggregate != "count") value(*a.arguments[i], d->arguments[i].type, known);
        }
    }

    // What is inside of a part has variables of its own beside those outside.
    void clauses(const std::vector<syntax::Clause>& all, Known& known) {
        for (const syntax::Clause& c : all) {
            Known inner = known;
            if (const auto* a = std::get_if<syntax::Atom>(&c.node)) atom(*a, known);
            if (const auto* n = std::get_if<syntax::Not>(&c.node)) clauses(n->clauses, inner);
            if (const auto* d = std::get_if<syntax::Delta>(&c.node)) atom(d->atom, known);
            if (const auto* b = std::get_if<syntax::BodyAggregate>(&c.node)) clauses(b->clauses, inner);
            if (const auto* f = std::get_if<syntax::Forall>(&c.node)) {
                atom(f->atom, inner);
                clauses(f->clauses, inner);
            }
        }
    }
    void heads(std::vector<syntax::HeadItem>& all, Known& known) {
        for (syntax::HeadItem& h : all)
            if (const auto* fact = std::get_if<syntax::HeadFact>(&h.node)) atom(fact->atom, known);
        for (syntax::HeadItem& h : all) {
            Known inner = known;
            if (auto* c = std::get_if<syntax::Comprehension>(&h.node)) {
                clauses(c->body, inner);
                heads(c->head, inner);
            }
            if (auto* a = std::get_if<syntax::RuleAggregate>(&h.node)) {
                clauses(a->body, inner);
                heads(a->each, inner);
                heads(a->result, known);
            }
            if (auto* i = std::get_if<syntax::HeadIf>(&h.node)) {
                heads(i->then_head, known);
                heads(i->else_head, known);
            }
            if (auto* e = std::get_if<syntax::Exists>(&h.node)) {
                for (const syntax::Name& v : e->variables) inner.erase(v.text);
                heads(e->head, inner);
                births_.push_back({e, std::move(inner)});
            }
        }
    }
    // A node that a rule makes is of its kinds from the start.
    void begin(const Birth& birth) {
        for (const syntax::Name& v : birth.made->variables) {
            const auto kinds = birth.known.find(v.text);
            if (kinds == birth.known.end()) continue;
            for (const std::string& kind : kinds->second)
                if (wanted_.contains(kind))
                    birth.made->head.push_back({syntax::HeadFact{of_kind(kind, syntax::Variable{v.text}, v.span), std::nullopt}, v.span});
        }
    }

    static bool is_axiom(const syntax::Rule& rule) {
        return !rule.selector &&
               std::ranges::all_of(rule.body, [](const syntax::Clause& c) { return std::holds_alternative<syntax::Constraint>(c.node); });
    }
    // The kind of the nodes at which a head of an axiom holds, where that is left open.
    std::optional<std::string> open_at(const syntax::HeadItem& item) const {
        const auto* fact = std::get_if<syntax::HeadFact>(&item.node);
        const syntax::Declaration* d = fact == nullptr ? nullptr : declaration_of(fact->atom);
        if (d == nullptr || d->arguments.empty()) return std::nullopt;
        const syntax::Expr& place = *fact->atom.arguments[0];
        const auto* bare = std::get_if<syntax::Call>(&place.node);
        const bool lower_case = bare != nullptr && !bare->parentheses && !constants_.contains(bare->name);
        const bool open =
            lower_case || std::holds_alternative<syntax::Variable>(place.node) || std::holds_alternative<syntax::Anonymous>(place.node);
        return open ? kind_of(d->arguments[0].type) : std::nullopt;
    }
    // Each head of a kind gets a rule of its own; other heads of the same axiom stay.
    void guard(syntax::Rule& rule, std::size_t item) {
        if (!rule.body.empty() && rule.head.size() > 1) return guard_together(rule);
        std::vector<syntax::HeadItem> rest;
        for (syntax::HeadItem& h : rule.head) {
            const std::optional<std::string> kind = open_at(h);
            if (!kind) {
                rest.push_back(std::move(h));
                continue;
            }
            syntax::Rule one;
            one.arrow = syntax::Arrow::View;
            one.span = rule.span;
            one.body = std::move(rule.body);
            one.body.push_back(guarded_by(*kind, place_of(h)));
            one.head.push_back(std::move(h));
            rule.body.clear();
            made_.emplace_back(std::move(one), tree_.unit_of[item]);
        }
        if (rest.empty()) rest.push_back({syntax::Nothing{}, {rule.span.file, rule.span.end, rule.span.end}});
        rule.head = std::move(rest);
    }
    // Under a condition all heads are of one kind.
    void guard_together(syntax::Rule& rule) {
        const std::optional<std::string> kind = open_at(rule.head.front());
        const bool alike = std::ranges::all_of(rule.head, [&](syntax::HeadItem& h) {
            return open_at(h) == kind && (!kind || written(place_of(h)) == written(place_of(rule.head.front())));
        });
        if (!alike) {
            report_.add(Kind::TypeMismatch, rule.span, "facts for nodes of several kinds stand under one condition").help =
                "write a fact of its own for each";
            return;
        }
        if (kind) rule.body.push_back(guarded_by(*kind, place_of(rule.head.front())));
        if (kind) rule.arrow = syntax::Arrow::View;
    }
    static syntax::Expr& place_of(syntax::HeadItem& h) { return *std::get<syntax::HeadFact>(h.node).atom.arguments[0]; }
    // The name of an open place.
    static std::string written(const syntax::Expr& place) {
        if (const auto* bare = std::get_if<syntax::Call>(&place.node)) return bare->name;
        const auto* variable = std::get_if<syntax::Variable>(&place.node);
        return variable != nullptr ? variable->name : "";
    }
    static syntax::Clause guarded_by(const std::string& kind, syntax::Expr& place) {
        if (std::holds_alternative<syntax::Anonymous>(place.node)) place.node = syntax::Variable{"Node"};
        const auto* bare = std::get_if<syntax::Call>(&place.node);
        return {bare != nullptr ? of_kind(kind, syntax::Call{bare->name, {}, false}, place.span)
                                : of_kind(kind, std::get<syntax::Variable>(place.node), place.span),
                place.span};
    }

    template <class Node>
    static syntax::Atom of_kind(const std::string& kind, Node node, Span span) {
        syntax::Atom atom{.sigil = syntax::Sigil::None, .name = {kind + "@kind", span}, .arguments = {}, .span = span};
        atom.arguments.push_back(std::make_unique<syntax::Expr>(syntax::Expr{std::move(node), span}));
        return atom;
    }
    // The predicates of kinds, the nodes that the text names, and the axioms, before all other rules.
    void declare() {
        std::vector<std::pair<syntax::Item, std::uint32_t>> all;
        for (std::size_t i = 0; i < tree_.items.size(); ++i) {
            const auto* kind = std::get_if<syntax::NodeKind>(&tree_.items[i]);
            if (kind == nullptr || !wanted_.contains(kind->name.text)) continue;
            syntax::Argument node;
            node.type = {"node", {}, kind->name.span};
            node.span = kind->name.span;
            syntax::Declaration d{.modifiers = {},
                                  .name = {kind->name.text + "@kind", kind->name.span},
                                  .arguments = {},
                                  .repeats = false,
                                  .span = kind->span};
            d.arguments.push_back(std::move(node));
            all.emplace_back(std::move(d), tree_.unit_of[i]);
            for (const auto& [id, use] : nodes_) {
                if (use.kind != kind->name.text) continue;
                syntax::Rule fact;
                fact.arrow = syntax::Arrow::Axiom;
                fact.span = use.span;
                fact.head.push_back({syntax::HeadFact{of_kind(use.kind, syntax::CatomLiteral{id}, use.span), std::nullopt}, use.span});
                all.emplace_back(std::move(fact), tree_.unit_of[i]);
            }
        }
        for (auto& one : made_) all.push_back(std::move(one));
        std::vector<syntax::Item> items;
        std::vector<std::uint32_t> unit_of;
        const auto rule =
            std::ranges::find_if(tree_.items, [](const syntax::Item& item) { return std::holds_alternative<syntax::Rule>(item); });
        const auto first = static_cast<std::size_t>(rule - tree_.items.begin());
        for (std::size_t i = 0; i <= tree_.items.size(); ++i) {
            if (i == first)
                for (auto& [item, unit] : all) {
                    items.push_back(std::move(item));
                    unit_of.push_back(unit);
                }
            if (i == tree_.items.size()) break;
            items.push_back(std::move(tree_.items[i]));
            unit_of.push_back(tree_.unit_of[i]);
        }
        tree_.items = std::move(items);
        tree_.unit_of = std::move(unit_of);
    }

    syntax::Tree& tree_;
    diagnostics::Reporter& report_;
    std::set<std::string> kinds_;
    std::map<std::string, const syntax::Type*> aliases_;
    std::map<std::pair<std::string, std::size_t>, const syntax::Declaration*> declared_;
    std::map<std::string, const syntax::Constant*> constants_;
    std::set<std::string> inside_;       // Constants whose values are being looked into.
    std::map<std::int64_t, Use> nodes_;  // The kinds of named nodes.
    std::set<std::string> wanted_;       // Kinds of axioms that leave their node open.
    std::vector<Birth> births_;
    std::vector<std::pair<syntax::Item, std::uint32_t>> made_;
};

}  // namespace

bool apply_node_kinds(syntax::Tree& tree, diagnostics::Reporter& report) { return NodeKinds(tree, report).run(); }

}  // namespace meld::check
