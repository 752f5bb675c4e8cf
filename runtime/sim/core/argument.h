// Arguments of facts as C++ values, for hand-written modules: numbers, strings, and lists of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "runtime/engine/tuple/values.h"

namespace meld::sim {

struct CatomId {
    std::uint64_t number = 0;
    bool operator==(const CatomId&) const = default;
};

// Items: the elements of a list, set or array in their order, or the fields of a struct, tuple or vec3.
struct Argument {
    std::variant<std::int64_t, double, bool, CatomId, std::string, std::vector<Argument>> value;

    Argument(int number) : value(std::int64_t{number}) {}
    Argument(std::int64_t number) : value(number) {}
    Argument(double number) : value(number) {}
    Argument(bool truth) : value(truth) {}
    Argument(CatomId id) : value(id) {}
    Argument(const char* text) : value(std::string(text)) {}
    Argument(std::string text) : value(std::move(text)) {}
    Argument(std::vector<Argument> items) : value(std::move(items)) {}
    bool operator==(const Argument&) const = default;

    // The content as a C++ type, one of those of `value`. Asking for another type is an error of the module.
    template <class T>
    const T& as() const {
        return std::get<T>(value);
    }
};

// The argument as a value of a type, its lists in the arena; an int may stand for a float. If the argument does not fit the type, that is
// an error of the module and ends the run.
Value to_value(tuple::Type type, const Argument& argument, tuple::Arena& arena);
Argument to_argument(tuple::Type type, Value value);

}  // namespace meld::sim
