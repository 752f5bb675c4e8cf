// What pictures and the viewer need of other libraries, in a shared library of its own: so meldsim runs where none of them is installed.
#pragma once

namespace meld::show {

struct Embree;
struct Cairo;
struct Civetweb;

struct ViewLibrary {
    const Embree* embree;
    const Cairo* cairo;
    const Civetweb* civetweb;
};

inline constexpr const char* kViewLibrary = "libmeld_view.so";
inline constexpr const char* kViewEntry = "meld_view";

}  // namespace meld::show

// The library's only exported function.
extern "C" const meld::show::ViewLibrary* meld_view();
