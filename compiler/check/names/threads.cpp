// Before type names are expanded: facts of threads. The machine of Linear Meld has several threads, among which it divides the nodes, and a
// program may keep facts at them, `type linear cache(thread, int)`. A rule that reads facts of a thread and of a node fires at a node with
// the facts of the thread that runs it. What such a program computes depends on who runs what. Here each node is a thread of its own, which
// is one of the ways in which that machine may run it, and the same in every run:
//     type linear cache(thread, int).    search(A, V), cache(T, V) -o found(A), cache(T, V).
// becomes
//     type linear cache(node, int).      search(A, V), cache(A, V) -o found(A), cache(A, V).
// Where a program keeps such facts, `@threads` and `@cpus` are `@world`, and `cpu-id(A)` is `node2int(A)`. `@host` and `@thread` are the
// node that the rule is about.
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "compiler/check/check.h"
#include "compiler/check/names/each_name.h"

namespace meld::check {

using diagnostics::Kind;

namespace {

constexpr const char* kThread = "thread";

const std::string* variable_name(const syntax::Expr& e) {
    const auto* variable = std::get_if<syntax::Variable>(&e.node);
    return variable == nullptr ? nullptr : &variable->name;
}

class Threads {
  public:
    Threads(syntax::Tree& tree, diagnostics::Reporter& report) : tree_(tree), report_(report) {}

    bool run() {
        if (std::ranges::any_of(tree_.items, declares_type)) return false;
        find_words();
        EachName<Threads> walk(*this);
        for (syntax::Item& item : tree_.items) {
            const auto* d = std::get_if<syntax::Declaration>(&item);
            if (d != nullptr && !d->arguments.empty() && is_thread(d->arguments[0].type)) {
                kept_.emplace(d->name.text, d->arguments.size());
                if (first_ == nullptr) first_ = d;
            }
            if (!std::holds_alternative<syntax::Rule>(item)) walk.item(item);
        }
        for (syntax::Item& item : tree_.items) {
            auto* rule = std::get_if<syntax::Rule>(&item);
            if (rule == nullptr) continue;
            look_at(*rule);
            walk.item(item);
        }
        if (first_ == nullptr) return false;
        report_
            .add(Kind::ThreadFact, first_->name.span,
                 fmt::format("facts of `{}` belong to a thread there, and here each node is a thread of its own", first_->name.text))
            .help = "it is one of the ways in which a machine of Linear Meld with so many threads runs the program; write `node` to say it";
        return true;
    }

    // ---- EachName
    void predicate(const syntax::Name&, std::optional<std::size_t>) {}
    void constant(const std::string&, syntax::Span) {}
    void capital(syntax::Expr& e) {
        auto& name = std::get<syntax::Variable>(e.node).name;
        if (!from_.empty() && name == from_) name = to_;
    }
    void function(std::string& name, syntax::Span) {
        if (first_ != nullptr && (name == "cpu-id" || name == "cpu_id")) name = "node2int";
    }
    void type(syntax::Type& t) {
        if (t.arguments.empty() && t.name == kThread) t.name = "node";
    }
    void expression(syntax::Expr& e) {
        const auto* call = std::get_if<syntax::Call>(&e.node);
        if (call == nullptr || !call->parentheses) return;
        if (first_ != nullptr && (call->name == "@threads" || call->name == "@cpus"))
            e.node = syntax::WorldSize{};
        else if (!place_.empty() && (call->name == "@thread" || call->name == "@host"))
            e.node = syntax::Variable{place_};
    }

  private:
    // Whether the program has a type of this name.
    static bool declares_type(const syntax::Item& item) {
        if (const auto* kind = std::get_if<syntax::NodeKind>(&item)) return kind->name.text == kThread;
        if (const auto* alias = std::get_if<syntax::Alias>(&item)) return alias->name.text == kThread;
        const auto* handle = std::get_if<syntax::Extern>(&item);
        return handle != nullptr && !handle->result && handle->name.text == kThread;
    }
    // The names of the type: `thread`, and those that the program gives it.
    void find_words() {
        words_ = {kThread};
        for (std::size_t known = 0; known != words_.size();) {
            known = words_.size();
            for (const syntax::Item& item : tree_.items)
                if (const auto* alias = std::get_if<syntax::Alias>(&item); alias != nullptr && is_thread(alias->type))
                    words_.insert(alias->name.text);
        }
    }
    bool is_thread(const syntax::Type& type) const { return type.arguments.empty() && words_.contains(type.name); }

    // Which variable of the rule is its thread, and which is its node. With facts of several nodes or threads in the body nobody can say,
    // and the check of places refuses the rule.
    void look_at(const syntax::Rule& rule) {
        threads_.clear();
        nodes_.clear();
        inside_.clear();
        clauses(rule.body);
        heads(rule.head);
        const std::string thread = threads_.size() == 1 ? *threads_.begin() : "", node = nodes_.size() == 1 ? *nodes_.begin() : "";
        const bool joined = !thread.empty() && !node.empty() && !inside_.contains(thread) && !inside_.contains(node);
        from_ = joined ? thread : "";
        to_ = joined ? node : "";
        place_ = !nodes_.empty() ? node : thread;
    }
    void clauses(const std::vector<syntax::Clause>& all) {
        for (const syntax::Clause& c : all) {
            if (const auto* a = std::get_if<syntax::Atom>(&c.node)) atom(*a);
            if (const auto* n = std::get_if<syntax::Not>(&c.node)) clauses(n->clauses);
            if (const auto* b = std::get_if<syntax::BodyAggregate>(&c.node)) clauses(b->clauses);
        }
    }
    void atom(const syntax::Atom& a) {
        const std::string* place = a.arguments.empty() ? nullptr : variable_name(*a.arguments[0]);
        if (place != nullptr) (kept_.contains({a.name.text, a.arguments.size()}) ? threads_ : nodes_).insert(*place);
    }
    void heads(const std::vector<syntax::HeadItem>& all) {
        for (const syntax::HeadItem& h : all) {
            if (const auto* c = std::get_if<syntax::Comprehension>(&h.node)) part(c->variables, c->body, c->head);
            if (const auto* a = std::get_if<syntax::RuleAggregate>(&h.node)) part(a->variables, a->body, a->each);
            if (const auto* e = std::get_if<syntax::Exists>(&h.node)) part(e->variables, {}, e->head);
            if (const auto* i = std::get_if<syntax::HeadIf>(&h.node)) {
                heads(i->then_head);
                heads(i->else_head);
            }
        }
    }
    // A part with variables of its own, whose facts say nothing about the place of the rule.
    void part(const std::vector<syntax::Name>& variables, const std::vector<syntax::Clause>& body,
              const std::vector<syntax::HeadItem>& head) {
        std::set<std::string> threads = threads_, nodes = nodes_;
        clauses(body);
        for (const syntax::Name& v : variables) {
            inside_.insert(v.text);
            threads_.erase(v.text);
            nodes_.erase(v.text);
        }
        threads_.insert(threads.begin(), threads.end());
        nodes_.insert(nodes.begin(), nodes.end());
        heads(head);
    }

    syntax::Tree& tree_;
    diagnostics::Reporter& report_;
    std::set<std::string> words_;
    std::set<std::pair<std::string, std::size_t>> kept_;  // Predicates whose facts belong to threads.
    const syntax::Declaration* first_ = nullptr;          // The first of them.
    // Of the rule: variables that stand for a thread and for a node at the beginning of a fact, and those that belong to its parts.
    std::set<std::string> threads_, nodes_, inside_;
    std::string from_, to_, place_;
};

}  // namespace

bool apply_threads(syntax::Tree& tree, diagnostics::Reporter& report) { return Threads(tree, report).run(); }

}  // namespace meld::check
