// Which names of a rule belong only to a negation, aggregate or comprehension. `X` in two of them is two variables, unless the body around
// them mentions it too.
#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>

#include "compiler/syntax/tree.h"

namespace meld::check {

class LocalNames {
  public:
    // The name, if the expression is just a variable.
    using NameOf = std::function<const std::string*(const syntax::Expr&)>;
    using Names = std::set<std::string>;

    LocalNames(const syntax::Rule& rule, NameOf name_of);

    // The names that are local to a part of the rule, by its address: a Not, Forall, BodyAggregate, Comprehension or
    // Exists, a RuleAggregate (its body and the heads of each match), or RuleAggregate::result.
    const Names& of(const void* part) const { return locals_.at(part); }

    // The variables in an expression.
    Names names_in(const syntax::Expr& e) const {
        Names names;
        add(e, names);
        return names;
    }

  private:
    using Clauses = std::vector<syntax::Clause>;
    using Heads = std::vector<syntax::HeadItem>;

    void add(const syntax::Expr& e, Names& out) const;
    void add(const syntax::Atom& atom, Names& out) const;
    void add(const Clauses& clauses, Names& out) const;
    void add(const Heads& heads, Names& out) const;
    // Notes which names are local to a part with these direct names, `always` even if they are known outside; returns all names that are
    // known inside.
    Names open(const void* part, const Names& direct, const Names& known, const Names& always = {});
    void visit(const Clauses& clauses, const Names& known);
    void visit(const Heads& heads, const Names& known);
    void visit(const syntax::RuleAggregate& aggregate, const Names& known);

    NameOf name_of_;
    std::map<const void*, Names> locals_;
};

}  // namespace meld::check
