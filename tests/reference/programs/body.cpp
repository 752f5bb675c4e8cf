#include "tests/reference/programs/body.h"

#include <fmt/format.h>

#include <algorithm>

namespace meld::reference {

const char* name_of(Kind kind) {
    constexpr const char* kNames[] = {"int", "float", "bool", "node", "string", "list int", ":(int, node)"};
    return kNames[static_cast<int>(kind)];
}

std::string Body::fresh(Kind kind) {
    constexpr const char* kStems[] = {"X", "F", "T", "N", "S", "L", "P"};
    const std::string name = fmt::format("{}{}", kStems[static_cast<int>(kind)], ++next_);
    variables_[kind].push_back(name);
    return name;
}

bool Body::has(Kind kind) const {
    const auto found = variables_.find(kind);
    return kind == Kind::Node || (found != variables_.end() && !found->second.empty());
}

std::string Body::variable(Kind kind) {
    const std::vector<std::string>& own = variables_[kind];
    if (kind == Kind::Node && (own.empty() || chance(random_, 60))) return any_catom();
    return pick(random_, own);
}

// ---- links

std::string Body::link() { return link(any_catom()); }

std::string Body::link(const std::string& from) {
    std::vector<const Known*> routes;
    for (const Known& k : known_)
        if (k.route && (!for_linear || k.certain)) routes.push_back(&k);
    // A catom that is already known by value, now and then.
    std::string to;
    if (!for_linear && !variables_[Kind::Node].empty() && chance(random_, 15)) {
        const std::string known = pick(random_, variables_[Kind::Node]);
        if (std::find(catoms_.begin(), catoms_.end(), known) == catoms_.end()) to = known;
    }
    if (to.empty()) to = std::string(1, static_cast<char>('A' + static_cast<int>(catoms_.size())));
    const bool forward = chance(random_, 50);
    const std::string pair = forward ? from + ", " + to : to + ", " + from;
    if (!for_linear && !routes.empty() && chance(random_, 25)) {
        const Known& route = *pick(random_, routes);
        std::string text = route.name + "(" + pair;
        for (std::size_t i = 1; i < route.arguments.size(); ++i) text += ", _";
        clauses_.push_back(text + ")");
    } else if (chance(random_, 25)) {
        clauses_.push_back("neighbor(" + pair + ", " + fresh(Kind::Int) + ")");
    } else {
        clauses_.push_back("neighbor(" + pair + ")");
    }
    catoms_.push_back(to);
    return to;
}

// ---- facts

std::vector<const Known*> Body::readable() const {
    std::vector<const Known*> out;
    for (const Known& k : known_) {
        const bool by_link = !k.arguments.empty() && k.arguments[0] == Kind::Node;
        if (!k.linear && (!for_linear || (k.certain && !by_link))) out.push_back(&k);
    }
    return out;
}

std::string Body::argument(Kind kind, bool may_bind) {
    const std::int64_t way = below(random_, 100);
    const bool bound = kind == Kind::Node || has(kind);
    if (way < 12) return "_";
    if (way < 40 && bound) return variable(kind);
    if (way < 46 && kind != Kind::Node) return literal(kind);
    if (may_bind && way < 75 && kind >= Kind::List) return "[]";
    if (way < 50 && bound && kind == Kind::Int) return fmt::format("{} + {}", variable(kind), below(random_, 3));
    return may_bind ? "?" : "_";
}

void Body::read(const Known& k, const std::string& at) {
    std::vector<std::string> arguments;
    for (const Kind kind : k.arguments) arguments.push_back(argument(kind, true));
    // New variables only now, so that none is used within its own fact.
    for (std::size_t i = 0; i < arguments.size(); ++i) {
        if (arguments[i] == "?") arguments[i] = fresh(k.arguments[i]);
        if (arguments[i] == "[]") arguments[i] = pattern(k.arguments[i]);
    }
    read(k, at, arguments);
}

// A list or a struct taken apart.
std::string Body::pattern(Kind kind) {
    const auto part = [&](Kind k) {
        return has(k) && k != Kind::Node && chance(random_, 20) ? variable(k) : chance(random_, 15) ? "_" : fresh(k);
    };
    if (kind == Kind::Pair) {
        const std::string first = part(Kind::Int);
        return ":(" + first + ", " + part(Kind::Node) + ")";
    }
    switch (below(random_, 4)) {
        case 0:
            return "[]";
        case 1:
            return "[" + part(Kind::Int) + "]";
        case 2: {
            const std::string first = part(Kind::Int);
            return "[" + first + ", " + part(Kind::Int) + "]";
        }
        default: {
            const std::string head = part(Kind::Int);
            return "[" + head + " | " + part(Kind::List) + "]";
        }
    }
}

void Body::read(const Known& k, const std::string& at, const std::vector<std::string>& arguments) {
    std::string text = k.name + "(" + at;
    for (const std::string& a : arguments) text += ", " + a;
    // Held for some ticks.
    const bool stable = !k.linear && may_wait && chance(random_, 5);
    clauses_.push_back(stable ? fmt::format("stable({}), {})", text, 1 + below(random_, 4)) : text + ")");
}

void Body::read_any(const std::string& at) {
    const std::vector<const Known*> all = readable();
    // What a neighbour senses travels like any other fact, and linear rules are to see what is certain.
    const bool sensed = !for_linear || at == "A";
    if (all.empty() && !sensed) return;
    if (all.empty() || (sensed && chance(random_, 22))) return world_fact(at);
    read(*pick(random_, all), at);
}

void Body::world_fact(const std::string& at) {
    switch (below(random_, 6)) {
        case 0:
            return clauses_.push_back("id(" + at + ", " + fresh(Kind::Int) + ")");
        case 1:
            return clauses_.push_back("neighborCount(" + at + ", " + fresh(Kind::Int) + ")");
        case 2:
            return clauses_.push_back("vacant(" + at + ", " + fresh(Kind::Int) + ")");
        case 3: {
            const std::string x = fresh(Kind::Int);
            return clauses_.push_back("cell(" + at + ", " + x + ", _, _)");
        }
        case 4: {
            const char* name = chance(random_, 70) ? "position" : "at";
            if (chance(random_, 40)) {
                vectors_.push_back(fmt::format("V{}", ++next_));
                return clauses_.push_back(fmt::format("{}({}, {})", name, at, vectors_.back()));
            }
            inexact_.push_back(fmt::format("P{}", ++next_));
            const char* form = chance(random_, 20) ? "{}({}, vec3({}, _, _))" : "{}({}, {}, _, _)";
            return clauses_.push_back(fmt::format(fmt::runtime(form), name, at, inexact_.back()));
        }
        default:
            return clauses_.push_back("neighborCount(" + at + ", " + (chance(random_, 50) ? "4" : fresh(Kind::Int)) + ")");
    }
}

// ---- tests

void Body::test() {
    constexpr const char* kComparisons[] = {"=", "<>", "<", "<=", ">", ">="};
    const std::string sign = kComparisons[below(random_, 6)];
    std::string text;
    switch (below(random_, 8)) {
        case 7: {
            const Kind kind = static_cast<Kind>(4 + below(random_, 3));
            if (!has(kind)) return;
            text = fmt::format("{} {} {}", variable(kind), sign == "=" || chance(random_, 60) ? "<>" : sign, compound_expression(kind));
            break;
        }
        case 0:
            if (!has(Kind::Float)) return;
            text = fmt::format("{} {} {}", variable(Kind::Float), sign, float_expression());
            break;
        case 1:
            if (!vectors_.empty() && chance(random_, 70)) {
                text = vector_test();
                break;
            }
            if (inexact_.empty()) return;
            text = fmt::format("{} * {} {} {}", pick(random_, inexact_), pick(random_, inexact_), chance(random_, 50) ? "<" : ">",
                               literal(Kind::Float));
            break;
        case 2:
            if (!has(Kind::Bool)) return;
            text = chance(random_, 50) ? variable(Kind::Bool) : "~" + variable(Kind::Bool);
            break;
        case 3:
            if (catoms_.size() < 2) return;
            text = fmt::format("{} {} {}", variable(Kind::Node), chance(random_, 70) ? "<>" : sign, variable(Kind::Node));
            break;
        case 4:
            if (!has(Kind::Int)) return;
            text = fmt::format("{} {} {} {} {} {} {}", variable(Kind::Int), sign, literal(Kind::Int), chance(random_, 50) ? "&&" : "||",
                               variable(Kind::Int), pick(random_, std::vector<std::string>{"<", ">", "<>"}), int_expression());
            break;
        default:
            if (!has(Kind::Int)) return;
            text = fmt::format("{} {} {}", variable(Kind::Int), sign == "=" ? "<=" : sign, int_expression());
    }
    tests_[text] = true;
    clauses_.push_back(text);
}

void Body::compare_places() {
    for (int n = 0; n < 2; ++n) {
        vectors_.push_back(fmt::format("V{}", ++next_));
        clauses_.push_back(fmt::format("{}({}, {})", chance(random_, 70) ? "position" : "at", any_catom(), vectors_.back()));
    }
    clauses_.push_back(vector_test());
    tests_[clauses_.back()] = true;
}

std::string Body::vector_test() {
    const std::string v = pick(random_, vectors_), w = pick(random_, vectors_), limit = literal(Kind::Float);
    switch (below(random_, 6)) {
        case 0:
            return fmt::format("distance({}, {} * 0.5) < {}", v, w, limit);
        case 1:
            return fmt::format("x({} - {}) <= {}", v, w, limit);
        case 2:
            return fmt::format("norm({} + {}) > {}", v, w, limit);
        case 3:
            return fmt::format("dot({}, cross({}, vec3(1.0, 0.5, {}))) <> 0.25", v, w, limit);
        case 4:
            return fmt::format(
                "dot(lnth(align([{0}, {1}, vec3(1.0, 0.5, {2})], nearest_rotation({1}, vec3({2}, 0.5, 1.0), {0})), 3), {0}) < {2}", v, w,
                limit);
        default:
            return fmt::format("{} {} {}", v, chance(random_, 50) ? "<>" : "=", w);
    }
}

void Body::set() {
    if (!has(Kind::Int)) return;
    if (chance(random_, 30)) {
        const std::string by = variable(Kind::Int);
        const std::string guard = by + " <> 0", text = fmt::format("{} {} {}", below(random_, 30), chance(random_, 50) ? "/" : "%", by);
        const std::string clause = fresh(Kind::Int) + " = " + text;
        tests_[guard] = tests_[clause] = true;
        clauses_.push_back(guard);
        clauses_.push_back(clause);
        return;
    }
    const Kind kind = chance(random_, 70) ? Kind::Int : Kind::Float;
    const std::string value = expression(kind);
    const std::string variable = fresh(kind);
    const std::string clause = chance(random_, 80) ? variable + " = " + value : value + " = " + variable;
    tests_[clause] = true;
    clauses_.push_back(clause);
}

// ---- negation

std::string Body::negated_atom() {
    const std::vector<const Known*> all = readable();
    if (all.empty() || chance(random_, 10))
        return fmt::format("vacant({}, {})", for_linear ? "A" : any_catom(), chance(random_, 50) ? "_" : literal(Kind::Int));
    const Known& k = *pick(random_, all);
    std::string text = k.name + "(" + any_catom();
    for (const Kind kind : k.arguments) text += ", " + argument(kind, false);
    return text + ")";
}

void Body::negate() {
    if (chance(random_, 60)) return clauses_.push_back("not " + negated_atom());
    // None of the neighbours has it, or has it alike.
    const std::vector<const Known*> all = readable();
    if (all.empty()) return;
    const Known& k = *pick(random_, all);
    std::string text = fmt::format("not (neighbor({}, Z), {}(Z", for_linear ? "A" : any_catom(), k.name);
    std::string inner;
    for (const Kind kind : k.arguments) {
        const std::string a = argument(kind, false);
        if (a == "_" && kind == Kind::Int && inner.empty() && chance(random_, 50)) {
            inner = fmt::format(", Q {} {}", chance(random_, 50) ? "<" : ">", has(Kind::Int) ? variable(Kind::Int) : literal(Kind::Int));
            text += ", Q";
        } else {
            text += ", " + a;
        }
    }
    clauses_.push_back(text + ")" + inner + ")");
}

// Each of the neighbours has it; sometimes with nothing else beside, or has none of it.
void Body::for_all() {
    const std::vector<const Known*> all = readable();
    if (all.empty()) return;
    const Known& k = *pick(random_, all);
    std::string text = fmt::format("{}(W", k.name), inner;
    for (const Kind kind : k.arguments) {
        if (kind == Kind::Int && inner.empty() && chance(random_, 60)) {
            inner = fmt::format(", V {} {}", chance(random_, 50) ? "<" : ">=", has(Kind::Int) ? variable(Kind::Int) : literal(Kind::Int));
            text += ", V";
        } else {
            text += ", _";
        }
    }
    text += ")" + inner;
    if (chance(random_, 20)) {
        text = "not (" + text + ")";
    } else if (chance(random_, 25)) {
        const Known& other = *pick(random_, all);
        text += ", not " + other.name + "(W";
        for (std::size_t a = 0; a < other.arguments.size(); ++a) text += ", _";
        text += ")";
    }
    clauses_.push_back(fmt::format("forall neighbor({}, W) [{}]", any_catom(), text));
}

// ---- aggregates and elements

void Body::aggregate() {
    std::vector<const Known*> countable;
    for (const Known* k : readable())
        if (std::find(k->arguments.begin(), k->arguments.end(), Kind::Int) != k->arguments.end()) countable.push_back(k);
    if (countable.empty()) return;
    const Known& k = *pick(random_, countable);
    const bool around = chance(random_, 60);
    // What a neighbour would gather from its own neighbours comes later than the rest.
    const std::string at = for_linear ? "A" : any_catom();
    std::string fact = k.name + "(" + (around ? "Y" : at);
    bool taken = false;
    for (const Kind kind : k.arguments) {
        const bool takes = kind == Kind::Int && !taken;
        fact += ", " + (takes ? "G" : argument(kind, false));
        taken = taken || takes;
    }
    const std::string body =
        (around ? "neighbor(" + at + ", Y), " : "") + fact + ")" + (chance(random_, 30) ? ", G > " + literal(Kind::Int) : "");
    if (chance(random_, 20)) {
        // In whatever order they come.
        const std::string all = fmt::format("L{}", ++next_);
        clauses_.push_back(all + " = collect G : { " + body + " }");
        clauses_.push_back(fresh(Kind::List) + " = lsort(" + all + ")");
        tests_[clauses_.back()] = true;
        return;
    }
    switch (below(random_, 10)) {
        case 0:
            clauses_.push_back(fresh(Kind::Float) + " = avg G : { " + body + " }");
            return;
        case 1:
            clauses_.push_back(fmt::format("{} = {}_k({}) G : {{ {} }}", fresh(Kind::List), chance(random_, 50) ? "min" : "max",
                                           1 + below(random_, 3), body));
            return;
        case 2:
            clauses_.push_back(fmt::format("{} = {} (G > {}) : {{ {} }}", fresh(Kind::Bool), chance(random_, 50) ? "and" : "or",
                                           literal(Kind::Int), body));
            return;
        default:
            break;
    }
    const std::string op = pick(random_, std::vector<std::string>{"sum G", "sum G * 2", "count", "min G", "max G", "mixed G"});
    clauses_.push_back(fresh(Kind::Int) + " = " + op + " : { " + body + " }");
}

void Body::proved() {
    const std::vector<const Known*> all = readable();
    if (!all.empty()) clauses_.push_back(fmt::format("proved({}, {})", fresh(Kind::Int), pick(random_, all)->name));
}

void Body::change() {
    std::vector<const Known*> numbers;
    for (const Known* k : readable())
        if (std::find(k->arguments.begin(), k->arguments.end(), Kind::Int) != k->arguments.end()) numbers.push_back(k);
    if (numbers.empty()) return;
    const Known& k = *pick(random_, numbers);
    std::string text = k.name + "(A", changing;
    for (const Kind kind : k.arguments) {
        const std::string one = kind == Kind::Int && changing.empty() ? fmt::format("X{}", ++next_) : argument(kind, false);
        if (kind == Kind::Int && changing.empty()) changing = one;
        text += ", " + one;
    }
    variables_[Kind::Int].push_back(changing);
    clauses_.push_back(fmt::format("delta({}; {})) {}", changing, text,
                                   for_linear            ? "> " + literal(Kind::Int)
                                   : chance(random_, 80) ? "< 2"
                                                         : "= 0"));
}

std::string Body::far_link() {
    const std::string from = catoms_.back(), to = std::string(1, static_cast<char>('A' + static_cast<int>(catoms_.size())));
    clauses_.push_back("neighbor(" + from + ", " + to + ")");
    return to;
}

void Body::element() {
    if (!has(Kind::List)) return;
    const std::string list = variable(Kind::List);
    clauses_.push_back((chance(random_, 70) ? fresh(Kind::Int) : variable_or_literal(Kind::Int)) + " in " + list);
}

// ---- expressions

std::string Body::literal(Kind kind) {
    switch (kind) {
        case Kind::Int:
            return std::to_string(below(random_, 6));
        case Kind::Float:
            return fmt::format("{}.{}", below(random_, 4), pick(random_, std::vector<std::string>{"0", "25", "5", "75"}));
        case Kind::Bool:
            return chance(random_, 50) ? "true" : "false";
        case Kind::Node:
            return "@" + std::to_string(below(random_, 5));
        case Kind::String:
            return pick(random_, std::vector<std::string>{"\"\"", "\"a\"", "\"ab\"", "\"b\""});
        case Kind::List:
            return pick(random_, std::vector<std::string>{"[]", "[1]", "[2, 0]", "[1, 2, 3]"});
        case Kind::Pair:
            return ":(" + std::to_string(below(random_, 4)) + ", @1)";
    }
    return "";
}

std::string Body::int_expression() {
    if (!has(Kind::Int)) return chance(random_, 70) ? literal(Kind::Int) : "node2int(" + variable(Kind::Node) + ")";
    const std::string x = variable(Kind::Int);
    if (has(Kind::List) && chance(random_, 40)) return number_of_list(variable(Kind::List), x);
    if (has(Kind::String) && chance(random_, 20)) return "strlen(" + variable(Kind::String) + ")";
    if (has(Kind::Float) && chance(random_, 10))
        return pick(random_, std::vector<std::string>{"floor(", "ceil(", "round("}) + variable(Kind::Float) + ")";
    switch (below(random_, 15)) {
        case 14:
            return fmt::format("{}({}, {})", chance(random_, 50) ? "folded" : "chosen", x, variable(Kind::Int));
        case 0:
            return fmt::format("({} + {}) % 7", x, variable(Kind::Int));
        case 1:
            return fmt::format("{} - {}", x, literal(Kind::Int));
        case 2:
            return fmt::format("{} * {} % 11", x, variable(Kind::Int));
        case 3:
            return fmt::format("min({}, {})", x, variable(Kind::Int));
        case 4:
            return fmt::format("max({}, {})", x, literal(Kind::Int));
        case 5:
            return fmt::format("abs({} - {})", x, variable(Kind::Int));
        case 6:
            return fmt::format("if {} > {} then {} else {} end", x, literal(Kind::Int), variable(Kind::Int), literal(Kind::Int));
        case 7:
            return fmt::format("{} / {}", x, 1 + below(random_, 3));
        case 8:
            return fmt::format("(-{})", x);
        case 9:
            return fmt::format("if {0} <> 0 then 20 / {0} else 0 end", x);
        case 10:
            return has(Kind::Float) ? fmt::format("truncate({})", variable(Kind::Float)) : x;
        case 11:
            return fmt::format("({} % 4) ^ 2", x);
        default:
            return x;
    }
}

// What an expression says of a list; where it might have no value, it asks first.
std::string Body::number_of_list(const std::string& list, const std::string& x) {
    switch (below(random_, 7)) {
        case 0:
            return fmt::format("lsum({}) % 9", list);
        case 1:
            return fmt::format("lcount({}, {})", list, x);
        case 2:
            return fmt::format("lindex({}, {})", list, x);
        case 3:
            return fmt::format("if llength({0}) > 1 then lnth({0}, 1) else {1} end", list, x);
        case 4:
            return fmt::format("if {0} <> [] then {1}({0}) else 0 end", list,
                               pick(random_, std::vector<std::string>{"lhead", "llast", "lmin", "lmax"}));
        default:
            return "llength(" + list + ")";
    }
}

std::string Body::list_expression(const std::string& own, const std::string& x) {
    const std::string other = chance(random_, 50) ? variable_or_literal(Kind::List) : fmt::format("[{}, 2]", x);
    switch (below(random_, 16)) {
        case 0:
            return fmt::format("[{} | {}]", x, own);
        case 1:
            return fmt::format("{} ++ [{}]", own, x);
        case 2:
            return fmt::format("[{}, {}]", x, variable_or_literal(Kind::Int));
        case 3:
            return fmt::format("{} ++ {}", own, literal(Kind::List));
        case 4:
            return fmt::format("{}({})", pick(random_, std::vector<std::string>{"lsort", "lreverse", "lunique", "ltail"}), own);
        case 5:
            return fmt::format("{}({}, {})", pick(random_, std::vector<std::string>{"lunion", "ldiff", "linter", "lappend"}), own, other);
        case 6:
            return fmt::format("{}({}, {})", pick(random_, std::vector<std::string>{"ladd", "lremove"}), own, x);
        case 7:
            return fmt::format("{}({}, {})", chance(random_, 50) ? "ltake" : "ldrop", own, below(random_, 3));
        case 8:
            return fmt::format("lsublist({}, {}, {})", own, below(random_, 2), 1 + below(random_, 3));
        case 9:
            return fmt::format("set2list({}(list2set({}), list2set({})))",
                               pick(random_, std::vector<std::string>{"sunion", "sinter", "sdiff"}), own, other);
        case 10:
            return fmt::format("shortened({}, {})", x, own);
        default:
            return own;
    }
}

std::string Body::variable_or_literal(Kind kind) { return has(kind) ? variable(kind) : literal(kind); }

std::string Body::float_expression() {
    if (!has(Kind::Float)) return has(Kind::Int) && chance(random_, 60) ? "float(" + variable(Kind::Int) + ")" : literal(Kind::Float);
    const std::string f = variable(Kind::Float);
    switch (below(random_, 8)) {
        case 0:
            return fmt::format("{} + {}", f, variable(Kind::Float));
        case 1:
            return fmt::format("{} - {}", f, literal(Kind::Float));
        case 2:
            return fmt::format("min({}, {}) * 0.5", f, literal(Kind::Float));
        case 3:
            return fmt::format("max({}, {})", f, literal(Kind::Float));
        case 4:
            return has(Kind::Int) ? fmt::format("{} + {}", f, variable(Kind::Int)) : f;
        case 5:
            return fmt::format("if {} > {} then {} else {} end", f, literal(Kind::Float), literal(Kind::Float), f);
        default:
            return f;
    }
}

std::string Body::compound_expression(Kind kind) {
    const std::string own = variable_or_literal(kind), x = variable_or_literal(Kind::Int);
    if (kind == Kind::List) return list_expression(own, x);
    if (kind == Kind::Pair) return chance(random_, 40) ? own : ":(" + x + ", " + variable(Kind::Node) + ")";
    switch (below(random_, 9)) {
        case 0:
            return own + " ++ " + literal(kind);
        case 1:
            return fmt::format("if {} > 2 then {} else {} end", x, own, literal(kind));
        case 2:
            return "int2str(" + x + ")";
        case 3:
            return "node2str(" + variable(Kind::Node) + ")";
        case 4:
            return fmt::format("substr({}, {}, {})", own, below(random_, 2), below(random_, 3));
        case 5:
            return fmt::format("concat({}, {})", own, literal(kind));
        default:
            return own;
    }
}

std::string Body::expression(Kind kind) {
    switch (kind) {
        case Kind::String:
        case Kind::List:
        case Kind::Pair:
            return compound_expression(kind);
        case Kind::Int:
            return int_expression();
        case Kind::Float:
            return float_expression();
        case Kind::Bool:
            if (has(Kind::Bool) && chance(random_, 50)) return variable(Kind::Bool);
            if (has(Kind::List) && chance(random_, 40))
                return fmt::format("lexists({}, {})", variable(Kind::List), variable_or_literal(Kind::Int));
            return has(Kind::Int) ? fmt::format("if {} > {} then true else false end", variable(Kind::Int), literal(Kind::Int))
                                  : literal(Kind::Bool);
        case Kind::Node:
            return chance(random_, 92) ? variable(Kind::Node) : literal(Kind::Node);
    }
    return "";
}

std::string Body::bounded(Kind kind) {
    if (kind == Kind::Node) return variable(kind);
    if (kind == Kind::Int && has(kind)) {
        if (chance(random_, 60)) return variable(kind);
        return fmt::format("({} + {}) % {}", variable(kind), chance(random_, 50) ? "1" : variable(kind), 3 + below(random_, 4));
    }
    return has(kind) ? variable(kind) : literal(kind);
}

std::vector<std::string> Body::shuffled() {
    std::vector<std::string> tests, others, out;
    for (const std::string& c : clauses_) (is_test(c) ? tests : others).push_back(c);
    std::shuffle(others.begin(), others.end(), random_);
    std::size_t t = 0, o = 0;
    while (t < tests.size() || o < others.size()) {
        const bool take_test = o == others.size() || (t < tests.size() && chance(random_, 40));
        out.push_back(take_test ? tests[t++] : others[o++]);
    }
    return out;
}

}  // namespace meld::reference
