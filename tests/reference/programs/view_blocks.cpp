// Blocks of given facts, views and recursion through sets.
#include <fmt/format.h>

#include <algorithm>

#include "tests/reference/programs/blocks.h"

namespace meld::reference {

namespace {

std::string signature(const std::string& name, const std::vector<Kind>& arguments, const std::string& modifiers = "",
                      const std::string& aggregate = "", std::size_t at = 0, const std::string& waits = "") {
    std::string text = "type " + modifiers + name + "(node";
    for (std::size_t i = 0; i < arguments.size(); ++i)
        text += std::string(", ") + (!aggregate.empty() && at == i ? aggregate + " " : "") + name_of(arguments[i]) + (at == i ? waits : "");
    return text + ").";
}

Kind any_kind(Random& random) {
    constexpr Kind kKinds[] = {Kind::Int, Kind::Int, Kind::Int, Kind::Float, Kind::Bool, Kind::Node};
    return kKinds[below(random, 6)];
}

// compound: how many in a hundred are strings, lists and structs.
std::vector<Kind> some_kinds(Random& random, std::int64_t most, int compound) {
    std::vector<Kind> kinds(static_cast<std::size_t>(below(random, most + 1)));
    for (Kind& k : kinds) k = chance(random, compound) ? static_cast<Kind>(4 + below(random, 3)) : any_kind(random);
    return kinds;
}

void fill(Body& body, Random& random, std::int64_t links) {
    for (std::int64_t i = 0; i < links; ++i) {
        // A chain more often than a star.
        if (i > 0 && chance(random, 65))
            body.link(body.catoms().back());
        else
            body.link();
    }
    for (const std::string& at : std::vector<std::string>(body.catoms()))
        if (chance(random, body.catoms().size() == 1 ? 100 : 70)) body.read_any(at);
    if (chance(random, 40)) body.read_any(body.any_catom());
    if (chance(random, 15)) body.aggregate();
    if (chance(random, 40)) body.element();
    if (chance(random, 8)) body.proved();
    if (chance(random, 6)) body.compare_places();
    for (std::int64_t i = below(random, 3); i > 0; --i) {
        if (chance(random, 30))
            body.set();
        else
            body.test();
    }
    if (chance(random, 25)) body.negate();
    if (chance(random, 10)) body.negate();
    if (chance(random, 10)) body.for_all();
}

std::int64_t some_links(Random& random) {
    constexpr std::int64_t kLinks[] = {0, 0, 0, 1, 1, 1, 1, 2, 2, 3};
    return kLinks[below(random, 10)];
}

std::string atom(const std::string& name, const std::string& at, const std::vector<std::string>& arguments) {
    std::string text = name + "(" + at;
    for (const std::string& a : arguments) text += ", " + a;
    return text + ")";
}

// Another way to write a head or two: by a condition, for every neighbour, or of all facts of a kind.
std::string several(Body& body, Random& random, const std::string& name, const std::string& place, std::vector<std::string> arguments,
                    const std::vector<Kind>& kinds) {
    const std::string one = atom(name, place, arguments);
    switch (below(random, 3)) {
        case 0: {
            for (std::size_t i = 0; i < kinds.size(); ++i)
                if (chance(random, 50)) arguments[i] = body.literal(kinds[i]);
            return fmt::format("(if {} > {} then {} otherwise {} end)", body.expression(Kind::Int), below(random, 4), one,
                               chance(random, 30) ? "1" : atom(name, place, arguments));
        }
        case 1:
            return fmt::format("{}, {{ U | neighbor({}, U) | {} }}", one, place, atom(name, chance(random, 50) ? place : "U", arguments));
        default: {
            const auto number = std::find(kinds.begin(), kinds.end(), Kind::Int);
            if (number != kinds.end()) arguments[static_cast<std::size_t>(number - kinds.begin())] = "V % 20";
            return fmt::format("[{} => V | U | neighbor({}, U{} | {}]", number == kinds.end() || chance(random, 50) ? "count" : "sum",
                               place, number == kinds.end() ? ")" : ", V)", atom(name, place, arguments));
        }
    }
}

}  // namespace

Block given_block(Random& random, const std::vector<Known>&, int names) {
    Block block;
    retraction::Given given{
        .predicate = fmt::format("g{}", names), .arguments = {}, .per_mille = static_cast<int>(80 + below(random, 600))};
    std::vector<Kind> kinds = some_kinds(random, 2, 0);
    for (const Kind k : kinds)
        given.arguments.push_back(k == Kind::Bool   ? std::pair<std::int64_t, std::int64_t>(0, 1)
                                  : k == Kind::Node ? std::pair<std::int64_t, std::int64_t>(0, 12)
                                                    : std::pair<std::int64_t, std::int64_t>(0, 5));
    block.declarations.push_back({given.predicate, signature(given.predicate, kinds)});
    block.known.push_back({.name = given.predicate, .arguments = kinds});
    block.given.push_back(std::move(given));
    return block;
}

Block error_block(Random& random, const std::vector<Known>&, int names) {
    Block block;
    const std::string given = fmt::format("e{}", names), name = fmt::format("e{}", names + 1);
    block.declarations = {{given, signature(given, {Kind::Int})}, {name, signature(name, {Kind::Float})}};
    block.given.push_back({.predicate = given, .arguments = {{0, 30}}, .per_mille = 120});
    // Each has no value for 29 alone.
    const std::vector<std::string> expressions = {"60 / (X - 29)",
                                                  "7 % (29 - X)",
                                                  "9223372036854775806 + X / 29 + X / 29 * (30 - X)",
                                                  "3.0 / float(X - 29)",
                                                  "2 ^ (if X = 29 then -1 else 3 end)",
                                                  "sqrt(if X = 29 then -1.0 else 4.0 end)",
                                                  "truncate(if X = 29 then 1e30 else 2.5 end)",
                                                  "(if X = 29 then -9223372036854775807 - 1 else X end) / (-1)"};
    const std::string value = pick(random, expressions);
    block.rules.push_back({.heads = {atom(name, "A", {chance(random, 60) ? value : "F"})}, .body = {atom(given, "A", {"X"})}});
    if (block.rules[0].heads[0].ends_with("F)")) block.rules[0].body.push_back("F = 0.0 + " + value);
    return block;
}

Block half_settled_block(Random& random, const std::vector<Known>& known, int names) {
    Block block;
    const auto name = [&](int i) { return fmt::format("h{}", names + i); };
    const std::string dist = name(0), farthest = name(1), share = name(2), total = name(3), without = name(4);
    // Each has a value where D is at most M.
    const std::vector<std::string> expressions = {"100 / (M - D + 1)",
                                                  "7 % (D - M - 1)",
                                                  "60 / (M - D + 1) + 60 / (M - D + 2)",
                                                  "truncate(100.0 / float(M - D + 1))",
                                                  "2 ^ ((M - D) % 5)",
                                                  "lnth([3, 1, 4, 1, 5, 9, 2, 6], (M - D) % 8)",
                                                  "9223372036854775807 - (if M < D then -1 else D end) - 9223372036854775800",
                                                  "truncate(if M < D then 1e30 else float(M) end)",
                                                  "truncate(sqrt(float(M - D)))",
                                                  "str2int(if M < D then \"much\" else int2str(M % 7) end)"};
    const std::string value = pick(random, expressions);
    const bool grouped = chance(random, 50), sums = chance(random, 40);
    block.declarations = {{dist, signature(dist, {Kind::Int}, "", "min", 0)},
                          {farthest, signature(farthest, {Kind::Int}, "", "max", 0)},
                          {share, grouped ? signature(share, {Kind::Node, Kind::Int})
                                          : signature(share, {Kind::Int}, "", chance(random, 50) ? "min" : "sum", 0)},
                          {total, signature(total, {Kind::Int}, "", sums ? "sum" : "max", 0)},
                          {without, signature(without, {Kind::Int})}};
    Body source(random, known);
    fill(source, random, 0);
    block.rules.push_back({.heads = {atom(dist, "A", {"0"})}, .body = source.shuffled()});
    block.rules.push_back({.heads = {atom(dist, "B", {"D + 1"})}, .body = {"neighbor(A, B)", atom(dist, "A", {"D"})}});
    block.rules.push_back({.heads = {atom(farthest, "A", {"D"})}, .body = {atom(dist, "A", {"D"})}});
    block.rules.push_back({.heads = {atom(farthest, "B", {"M"})}, .body = {"neighbor(A, B)", atom(farthest, "A", {"M"})}});
    const auto arguments = [&](const std::string& last) {
        return grouped ? std::vector<std::string>{"B", last} : std::vector<std::string>{last};
    };
    DraftRule rule{.heads = {atom(share, "A", arguments(value))},
                   .body = {"neighbor(A, B)", atom(dist, "A", {"D"}), atom(farthest, chance(random, 50) ? "A" : "B", {"M"})}};
    if (chance(random, 35)) rule = {.heads = {atom(share, "A", arguments("S"))}, .body = rule.body};
    if (rule.heads[0].ends_with("S)")) rule.body.push_back("S = " + value);
    block.rules.push_back(rule);
    block.rules.push_back({.heads = {atom(total, "A", {sums && chance(random, 30) ? "9223372036854775807 / 3 - S % 2" : "S"})},
                           .body = {"neighbor(A, B)", grouped ? atom(share, "B", {"_", "S"}) : atom(share, "B", {"S"})}});
    block.rules.push_back({.heads = {atom(without, "A", {"X"})},
                           .body = {"neighborCount(A, X)", "not " + (grouped ? atom(share, "A", {"_", "_"}) : atom(share, "A", {"_"}))}});
    // The last has results only where something is missing.
    if (chance(random, 70)) {
        block.rules.pop_back();
        block.declarations.pop_back();
    }
    block.known = {{.name = dist, .arguments = {Kind::Int}}, {.name = total, .arguments = {Kind::Int}}};
    return block;
}

Block view_block(Random& random, const std::vector<Known>& known, int names) {
    Block block;
    const std::string name = fmt::format("v{}", names);
    std::vector<Kind> kinds = some_kinds(random, 3, 18);
    std::string aggregate;
    std::size_t at = 0;
    if (!kinds.empty() && chance(random, 45)) {
        constexpr const char* kAggregates[] = {"min", "max", "sum", "count", "first", "avg", "and", "or", "min_k(2)", "max_k(3)"};
        aggregate = kAggregates[chance(random, 70) ? below(random, 5) : 5 + below(random, 5)];
        at = static_cast<std::size_t>(below(random, static_cast<std::int64_t>(kinds.size())));
        if (chance(random, 15)) {
            // One that is not commutative, so that the order shows.
            aggregate = fmt::format("f{}", names);
            block.declarations.push_back(
                {aggregate, fmt::format("fun {}(int SoFar, int Value) : int = (3 * (SoFar % 1000) - Value % 1000) % 1000.", aggregate)});
        }
        const bool function = aggregate.starts_with("f") && aggregate != "first";
        const bool elements = aggregate.find("_k") != std::string::npos, truth = aggregate == "and" || aggregate == "or";
        if (aggregate == "sum" || aggregate == "count" || aggregate == "avg" || elements || function) at = kinds.size() - 1;
        if (aggregate == "avg") kinds[at] = Kind::Float;
        if (truth) kinds[at] = Kind::Bool;
        if (elements) kinds[at] = Kind::List;
        if (aggregate == "count" || function) kinds[at] = Kind::Int;
        const bool free = !function && !elements && !truth && aggregate != "sum" && aggregate != "count" && aggregate != "avg";
        if (free && chance(random, 10)) kinds[at] = Kind::List;
        if (free && (kinds[at] == Kind::List || kinds[at] == Kind::String)) {
            const std::int64_t way = below(random, 100);
            if (way < 40)
                aggregate = "append";
            else if (way < 80 && kinds[at] == Kind::List)
                aggregate = "set_union";
            if (way < 80) kinds.resize(at + 1);
        }
        if (aggregate == "sum") kinds[at] = chance(random, 70) ? Kind::Int : Kind::Float;
    }
    // What a rule gives: an aggregate that keeps a list of values takes them one by one.
    std::vector<Kind> given = kinds;
    if (aggregate.find("_k") != std::string::npos) given[at] = Kind::Int;
    std::string waits;
    if (!aggregate.empty() && chance(random, 35)) {
        std::vector<std::string> links{"neighbor"};
        for (const Known& k : known)
            if (k.route) links.push_back(k.name);
        waits = fmt::format(" [{} {}]", chance(random, 50) ? "<-" : "->", pick(random, links));
    }
    std::string declaration = signature(name, kinds, "", aggregate, at, waits);
    if (aggregate == "set_union") declaration.replace(declaration.find("set_union list"), 14, "set_union set");
    block.declarations.push_back({name, declaration});
    for (int rules = chance(random, 25) ? 2 : 1; rules > 0; --rules) {
        Body body(random, known);
        body.may_wait = true;
        fill(body, random, waits.empty() ? some_links(random) : 1 + below(random, 2));
        std::vector<std::string> arguments;
        for (std::size_t i = 0; i < kinds.size(); ++i)
            arguments.push_back(aggregate == "count" && i == at ? body.expression(any_kind(random)) : body.expression(given[i]));
        if (aggregate == "set_union") arguments[at] = "list2set(" + arguments[at] + ")";
        // A change is seen where the rule runs, which is where its head is.
        const bool changes = chance(random, 6);
        if (changes) body.change();
        const std::string place = changes ? "A" : body.any_catom();
        const std::string delay =
            aggregate != "first" && chance(random, 10) ? pick(random, std::vector<std::string>{"@+1", "@+2", "@+3", "@+2ms"}) : "";
        const bool many = delay.empty() && !changes && chance(random, 12);
        const std::string head = many ? several(body, random, name, place, arguments, given) : atom(name, place, arguments) + delay;
        block.rules.push_back({.heads = {head}, .body = body.shuffled()});
    }
    if (chance(random, 8)) {
        // An axiom, at one catom or at all of them.
        std::vector<std::string> arguments;
        Body body(random, known);
        for (const Kind k : given) arguments.push_back(body.literal(k));
        if (aggregate == "set_union") arguments[at] = "list2set(" + arguments[at] + ")";
        block.rules.push_back({.heads = {atom(name, chance(random, 50) ? "@2" : "A", arguments)}});
    }
    if (aggregate == "set_union") {
        // Later blocks read it as a list.
        std::vector<std::string> arguments;
        for (std::size_t i = 0; i < kinds.size(); ++i) arguments.push_back(fmt::format("X{}", i));
        const std::string listed = name + "l", set = atom(name, "A", arguments);
        arguments[at] = "set2list(" + arguments[at] + ")";
        block.declarations.push_back({listed, signature(listed, kinds)});
        block.rules.push_back({.heads = {atom(listed, "A", arguments)}, .body = {set}});
        block.known.push_back({.name = listed, .arguments = kinds});
        return block;
    }
    block.known.push_back({.name = name, .arguments = kinds});
    return block;
}

Block rounds_block(Random& random, const std::vector<Known>& known, int names) {
    Block block;
    const std::string value = fmt::format("u{}", names), around = fmt::format("u{}", names + 1), arrow = chance(random, 50) ? "<-" : "->";
    const std::string aggregate = pick(random, std::vector<std::string>{"sum", "min", "max", "count", "mixed"});
    block.declarations = {{value, signature(value, {Kind::Int, Kind::Int})},
                          {around, signature(around, {Kind::Int, Kind::Int}, "", aggregate, 1, fmt::format(" [{} neighbor]", arrow))}};
    Body body(random, known);
    fill(body, random, below(random, 2));
    block.rules.push_back({.heads = {atom(value, body.any_catom(), {"0", body.bounded(Kind::Int) + " % 7"})}, .body = body.shuffled()});
    block.rules.push_back({.heads = {atom(around, "A", {"R", chance(random, 30) ? "V + R" : "V"})},
                           .body = {chance(random, 50) ? "neighbor(A, B)" : "neighbor(B, A)", atom(value, "B", {"R", "V"})}});
    block.rules.push_back(
        {.heads = {atom(value, "A", {"R + 1", "(V + S) % 7"})},
         .body = {atom(around, "A", {"R", "S"}), atom(value, "A", {"R", "V"}), fmt::format("R < {}", 1 + below(random, 4))}});
    block.known.push_back({.name = value, .arguments = {Kind::Int, Kind::Int}});
    return block;
}

Block walks_block(Random& random, const std::vector<Known>& known, int names) {
    Block block;
    const std::string walks = fmt::format("c{}", names), reached = fmt::format("c{}", names + 1);
    const bool counted = chance(random, 40), real = !counted && chance(random, 25);
    const std::vector<Kind> kinds{Kind::Int, real ? Kind::Float : Kind::Int};
    block.declarations.push_back({walks, signature(walks, kinds, "", counted ? "count" : "sum", 1)});
    Body start(random, known);
    fill(start, random, below(random, 2));
    const std::string longer = fmt::format("K < {}", 1 + below(random, 4));
    if (counted) {
        // A set between the counts: catoms that enough walks of a length reach.
        block.declarations.push_back({reached, signature(reached, {Kind::Int})});
        block.rules.push_back({.heads = {atom(reached, start.any_catom(), {"0"})}, .body = start.shuffled()});
        block.rules.push_back({.heads = {atom(walks, "A", {"K", "B"})}, .body = {"neighbor(A, B)", atom(reached, "B", {"K"})}});
        block.rules.push_back({.heads = {atom(reached, "A", {"K + 1"})},
                               .body = {atom(walks, "A", {"K", "N"}), fmt::format("N > {}", below(random, 3)), longer}});
        block.known.push_back({.name = reached, .arguments = {Kind::Int}});
    } else {
        block.rules.push_back({.heads = {atom(walks, start.any_catom(), {"0", start.expression(kinds[1])})}, .body = start.shuffled()});
        const std::string step = real ? "N * 0.5" : chance(random, 50) ? "N" : "N % 7 - K";
        block.rules.push_back({.heads = {atom(walks, "A", {"K + 1", step})},
                               .body = {chance(random, 50) ? "neighbor(A, B)" : "neighbor(B, A)", atom(walks, "B", {"K", "N"}), longer}});
    }
    block.known.push_back({.name = walks, .arguments = kinds});
    return block;
}

// Who stays in a contest depends on who else does: on absences, numbers and sums of the round, at the catom and over links.
Block contest_block(Random& random, const std::vector<Known>& known, int names) {
    Block block;
    const auto name = [&](const char* what) { return fmt::format("{}{}", what, names); };
    const std::string in = name("in"), out = name("out"), number = name("number"), points = name("points");
    const std::string more = fmt::format("K < {}", 1 + below(random, 5));
    block.declarations = {{in, signature(in, {Kind::Int})}, {out, signature(out, {Kind::Int})}};
    Body start(random, known);
    fill(start, random, below(random, 2));
    block.rules.push_back({.heads = {atom(in, start.any_catom(), {"0"})}, .body = start.shuffled()});
    const auto at = [&](const std::string& predicate, const char* catom) { return atom(predicate, catom, {"K"}); };
    const std::vector<std::vector<std::string>> losing = {
        {at(in, "A"), "neighbor(A, B)", at(in, "B"), "A < B"},
        {at(in, "A"), "not (neighbor(A, B), " + at(in, "B") + ")"},
        {"neighbor(A, B)", at(in, "B"), "not " + at(in, "A")},
        {at(in, "A"), fmt::format("N = count : {{ neighbor(A, B), {} }}", at(in, "B")), fmt::format("N % {} = 0", 2 + below(random, 2))},
        {at(in, "A"), "not (neighbor(A, B), neighbor(B, C), " + at(in, "C") + ", C <> A)"}};
    const std::vector<std::vector<std::string>> staying = {{at(in, "A"), "not " + at(out, "A")},
                                                           {"neighbor(A, B)", at(out, "B"), "not " + at(in, "A")},
                                                           {at(in, "A"), "forall neighbor(A, B)[" + at(out, "B") + "]"},
                                                           {"neighbor(A, B)", at(in, "B"), "not (neighbor(A, C), " + at(out, "C") + ")"}};
    for (std::int64_t n = 1 + below(random, 2); n > 0; --n) block.rules.push_back({.heads = {at(out, "A")}, .body = pick(random, losing)});
    for (std::int64_t n = 1 + below(random, 2); n > 0; --n) {
        std::vector<std::string> body = pick(random, staying);
        body.push_back(more);
        block.rules.push_back({.heads = {atom(in, "A", {"K + 1"})}, .body = body});
    }
    block.known = {{.name = in, .arguments = {Kind::Int}}, {.name = out, .arguments = {Kind::Int}}};
    if (chance(random, 50)) {
        block.declarations.push_back({number, signature(number, {Kind::Int, Kind::Int}, "", "count", 1)});
        const std::string counted = at(chance(random, 50) ? in : out, "B");
        block.rules.push_back({.heads = {atom(number, "A", {"K", "B"})}, .body = {"neighbor(A, B)", counted}});
        block.rules.push_back(
            {.heads = {atom(in, "A", {"K + 1"})},
             .body = {atom(number, "A", {"K", "N"}), fmt::format("N > {}", below(random, 3)), "not " + at(out, "A"), more}});
        block.known.push_back({.name = number, .arguments = {Kind::Int, Kind::Int}});
    }
    if (chance(random, 50)) {
        block.declarations.push_back({points, signature(points, {Kind::Int, Kind::Int}, "", "sum", 1)});
        block.rules.push_back({.heads = {atom(points, "A", {"0", "1"})}, .body = {at(in, "A")}});
        block.rules.push_back({.heads = {atom(points, "A", {"K + 1", "X"})}, .body = {atom(points, "A", {"K", "X"}), at(in, "A"), more}});
        block.rules.push_back({.heads = {atom(points, "A", {"K + 1", "X % 3"})},
                               .body = {"neighbor(A, B)", atom(points, "B", {"K", "X"}), "not " + at(out, "B"), more}});
        block.known.push_back({.name = points, .arguments = {Kind::Int, Kind::Int}});
    }
    return block;
}

// p and q, each with rules from below and rules over themselves.
Block set_recursion_block(Random& random, const std::vector<Known>& known, int names) {
    Block block;
    std::vector<Known> own;
    for (std::int64_t i = 0, n = 1 + below(random, 3); i < n; ++i) {
        std::vector<Kind> kinds;
        const std::int64_t form = below(random, 5);
        if (form == 1) kinds = {Kind::Int};
        if (form == 2) kinds = {Kind::Int, Kind::Int};
        if (form == 3) kinds = {Kind::Node};
        if (form == 4) kinds = {Kind::Node, Kind::Int};
        own.push_back({.name = fmt::format("r{}", names + static_cast<int>(i)), .arguments = kinds});
        block.declarations.push_back({own.back().name, signature(own.back().name, kinds)});
    }
    const auto rule = [&](const Known& head, Body& body) {
        std::vector<std::string> arguments;
        for (const Kind k : head.arguments) arguments.push_back(body.bounded(k));
        block.rules.push_back({.heads = {atom(head.name, body.any_catom(), arguments)}, .body = body.shuffled()});
    };
    const bool local = chance(random, 20);
    for (std::size_t i = 0; i < own.size(); ++i) {
        if (i == 0 || chance(random, 60)) {
            Body body(random, known);
            fill(body, random, below(random, 2));
            rule(own[i], body);
        }
        for (std::int64_t n = 1 + below(random, 2); n > 0; --n) {
            Body body(random, known);
            for (std::int64_t links = local ? 0 : pick(random, std::vector<std::int64_t>{0, 1, 1, 1, 1, 2}); links > 0; --links)
                body.link();
            // One that comes before in the circle, and maybe another.
            body.read(own[(i + own.size() - 1) % own.size()], body.any_catom());
            if (chance(random, 30)) body.read(pick(random, own), body.any_catom());
            if (chance(random, 60)) body.read_any(body.any_catom());
            if (chance(random, 25)) body.test();
            if (chance(random, 15)) body.negate();
            rule(own[i], body);
        }
    }
    block.known = own;
    return block;
}

// What improves gets worse with every step, or stays, but by way of a set.
Block best_recursion_block(Random& random, const std::vector<Known>& known, int names) {
    Block block;
    const bool least = chance(random, 65), real = chance(random, 15);
    const Kind kind = real ? Kind::Float : Kind::Int;
    const Kind group_kind = chance(random, 50) ? Kind::Node : Kind::Int;
    const bool group = chance(random, 35), ride = chance(random, 35);
    const int ways = chance(random, 25) ? 2 : 1;
    bool guarded = false, handed_on = false;
    std::vector<Known> own;
    for (int i = 0; i < ways; ++i) {
        std::vector<Kind> kinds;
        if (group) kinds.push_back(group_kind);
        kinds.push_back(kind);
        if (ride) kinds.push_back(Kind::Node);
        own.push_back({.name = fmt::format("m{}", names + i), .arguments = kinds});
        block.declarations.push_back({own.back().name, signature(own.back().name, kinds, "", least ? "min" : "max", group ? 1 : 0)});
    }
    const auto arguments = [&](const std::string& key, const std::string& value, const std::string& rider) {
        std::vector<std::string> all;
        if (group) all.push_back(key);
        all.push_back(value);
        if (ride) all.push_back(rider);
        return all;
    };
    for (std::size_t i = 0; i < own.size(); ++i) {
        if (i == 0 || chance(random, 30)) {
            Body body(random, known);
            fill(body, random, below(random, 2));
            block.rules.push_back(
                {.heads = {atom(
                     own[i].name, "A",
                     arguments(body.bounded(group_kind), chance(random, 50) ? body.literal(kind) : body.bounded(kind), body.any_catom()))},
                 .body = body.shuffled()});
        }
        for (std::int64_t n = chance(random, 25) ? 2 : 1; n > 0; --n) {
            Body body(random, known);
            const bool local = group && chance(random, 20);
            const std::string from = local ? "A" : body.link(), to = from == "A" ? body.any_catom() : "A";
            if (chance(random, 55)) body.read_any(body.any_catom());
            std::string step = real ? "0.5" : std::to_string(below(random, 3));
            if (body.has(kind) && chance(random, 60)) step = "abs(" + body.variable(kind) + ")";
            std::string key = "K";
            if (group && group_kind == Kind::Int && chance(random, 40)) key = body.bounded(Kind::Int);
            const std::string other = body.has(kind) ? body.variable(kind) : body.literal(kind);
            const std::string value = chance(random, 25) ? fmt::format("{}(D, {})", least ? "max" : "min", other)
                                                         : fmt::format("D {} {}", least ? "+" : "-", step);
            const std::string rider = chance(random, 50) ? from : "R";
            handed_on = handed_on || (ride && rider == "R");
            if (chance(random, 20)) body.negate();
            std::vector<std::string> read = arguments("K", "D", rider == "R" ? "R" : "_");
            if (key != "K" && group) read[0] = chance(random, 50) ? "_" : body.has(Kind::Int) ? body.variable(Kind::Int) : "_";
            body.read(own[(i + 1) % own.size()], from, read);
            // Better values satisfy it all the more.
            const bool guards = chance(random, 30);
            guarded = guarded || guards;
            if (guards) body.clause(least ? fmt::format("D < {}", real ? "6.0" : "12") : fmt::format("D > {}", real ? "-6.0" : "-12"));
            block.rules.push_back({.heads = {atom(own[i].name, to, arguments(key, value, rider))}, .body = body.shuffled()});
        }
    }
    if (!group && chance(random, 20)) {
        // A set within the same stratum. What it leads to is worse than what it comes from; or, where it asks only whether there
        // is a value, better than all others. Then values that were replaced must still lead on, which payloads need not.
        const std::string name = fmt::format("m{}", names + ways);
        const bool better = !(guarded && handed_on) && chance(random, 50);
        block.declarations.push_back({name, signature(name, {})});
        DraftRule some{.heads = {atom(name, "A", {})}, .body = {atom(own[0].name, "A", arguments("", better ? "_" : "D", "_"))}};
        if (!better) some.body.push_back(fmt::format("D {}3{}", least ? "< " : "> -", real ? ".0" : ""));
        block.rules.push_back(std::move(some));
        const std::string value = fmt::format("{}{}{}", least == better ? "-" : "", better ? 9 : 4, real ? ".0" : "");
        block.rules.push_back(
            {.heads = {atom(own[0].name, "B", arguments("", value, "A"))}, .body = {"neighbor(A, B)", atom(name, "A", {})}});
        block.known.push_back({.name = name});
    }
    block.known.insert(block.known.end(), own.begin(), own.end());
    return block;
}

// Values that improve through what follows from them: sets ask whether there is one, or one within a bound, and better ones come
// of that, or are computed, up to a limit. All rules are monotone, so the model is finite and one.
Block improving_block(Random& random, const std::vector<Known>& known, int names) {
    Block block;
    const bool least = chance(random, 65), real = chance(random, 15), group = chance(random, 30), ride = chance(random, 15);
    const Kind kind = real ? Kind::Float : Kind::Int;
    const auto number = [&](std::int64_t n) { return fmt::format("{}{}", n, real ? ".0" : ""); };
    std::vector<Known> values, sets;
    for (std::int64_t i = 0, n = 1 + below(random, 2); i < n; ++i) {
        std::vector<Kind> kinds;
        if (group) kinds.push_back(Kind::Int);
        kinds.push_back(kind);
        if (ride) kinds.push_back(Kind::Node);
        values.push_back({.name = fmt::format("i{}", names + static_cast<int>(i)), .arguments = kinds});
        block.declarations.push_back({values.back().name, signature(values.back().name, kinds, "", least ? "min" : "max", group ? 1 : 0)});
    }
    for (std::int64_t i = 0, n = below(random, 3); i < n; ++i) {
        sets.push_back({.name = fmt::format("i{}", names + static_cast<int>(values.size()) + static_cast<int>(i)),
                        .arguments = group ? std::vector{Kind::Int} : std::vector<Kind>{}});
        block.declarations.push_back({sets.back().name, signature(sets.back().name, sets.back().arguments)});
    }
    const auto value_atom = [&](const std::string& name, const std::string& at, const std::string& key, const std::string& value,
                                const std::string& rider) {
        std::vector<std::string> all;
        if (group) all.push_back(key);
        all.push_back(value);
        if (ride) all.push_back(rider);
        return atom(name, at, all);
    };
    const auto set_atom = [&](const std::string& name, const std::string& at, const std::string& key) {
        return atom(name, at, group ? std::vector{key} : std::vector<std::string>{});
    };
    const auto rule = [&](const std::string& head, Body& body) { block.rules.push_back({.heads = {head}, .body = body.shuffled()}); };
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (i > 0 && chance(random, 60)) continue;
        Body body(random, known);
        fill(body, random, below(random, 2));
        rule(value_atom(values[i].name, "A", fmt::format("{}", below(random, 2)), number(below(random, 13) - 3), "A"), body);
    }
    for (const Known& set : sets)
        for (std::int64_t n = chance(random, 30) ? 2 : 1; n > 0; --n) {
            Body body(random, known);
            const std::string from = chance(random, 80) ? body.link() : "A";
            if (chance(random, 30)) body.read_any(body.any_catom());
            const bool bounded = chance(random, 45);
            std::string bound = number(below(random, 12) - 3);
            if (body.has(kind) && chance(random, 40)) bound = body.variable(kind);
            body.clause(value_atom(pick(random, values).name, from, "K", bounded ? "D" : "_", "_"));
            if (bounded) body.clause(fmt::format("D {} {}", least ? "<" : ">", bound));
            if (chance(random, 15)) body.clause(set_atom(pick(random, sets).name, from, "K"));
            rule(set_atom(set.name, "A", "K"), body);
        }
    for (const Known& set : sets) {
        Body body(random, known);
        const std::string from = chance(random, 80) ? body.link() : "A";
        if (chance(random, 30)) body.read_any(body.any_catom());
        body.clause(set_atom(set.name, from, "K"));
        rule(value_atom(pick(random, values).name, "A", "K", number(below(random, 13) - 3), from), body);
    }
    for (const Known& value : values)
        for (std::int64_t n = chance(random, 40) ? 2 : 1; n > 0; --n) {
            Body body(random, known);
            const std::string from = chance(random, 85) ? body.link() : "A";
            if (chance(random, 30)) body.read_any(body.any_catom());
            const std::string away = least ? "+" : "-", closer = least ? "-" : "+", worst = least ? "max" : "min",
                              best = least ? "min" : "max";
            const std::vector<std::string> steps = {fmt::format("D {} {}", away, number(1 + below(random, 2))),
                                                    "D",
                                                    fmt::format("{}(D {} {}, {})", worst, closer, number(1), number(below(random, 5) - 3)),
                                                    fmt::format("{}(D, {})", best, number(below(random, 9) - 2)),
                                                    fmt::format("{}(D, {})", worst, number(below(random, 9) - 2)),
                                                    real ? "D" : "D / 2",
                                                    real ? "0.0 + D" : fmt::format("stepped(D, {})", 1 + below(random, 3))};
            body.clause(value_atom(pick(random, values).name, from, "K", "D", "_"));
            if (chance(random, 30)) body.clause(fmt::format("D {} {}", least ? "<" : ">", number(least ? 9 : -9)));
            if (!sets.empty() && chance(random, 25)) body.clause(set_atom(pick(random, sets).name, chance(random, 50) ? from : "A", "K"));
            rule(value_atom(value.name, "A", "K", pick(random, steps), from), body);
        }
    block.known.insert(block.known.end(), values.begin(), values.end());
    block.known.insert(block.known.end(), sets.begin(), sets.end());
    return block;
}

Block tree_block(Random& random, const std::vector<Known>& known, int names) {
    Block block;
    const std::string dist = fmt::format("d{}", names), parent = fmt::format("d{}", names + 1), total = fmt::format("d{}", names + 2);
    const bool ride = chance(random, 40), count = chance(random, 25), real = !count && chance(random, 20);
    block.declarations.push_back({dist, signature(dist, ride ? std::vector{Kind::Int, Kind::Node} : std::vector{Kind::Int}, "", "min", 0)});
    Body source(random, known);
    fill(source, random, 0);
    block.rules.push_back(
        {.heads = {atom(dist, "A", ride ? std::vector<std::string>{"0", "A"} : std::vector<std::string>{"0"})}, .body = source.shuffled()});
    block.rules.push_back(
        {.heads = {atom(dist, "B", ride ? std::vector<std::string>{"D + 1", "A"} : std::vector<std::string>{"D + 1"})},
         .body = {"neighbor(A, B)", atom(dist, "A", ride ? std::vector<std::string>{"D", "_"} : std::vector<std::string>{"D"})}});
    block.declarations.push_back({parent, ride ? signature(parent, {Kind::Node}, "route ")
                                               : signature(parent, {Kind::Node}, "route ", chance(random, 50) ? "min" : "max", 0)});
    if (ride)
        block.rules.push_back({.heads = {atom(parent, "A", {"P"})}, .body = {atom(dist, "A", {"D", "P"}), "D > 0"}});
    else
        block.rules.push_back(
            {.heads = {atom(parent, "A", {"P"})},
             .body = {"neighbor(A, P)", atom(dist, "P", {"D"}), atom(dist, "A", {chance(random, 50) ? "E" : "D + 1"}), "E = D + 1"}});
    if (!ride && block.rules.back().body[2].find('E') == std::string::npos) block.rules.back().body.pop_back();
    block.declarations.push_back({total, signature(total, {real ? Kind::Float : Kind::Int}, "", count ? "count" : "sum", 0)});
    Body weight(random, known);
    fill(weight, random, 0);
    block.rules.push_back({.heads = {atom(total, "A", {weight.expression(real ? Kind::Float : Kind::Int)})}, .body = weight.shuffled()});
    if (chance(random, 75))
        block.rules.push_back({.heads = {atom(total, "A", {"S"})}, .body = {atom(parent, "B", {"A"}), atom(total, "B", {"S"})}});
    else
        block.rules.push_back(
            {.heads = {atom(total, "A", {real ? "S * 0.5" : "S + 1"})}, .body = {atom(parent, "A", {"B"}), atom(total, "B", {"S"})}});
    block.known = {{.name = dist, .arguments = ride ? std::vector{Kind::Int, Kind::Node} : std::vector{Kind::Int}},
                   {.name = parent, .arguments = {Kind::Node}, .route = true},
                   {.name = total, .arguments = {real ? Kind::Float : Kind::Int}}};
    return block;
}

}  // namespace meld::reference
