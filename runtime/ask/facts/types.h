// The types of a checked program as the kernel and the columns know types: numbers in a table that grows with what a question needs.
#pragma once

#include <deque>
#include <map>
#include <string>
#include <vector>

#include "compiler/check/program/program.h"
#include "runtime/engine/tuple/values.h"

namespace meld::inspect {

class Types {
  public:
    Types();
    Types(const Types&) = delete;
    Types& operator=(const Types&) = delete;

    // What nothing determines, such as the elements of [], is int.
    u16 number(const check::Type& type);
    // Valid as long as this, however many types are added.
    const TypeInfo* table() const { return table_.data(); }
    tuple::Type of(const check::Type& type) {
        const u16 known = number(type);
        return {table_.data(), known};
    }

  private:
    std::vector<TypeInfo> table_;
    std::deque<std::vector<u16>> parts_;
    std::map<std::string, u16> by_name_;
};

}  // namespace meld::inspect
