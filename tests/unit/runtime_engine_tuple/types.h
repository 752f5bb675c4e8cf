// A table of types for tests, made as it grows.
#pragma once

#include <deque>
#include <vector>

#include "runtime/engine/tuple/values.h"

namespace meld::tuple {

class Types {
  public:
    Types() {
        infos_.reserve(1000);  // Types given out point into the table.
        for (const ValueType simple : {ValueType::Int, ValueType::Float, ValueType::Bool, ValueType::Node}) add(simple);
    }
    u16 add(ValueType kind, std::vector<u16> parts = {}) {
        parts_.push_back(std::move(parts));
        infos_.push_back({kind, static_cast<u16>(parts_.back().size()), parts_.back().data()});
        return static_cast<u16>(infos_.size() - 1);
    }
    Type operator[](u16 number) const { return {infos_.data(), number}; }
    const TypeInfo* table() const { return infos_.data(); }

    static constexpr u16 kInt = 0, kFloat = 1, kBool = 2, kNode = 3;

  private:
    std::deque<std::vector<u16>> parts_;
    std::vector<TypeInfo> infos_;
};

}  // namespace meld::tuple
