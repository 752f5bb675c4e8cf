// The tree as Meld text. Parsing the output gives the same tree; brackets are printed only where the grammar needs them.
#include <fmt/format.h>

#include "compiler/syntax/parse.h"
#include "compiler/syntax/printer.h"
#include "compiler/syntax/stable_name.h"

namespace meld::syntax {

namespace {

template <class T, class Print>
std::string joined(const std::vector<T>& list, Print print_one, const char* separator = ", ") {
    std::string result;
    for (const T& element : list) {
        if (!result.empty()) result += separator;
        result += print_one(element);
    }
    return result;
}

std::string text(const Name& name) { return name.text; }
std::string names(const std::vector<Name>& list) { return joined(list, text); }

// A section between two bars keeps its blanks, so that { | body | head } has no `||`.
std::string section(std::string text) { return text.empty() ? " " : " " + text + " "; }

std::string last_section(const std::string& text) { return text.empty() ? " " : " " + text; }

// ---- bodies

std::string print_atom(const Atom& atom) {
    static constexpr const char* kSigils[] = {"", "!", "?", "$"};
    return kSigils[static_cast<std::size_t>(atom.sigil)] +
           print_fact(atom.name.text, joined(atom.arguments, [](const ExprPtr& argument) { return print(*argument); }));
}

std::string print_clauses(const std::vector<Clause>& clauses) { return joined(clauses, print_clause); }

struct ClausePrinter {
    std::string operator()(const Atom& atom) const { return print_atom(atom); }
    std::string operator()(const Constraint& constraint) const {
        // A call alone would be read as an atom, also in brackets, so a condition that is a call prints the same.
        return print(*constraint.condition);
    }
    std::string operator()(const Not& negation) const {
        const bool one_atom = negation.clauses.size() == 1 && std::holds_alternative<Atom>(negation.clauses[0].node);
        return one_atom ? "not " + print_clauses(negation.clauses) : "not (" + print_clauses(negation.clauses) + ")";
    }
    std::string operator()(const Forall& forall) const {
        return fmt::format("forall {}[{}]", print_atom(forall.atom), print_clauses(forall.clauses));
    }
    std::string operator()(const Element& element) const { return print(*element.element) + " in " + print(*element.list); }
    std::string operator()(const Delta& delta) const {
        return fmt::format("delta({}; {}) {} {}", delta.variable.text, print_atom(delta.atom), spelling(delta.op), print(*delta.bound));
    }
    std::string operator()(const Proved& proved) const {
        if (proved.at != nullptr) return fmt::format("{} = proved({}, {})", print(*proved.count), print(*proved.at), proved.predicate.text);
        return fmt::format("proved({}, {})", print(*proved.count), proved.predicate.text);
    }
    std::string operator()(const BodyAggregate& aggregate) const {
        const std::string value = aggregate.value == nullptr ? "" : print(*aggregate.value) + " ";
        const std::string parameter = aggregate.parameter == nullptr ? "" : "(" + print(*aggregate.parameter) + ")";
        return fmt::format("{} = {}{} {}: {{ {} }}", aggregate.result.text, aggregate.op, parameter, value,
                           print_clauses(aggregate.clauses));
    }
};

// ---- heads

std::string print_heads(const std::vector<HeadItem>& heads) { return joined(heads, print_head); }

std::string print_delay(const Delay& delay) {
    const char* unit = delay.unit == Delay::Unit::Seconds ? "s" : delay.unit == Delay::Unit::Milliseconds ? "ms" : "";
    return fmt::format("@+{}{}", plain_decimal(delay.amount), unit);
}

std::string print_result(const HeadAggregate& aggregate) {
    if (aggregate.function.empty()) {
        const std::string parameter = aggregate.parameter == nullptr ? "" : "(" + print(*aggregate.parameter) + ")";
        return fmt::format("{}{} => {}", aggregate.op, parameter, aggregate.result.text);
    }
    const std::string initial = aggregate.parameter == nullptr ? "" : print(*aggregate.parameter) + " ";
    return fmt::format("{} {} {}=> {}", aggregate.op, aggregate.function, initial, aggregate.result.text);
}

struct HeadPrinter {
    std::string operator()(const HeadFact& fact) const { return print_atom(fact.atom) + (fact.delay ? print_delay(*fact.delay) : ""); }
    std::string operator()(const Comprehension& node) const {
        return fmt::format("{{{}|{}|{}}}", section(names(node.variables)), section(print_clauses(node.body)),
                           section(print_heads(node.head)));
    }
    std::string operator()(const RuleAggregate& node) const {
        // Without a head for each match there are three sections, unless the last would be empty as well.
        const bool has_each = !node.each.empty();
        const std::string each = has_each ? section(print_heads(node.each)) + "|" : "";
        return fmt::format("[{} |{}|{}|{}{}]", joined(node.aggregates, print_result), section(names(node.variables)),
                           section(print_clauses(node.body)), each, last_section(print_heads(node.result)));
    }
    std::string operator()(const Exists& node) const {
        return fmt::format("exists {}. ({})", names(node.variables), print_heads(node.head));
    }
    std::string operator()(const HeadIf& node) const {
        const std::string otherwise = node.else_head.empty() ? "" : " otherwise " + print_heads(node.else_head);
        return fmt::format("(if {} then {}{} end)", print(*node.condition), print_heads(node.then_head), otherwise);
    }
    std::string operator()(const HeadLet& node) const { return node.variable.text + " = " + print(*node.value); }
    std::string operator()(const Nothing&) const { return "1"; }
};

// ---- declarations

std::string print_type(const Type& type) {
    const std::string fields = joined(type.arguments, print_type);
    if (type.name == "struct") return ":(" + fields + ")";
    if (type.name == "tuple") return "(" + fields + ")";
    return type.arguments.empty() ? type.name : type.name + " " + fields;
}

std::string print_aggregate(const Argument& argument) {
    if (!argument.aggregate_parameter) return argument.aggregate;
    const auto* number = std::get_if<std::int64_t>(&*argument.aggregate_parameter);
    return fmt::format("{}({})", argument.aggregate,
                       number != nullptr ? std::to_string(*number) : std::get<Name>(*argument.aggregate_parameter).text);
}

std::string print_argument(const Argument& argument) {
    std::string result = argument.aggregate.empty() ? "" : print_aggregate(argument) + " ";
    result += print_type(argument.type);
    if (argument.neighbour_complete)
        result += fmt::format(" [{} {}]", argument.neighbour_outgoing ? "->" : "<-", argument.neighbour_link.text);
    if (argument.name) result += " " + argument.name->text;
    return result;
}

std::string print_signature(const Declaration& declaration) {
    std::string result;
    for (const Name& modifier : declaration.modifiers) result += modifier.text + " ";
    return result + fmt::format("{}({})", declaration.name.text, joined(declaration.arguments, print_argument));
}

struct ItemPrinter {
    std::string operator()(const Declaration& node) const {
        return fmt::format("type {}{}.", print_signature(node), node.repeats ? " while" : "");
    }
    std::string operator()(const Constant& node) const { return fmt::format("const {} = {}.", node.name.text, print(*node.value)); }
    std::string operator()(const Function& node) const {
        const auto parameter = [](const Parameter& one) { return print_type(one.type) + " " + one.name.text; };
        return fmt::format("fun {}({}) : {} = {}.", node.name.text, joined(node.parameters, parameter), print_type(node.result),
                           print(*node.body));
    }
    std::string operator()(const Extern& node) const {
        if (!node.result) return fmt::format("extern type {}.", node.name.text);
        return fmt::format("extern {} {}({}).", print_type(*node.result), node.name.text, joined(node.arguments, print_type));
    }
    std::string operator()(const Alias& node) const { return fmt::format("type {} {}.", print_type(node.type), node.name.text); }
    std::string operator()(const NodeKind& node) const { return fmt::format("node {}.", node.name.text); }
    std::string operator()(const Import& node) const {
        const std::string what = node.declaration ? print_signature(*node.declaration) : node.predicate.text;
        const std::string as = node.as.text == node.predicate.text ? "" : " as " + node.as.text;
        return fmt::format("import {}{} from {}.", what, as, quoted_text(node.path));
    }
    std::string operator()(const Export& node) const { return fmt::format("export {}.", node.predicate.text); }
    std::string operator()(const Module& node) const { return fmt::format("module {}.", node.name.text); }
    std::string operator()(const Hint& node) const { return fmt::format("{} {}.", node.directive.text, node.text); }
    std::string operator()(const Rule& node) const { return print(node); }
};

std::string print_selector(const Selector& selector) {
    switch (selector.order) {
        case Selector::Order::Ascending:
            return "asc => " + selector.variable.text;
        case Selector::Order::Descending:
            return "desc => " + selector.variable.text;
        case Selector::Order::Random:
            return "random => " + selector.variable.text;
        case Selector::Order::Minimum:
            return "min => " + selector.variable.text;
    }
    return "";
}

}  // namespace

std::string print_clause(const Clause& clause) { return std::visit(ClausePrinter{}, clause.node); }
std::string print_head(const HeadItem& head) { return std::visit(HeadPrinter{}, head.node); }

std::string print(const Rule& rule) {
    std::string body = print_clauses(rule.body);
    if (rule.selector) body = fmt::format("[{} |{}]", print_selector(*rule.selector), last_section(body));
    switch (rule.arrow) {
        case Arrow::Axiom:
            return print_heads(rule.head) + ".";
        case Arrow::View:
            return fmt::format("{} :- {}.", print_heads(rule.head), body);
        case Arrow::Linear:
            return fmt::format("{} -o {}.", body, print_heads(rule.head));
        case Arrow::Question:
            return body;
    }
    return "";
}

std::string print(const Type& type) { return print_type(type); }
std::string print(const Declaration& declaration) { return ItemPrinter{}(declaration); }

std::string print(const Tree& tree) {
    std::string result;
    for (const Item& item : tree.items) result += std::visit(ItemPrinter{}, item) + "\n";
    return result;
}

}  // namespace meld::syntax
