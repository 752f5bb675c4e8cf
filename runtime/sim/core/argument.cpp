#include "runtime/sim/core/argument.h"

#include <algorithm>
#include <bit>
#include <string_view>

#include "runtime/base/assert.h"
#include "runtime/engine/tuple/value_text.h"
#include "runtime/engine/tuple/values.h"

namespace meld::sim {
namespace {

// The content of an argument that must be of one C++ type.
template <class T>
const T& content(tuple::Type type, const Argument& argument) {
    const T* found = std::get_if<T>(&argument.value);
    MELD_CHECK(found != nullptr, "a module gives an argument of another type where the program has {}", tuple::type_name(type));
    return *found;
}

const List* to_items(tuple::Type type, const std::vector<Argument>& items, tuple::Arena& arena) {
    MELD_CHECK(!type.has_fields() || items.size() == type.field_count(), "a module gives {} fields where the program has {}", items.size(),
               tuple::type_name(type));
    std::vector<Value> values;
    for (std::size_t i = 0; i < items.size(); ++i) values.push_back(to_value(type.item(i), items[i], arena));
    if (type.kind() == ValueType::Set) {
        const tuple::Type item = type.item(0);
        std::sort(values.begin(), values.end(), [item](Value a, Value b) { return tuple::compare(item, a, b) < 0; });
        const auto same = [item](Value a, Value b) { return tuple::compare(item, a, b) == 0; };
        values.erase(std::unique(values.begin(), values.end(), same), values.end());
    }
    std::vector<u64> words;
    for (const Value value : values) words.push_back(std::bit_cast<u64>(value));
    return arena.list(words);
}

}  // namespace

Value to_value(tuple::Type type, const Argument& argument, tuple::Arena& arena) {
    Value value{};
    switch (type.kind()) {
        case ValueType::Int:
            value.integer = content<std::int64_t>(type, argument);
            break;
        case ValueType::Float: {
            const auto* whole = std::get_if<std::int64_t>(&argument.value);
            value.real = whole != nullptr ? static_cast<double>(*whole) : content<double>(type, argument);
            break;
        }
        case ValueType::Bool:
            value.integer = content<bool>(type, argument) ? 1 : 0;
            break;
        case ValueType::Node:
            value.catom = content<CatomId>(type, argument).number;
            break;
        case ValueType::String:
            value.list = arena.text(content<std::string>(type, argument));
            break;
        default:
            value.list = to_items(type, content<std::vector<Argument>>(type, argument), arena);
    }
    return value;
}

Argument to_argument(tuple::Type type, Value value) {
    switch (type.kind()) {
        case ValueType::Int:
            return static_cast<std::int64_t>(value.integer);
        case ValueType::Float:
            return value.real;
        case ValueType::Bool:
            return value.integer != 0;
        case ValueType::Node:
            return CatomId{value.catom};
        case ValueType::String:
            return std::string(tuple::bytes_of(value.list));
        default:
            break;
    }
    std::vector<Argument> items;
    for (std::size_t i = 0; i < tuple::length(value.list); ++i) items.push_back(to_argument(type.item(i), tuple::item(value.list, i)));
    return items;
}

}  // namespace meld::sim
