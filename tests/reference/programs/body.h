// Builds one random rule: which catoms it joins, what it reads there, and expressions over what is bound.
#pragma once

#include <map>

#include "tests/reference/programs/draft.h"

namespace meld::reference {

using retraction::below;
using retraction::Random;

// List is a list of ints, Pair a struct of an int and a catom.
enum class Kind { Int, Float, Bool, Node, String, List, Pair };
const char* name_of(Kind kind);

// A predicate that rules may read.
struct Known {
    std::string name;
    std::vector<Kind> arguments = {};  // After the catom.
    bool linear = false;
    bool route = false;
    bool certain = true;  // Its facts are certain in every tick; linear rules read no others.
};

inline bool chance(Random& random, int percent) { return below(random, 100) < percent; }
template <class T>
const T& pick(Random& random, const std::vector<T>& from) {
    return from[static_cast<std::size_t>(below(random, static_cast<std::int64_t>(from.size())))];
}

// Functions that every random program has, and its expressions may call.
constexpr const char* kFunctions[] = {
    "fun folded(int X, int Y) : int = let Z = X * 3 - Y in if Z > 9 then Z % 10 else Z end end.",
    "fun chosen(int X, int Y) : int = if X > Y then folded(X, 1) % 6 else min(X, 2) end.",
    // The same in any order.
    "fun mixed(int X, int Y) : int = X * Y % 17.",
    // Greater numbers give greater ones.
    "fun stepped(int X, int Y) : int = if Y > 2 then X / 2 else X / 3 + 1 end.",
    "fun shortened(int X, list int L) : list int = ltake([X | L], 3).",
};

class Body {
  public:
    Body(Random& random, const std::vector<Known>& known) : random_(random), known_(known) {}

    // ---- clauses, in the order of the calls
    // A new catom next to one of those there are; returns its name.
    std::string link();
    std::string link(const std::string& from);
    // A fact of this predicate; every argument a new variable, a bound one, a literal or `_`.
    void read(const Known& predicate, const std::string& at);
    // The same with these arguments.
    void read(const Known& predicate, const std::string& at, const std::vector<std::string>& arguments);
    // A fact of any predicate, or of the world, with something to bind.
    void read_any(const std::string& at);
    void test();
    // Something of where two catoms stand, as vec3.
    void compare_places();
    // A value for a new variable.
    void set();
    void negate();
    void for_all();
    // A sum, count, least or greatest over what is here or at the neighbours.
    void aggregate();
    // How many facts of a kind there are here.
    void proved();
    // A fact whose number has changed in this tick, or in a view one that has hardly changed.
    void change();
    // An element of a list.
    void element();
    // Without a word more for the catom; a place two links away.
    std::string far_link();
    void clause(const std::string& text) { clauses_.push_back(text); }

    // ---- what is bound
    std::string fresh(Kind kind);
    std::string any_catom() { return pick(random_, catoms_); }
    const std::vector<std::string>& catoms() const { return catoms_; }
    bool has(Kind kind) const;
    // A bound variable of a kind; one must be there.
    std::string variable(Kind kind);
    // An expression; ints stay small.
    std::string expression(Kind kind);
    // A bound variable, or an expression that takes few values: for recursion, where any other might go on for ever.
    std::string bounded(Kind kind);
    std::string literal(Kind kind);

    // The clauses in any order that keeps the tests as they stand: a test may guard the next one.
    std::vector<std::string> shuffled();
    const std::vector<std::string>& clauses() const { return clauses_; }
    // Only certain predicates and none whose order of matching depends on how it is stored.
    bool for_linear = false;
    // Facts may be asked to be stable: not in a recursion, which is through what is there.
    bool may_wait = false;

  private:
    std::string argument(Kind kind, bool may_bind);
    std::string pattern(Kind kind);
    std::string int_expression();
    std::string float_expression();
    std::string compound_expression(Kind kind);
    std::string list_expression(const std::string& own, const std::string& x);
    std::string number_of_list(const std::string& list, const std::string& x);
    std::string variable_or_literal(Kind kind);
    std::string vector_test();
    std::string negated_atom();
    void world_fact(const std::string& at);
    std::vector<const Known*> readable() const;
    bool is_test(const std::string& clause) const { return tests_.contains(clause); }

    Random& random_;
    const std::vector<Known>& known_;
    std::vector<std::string> catoms_{"A"};
    std::map<Kind, std::vector<std::string>> variables_;
    std::vector<std::string> vectors_;  // Places as vec3: read in tests alone, too.
    std::vector<std::string> inexact_;  // Floats whose sums depend on their order: read in tests alone.
    std::vector<std::string> clauses_;
    std::map<std::string, bool> tests_;
    int next_ = 0;
};

}  // namespace meld::reference
