#include "runtime/record/hdf5_library.h"

#include <cstdlib>
#include <string_view>

namespace meld::record {

namespace {

// The innermost entry of HDF5's error stack is where it began; the system's own words are quoted in it.
herr_t take_innermost(unsigned depth, const H5E_error2_t* entry, void* result) {
    if (depth == 0 && entry->desc != nullptr) *static_cast<std::string*>(result) = entry->desc;
    return 0;
}

}  // namespace

std::string text_of_last_error() {
    std::string text;
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take_innermost, &text);
    constexpr std::string_view key = "error message = '";
    const std::size_t begin = text.find(key);
    if (begin == std::string::npos) return text.empty() ? "HDF5 gives no reason" : text;
    const std::size_t message = begin + key.size();
    return text.substr(message, text.find('\'', message) - message);
}

void set_up_library_once() {
    static const bool done = [] {
        // A file that could not be written must not be tried again when the process ends.
        H5dont_atexit();
        H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
        // Viewers may read while we write: every flushed step is complete.
        setenv("HDF5_USE_FILE_LOCKING", "FALSE", 0);
        return true;
    }();
    static_cast<void>(done);
}

}  // namespace meld::record
