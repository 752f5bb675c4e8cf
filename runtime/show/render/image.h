// A finished picture, and the file that it becomes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/base/files/output_file.h"

namespace meld::render {

struct Image {
    std::size_t width = 0, height = 0;
    // By rows from above: alpha, red, green and blue, from the highest byte down; the colours multiplied with alpha.
    std::vector<std::uint32_t> pixels = {};
};

// As PNG. Errors: those of the file.
Result<void> write_png(Image& image, OutputFile& file);
// The same in memory.
std::string png_of(Image& image);

}  // namespace meld::render
