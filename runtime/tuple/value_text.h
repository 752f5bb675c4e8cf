// Values as text: literals of the language, which facts files, world files and the command line share.
#pragma once

#include <string>
#include <string_view>

#include "runtime/base/error.h"
#include "runtime/tuple/values.h"

namespace meld::tuple {

// 12  0.5  true  @7  "text"  [1, 2]  {1, 2}  :(1, 2.0)  (1, 2)  vec3(1.0, 2.0, 3.0). A set, which the language has no literal
// for, stands in braces, an array in brackets as a list does. Floats have the shortest form that reads back the same, with
// a point; bytes of a string that are no visible text (runtime/base/visible.h) stand as \x and two digits.
std::string print_value(Type type, Value v);
// The same of a string with these bytes.
std::string print_text(std::string_view bytes);
// "list int", as a program declares it.
std::string type_name(Type type);

// What print_value wrote, or a person: blanks anywhere between, an int where a float is wanted, sets in any order, `nil` for
// []. A string may stand without its quotes if it is the whole value, and any other value within quotes, as world files
// need for what TOML cannot say. Lists are made in the arena.
Result<Value> parse_value(Type type, std::string_view text, Arena& arena);

}  // namespace meld::tuple
