// The entry of the library.
#include "runtime/show/library/plugin/view_plugin.h"

#include "runtime/show/library/plugin/cairo_table.h"
#include "runtime/show/library/plugin/civetweb_table.h"
#include "runtime/show/library/plugin/embree_table.h"

const meld::show::ViewLibrary* meld_view() {
#define MELD_CALL(name) .name = &::name,
    static constexpr meld::show::Embree embree = {
#include "runtime/show/library/plugin/embree.def"
    };
    static constexpr meld::show::Cairo cairo = {
#include "runtime/show/library/plugin/cairo.def"
    };
    static constexpr meld::show::Civetweb civetweb = {
#include "runtime/show/library/plugin/civetweb.def"
    };
#undef MELD_CALL
    static constexpr meld::show::ViewLibrary library = {.embree = &embree, .cairo = &cairo, .civetweb = &civetweb};
    return &library;
}
