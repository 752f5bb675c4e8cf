// Before type names are expanded: kinds of nodes. `node leaf.` declares a kind, and a node is of it if it stands where a leaf is wanted, in
// a fact of the text or in a rule, itself, in a list or in a constant. A fact of the text for every node, idle(L), of a predicate of leaves
// is one for every leaf:
//     node leaf.  type idle(leaf).  type next(leaf, leaf).     next(@1, @2).  idle(L).
// becomes
//     type leaf@kind(node).     leaf@kind(@1).  leaf@kind(@2).  idle(L) :- leaf@kind(L).
// A node or a variable of two kinds is an error. Nodes that rules make are of the kind of the facts with which they begin.
#include <algorithm>
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
        for (std::size_t i = 0; i < tree_.items.size(); ++i)
            if (auto* rule = std::get_if<syntax::Rule>(&tree_.items[i])) {
                Known known;
                clauses(rule->body, known);
                heads(rule->head, known);
                if (is_axiom(*rule)) guard(*rule, i);
            }
        declare();
        return true;
    }

  private:
    struct Use {
        std::string kind;
        Span span;
    };
    using Known = std::map<std::string, Use>;  // The kinds of the variables of a rule, by name.

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

    void of_kind(std::map<std::string, Use>& known, const std::string& name, const std::string& kind, Span span) {
        const auto [at, fresh] = known.emplace(name, Use{kind, span});
        if (fresh || at->second.kind == kind) return;
        auto& d =
            report_.add(Kind::TypeMismatch, span, fmt::format("`{}` is a `{}` here, and a `{}` elsewhere", name, kind, at->second.kind));
        d.labels = {{at->second.span, fmt::format("a `{}` here", at->second.kind)}};
        d.help = "a node is of one kind; where any node will do, declare the argument as `node`";
    }

    void value(const syntax::Expr& e, const syntax::Type& type, Known& known) {
        if (const std::optional<std::string> kind = kind_of(type)) {
            if (const auto* node = std::get_if<syntax::CatomLiteral>(&e.node)) of_kind(nodes_, fmt::format("@{}", node->id), *kind, e.span);
            if (const auto* variable = std::get_if<syntax::Variable>(&e.node)) of_kind(known, variable->name, *kind, e.span);
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
                begin(*e, inner);
            }
        }
    }
    // A node that a rule makes is of a kind from the start.
    void begin(syntax::Exists& exists, const Known& known) {
        for (const syntax::Name& v : exists.variables) {
            const auto kind = known.find(v.text);
            if (kind == known.end()) continue;
            begun_.insert(kind->second.kind);
            exists.head.push_back({syntax::HeadFact{of_kind(kind->second.kind, syntax::Variable{v.text}, v.span), std::nullopt}, v.span});
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
        std::vector<syntax::HeadItem> rest;
        for (syntax::HeadItem& h : rule.head) {
            const std::optional<std::string> kind = open_at(h);
            if (!kind || (!rule.body.empty() && rule.head.size() > 1)) {
                rest.push_back(std::move(h));
                continue;
            }
            guarded_.insert(*kind);
            syntax::Expr& place = *std::get<syntax::HeadFact>(h.node).atom.arguments[0];
            if (std::holds_alternative<syntax::Anonymous>(place.node)) place.node = syntax::Variable{"Node"};
            syntax::Rule one;
            one.arrow = syntax::Arrow::View;
            one.span = rule.span;
            one.body = std::move(rule.body);
            const Span span = place.span;
            const auto* bare = std::get_if<syntax::Call>(&place.node);
            one.body.push_back({bare != nullptr ? of_kind(*kind, syntax::Call{bare->name, {}, false}, span)
                                                : of_kind(*kind, std::get<syntax::Variable>(place.node), span),
                                span});
            one.head.push_back(std::move(h));
            rule.body.clear();
            made_.emplace_back(std::move(one), tree_.unit_of[item]);
        }
        if (rest.empty()) rest.push_back({syntax::Nothing{}, {rule.span.file, rule.span.end, rule.span.end}});
        rule.head = std::move(rest);
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
            if (kind == nullptr || !(guarded_.contains(kind->name.text) || begun_.contains(kind->name.text))) continue;
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
            for (const auto& [name, use] : nodes_) {
                if (use.kind != kind->name.text) continue;
                syntax::Rule fact;
                fact.arrow = syntax::Arrow::Axiom;
                fact.span = use.span;
                fact.head.push_back(
                    {syntax::HeadFact{of_kind(use.kind, syntax::CatomLiteral{std::stoll(name.substr(1))}, use.span), std::nullopt},
                     use.span});
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
    std::set<std::string> inside_;           // Constants whose values are being looked into.
    std::map<std::string, Use> nodes_;       // The kinds of named nodes, by "@7".
    std::set<std::string> guarded_, begun_;  // Kinds of open axioms, and of nodes that rules make.
    std::vector<std::pair<syntax::Item, std::uint32_t>> made_;
};

}  // namespace

bool apply_node_kinds(syntax::Tree& tree, diagnostics::Reporter& report) { return NodeKinds(tree, report).run(); }

}  // namespace meld::check
