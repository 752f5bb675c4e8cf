// Instead of runtime/show/view/page/page.cpp in a program that is built without the viewer.
#include "runtime/show/view/page/page.h"

namespace meld::view {

std::string_view viewer_page() { return {}; }

}  // namespace meld::view
