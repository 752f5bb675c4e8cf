#include "runtime/ask/facts/types.h"

#include "runtime/base/assert.h"

namespace meld::inspect {

using check::Type;

namespace {

ValueType value_type(Type::Kind kind) {
    switch (kind) {
        case Type::Kind::Error:
        case Type::Kind::Int:
            return ValueType::Int;
        case Type::Kind::Float:
            return ValueType::Float;
        case Type::Kind::Bool:
            return ValueType::Bool;
        case Type::Kind::Node:
            return ValueType::Node;
        case Type::Kind::String:
            return ValueType::String;
        case Type::Kind::List:
            return ValueType::List;
        case Type::Kind::Set:
            return ValueType::Set;
        case Type::Kind::Array:
            return ValueType::Array;
        case Type::Kind::Struct:
            return ValueType::Struct;
        case Type::Kind::Tuple:
            return ValueType::Tuple;
        case Type::Kind::Vec3:
            return ValueType::Vec3;
    }
    return ValueType::Int;
}

}  // namespace

Types::Types() {
    // So that the table never moves.
    table_.reserve(kNone16);
    for (const Type& simple : {Type::Int, Type::Float, Type::Bool, Type::Node}) number(simple);
    MELD_ENSURE(table_.size() == kScalarTypes);
}

u16 Types::number(const Type& type) {
    // The first four are those of every table.
    if (type.parts.empty() && type.kind <= Type::Kind::Node && table_.size() >= kScalarTypes)
        return static_cast<u16>(value_type(type.kind));
    std::vector<u16> parts;
    for (const Type& part : type.parts) parts.push_back(number(part));
    std::string name(1, static_cast<char>(value_type(type.kind)));
    for (const u16 part : parts) name.append(reinterpret_cast<const char*>(&part), sizeof part);
    const auto [at, is_new] = by_name_.emplace(std::move(name), static_cast<u16>(table_.size()));
    if (!is_new) return at->second;
    MELD_CHECK(table_.size() < kNone16, "a question with {} types", table_.size());
    parts_.push_back(std::move(parts));
    table_.push_back({value_type(type.kind), static_cast<u16>(parts_.back().size()), parts_.back().data()});
    return at->second;
}

}  // namespace meld::inspect
