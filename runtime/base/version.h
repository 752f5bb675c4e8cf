// The version of Claymeld, which every program prints. CMakeLists.txt reads it from here.
#pragma once

namespace meld {

inline constexpr char kVersion[] = "0.1.0";

}  // namespace meld
