#include "runtime/show/render/number.h"

#include <fmt/format.h>

namespace meld::render {

std::string text_of(Number number, bool whole) {
    return whole ? fmt::format("{:.0f}", number) : fmt::format("{}", static_cast<double>(number));
}

}  // namespace meld::render
