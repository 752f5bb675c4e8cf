// Instead of runtime/show/library/view_library.cpp in a program that is built without pictures and the viewer.
#include "runtime/show/library/view_library.h"

namespace meld::show {

Result<void> need_view() {
    return fail("this meldsim was built without pictures and the viewer", "Use one that was built with -DCLAYMELD_VIEWER=ON");
}

}  // namespace meld::show
