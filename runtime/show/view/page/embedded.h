// What the build makes of the files in this folder.
#pragma once

namespace meld::page {

extern const char kPage[];

}  // namespace meld::page
