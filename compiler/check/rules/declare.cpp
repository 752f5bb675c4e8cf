// Pass 1: predicates and constants from declarations.
// Assumes expand_type_names(); leaves every declared name in the tables, with Type::Error where its type was refused.
#include <algorithm>
#include <map>

#include "compiler/check/check.h"
#include "compiler/check/names/later_fixes.h"
#include "compiler/check/program/library.h"
#include "compiler/check/program/types.h"
#include "compiler/check/rules/priorities.h"
#include "runtime/module/abi/actions.h"
#include "runtime/module/abi/senses.h"

namespace meld::check {

using diagnostics::Kind;
using Fit = diagnostics::Edit::Fit;

namespace {

// Whether only some worlds know the name: those of bodies, of amoebots, of nodes with a range, or those that name their moves.
bool of_some_worlds(const std::string& name) {
    using Performer = ActionInfo::Performer;
    if (is_body_sense(name) || is_amoebot_sense(name) || is_range_sense(name) || is_move_sense(name)) return true;
    return std::ranges::any_of(known_actions(), [&](const ActionInfo& action) {
        return action.word == name && (action.performer == Performer::Bodies || action.performer == Performer::Amoebots ||
                                       action.performer == Performer::Points || action.has(ActionInfo::kByTable));
    });
}

class Declarer {
  public:
    Declarer(const syntax::Tree& tree, std::uint32_t prelude_files, Program& program, diagnostics::Reporter& report)
        : tree_(tree), prelude_files_(prelude_files), program_(program), report_(report) {}

    void run() {
        for (const syntax::Item& item : tree_.items)
            if (const auto* handle = std::get_if<syntax::Extern>(&item); handle != nullptr && !handle->result)
                types_.emplace(handle->name.text, Type::Int);
        for (const syntax::Item& item : tree_.items) std::visit([&](const auto& it) { declare(it); }, item);
    }

  private:
    // ---- predicates

    void declare(const syntax::Declaration& d) {
        const std::size_t errors = report_.error_count();
        Predicate p;
        p.name = d.name.text;
        p.span = d.name.span;
        p.declaration = d.span;
        p.prelude = d.span.file < prelude_files_;
        p.repeats = d.repeats;
        // No program can write such a name: expand_stable() did.
        p.auxiliary = p.name.find('@') != std::string::npos;
        modifiers(d, p);
        for (const syntax::Argument& a : d.arguments)
            p.arguments.push_back({to_type(a.type, types_, tree_, report_), a.name ? a.name->text : ""});
        ignore_route(d, p);
        check_shape(d, p);
        p.refused = report_.error_count() > errors;
        add(d, std::move(p));
    }

    void modifiers(const syntax::Declaration& d, Predicate& p) {
        const syntax::Name* kind = nullptr;
        for (const syntax::Name& m : d.modifiers) {
            if (m.text == "route") {
                p.route = true;
            } else if (m.text == "sensed") {
                p.sensed = true;
            } else if (m.text == "neighbor") {
                // A link of the program's own, as `neighbor` is the world's.
                p.route = true;
            } else if (m.text == "virtual") {
                auto& ignored = report_.add(Kind::HintIgnored, m.span, "`virtual` has no effect here");
                ignored.help = "a link is followed only while its two catoms touch, whoever makes it";
                ignored.fixes = {safe(diagnostics::leave_out(m.span, "`virtual`", Fit::Word))};
            } else if (m.text == "linear" || m.text == "action" || m.text == "persistent") {
                if (kind != nullptr && kind->text != m.text) {
                    auto& both =
                        report_.add(Kind::BadModifiers, m.span, fmt::format("`{}` is declared both {} and {}", p.name, kind->text, m.text));
                    both.labels = {{kind->span, "declared here as " + kind->text}};
                    for (const syntax::Name* one : {&m, kind})
                        both.fixes.push_back(diagnostics::leave_out(one->span, fmt::format("`{}`", one->text), Fit::Word));
                }
                kind = &m;
                p.kind = m.text == "linear"   ? PredicateKind::Linear
                         : m.text == "action" ? PredicateKind::Action
                                              : PredicateKind::Persistent;
            } else {
                auto& unknown = report_.add(Kind::BadModifiers, m.span, fmt::format("`{}` is not a modifier", m.text));
                unknown.help = "modifiers are route, neighbor, linear, action, sensed, persistent and virtual";
                const std::string near =
                    diagnostics::nearest_name(m.text, {"route", "neighbor", "linear", "action", "sensed", "persistent"});
                if (!near.empty()) unknown.fixes.push_back(diagnostics::write(m.span, near));
                unknown.fixes.push_back(diagnostics::leave_out(m.span, fmt::format("`{}`", m.text), Fit::Word));
            }
        }
        if (p.sensed && p.kind == PredicateKind::Action)
            leave_out(d, "sensed",
                      report_.add(Kind::BadModifiers, d.name.span, fmt::format("`{}` cannot be both sensed and an action", p.name)));
        if (p.sensed && p.kind == PredicateKind::Persistent) p.kind = PredicateKind::Sensed;
        if (p.repeats && p.kind != PredicateKind::Action) {
            auto& lasting =
                report_.add(Kind::BadModifiers, d.name.span, fmt::format("`while` is for actions, and `{}` is not an action", p.name));
            lasting.help = fmt::format("write `type action {}(...) while.`", p.name);
            lasting.fixes = {kind == nullptr ? diagnostics::insert(d.name.span, "action ") : diagnostics::write(kind->span, "action")};
        }
    }

    // The fix that leaves out this modifier.
    static void leave_out(const syntax::Declaration& d, std::string_view modifier, diagnostics::Diagnostic& message) {
        for (const syntax::Name& m : d.modifiers)
            if (m.text == modifier) message.fixes.push_back(diagnostics::leave_out(m.span, fmt::format("`{}`", modifier), Fit::Word));
    }

    // Linear facts go to catoms that a rule knows by value wherever these can be reached, so a linear predicate that only names catoms
    // need not be a route, as Linear Meld wants it.
    void ignore_route(const syntax::Declaration& d, Predicate& p) {
        if (!p.route || !p.linear() || p.arguments.size() < 3 || p.arguments[1].type == Type::Node || p.arguments[1].type == Type::Error)
            return;
        p.route = false;
        for (const syntax::Name& m : d.modifiers) {
            if (m.text != "route") continue;
            auto& ignored = report_.add(Kind::HintIgnored, m.span, "`route` has no effect here");
            ignored.help = fmt::format("the second argument of `{}` is not the catom that it points to", p.name);
            ignored.fixes = {safe(diagnostics::leave_out(m.span, "`route`", Fit::Word))};
        }
    }

    void check_shape(const syntax::Declaration& d, const Predicate& p) {
        const bool first_ok = !p.arguments.empty() && (p.arguments[0].type == Type::Node || p.arguments[0].type == Type::Error);
        if (!first_ok)
            report_
                .add(Kind::FirstArgumentNotNode, d.arguments.empty() ? d.name.span : d.arguments[0].span,
                     fmt::format("the first argument of `{}` must be the catom where the fact lives", p.name))
                .help = fmt::format("write `{}(node{})`", p.name, d.arguments.size() > 1 ? ", ..." : "");
        if (p.route && (p.arguments.size() < 2 || (p.arguments[1].type != Type::Node && p.arguments[1].type != Type::Error))) {
            auto& second = report_.add(Kind::RouteSecondNotNode, d.name.span,
                                       fmt::format("the second argument of the route `{}` must be the catom it points to", p.name));
            second.help = fmt::format("write `{}`{}, or leave out `route`", route_declaration(p),
                                      p.arguments.size() > 1 ? ", with the arguments in this order wherever it is used" : "");
            leave_out(d, "route", second);
        }
    }

    // With the first of the other catoms second, or with one more.
    static std::string route_declaration(const Predicate& p) {
        std::string types = "node, node";
        bool moved = false;
        for (std::size_t i = 1; i < p.arguments.size(); ++i) {
            if (!moved && p.arguments[i].type == Type::Node)
                moved = true;
            else
                types += ", " + type_name(p.arguments[i].type);
        }
        return fmt::format("type {}route {}({})", p.linear() ? "linear " : p.kind == PredicateKind::Action ? "action " : "", p.name, types);
    }

    void add(const syntax::Declaration& d, Predicate p) {
        const auto key = std::pair(p.name, p.arguments.size());
        const auto found = names_.find(key);
        if (found == names_.end()) {
            if (!p.prelude && !p.refused) refuse_other_form(d, p);
            names_.emplace(key, program_.predicates.add(std::move(p)));
            return;
        }
        Predicate& before = program_.predicates[found->second];
        if (!before.prelude || p.prelude) {
            auto& twice = report_.add(Kind::DuplicateDeclaration, d.name.span, fmt::format("`{}` is declared twice", p.signature()));
            twice.labels = {{before.span, "first declared here"}};
            twice.help = "leave out one of the two";
            twice.fixes = {diagnostics::leave_out(d.span, "this declaration", Fit::Item)};
            return;
        }
        const bool same_types = std::equal(p.arguments.begin(), p.arguments.end(), before.arguments.begin(), before.arguments.end(),
                                           [](const Argument& a, const Argument& b) { return a.type == b.type || a.type == Type::Error; });
        const bool same =
            same_types && p.linear() == before.linear() && (p.kind == PredicateKind::Action) == (before.kind == PredicateKind::Action);
        // The runtime's names are common words: a program may mean its own predicate by `at(node, int, int, int)` or by `linear
        // watch(node)`, and one that also states facts of it, `neighbor(@0, @1).`, brings a world of its own. But an action without the
        // keyword is more likely an oversight. A program that means one of bodies or amoebots writes `sensed` or `action`.
        const bool other_words =
            (!same && (!same_types || p.linear())) || of_some_worlds(p.name) || (same && before.sensed && is_stated(d, p.arguments.size()));
        if (other_words && !p.sensed && p.kind != PredicateKind::Action) {
            if (before.sensed) p.hides = {before.span, form(before)};
            before = std::move(p);
            return;
        }
        if (!same) {
            before.refused = true;
            in_form_of(before, d, fmt::format("the runtime knows `{}` in another form", p.signature()));
            return;
        }
        before.repeats = before.repeats || p.repeats;
        before.route = before.route || p.route;
        before.repeated = true;
    }

    // Whether the text states a fact of a declared predicate, as an axiom.
    bool is_stated(const syntax::Declaration& d, std::size_t arguments) const {
        return std::ranges::any_of(tree_.items, [&](const syntax::Item& item) {
            const auto* rule = std::get_if<syntax::Rule>(&item);
            return rule != nullptr && rule->body.empty() && std::ranges::any_of(rule->head, [&](const syntax::HeadItem& head) {
                       const auto* fact = std::get_if<syntax::HeadFact>(&head.node);
                       return fact != nullptr && fact->atom.name.text == d.name.text && fact->atom.arguments.size() == arguments;
                   });
        });
    }

    // A predicate of the prelude declared with another number of arguments is a mistake, not a new predicate.
    void refuse_other_form(const syntax::Declaration& d, Predicate& p) {
        if (!p.sensed && p.kind != PredicateKind::Action) return;
        for (const Predicate& known : program_.predicates)
            if (known.prelude && known.name == p.name) {
                in_form_of(known, d, fmt::format("the runtime does not know `{}` with {} arguments", p.name, p.arguments.size()));
                p.refused = true;
                return;
            }
    }

    void in_form_of(const Predicate& known, const syntax::Declaration& d, std::string message) {
        auto& other = report_.add(Kind::SensedMismatch, d.name.span, std::move(message));
        other.help = "write `" + form(known) + "`";
        other.fixes = {diagnostics::write(d.span, without_stop(form(known))),
                       diagnostics::leave_out(d.span, "this declaration, which the prelude has", Fit::Item)};
    }
    static std::string form(const Predicate& p) {
        std::string text = "type ";
        if (p.kind == PredicateKind::Action) text += "action ";
        if (p.linear()) text += "linear ";
        if (p.sensed) text += "sensed ";
        if (p.route) text += "route ";
        text += p.name + "(";
        for (std::size_t i = 0; i < p.arguments.size(); ++i) text += (i ? ", " : "") + type_name(p.arguments[i].type);
        return text + ").";
    }

    // ---- constants

    void declare(const syntax::Constant& c) {
        const auto found = constants_.find(c.name.text);
        if (found != constants_.end()) {
            auto& twice =
                report_.add(Kind::DuplicateDeclaration, c.name.span, fmt::format("the constant `{}` is declared twice", c.name.text));
            twice.labels = {{program_.constants[found->second].span, "first declared here"}};
            twice.fixes = {diagnostics::leave_out(c.span, "this declaration", Fit::Item)};
            return;
        }
        Constant constant;
        constant.name = c.name.text;
        constant.span = c.name.span;
        constant.prelude = c.span.file < prelude_files_;
        constants_.emplace(c.name.text, program_.constants.add(constant));
    }

    // ---- functions

    void declare(const syntax::Function& tree) {
        Function f;
        f.name = tree.name.text;
        f.span = tree.name.span;
        for (const syntax::Parameter& p : tree.parameters)
            f.variables.add({p.name.text, p.name.span, to_type(p.type, types_, tree_, report_)});
        f.result = to_type(tree.result, types_, tree_, report_);
        for (std::size_t i = 0; i < tree.parameters.size(); ++i)
            for (std::size_t k = 0; k < i; ++k)
                if (tree.parameters[i].name.text == tree.parameters[k].name.text)
                    report_
                        .add(Kind::DuplicateDeclaration, tree.parameters[i].name.span,
                             fmt::format("`{}` has two parameters `{}`", f.name, tree.parameters[i].name.text))
                        .labels = {{tree.parameters[k].name.span, "first declared here"}};
        add(std::move(f), tree.span);
    }
    void declare(const syntax::Extern& tree) {
        // A type that only extern functions interpret. It is known already.
        if (!tree.result) return;
        Function f;
        f.name = tree.name.text;
        f.span = tree.name.span;
        f.external = true;
        for (std::size_t i = 0; i < tree.arguments.size(); ++i)
            f.variables.add(
                {fmt::format("argument {}", i + 1), tree.arguments[i].span, to_type(tree.arguments[i], types_, tree_, report_)});
        f.result = to_type(*tree.result, types_, tree_, report_);
        if (const LibraryFunction* same = library_function(tree.name.text, tree.arguments.size())) {
            // Older implementations wanted to be told of their functions.
            const bool library = !program_.links_c && alike(*same, f);
            auto& note =
                report_.add(Kind::HidesLibrary, tree.name.span,
                            library ? fmt::format("`{}` is a function of the library, which is called where no C file is linked", f.name)
                                    : fmt::format("`{}` is a function of the library too, and this declaration hides it", f.name));
            note.help = fmt::format("to call the library's{}, leave the declaration out",
                                    library ? " in any case" : fmt::format(", {}", same->signature));
            note.fixes = {diagnostics::leave_out(tree.span, "this declaration", Fit::Item)};
            if (library) return;
        }
        // `use "older".` has it already, in Meld.
        if (is_older(f.name) && !program_.links_c && is_defined(f.name)) {
            auto& note = report_.add(Kind::HidesLibrary, tree.name.span, fmt::format("`{}` is a function of the library `older`", f.name));
            note.help = "leave the declaration out";
            note.fixes = {diagnostics::leave_out(tree.span, "this declaration", Fit::Item)};
            return;
        }
        add(std::move(f), tree.span);
    }
    bool is_defined(const std::string& function) const {
        return std::ranges::any_of(tree_.items, [&](const syntax::Item& item) {
            const auto* f = std::get_if<syntax::Function>(&item);
            return f != nullptr && f->name.text == function;
        });
    }
    // Whether a declaration says of a function what the library says.
    static bool alike(const LibraryFunction& library, const Function& f) {
        LibraryBindings bindings;
        if (library.parameters.size() != f.variables.count()) return false;
        for (std::size_t i = 0; i < library.parameters.size(); ++i)
            if (!match(library.parameters[i], f.variables[VariableId(i)].type, bindings)) return false;
        return match(library.result, f.result, bindings);
    }
    void add(Function f, Span item) {
        f.parameter_count = f.variables.count();
        const auto [found, added] = functions_.emplace(f.name, f.span);
        if (!added) {
            auto& twice = report_.add(Kind::DuplicateDeclaration, f.span, fmt::format("the function `{}` is declared twice", f.name));
            twice.labels = {{found->second, "first declared here"}};
            twice.fixes = {diagnostics::leave_out(item, "this declaration", Fit::Item)};
            return;
        }
        program_.functions.add(std::move(f));
    }

    // ---- the rest

    // Done by the passes before.
    void declare(const syntax::Alias&) {}
    void declare(const syntax::NodeKind&) {}
    void declare(const syntax::Import&) {}
    void declare(const syntax::Export&) {}
    void declare(const syntax::Module&) {}
    void declare(const syntax::Hint& h) {
        program_.priorities_upwards = program_.priorities_upwards || is_upwards(h);
        if (is_upwards(h) || is_downwards(h) || priority_of_all(h, "@default") || priority_of_all(h, "@initial")) return;
        auto& d = report_.add(Kind::HintIgnored, h.span, fmt::format("`{}` has no effect here", h.directive.text));
        if (h.directive.text == "data") {
            d.help = "give the facts in the world file, under [facts]";
            return;
        }
        d.help = "results do not depend on it; it can be left out";
        d.fixes = {safe(diagnostics::leave_out(h.span, "this hint", Fit::Item))};
    }
    void declare(const syntax::Rule&) {}

    const syntax::Tree& tree_;
    std::uint32_t prelude_files_;
    TypeNames types_ = language_types();
    Program& program_;
    diagnostics::Reporter& report_;
    std::map<std::pair<std::string, std::size_t>, PredicateId> names_;
    std::map<std::string, ConstantId> constants_;
    std::map<std::string, Span> functions_;
};

// `undelivered-token`, in a module `m-undelivered-token`: the place where facts of the linear `token` come back that cannot be delivered.
// It has the sending catom, the target catom, and the other arguments.
void find_returns(Program& program, diagnostics::Reporter& report) {
    static const std::string word = "undelivered-";
    for (Predicate& p : program.predicates) {
        const std::size_t at = p.name.find(word);
        if (at == std::string::npos || (at > 0 && p.name[at - 1] != '-')) continue;
        const std::string name = p.name.substr(0, at) + p.name.substr(at + word.size());
        const Predicate* sent = nullptr;
        for (const PredicateId id : program.predicates.ids()) {
            const Predicate& other = program.predicates[id];
            if (other.name != name || !other.linear()) continue;
            sent = &other;
            std::vector<Type> wanted{Type::Node};
            for (const Argument& a : other.arguments) wanted.push_back(a.type);
            const bool same = p.linear() && std::equal(wanted.begin(), wanted.end(), p.arguments.begin(), p.arguments.end(),
                                                       [](const Type& t, const Argument& a) { return t == a.type; });
            if (same) p.returns = id;
        }
        p.sensed = p.sensed || p.returns.valid();
        if (sent == nullptr || p.returns.valid() || p.refused) continue;
        std::string form = "type linear " + p.name + "(node";
        for (const Argument& a : sent->arguments) form += ", " + type_name(a.type);
        auto& d =
            report.add(Kind::SensedMismatch, p.span, fmt::format("facts of `{}` that cannot be delivered come back in another form", name));
        d.help = "write `" + form + ").`";
        d.fixes = {diagnostics::write(p.declaration, form + ")")};
        p.refused = true;
    }
}

}  // namespace

void declare(const syntax::Tree& tree, std::uint32_t prelude_files, Program& program, diagnostics::Reporter& report) {
    Declarer(tree, prelude_files, program, report).run();
    for (Predicate& p : program.predicates)
        if (p.prelude && p.sensed) p.world = world_source(p.name, p.arguments.size() - 1);
    find_returns(program, report);
}

}  // namespace meld::check
