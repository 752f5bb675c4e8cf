#include "runtime/show/render/image.h"

#include <algorithm>
#include <new>

#include "runtime/base/assert.h"
#include "runtime/show/render/surface.h"

namespace meld::render {

namespace {

using Append = cairo_write_func_t;

void write(Image& image, Append append, void* to) {
    const bool opaque = std::ranges::all_of(image.pixels, [](std::uint32_t pixel) { return pixel >> 24 == 255; });
    const Surface surface = surface_of(image, opaque ? CAIRO_FORMAT_RGB24 : CAIRO_FORMAT_ARGB32);
    const cairo_status_t status = cairo_surface_write_to_png_stream(surface.get(), append, to);
    if (status == CAIRO_STATUS_NO_MEMORY) throw std::bad_alloc();
    MELD_CHECK(status == CAIRO_STATUS_SUCCESS, "a picture cannot be written: {}", cairo_status_to_string(status));
}

}  // namespace

Result<void> write_png(Image& image, OutputFile& file) {
    const Append append = [](void* to, const unsigned char* bytes, unsigned int count) {
        static_cast<OutputFile*>(to)->write({reinterpret_cast<const char*>(bytes), count});
        return CAIRO_STATUS_SUCCESS;
    };
    write(image, append, &file);
    return file.flush();
}

std::string png_of(Image& image) {
    std::string out;
    const Append append = [](void* to, const unsigned char* bytes, unsigned int count) {
        static_cast<std::string*>(to)->append(reinterpret_cast<const char*>(bytes), count);
        return CAIRO_STATUS_SUCCESS;
    };
    write(image, append, &out);
    return out;
}

}  // namespace meld::render
