// How an expression, a condition or a head changes when the value of a min or max that a rule reads improves.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "compiler/check/program/program.h"

namespace meld::check {

// How an expression follows a value: it stays, moves in the same direction or stays, in the opposite direction or stays, or in any
// direction.
enum class Course { Constant, Same, Opposite, Unknown };

// One value of one atom in a rule's body.
class Improvement {
  public:
    // `best` keeps the least or greatest value: the direction in which it improves.
    Improvement(const Program& program, const Rule& rule, const Atom& atom, VariableId value, Aggregate best);

    Course course(const Term& expression) const { return course(expression, courses_); }
    // Whether every test of the value in the body stays true while it improves.
    bool keeps_body() const;
    // The first condition that need not stay true while the value improves; null if there is none.
    const Term* first_lost() const;
    // Whether the body tests the value.
    bool bounded() const;
    // Whether the expression is never better than the value.
    bool worse(const Term& expression) const;
    // Whether the expression moves in the same direction as the value, or in the opposite one. Booleans count too: `~X` opposes X.
    bool follows(const Term& expression) const { return moves(expression, Course::Same); }
    bool opposes(const Term& expression) const { return moves(expression, Course::Opposite); }
    // Whether it consists of the value and something that does not depend on it.
    bool shifted(const Term& expression) const;

  private:
    using Courses = std::map<VariableId, Course>;

    void find_definitions();
    bool bound_by_fact(VariableId v) const;
    bool mentions(const Term& t) const;
    bool moves(const Term& t, Course way) const;
    Course course(const Term& t, const Courses& known) const;
    Course call(const Term& t, const Courses& known) const;
    Course multiplied(const Term& t, const Courses& known) const;
    bool keeps(const Term& test) const;
    bool at_least_zero(const Term& t, bool at_most) const;

    const Program& program_;
    const Rule& rule_;
    const Atom& atom_;
    VariableId value_;
    bool least_;
    Courses courses_;                            // Of variables that depend on the value.
    std::map<VariableId, const Term*> defined_;  // The terms that the body makes them equal to.
    std::vector<const Clause*> definitions_;
};

}  // namespace meld::check
