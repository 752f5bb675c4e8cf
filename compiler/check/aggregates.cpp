// Pass: aggregates of declarations, `min int D`, `sum float [<- neighbor]`, or `blend int` with a function of the program.
// Assumes declare(): the functions and links they name may stand anywhere.
#include <algorithm>
#include <map>

#include "compiler/check/check.h"
#include "compiler/check/types.h"

namespace meld::check {

using diagnostics::Kind;

namespace {

const std::map<std::string, Aggregate> kAggregates = {
    {"min", Aggregate::Min},     {"max", Aggregate::Max},   {"sum", Aggregate::Sum},       {"count", Aggregate::Count},
    {"first", Aggregate::First}, {"any", Aggregate::First}, {"append", Aggregate::Append}, {"set_union", Aggregate::SetUnion}};

class Aggregates {
  public:
    Aggregates(const syntax::Tree& tree, Program& program, diagnostics::Reporter& report)
        : tree_(tree), program_(program), report_(report) {}

    void run() {
        for (const syntax::Item& item : tree_.items) {
            const auto* d = std::get_if<syntax::Declaration>(&item);
            if (d == nullptr) continue;
            // A declaration that repeats another one has no predicate of its own.
            const auto own = std::find_if(program_.predicates.begin(), program_.predicates.end(), [&](const Predicate& p) {
                return p.span.file == d->name.span.file && p.span.begin == d->name.span.begin;
            });
            if (own == program_.predicates.end()) continue;
            const std::size_t errors = report_.error_count();
            for (std::size_t i = 0; i < d->arguments.size(); ++i) argument(*d, i, *own);
            own->refused = own->refused || report_.error_count() > errors;
        }
    }

  private:
    // A rule can do by itself what the aggregate would.
    static std::string linear_help(const Predicate& p, const std::string& aggregate) {
        const std::string out = fmt::format("leave out `{}`", aggregate);
        if (p.arguments.size() != 2 || (aggregate != "min" && aggregate != "max" && aggregate != "sum")) return out;
        const std::string both = fmt::format("{0}(A, X), {0}(A, Y)", p.name);
        if (aggregate == "sum") return out + fmt::format(", and add: `{} -o {}(A, X + Y).`", both, p.name);
        return out + fmt::format(", and keep one of two: `{}, X {} Y -o {}(A, X).`", both, aggregate == "min" ? "<=" : ">=", p.name);
    }

    void argument(const syntax::Declaration& d, std::size_t i, Predicate& p) {
        const syntax::Argument& a = d.arguments[i];
        if (a.aggregate.empty()) {
            if (a.neighbour_complete)
                complain(a.neighbour_link.span, "only an aggregate waits for neighbours",
                         fmt::format("write `sum {} [{} {}]`", type_name(p.arguments[i].type), a.neighbour_outgoing ? "->" : "<-",
                                     a.neighbour_link.text));
            return;
        }
        if (p.aggregate != Aggregate::None)
            return complain(a.aggregate_span, fmt::format("`{}` has two aggregates", p.name), "split it into two predicates with one each");
        const auto known = kAggregates.find(a.aggregate);
        p.aggregate = known == kAggregates.end() ? Aggregate::Custom : known->second;
        p.aggregate_at = i;
        if (i == 0) complain(a.aggregate_span, "the catom itself cannot be aggregated", "");
        if (p.kind == PredicateKind::Linear || p.kind == PredicateKind::Action)
            complain(a.aggregate_span,
                     fmt::format("`{}` is {}, and only views are aggregated", p.name, p.linear() ? "linear" : "an action"),
                     p.linear() ? linear_help(p, a.aggregate) : "leave it out");
        if (i + 1 != d.arguments.size() && folds(p.aggregate))
            complain(a.aggregate_span, fmt::format("no argument can ride along with {}: no single fact wins", article(a.aggregate)),
                     "put the arguments of the group before the aggregate");
        if (p.aggregate == Aggregate::Custom)
            function(a, p);
        else if (p.arguments[i].type != Type::Error)
            value(a, p.aggregate, p.arguments[i].type);
        if (a.neighbour_complete) link(a, p);
    }

    void value(const syntax::Argument& a, Aggregate aggregate, const Type& type) {
        const std::string name = type_name(type);
        const bool sums = type.numeric() || type == Type::Vec3 || type == Type::list_of(Type::Float);
        if (aggregate == Aggregate::Sum && !sums)
            complain(a.aggregate_span, fmt::format("a sum of {} values has no meaning", name),
                     "sum an int, a float, a vec3 or a list of floats");
        if (aggregate == Aggregate::Count && type != Type::Int) complain(a.aggregate_span, "a count is an int", "write `count int`");
        if (aggregate == Aggregate::SetUnion && type.kind != Type::Kind::Set)
            complain(a.aggregate_span, fmt::format("a union is of sets, and this is {}", article(name)),
                     fmt::format("write `set_union set {}`", type.kind == Type::Kind::List ? type_name(type.parts[0]) : name));
        if (aggregate == Aggregate::Append && type.kind != Type::Kind::List && type != Type::String)
            complain(a.aggregate_span, fmt::format("only lists and strings are appended, and this is {}", article(name)),
                     fmt::format("write `append list {}`", type.kind == Type::Kind::Set ? type_name(type.parts[0]) : name));
    }
    static std::string article(const std::string& type) {
        return (std::string("aeiou").find(type[0]) == std::string::npos ? "a " : "an ") + type;
    }

    // A function that makes one value of two.
    void function(const syntax::Argument& a, Predicate& p) {
        for (const FunctionId id : program_.functions.ids())
            if (program_.functions[id].name == a.aggregate) p.fold = id;
        if (!p.fold.valid()) return unknown(a);
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
                           fmt::format("an aggregate makes one value of two, and `{}` takes {}", f.name, f.parameter_count));
        const Type& type = p.arguments[p.aggregate_at].type;
        for (const Type& other : {f.variables[VariableId(0)].type, f.variables[VariableId(1)].type, f.result})
            if (!(other == type) && other != Type::Error && type != Type::Error)
                return differs(Kind::TypeMismatch, fmt::format("`{}` makes one {} of two, and `{}` is about {} values", p.name,
                                                               type_name(type), f.name, type_name(other)));
    }
    void unknown(const syntax::Argument& a) {
        if (tree_.is_lost(a.aggregate)) return;
        std::vector<std::string> known;
        for (const auto& [name, aggregate] : kAggregates) known.push_back(name);
        for (const Function& f : program_.functions) known.push_back(f.name);
        const std::string near = diagnostics::nearest_name(a.aggregate, known);
        report_.add(Kind::UnknownFunction, a.aggregate_span, fmt::format("there is no aggregate and no function `{}`", a.aggregate)).help =
            near.empty() ? "aggregates are any, append, count, first, max, min, set_union and sum, or a function of two arguments"
                         : fmt::format("did you mean `{}`?", near);
    }

    // The links that must all have contributed.
    void link(const syntax::Argument& a, Predicate& p) {
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
                                  fmt::format("`{}` {}, and what is waited for are links that stay", other->name,
                                              other->route ? "is linear" : "is no route"));
            d.labels = {{other->span, "declared here"}};
            d.help = other->route ? "wait for `neighbor`, or for a view of these links"
                                  : fmt::format("declare it `type route {}(...)`", other->name);
            return;
        }
        std::vector<std::string> routes;
        for (const Predicate& q : program_.predicates)
            if (q.route) routes.push_back(q.name);
        const std::string near = diagnostics::nearest_name(a.neighbour_link.text, routes);
        report_.add(Kind::UnknownPredicate, a.neighbour_link.span, fmt::format("there is no predicate `{}`", a.neighbour_link.text)).help =
            near.empty() ? "name `neighbor`, or a predicate that is declared `route`" : fmt::format("did you mean `{}`?", near);
    }

    void complain(Span span, const std::string& what, const std::string& help) { report_.add(Kind::BadAggregate, span, what).help = help; }

    const syntax::Tree& tree_;
    Program& program_;
    diagnostics::Reporter& report_;
};

}  // namespace

void declare_aggregates(const syntax::Tree& tree, Program& program, diagnostics::Reporter& report) {
    Aggregates(tree, program, report).run();
}

}  // namespace meld::check
