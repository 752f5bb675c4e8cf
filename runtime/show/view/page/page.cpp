#include "runtime/show/view/page/page.h"

#include "runtime/show/view/page/embedded.h"

namespace meld::view {

std::string_view viewer_page() {
    static const std::string_view kText = page::kPage;
    return kText;
}

}  // namespace meld::view
