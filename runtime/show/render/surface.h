// Pictures as Cairo draws on them. Private to runtime/show/render.
#pragma once

#include <memory>

#include "runtime/show/library/cairo_calls.h"
#include "runtime/show/render/image.h"

namespace meld::render {

using Surface = std::unique_ptr<cairo_surface_t, decltype(&::cairo_surface_destroy)>;
using Pen = std::unique_ptr<cairo_t, decltype(&::cairo_destroy)>;

// Of the image's own pixels, which must outlive it.
inline Surface surface_of(Image& image, cairo_format_t format = CAIRO_FORMAT_ARGB32) {
    return {
        cairo_image_surface_create_for_data(reinterpret_cast<unsigned char*>(image.pixels.data()), format, static_cast<int>(image.width),
                                            static_cast<int>(image.height), static_cast<int>(4 * image.width)),
        cairo_surface_destroy};
}

inline Pen pen_for(const Surface& surface) { return {cairo_create(surface.get()), cairo_destroy}; }

}  // namespace meld::render
