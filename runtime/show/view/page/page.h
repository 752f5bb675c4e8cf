// The viewer: one page with its program and its style, which asks nothing of any other place.
#pragma once

#include <string_view>

namespace meld::view {

// Served with a token in its address it speaks to its server; with a run written behind it, it shows that (runtime/show/view/share).
std::string_view viewer_page();

}  // namespace meld::view
