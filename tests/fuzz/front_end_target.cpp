// Fuzz target: whatever the text, the front end ends with diagnostics or a checked program.
#include <cstdint>

#include "tests/fuzz/front_end.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    meld::fuzz::front_end(std::string(reinterpret_cast<const char*>(data), size));
    return 0;
}
