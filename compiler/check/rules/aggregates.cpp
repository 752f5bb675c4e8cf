// Pass: aggregates of declarations, `min int D`, `sum float [<- neighbor]`, or `blend int` with a function of the program. Assumes
// declare(): the functions and links they name may be declared anywhere.
#include <algorithm>

#include "compiler/check/check.h"
#include "compiler/check/program/library_fold.h"
#include "compiler/check/program/types.h"
#include "runtime/base/assert.h"

namespace meld::check {

using diagnostics::Kind;
using Fit = diagnostics::Edit::Fit;

namespace {

class Aggregates {
  public:
    Aggregates(const syntax::Tree& tree, Program& program, diagnostics::Reporter& report)
        : tree_(tree), program_(program), report_(report) {}

    void run() {
        for (const syntax::Item& item : tree_.items) {
            const auto* d = std::get_if<syntax::Declaration>(&item);
            if (d == nullptr) continue;
            // A declaration that repeats another one has no predicate of its own; one in a file that is read twice has two, with two names.
            const auto own = std::find_if(program_.predicates.begin(), program_.predicates.end(), [&](const Predicate& p) {
                return p.span.file == d->name.span.file && p.span.begin == d->name.span.begin && p.name == d->name.text;
            });
            if (own == program_.predicates.end()) continue;
            const std::size_t errors = report_.error_count();
            for (std::size_t i = 0; i < d->arguments.size(); ++i) argument(*d, i, *own);
            own->refused = own->refused || report_.error_count() > errors;
        }
    }

  private:
    // A rule that does the same as the aggregate.
    static std::string linear_help(const Predicate& p, const std::string& aggregate) {
        const std::string out = fmt::format("leave out `{}`", aggregate);
        if (p.arguments.size() != 2 || (aggregate != "min" && aggregate != "max" && aggregate != "sum")) return out;
        const std::string both = fmt::format("{0}(A, X), {0}(A, Y)", p.name);
        if (aggregate == "sum") return out + fmt::format(", and add: `{} -o {}(A, X + Y).`", both, p.name);
        return out + fmt::format(", and keep one of two: `{}, X {} Y -o {}(A, X).`", both, aggregate == "min" ? "<=" : ">=", p.name);
    }

    void argument(const syntax::Declaration& d, std::size_t i, Predicate& p) {
        MELD_EXPECT(d.arguments.size() == p.arguments.size(), "{} was declared with {} arguments", p.signature(), d.arguments.size());
        const syntax::Argument& a = d.arguments[i];
        if (a.aggregate.empty()) {
            if (a.neighbour_complete)
                complain(a.neighbour_link.span, "only an aggregate waits for neighbours",
                         fmt::format("write `sum {} [{} {}]`", type_name(p.arguments[i].type), a.neighbour_outgoing ? "->" : "<-",
                                     a.neighbour_link.text));
            return;
        }
        if (p.aggregate != Aggregate::None) {
            complain(a.aggregate_span, fmt::format("`{}` has two aggregates", p.name), "split it into two predicates with one each");
            return;
        }
        p.aggregate = named(a);
        p.aggregate_at = i;
        const diagnostics::Fix without = diagnostics::leave_out(a.aggregate_span, fmt::format("`{}`", a.aggregate), Fit::Word);
        if (i == 0) complain(a.aggregate_span, "the catom itself cannot be aggregated", "").fixes = {without};
        if (p.kind == PredicateKind::Linear || p.kind == PredicateKind::Action)
            complain(a.aggregate_span,
                     fmt::format("`{}` is {}, and only views are aggregated", p.name, p.linear() ? "linear" : "an action"),
                     p.linear() ? linear_help(p, a.aggregate) : "leave it out")
                .fixes = {without};
        if (i + 1 != d.arguments.size() && !info(p.aggregate).has(AggregateInfo::kPayload))
            complain(a.aggregate_span, fmt::format("{} has no payload: no single fact wins", article(a.aggregate)),
                     "put the arguments of the group before the aggregate");
        if (p.aggregate == Aggregate::Custom)
            function(a, p);
        else if (p.arguments[i].type != Type::Error)
            value(a, p.aggregate, p.arguments[i].type);
        parameter(a, p, d.span);
        if (a.neighbour_complete) link(a, p);
    }

    // A function of the program takes precedence over the aggregates that yield to it.
    Aggregate named(const syntax::Argument& a) const {
        const Aggregate known = syntax::declared_aggregate(a.aggregate);
        const bool hidden =
            info(known).has(AggregateInfo::kYields) &&
            std::any_of(program_.functions.begin(), program_.functions.end(), [&](const Function& f) { return f.name == a.aggregate; });
        return hidden ? Aggregate::Custom : known;
    }

    // min_k(3), or min_k(size) with a constant.
    void parameter(const syntax::Argument& a, Predicate& p, Span item) {
        const bool takes = info(p.aggregate).has(AggregateInfo::kParameter);
        if (takes && !a.aggregate_parameter)
            complain(a.aggregate_span, fmt::format("`{}` needs to know how many values it keeps", a.aggregate),
                     fmt::format("write `{}(3)`", a.aggregate))
                .fixes = {diagnostics::write(a.aggregate_span, a.aggregate + "(3)")};
        if (!takes && a.aggregate_parameter)
            complain(a.aggregate_span, fmt::format("`{}` takes no number", a.aggregate), fmt::format("write `{}` alone", a.aggregate))
                .fixes = {diagnostics::write(a.aggregate_span, a.aggregate)};
        if (!takes || !a.aggregate_parameter) return;
        p.parameter.span = a.aggregate_span;
        p.parameter.type = Type::Int;
        if (const auto* number = std::get_if<std::int64_t>(&*a.aggregate_parameter)) {
            p.parameter.op = Op::Int;
            p.parameter.integer = *number;
            if (*number < 1)
                complain(a.aggregate_span, fmt::format("`{}` keeps at least one value", a.aggregate),
                         fmt::format("write `{}(1)`", a.aggregate))
                    .fixes = {diagnostics::write(a.aggregate_span, a.aggregate + "(1)")};
            return;
        }
        const syntax::Name& name = std::get<syntax::Name>(*a.aggregate_parameter);
        std::vector<std::string> known;
        for (const ConstantId id : program_.constants.ids()) {
            known.push_back(program_.constants[id].name);
            if (known.back() != name.text) continue;
            p.parameter.op = Op::Constant;
            p.parameter.constant = id;
            return;
        }
        if (tree_.is_lost(name.text)) return;
        const std::string near = diagnostics::nearest_name(name.text, known);
        auto& d = report_.add(Kind::UnknownFunction, name.span, fmt::format("there is no constant `{}`", name.text));
        if (!near.empty()) return d.did_you_mean(near, name.span, Fit::Name);
        const std::string declaration = fmt::format("const {} = 3.", name.text);
        d.help = fmt::format("declare it: `{}`", declaration);
        d.fixes = {{.title = fmt::format("Declare `{}`", declaration), .edits = {{item, declaration, Fit::Before}}}};
    }

    void value(const syntax::Argument& a, Aggregate aggregate, const Type& type) {
        const std::string name = type_name(type);
        const auto misuse = [&](bool fits, const std::string& what, const std::string& help) {
            if (!fits) complain(a.aggregate_span, what, help);
        };
        // The same where one aggregate and type would do.
        const auto needs = [&](bool fits, const std::string& what, std::string right) {
            if (fits) return;
            auto& d = complain(a.aggregate_span, what, fmt::format("write `{}`", right));
            d.fixes = {diagnostics::write(a.aggregate_span.to(a.type.span), std::move(right))};
        };
        switch (info(aggregate).values) {
            case AggregateInfo::Values::Summable:
                misuse(summable(type), fmt::format("a sum of {} values has no meaning", name), kSummable);
                break;
            case AggregateInfo::Values::Counted:
                needs(type == Type::Int, "a count is an int", "count int");
                break;
            case AggregateInfo::Values::Sets:
                needs(type.kind == Type::Kind::Set, fmt::format("a union is of sets, and this is {}", article(name)),
                      fmt::format("set_union set {}", type.kind == Type::Kind::List ? type_name(type.parts[0]) : name));
                break;
            case AggregateInfo::Values::Lists:
                needs(type.kind == Type::Kind::List || type == Type::String,
                      fmt::format("only lists and strings are appended, and this is {}", article(name)),
                      fmt::format("append list {}", type.kind == Type::Kind::Set ? type_name(type.parts[0]) : name));
                break;
            case AggregateInfo::Values::Reals:
                needs(type == Type::Float, "an average is a float", fmt::format("{} float", a.aggregate));
                break;
            case AggregateInfo::Values::Bools:
                needs(type == Type::Bool, fmt::format("`{}` joins truth values, and this is {}", a.aggregate, article(name)),
                      fmt::format("{} bool", a.aggregate));
                break;
            case AggregateInfo::Values::Elements:
                needs(type.kind == Type::Kind::List, fmt::format("`{}` keeps a list, and this is {}", a.aggregate, article(name)),
                      fmt::format("{}(3) list {}", a.aggregate, type.kind == Type::Kind::Set ? type_name(type.parts[0]) : name));
                break;
            case AggregateInfo::Values::Any:
            case AggregateInfo::Values::Ordered:
                break;
        }
    }
    static std::string article(const std::string& type) {
        return (std::string("aeiou").find(type[0]) == std::string::npos ? "a " : "an ") + type;
    }

    // A function that combines two values into one.
    void function(const syntax::Argument& a, Predicate& p) {
        MELD_EXPECT(p.aggregate == Aggregate::Custom && !p.fold.valid(), "{} has a function", p.name);
        for (const FunctionId id : program_.functions.ids())
            if (program_.functions[id].name == a.aggregate && !program_.functions[id].of_library) p.fold = id;
        if (!p.fold.valid()) return of_library(a, p);
        const Function& f = program_.functions[p.fold];
        if (f.refused) return;
        const auto differs = [&](Kind kind, const std::string& what) {
            auto& d = report_.add(kind, a.aggregate_span, what);
            d.labels = {{f.span, "declared here"}};
            const std::string type = type_name(p.arguments[p.aggregate_at].type);
            d.help = fmt::format("write `fun {0}({1} SoFar, {1} Value) : {1} = ...`", f.name, type);
        };
        if (f.parameter_count != 2)
            return differs(Kind::ArityMismatch,
                           fmt::format("an aggregate function takes two arguments, and `{}` takes {}", f.name, f.parameter_count));
        const Type& type = p.arguments[p.aggregate_at].type;
        for (const Type& other : {f.variables[VariableId(0)].type, f.variables[VariableId(1)].type, f.result})
            if (!(other == type) && other != Type::Error && type != Type::Error)
                return differs(Kind::TypeMismatch, fmt::format("`{}` makes one {} of two, and `{}` is about {} values", p.name,
                                                               type_name(type), f.name, type_name(other)));
    }
    void of_library(const syntax::Argument& a, Predicate& p) {
        const Type& type = p.arguments[p.aggregate_at].type;
        const std::optional<FunctionId> fold = library_fold(program_, a.aggregate, type, a.aggregate_span);
        if (fold) {
            p.fold = *fold;
        } else if (const LibraryFunction* f = library_function(a.aggregate, 2)) {
            if (type != Type::Error) refuse_library_fold(*f, type, a.aggregate_span, report_);
        } else {
            unknown(a);
        }
    }
    void unknown(const syntax::Argument& a) {
        if (tree_.is_lost(a.aggregate)) return;
        const std::vector<std::string> words = syntax::words_of_declared_aggregates();
        std::vector<std::string> known = words;
        for (const Function& f : program_.functions)
            if (!f.of_library) known.push_back(f.name);
        const std::string near = diagnostics::nearest_name(a.aggregate, known);
        auto& d =
            report_.add(Kind::UnknownFunction, a.aggregate_span, fmt::format("there is no aggregate and no function `{}`", a.aggregate));
        if (near.empty())
            d.help = fmt::format("aggregates are {}, or a function of two arguments", diagnostics::in_words(words));
        else
            d.did_you_mean(near, a.aggregate_span, Fit::Name);
    }

    // The links that must all have contributed.
    void link(const syntax::Argument& a, Predicate& p) {
        MELD_EXPECT(a.neighbour_complete && !p.complete_link.valid(), "{} waits for two links", p.name);
        const Predicate* other = nullptr;
        for (const PredicateId id : program_.predicates.ids()) {
            const Predicate& q = program_.predicates[id];
            if (q.name != a.neighbour_link.text) continue;
            other = &q;
            if (!q.route || q.linear() ||
                (p.complete_link.valid() && program_.predicates[p.complete_link].arguments.size() <= q.arguments.size()))
                continue;
            p.complete_link = id;
            p.complete_outgoing = a.neighbour_outgoing;
        }
        if (p.complete_link.valid() || (other == nullptr && tree_.is_lost(a.neighbour_link.text))) return;
        if (other != nullptr) {
            auto& d = report_.add(Kind::BadAggregate, a.neighbour_link.span,
                                  fmt::format("`{}` {}, and an aggregate can wait only for links that stay", other->name,
                                              other->route ? "is linear" : "is not a route"));
            d.labels = {{other->span, "declared here"}};
            d.help = other->route ? "wait for `neighbor`, or for a view of these links"
                                  : fmt::format("declare it `type route {}(...)`", other->name);
            const bool points = other->arguments.size() > 1 && other->arguments[1].type == Type::Node;
            if (other->route)
                d.fixes = {diagnostics::write(a.neighbour_link.span, waiting_for(a, "neighbor"))};
            else if (points && !other->linear())
                d.fixes = {diagnostics::insert(other->span, "route ")};
            return;
        }
        std::vector<std::string> routes;
        for (const Predicate& q : program_.predicates)
            if (q.route) routes.push_back(q.name);
        const std::string near = diagnostics::nearest_name(a.neighbour_link.text, routes);
        auto& d =
            report_.add(Kind::UnknownPredicate, a.neighbour_link.span, fmt::format("there is no predicate `{}`", a.neighbour_link.text));
        d.help = near.empty() ? "name `neighbor`, or a predicate that is declared `route`" : fmt::format("did you mean `{}`?", near);
        if (!near.empty()) d.fixes = {diagnostics::write(a.neighbour_link.span, waiting_for(a, near))};
    }

    // What stands at neighbour_link, with another link.
    static std::string waiting_for(const syntax::Argument& a, const std::string& link) {
        return fmt::format("[{} {}]", a.neighbour_outgoing ? "->" : "<-", link);
    }
    diagnostics::Diagnostic& complain(Span span, const std::string& what, const std::string& help) {
        auto& d = report_.add(Kind::BadAggregate, span, what);
        d.help = help;
        return d;
    }

    const syntax::Tree& tree_;
    Program& program_;
    diagnostics::Reporter& report_;
};

}  // namespace

void check_aggregate_parameters(const Program& program, diagnostics::Reporter& report) {
    for (const Predicate& p : program.predicates) {
        if (p.parameter.op != Op::Constant) continue;
        const Constant& c = program.constants[p.parameter.constant];
        const bool known = !c.argument && !c.computed.valid();
        if (c.type != Type::Int && c.type != Type::Error)
            report
                .add(Kind::TypeMismatch, p.parameter.span,
                     fmt::format("`{}` keeps a number of values that is an int, and `{}` is {}", p.name, c.name, type_name(c.type)))
                .labels = {{c.span, "declared here"}};
        else if (c.type == Type::Int && known && c.integer < 1)
            report
                .add(Kind::BadAggregate, p.parameter.span,
                     fmt::format("`{}` keeps at least one value, and `{}` is {}", p.name, c.name, c.integer))
                .labels = {{c.span, "declared here"}};
    }
}

void declare_aggregates(const syntax::Tree& tree, Program& program, diagnostics::Reporter& report) {
    Aggregates(tree, program, report).run();
}

}  // namespace meld::check
