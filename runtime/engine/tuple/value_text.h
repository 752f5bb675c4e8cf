// Values as text: literals of the language, which facts files, world files and the command line share.
#pragma once

#include <string>
#include <string_view>

#include "runtime/base/error.h"
#include "runtime/engine/tuple/values.h"

namespace meld::tuple {

// 12  0.5  true  @7  "text"  [1, 2]  {1, 2}  :(1, 2.0)  (1, 2)  vec3(1.0, 2.0, 3.0). A set, for which the language has no literal, is in
// braces; an array in brackets, like a list. Floats have the shortest form that reads back the same, with a point; bytes of a string that
// are not visible text (runtime/base/terminal/terminal_text.h) are \x and two digits.
std::string print_value(Type type, Value v);
// The same for a string with these bytes.
std::string print_text(std::string_view bytes);
// The same but for a string that is the whole value: it stands without its quotes, and those in it without backslash.
std::string print_plain(Type type, Value v);
// "list int", as a program declares it.
std::string type_name(Type type);

// Reads what print_value or a person has written: blanks are allowed anywhere between tokens, an int in place of a float, sets in any
// order, `nil` for []. A string may omit its quotes if it is the whole value, and any other value may be in quotes, as world files need for
// values that TOML cannot express. Lists are made in the arena.
Result<Value> parse_value(Type type, std::string_view text, Arena& arena);

}  // namespace meld::tuple
