// What a page is answered.
#pragma once

#include <string>

#include "runtime/show/view/fields.h"

namespace meld::view {

struct Reply {
    Json words = Json::object();
    std::string binary = {};
};

}  // namespace meld::view
