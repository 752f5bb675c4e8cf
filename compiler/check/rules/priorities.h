// What Linear Meld's directives say of the priorities of nodes.
#pragma once

#include <optional>
#include <string_view>

#include "compiler/syntax/tree.h"

namespace meld::check {

// `priority @order asc.`: the least priority goes first.
bool is_upwards(const syntax::Hint& hint);
// `priority @order desc.`, which is so anyway.
bool is_downwards(const syntax::Hint& hint);
// The number of `priority WORD NUMBER.`, where the word is @default or @initial.
std::optional<double> priority_of_all(const syntax::Hint& hint, std::string_view word);

}  // namespace meld::check
