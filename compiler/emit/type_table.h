// The types of values of more than one word that a module mentions, numbered as ModuleInfo::types has them.
#pragma once

#include <string>
#include <vector>

#include "compiler/emit/writer.h"

namespace meld::emit {

class TypeTable {
  public:
    // All types of the predicates, constants, functions and rules of a plan.
    explicit TypeTable(const plan::Plan& plan);

    // The number of a type: 0 to 3 for Int, Float, Bool and Node.
    std::size_t number(const check::Type& type) const;
    // kTypes[] and the arrays it points to.
    void emit(Writer& w) const;
    std::size_t count() const { return types_.size(); }

  private:
    void add(const check::Type& type);
    void add(const check::Term& term);

    std::vector<check::Type> types_;  // Parts before the types that contain them.
};

// The name of a kind in ValueType.
const char* value_type(const check::Type& type);

}  // namespace meld::emit
