// Pass 2: constants and functions. Their expressions become terms; constants get their values, or, if only the run can compute a value, a
// function that does. Assumes declare(): every name is in the tables, functions with their types.
#include <map>

#include "compiler/check/check.h"
#include "compiler/check/names/scope.h"
#include "compiler/check/program/fold.h"
#include "runtime/base/assert.h"

namespace meld::check {

using diagnostics::Kind;

namespace {

class Values {
  public:
    Values(const syntax::Tree& tree, Program& program, diagnostics::Reporter& report)
        : program_(program), report_(report), names_(program, tree) {
        for (const syntax::Item& item : tree.items) {
            // Of two with one name only the first is in the tables.
            if (const auto* c = std::get_if<syntax::Constant>(&item)) constants_.emplace(c->name.text, Pending{c});
            if (const auto* f = std::get_if<syntax::Function>(&item)) functions_.push_back(f);
        }
    }

    void run() {
        for (auto& [name, pending] : constants_) {
            pending.id = names_.constants.at(name);
            by_id_.emplace(pending.id, &pending);
        }
        for (auto& [name, pending] : constants_) type_all(pending);
        for (const syntax::Function* f : functions_) function(*f);
        // In this order a constant finds those computed that it names.
        for (Pending* pending : typed_) compute(*pending);
    }

  private:
    enum class State { Waiting, Busy, Done };
    struct Pending {
        const syntax::Constant* tree;
        ConstantId id = {};
        State typed = State::Waiting, computed = State::Waiting;
        std::vector<Pending*> names = {};  // The constants that its expression names.
        bool wrong = false;
        Term term = {};
        Rule variables = {};
        std::optional<Term> value = {};
    };

    // ---- terms

    void find_names(const syntax::Expr& e, Pending& of) {
        const auto all = [&](const std::vector<syntax::ExprPtr>& values) {
            for (const auto& value : values) find_names(*value, of);
        };
        if (const auto* c = std::get_if<syntax::Call>(&e.node)) {
            all(c->arguments);
            const auto named = c->parentheses ? constants_.end() : constants_.find(c->name);
            if (named != constants_.end()) of.names.push_back(&named->second);
        }
        if (const auto* u = std::get_if<syntax::Unary>(&e.node)) find_names(*u->operand, of);
        if (const auto* b = std::get_if<syntax::Binary>(&e.node)) {
            find_names(*b->left, of);
            find_names(*b->right, of);
        }
        if (const auto* chain = std::get_if<syntax::Chain>(&e.node))
            for (const auto& operand : chain->operands) find_names(*operand, of);
        if (const auto* c = std::get_if<syntax::Conditional>(&e.node)) {
            find_names(*c->condition, of);
            find_names(*c->then_value, of);
            find_names(*c->else_value, of);
        }
        if (const auto* l = std::get_if<syntax::ListValue>(&e.node)) {
            all(l->elements);
            if (l->rest) find_names(*l->rest, of);
        }
        if (const auto* s = std::get_if<syntax::StructValue>(&e.node)) all(s->fields);
        if (const auto* t = std::get_if<syntax::TupleValue>(&e.node)) all(t->fields);
        if (const auto* l = std::get_if<syntax::Let>(&e.node)) {
            find_names(*l->value, of);
            find_names(*l->body, of);
        }
    }

    // Types a constant, after those that its expression names. Chains of constants may be long, so there is no recursion.
    void type_all(Pending& root) {
        struct Open {
            Pending* pending;
            std::size_t next = 0;
        };
        std::vector<Open> open;
        const auto enter = [&](Pending& pending) {
            if (pending.typed == State::Busy) by_itself(pending);
            if (pending.typed != State::Waiting) return;
            pending.typed = State::Busy;
            find_names(*pending.tree->value, pending);
            open.push_back({&pending});
        };
        enter(root);
        while (!open.empty()) {
            Pending& pending = *open.back().pending;
            if (open.back().next < pending.names.size()) {
                enter(*pending.names[open.back().next++]);
                continue;
            }
            open.pop_back();
            for (const Pending* named : pending.names) pending.wrong = pending.wrong || named->wrong;
            pending.typed = State::Done;
            type(pending);
            typed_.push_back(&pending);
        }
    }
    void type(Pending& pending) {
        if (pending.wrong) return;
        const std::size_t errors = report_.error_count();
        Scope scope(program_, names_, pending.variables, report_, false);
        pending.term = scope.resolve(*pending.tree->value, Type::Error, fmt::format("the constant `{}`", pending.tree->name.text));
        no_variables(pending.term, {}, fmt::format("a constant has no variables"));
        pending.wrong = report_.error_count() > errors;
        if (!pending.wrong) program_.constants[pending.id].type = pending.term.type;
    }
    void by_itself(Pending& pending) {
        if (!pending.wrong)
            report_.add(Kind::BadConstant, pending.tree->name.span,
                        fmt::format("the constant `{}` is defined by itself", pending.tree->name.text));
        pending.wrong = true;
    }

    void no_variables(const Term& term, const Variables& but, const std::string& why) {
        each_free_use(term, [&](const Term& t) {
            if (but.contains(t.variable)) return;
            report_.add(Kind::UnboundVariable, t.span, why);
        });
    }

    void function(const syntax::Function& tree) {
        const auto found = names_.functions.find(tree.name.text);
        if (found == names_.functions.end() || program_.functions[found->second].span.begin != tree.name.span.begin ||
            program_.functions[found->second].span.file != tree.name.span.file)
            return;
        Function& f = program_.functions[found->second];
        const std::size_t errors = report_.error_count();
        Rule makeshift;
        bool lower_case = false;
        Variables parameters;
        for (const syntax::Parameter& p : tree.parameters)
            lower_case = lower_case || std::islower(static_cast<unsigned char>(p.name.text[0]));
        Scope scope(program_, names_, makeshift, report_, lower_case);
        MELD_ASSERT(f.parameter_count == tree.parameters.size(), "{} has {} parameters", f.name, f.parameter_count);
        for (std::size_t i = 0; i < f.parameter_count; ++i) {
            const Variable& parameter = f.variables[VariableId(i)];
            const VariableId v = scope.variable(parameter.name, parameter.span);
            makeshift.variables[v].type = parameter.type;
            parameters.insert(v);
        }
        f.body = scope.resolve(*tree.body, f.result, fmt::format("the result of `{}`", f.name), false, f.span);
        std::string names;
        for (std::size_t i = 0; i < f.parameter_count; ++i) names += (names.empty() ? "`" : ", `") + f.variables[VariableId(i)].name + "`";
        no_variables(f.body, parameters,
                     names.empty() ? fmt::format("`{}` has no parameters", f.name)
                                   : fmt::format("only the parameters of `{}` have a value here: {}", f.name, names));
        f.variables = std::move(makeshift.variables);
        f.refused = report_.error_count() > errors;
    }

    // ---- values of constants

    void compute(Pending& pending) {
        MELD_EXPECT(pending.typed == State::Done, "{} has no type yet", pending.tree->name.text);
        if (pending.computed == State::Done) return;
        if (pending.computed == State::Busy) {
            by_itself(pending);
            return;
        }
        pending.computed = State::Busy;
        if (!pending.wrong) {
            Folder folder(program_, [this](ConstantId id) { return value_of(id); });
            pending.value = folder.fold(pending.term);
            if (!folder.wrong().empty())
                report_.add(Kind::BadConstant, folder.wrong_at(), folder.wrong());
            else if (pending.value)
                keep(program_.constants[pending.id], *pending.value);
            else if (!pending.wrong)
                leave_to_the_run(pending);
        }
        pending.computed = State::Done;
    }
    std::optional<Term> value_of(ConstantId id) {
        const auto found = by_id_.find(id);
        if (found == by_id_.end()) return std::nullopt;
        compute(*found->second);
        return found->second->value;
    }
    static void keep(Constant& c, const Term& value) {
        c.integer = value.integer;
        c.real = value.op == Op::Float ? value.real : static_cast<double>(value.integer);
        c.text = value.text;
        c.value = value;
    }
    void leave_to_the_run(Pending& pending) {
        Constant& c = program_.constants[pending.id];
        MELD_EXPECT(!c.computed.valid() && !pending.value, "{} has a value", c.name);
        Function f;
        f.name = c.name;
        f.span = c.span;
        f.result = c.type;
        f.body = pending.term;
        f.variables = pending.variables.variables;
        c.computed = program_.functions.add(std::move(f));
    }

    Program& program_;
    diagnostics::Reporter& report_;
    Names names_;
    std::map<std::string, Pending> constants_;
    std::map<ConstantId, Pending*> by_id_;
    std::vector<Pending*> typed_;  // In the order of typing: each after those that it names.
    std::vector<const syntax::Function*> functions_;
};

}  // namespace

void resolve_values(const syntax::Tree& tree, Program& program, diagnostics::Reporter& report) { Values(tree, program, report).run(); }

}  // namespace meld::check
