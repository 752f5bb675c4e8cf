#include "runtime/results/hdf5/hdf5_library.h"

#include <cstdlib>
#include <string_view>

namespace meld::record {

namespace {

// A write takes some microseconds, in which a reader can find a part of the old and a part of the new. The library waits between attempts,
// at first a nanosecond and then always twice as long: 17 ms in all.
constexpr unsigned kReadAttempts = 25;

// The innermost entry of HDF5's error stack is where it began; the system's own words are quoted in it.
herr_t take_innermost(unsigned depth, const H5E_error2_t* entry, void* result) {
    if (depth == 0 && entry->desc != nullptr) *static_cast<std::string*>(result) = entry->desc;
    return 0;
}

}  // namespace

hid_t open_to_read(const std::string& path) {
    set_up_library_once();
    const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    if (H5Pset_metadata_read_attempts(access, kReadAttempts) < 0) return -1;
    return H5Fopen(path.c_str(), H5F_ACC_RDONLY, access);
}

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
