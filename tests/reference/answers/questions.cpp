#include "tests/reference/answers/questions.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>

#include "compiler/front/body.h"
#include "tests/reference/evaluator/solver.h"
#include "tests/reference/trials/run.h"

namespace meld::reference {

namespace {

// What a question may not ask, or what counts at the catom of a rule; and what depends on the order in which facts are looked at.
bool can_be_asked(const std::string& body) {
    const auto none_of = {"delta(", "randint(", "stable(", "proved(", "collect ", "custom "};
    return std::ranges::none_of(none_of, [&](const char* word) { return body.find(word) != std::string::npos; });
}

// Facts of predicates by chance, which share a value of one type and no catom.
class Join {
  public:
    Join(Random& random, const check::Program& program) : random_(random), program_(program) {
        for (const check::PredicateId id : program.predicates.ids()) {
            const check::Predicate& p = program.predicates[id];
            if (p.world == check::WorldSource::None && p.kind != check::PredicateKind::Action && !p.prelude && p.arguments.size() > 1 &&
                p.name.find('@') == std::string::npos)
                known_.push_back(&p);
        }
    }
    std::optional<std::string> body() {
        if (known_.empty()) return std::nullopt;
        const check::Predicate& first = *pick(random_, known_);
        const std::size_t at = 1 + static_cast<std::size_t>(below(random_, static_cast<std::int64_t>(first.arguments.size()) - 1));
        const check::Type& type = first.arguments[at].type;
        std::vector<std::string> clauses{fact(first, at, "A")};
        std::vector<std::pair<const check::Predicate*, std::size_t>> others;
        for (const check::Predicate* p : known_)
            for (std::size_t i = 1; i < p->arguments.size(); ++i)
                if (p->arguments[i].type == type) others.emplace_back(p, i);
        if (chance(random_, 60)) {
            const auto& [p, i] = pick(random_, others);
            clauses.push_back(fact(*p, i, "B"));
        }
        // The reference reads linear facts only where the rest of a body has said at which catom.
        std::erase_if(others, [](const auto& other) { return other.first->linear(); });
        if (!others.empty() && chance(random_, 30)) {
            const auto& [p, i] = pick(random_, others);
            clauses.push_back("not " + fact(*p, i, "_"));
        }
        if (!others.empty() && chance(random_, 40)) {
            const auto& [p, i] = pick(random_, others);
            clauses.push_back(fmt::format("N = count : {{ {} }}", fact(*p, i, "C")));
        }
        if (!others.empty() && chance(random_, 40)) {
            const auto& [p, i] = pick(random_, others);
            if (const auto of = argument_of(*p, check::Type::Int, i)) {
                // Apart, so that every compiler draws in this order.
                const std::string aggregate = pick(random_, std::vector<std::string>{"sum", "min", "max"});
                clauses.push_back(fmt::format("S = {} W : {{ {} }}", aggregate, fact(*p, i, "C", of, "W")));
            }
        }
        const check::Predicate& listed = *pick(random_, known_);
        if (const auto of = argument_of(listed, check::Type::list_of(check::Type::Int), 0); of && chance(random_, 60)) {
            clauses.push_back(fact(listed, 0, "D", of, "L"));
            clauses.push_back("X in L");
        }
        if (chance(random_, 30)) clauses.push_back("neighbor(A, E)");
        std::ranges::shuffle(clauses, random_);
        return fmt::format("{}", fmt::join(clauses, ", "));
    }

  private:
    // An argument of this type, but not the one that is shared.
    std::optional<std::size_t> argument_of(const check::Predicate& p, const check::Type& type, std::size_t shared) const {
        for (std::size_t i = 1; i < p.arguments.size(); ++i)
            if (i != shared && p.arguments[i].type == type) return i;
        return std::nullopt;
    }
    std::string fact(const check::Predicate& p, std::size_t shared, const std::string& at, std::optional<std::size_t> named = {},
                     const std::string& name = "") {
        std::string text = p.name + "(" + at;
        for (std::size_t i = 1; i < p.arguments.size(); ++i)
            text += i == named                                      ? ", " + name
                    : i == shared                                   ? ", V"
                    : chance(random_, 50) || at == "_" || at == "C" ? ", _"
                                                                    : fmt::format(", {}{}", at, i);
        return text + ")";
    }

    Random& random_;
    const check::Program& program_;
    std::vector<const check::Predicate*> known_;
};

// The catoms at which linear facts are read: the solver must know them before it reads.
std::vector<std::size_t> places_of_linear(const check::Program& program, const std::vector<check::Clause>& body) {
    std::vector<std::size_t> places;
    for (const check::Clause& c : body)
        if (c.kind == check::Clause::Kind::Atom && program.predicates[c.atom.predicate].linear())
            places.push_back(c.atom.arguments[0].variable.index());
    std::ranges::sort(places);
    places.erase(std::unique(places.begin(), places.end()), places.end());
    return places;
}

// A question consumes nothing.
void only_read(std::vector<check::Clause>& body) {
    for (check::Clause& c : body) {
        c.atom.read_only = true;
        only_read(c.inner);
    }
}

}  // namespace

std::optional<std::string> make_question(Random& random, const Draft& draft, const check::Program& program) {
    std::optional<std::string> body;
    if (!draft.rules.empty() && chance(random, 60)) {
        const DraftRule& rule = pick(random, draft.rules);
        if (!rule.body.empty()) body = fmt::format("{}", fmt::join(rule.body, ", "));
    } else {
        body = Join(random, program).body();
    }
    return body && can_be_asked(*body) ? body : std::nullopt;
}

Rows answer(const inspect::Program& asked, const Scene& scene, const Facts& facts, const std::vector<Bag>& linear) {
    check::Rule rule = asked.question();
    only_read(rule.body);
    const std::vector<check::VariableId> variables = front::answers(rule);
    const std::vector<std::size_t> places = places_of_linear(asked.checked(), rule.body);
    Rows rows;
    Environment env(rule.variables.count());
    const Sight sight{scene, facts, &linear};
    const std::function<void(std::size_t)> from = [&](std::size_t i) {
        if (i < places.size()) {
            for (const auto& [catom, links] : scene.links) {
                env[places[i]] = value_of(catom);
                from(i + 1);
            }
            env[places[i]].reset();
            return;
        }
        Solver solver(sight);
        solver.solve(rule.body, env, [&] {
            Row row;
            for (const check::VariableId v : variables) row.push_back(*env[v.index()]);
            rows.insert(std::move(row));
            return false;
        });
    };
    from(0);
    return rows;
}

namespace {

Value value_of_cell(const check::Type& type, meld::Value v) {
    if (type == check::Type::String)
        return {v.list == nullptr ? std::string() : std::string(reinterpret_cast<const char*>(v.list->items), v.list->count)};
    if (!type.compound()) return type == check::Type::Float ? value_of(v.real) : value_of(v.integer);
    Values items;
    for (std::size_t i = 0; i < tuple::length(v.list); ++i) {
        const check::Type& part = type == check::Type::Vec3                                                         ? check::Type::Float
                                  : type.kind == check::Type::Kind::Struct || type.kind == check::Type::Kind::Tuple ? type.parts[i]
                                                                                                                    : type.parts[0];
        items.push_back(value_of_cell(part, tuple::item(v.list, i)));
    }
    return value_of(std::move(items));
}

}  // namespace

Rows rows_of(const inspect::Table& table) {
    Rows rows;
    for (std::size_t row = 0; row < table.rows(); ++row) {
        Row out;
        for (std::size_t i = 0; i < table.columns().size(); ++i) out.push_back(value_of_cell(table.columns()[i].type, table.cell(row, i)));
        rows.insert(std::move(out));
    }
    return rows;
}

}  // namespace meld::reference
