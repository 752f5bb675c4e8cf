#include "tests/reference/programs/variants.h"

#include <fmt/format.h>

#include <algorithm>
#include <regex>

#include "tests/reference/evaluator/model.h"
#include "tests/reference/programs/body.h"

namespace meld::reference {

namespace {

using retraction::Random;

// p(A, X, [Y | _]): nothing but an atom.
bool is_atom(const std::string& clause) {
    static const std::regex beginning(R"(^[a-z][\w-]*\()");
    if (!std::regex_search(clause, beginning) || clause.starts_with("not ") || clause.starts_with("delta(")) return false;
    int depth = 0;
    for (std::size_t i = 0; i < clause.size(); ++i) {
        depth += clause[i] == '(' ? 1 : clause[i] == ')' ? -1 : 0;
        if (depth == 0 && clause[i] == ')') return i + 1 == clause.size();
    }
    return false;
}

// Atoms change places; what lies between them stays in its order, since one test may guard the next.
void reorder(Random& random, std::vector<std::string>& body) {
    std::vector<std::string> atoms, others;
    for (const std::string& clause : body) (is_atom(clause) ? atoms : others).push_back(clause);
    std::shuffle(atoms.begin(), atoms.end(), random);
    body.clear();
    for (std::size_t a = 0, o = 0; a < atoms.size() || o < others.size();) {
        const bool takes_atom = o == others.size() || (a < atoms.size() && chance(random, 50));
        body.push_back(takes_atom ? atoms[a++] : others[o++]);
    }
}

// Once more, where all of it is bound already, so that there are no more ways than before.
bool repeat(Random& random, std::vector<std::string>& body) {
    std::vector<std::string> atoms;
    for (const std::string& clause : body)
        if (is_atom(clause) && clause.find('_') == std::string::npos) atoms.push_back(clause);
    if (atoms.empty()) return false;
    const auto at = body.begin() + below(random, static_cast<std::int64_t>(body.size()) + 1);
    body.insert(at, pick(random, atoms));
    return true;
}

// The words of a text, one after the other, with what lies between them.
std::string each_word(const std::string& text, const std::function<std::string(const std::string&)>& replace) {
    static const std::regex word(R"(\$?[A-Za-z_](?:[\w]|-(?=[A-Za-z]))*)");
    std::string out;
    auto from = text.cbegin();
    for (std::sregex_iterator at(text.begin(), text.end(), word), end; at != end; ++at) {
        out.append(from, text.cbegin() + at->position());
        out += replace(at->str());
        from = text.cbegin() + at->position() + at->length();
    }
    return out.append(from, text.cend());
}

// What the predicates of a program are derived from, by any number of rules.
class Reads {
  public:
    explicit Reads(const Draft& draft) {
        for (const DraftRule& rule : draft.rules)
            for (const std::string& head : rule.heads)
                each_word(head, [&](const std::string& name) {
                    for (const std::string& clause : rule.body)
                        each_word(clause, [&](const std::string& read) {
                            reads_[name].insert(read);
                            return read;
                        });
                    return name;
                });
    }
    bool recursive(const DraftRule& rule) const {
        std::set<std::string> seen, heads;
        for (const std::string& head : rule.heads)
            each_word(head, [&](const std::string& name) {
                heads.insert(name);
                return name;
            });
        std::vector<std::string> open(heads.begin(), heads.end());
        while (!open.empty()) {
            const auto found = reads_.find(open.back());
            open.pop_back();
            if (found == reads_.end()) continue;
            for (const std::string& name : found->second) {
                if (heads.contains(name) && name[0] >= 'a' && name[0] <= 'z') return true;
                if (seen.insert(name).second) open.push_back(name);
            }
        }
        return false;
    }

  private:
    std::map<std::string, std::set<std::string>> reads_;
};

// Whether all arguments of the atom's predicate are numbers and nodes.
bool is_plain(const Draft& draft, const std::string& atom) {
    const std::string name = atom.substr(0, atom.find('('));
    return std::ranges::none_of(draft.declarations, [&](const Declaration& d) {
        return d.name == name && (d.text.find(":(") != std::string::npos || d.text.find("set ") != std::string::npos ||
                                  d.text.find("list ") != std::string::npos);
    });
}

// By a number that an atom binds. Not in a recursion: a value that is asked for its remainder is not the best one any more.
bool split(Random& random, Draft& draft) {
    const Reads reads(draft);
    static const std::regex number(R"(\bX\d+\b)");
    std::vector<std::pair<std::size_t, std::string>> ways;
    for (std::size_t r = 0; r < draft.rules.size(); ++r) {
        if (reads.recursive(draft.rules[r])) continue;
        for (const std::string& clause : draft.rules[r].body)
            if (is_atom(clause) && is_plain(draft, clause) && clause.find('+') == std::string::npos)
                for (std::sregex_iterator at(clause.begin(), clause.end(), number), end; at != end; ++at) ways.emplace_back(r, at->str());
    }
    if (ways.empty()) return false;
    const auto& [r, variable] = pick(random, ways);
    const std::int64_t of = 2 + below(random, 2);
    DraftRule other = draft.rules[r];
    draft.rules[r].body.push_back(fmt::format("{} % {} = 0", variable, of));
    other.body.push_back(fmt::format("{} % {} <> 0", variable, of));
    draft.rules.push_back(std::move(other));
    return true;
}

std::map<std::string, std::string> new_names(const check::Program& program, const Draft& draft) {
    std::map<std::string, std::string> names;
    std::size_t left = draft.declarations.size();
    for (const Declaration& d : draft.declarations)
        for (const PredicateId p : program.predicates.ids())
            // In the opposite order, if they are sorted.
            if (program.predicates[p].name == d.name && !names.contains(d.name)) names[d.name] = fmt::format("q{:03}", left--);
    return names;
}

void rename(Draft& draft, const std::map<std::string, std::string>& names) {
    const auto renamed = [&](std::string& text) {
        text = each_word(text, [&](const std::string& word) { return names.contains(word) ? names.at(word) : word; });
    };
    for (Declaration& d : draft.declarations) renamed(d.name), renamed(d.text);
    for (DraftRule& rule : draft.rules) {
        for (std::string& head : rule.heads) renamed(head);
        for (std::string& clause : rule.body) renamed(clause);
    }
    for (retraction::Given& g : draft.given) renamed(g.predicate);
}

std::int64_t number_in(const std::map<std::int64_t, std::int64_t>& numbers, std::int64_t id) {
    const auto found = numbers.find(id);
    return found == numbers.end() ? id : found->second;
}

Value renumber(const check::Type& type, const Value& value, const std::map<std::int64_t, std::int64_t>& numbers) {
    if (type == check::Type::Node) return value_of(number_in(numbers, value.integer()));
    if (type.parts.empty()) return value;
    Values items;
    const Values& old = value.items();
    for (std::size_t i = 0; i < old.size(); ++i) items.push_back(renumber(type.parts[std::min(i, type.parts.size() - 1)], old[i], numbers));
    return value_of(std::move(items));
}

void permute(Random& random, Trial& trial, const check::Program& program, std::map<std::int64_t, std::int64_t>& numbers) {
    retraction::Case& world = trial.world;
    std::vector<std::int64_t> ids;
    for (const world::Cell& cell : world.cells) ids.push_back(cell.x);
    std::vector<std::int64_t> others = ids;
    std::shuffle(others.begin(), others.end(), random);
    for (std::size_t i = 0; i < ids.size(); ++i) numbers[ids[i]] = others[i];
    const auto moved = [&](world::Cell& cell) { cell = retraction::node(static_cast<std::uint64_t>(number_in(numbers, cell.x))); };
    std::set<std::pair<std::uint64_t, std::uint64_t>> links;
    for (const auto& [a, b] : world.links) {
        const auto there = [&](std::uint64_t id) { return static_cast<std::uint64_t>(number_in(numbers, static_cast<std::int64_t>(id))); };
        links.insert(std::minmax(there(a), there(b)));
    }
    world.links = std::move(links);
    for (auto& burst : world.bursts)
        for (retraction::Change& change : burst) {
            moved(change.cell);
            moved(change.to);
            if (change.kind > retraction::Change::Kind::Take) continue;
            const retraction::Given& given = trial.draft.given[change.given];
            for (const PredicateId p : program.predicates.ids())
                if (program.predicates[p].name == given.predicate)
                    for (std::size_t i = 0; i < change.arguments.size(); ++i)
                        if (program.predicates[p].arguments[i + 1].type == check::Type::Node)
                            change.arguments[i] = number_in(numbers, change.arguments[i]);
        }
}

}  // namespace

Draft views_of(const Draft& draft) {
    Draft out = draft;
    std::erase_if(out.rules, [](const DraftRule& rule) { return rule.linear || !rule.select.empty(); });
    return out;
}

std::string describe(const Variation& v) {
    std::string text;
    for (const auto& [is, word] : {std::pair(v.reordered, "reordered"), std::pair(v.redundant, "redundant atoms"),
                                   std::pair(v.split, "split"), std::pair(v.renamed, "renamed"), std::pair(v.permuted, "other numbers")})
        if (is) text += fmt::format("{}{}", text.empty() ? "" : ", ", word);
    return text;
}

Varied vary(const Trial& trial, const check::Program& program, const Variation& variation, std::uint64_t seed) {
    Random random(seed);
    Varied out{.trial = trial};
    Draft& draft = out.trial.draft;
    if (variation.permuted) {
        permute(random, out.trial, program, out.numbers);
        ++out.changes;
    }
    if (variation.split)
        for (int n = 0; n < 2; ++n) out.changes += split(random, draft);
    for (DraftRule& rule : draft.rules) {
        if (variation.redundant && chance(random, 60)) out.changes += repeat(random, rule.body);
        if (variation.reordered && rule.body.size() > 1) reorder(random, rule.body), ++out.changes;
    }
    if (variation.reordered) {
        std::shuffle(draft.rules.begin(), draft.rules.end(), random);
        std::shuffle(draft.declarations.begin(), draft.declarations.end(), random);
    }
    if (variation.renamed) {
        out.names = new_names(program, trial.draft);
        rename(draft, out.names);
        out.changes += out.names.size();
    }
    return out;
}

bool comparable(const check::Program& program, const Variation& variation) {
    for (const check::Stratum& stratum : program.strata)
        for (const PredicateId p : stratum.predicates) {
            const check::Predicate& predicate = program.predicates[p];
            if (predicate.prelude) continue;
            if (left_to_history(predicate, stratum)) return false;
            // Of equal values the least payload is kept, and which one that is depends on the numbers of nodes.
            const bool payload = keeps_best(predicate.aggregate) && predicate.aggregate_at + 1 < predicate.arguments.size();
            if (variation.permuted && payload) return false;
        }
    return true;
}

Facts translate(const check::Program& program, const Facts& facts, const check::Program& other, const Varied& varied) {
    Facts out(other.predicates.count());
    for (const PredicateId p : program.predicates.ids()) {
        const check::Predicate& predicate = program.predicates[p];
        const auto renamed = varied.names.find(predicate.name);
        const std::string& name = renamed == varied.names.end() ? predicate.name : renamed->second;
        for (const PredicateId q : other.predicates.ids()) {
            if (other.predicates[q].name != name || other.predicates[q].arguments.size() != predicate.arguments.size()) continue;
            for (const Row& row : facts[p.index()]) {
                Row there;
                for (std::size_t i = 0; i < row.size(); ++i) there.push_back(renumber(predicate.arguments[i].type, row[i], varied.numbers));
                out[q.index()].insert(std::move(there));
            }
        }
    }
    return out;
}

}  // namespace meld::reference
