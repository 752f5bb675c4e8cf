#include "runtime/render/image.h"

#include <algorithm>
#include <new>

#include "runtime/base/assert.h"
#include "runtime/render/surface.h"

namespace meld::render {

namespace {

cairo_status_t append(void* file, const unsigned char* bytes, unsigned int count) {
    static_cast<OutputFile*>(file)->write({reinterpret_cast<const char*>(bytes), count});
    return CAIRO_STATUS_SUCCESS;
}

}  // namespace

Result<void> write_png(Image& image, OutputFile& file) {
    const bool opaque = std::ranges::all_of(image.pixels, [](std::uint32_t pixel) { return pixel >> 24 == 255; });
    const Surface surface = surface_of(image, opaque ? CAIRO_FORMAT_RGB24 : CAIRO_FORMAT_ARGB32);
    const cairo_status_t status = cairo_surface_write_to_png_stream(surface.get(), append, &file);
    if (status == CAIRO_STATUS_NO_MEMORY) throw std::bad_alloc();
    MELD_CHECK(status == CAIRO_STATUS_SUCCESS, "a picture cannot be written: {}", cairo_status_to_string(status));
    return file.flush();
}

}  // namespace meld::render
