#include "runtime/results/hdf5/hdf5_driver.h"

#include <map>
#include <optional>

#include "runtime/base/process/liveness.h"

namespace meld::record {

namespace {

constexpr haddr_t kFewestBytesAhead = 64;
// The system writes page by page, and a kill may come between two.
constexpr haddr_t kPage_bytes = 4096;
// A packed chunk is written again in its place if it has as many bytes as before: of longer ones hardly any.
constexpr haddr_t kShortData_bytes = 1024;

H5FD_class_t own_driver;
struct Space {
    std::optional<haddr_t> next;  // Address; none before the library has read where the end of the file is.
    bool given = false;           // Whether any has been allocated: else the file is as it was found.
};
std::map<const H5FD_t*, Space> spaces;
H5FD_t* last_file = nullptr;
H5FD_t* (*open_as_library)(const char*, unsigned, hid_t, haddr_t) = nullptr;
herr_t (*truncate_as_library)(H5FD_t*, hid_t, hbool_t) = nullptr;
herr_t (*close_as_library)(H5FD_t*) = nullptr;

H5FD_t* open_file(const char* name, unsigned flags, hid_t access, haddr_t most) {
    last_file = open_as_library(name, flags, access, most);
    if (last_file != nullptr && (flags & H5F_ACC_TRUNC) != 0)
        spaces[last_file] = {.next = 0};
    else if (last_file != nullptr)
        spaces[last_file] = {};
    return last_file;
}

haddr_t give_space(H5FD_t* file, H5FD_mem_t type, hid_t, hsize_t size_bytes) {
    liveness::beat();
    haddr_t address = next_address(file);
    // What can only be read as a whole is in one page, so that a kill leaves it as it was before a write or after it.
    if (size_bytes <= (type == H5FD_MEM_DRAW ? kShortData_bytes : kPage_bytes) && address % kPage_bytes + size_bytes > kPage_bytes)
        address += kPage_bytes - address % kPage_bytes;
    const haddr_t next = address + size_bytes;
    spaces[file] = {.next = next, .given = true};
    // Never just before the end: the library would let the data there grow into the space ahead without notice.
    if (next >= own_driver.get_eoa(file, type)) own_driver.set_eoa(file, type, next + kFewestBytesAhead);
    return address;
}

herr_t keep_space(H5FD_t*, H5FD_mem_t, hid_t, haddr_t, hsize_t) { return 0; }

// The library truncates a file before it writes the new position of its end, and readers refuse a file that is shorter than that position.
// So it is truncated after everything has been written.
herr_t lengthen_only(H5FD_t* file, hid_t list, hbool_t closing) {
    const bool shorter = own_driver.get_eoa(file, H5FD_MEM_DEFAULT) < own_driver.get_eof(file, H5FD_MEM_DEFAULT);
    return shorter ? 0 : truncate_as_library(file, list, closing);
}

herr_t cut_and_close(H5FD_t* file) {
    const herr_t cut = spaces[file].given ? truncate_as_library(file, H5P_DEFAULT, true) : 0;
    spaces.erase(file);
    const herr_t closed = close_as_library(file);
    return cut < 0 ? cut : closed;
}

}  // namespace

hid_t append_driver() {
    static const hid_t made = [] {
        const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
        H5Pset_fapl_sec2(access);
        H5FD_t* const some_file = H5FDopen("/dev/null", H5F_ACC_RDONLY, access, haddr_t{1} << 40);
        if (some_file == nullptr) return hid_t{-1};
        own_driver = *some_file->cls;
        H5FDclose(some_file);
        open_as_library = own_driver.open;
        truncate_as_library = own_driver.truncate;
        close_as_library = own_driver.close;
        own_driver.open = open_file;
        own_driver.alloc = give_space;
        own_driver.free = keep_space;
        own_driver.truncate = lengthen_only;
        own_driver.close = cut_and_close;
        return H5FDregister(&own_driver);
    }();
    return made;
}

H5FD_t* last_opened() { return last_file; }

haddr_t next_address(H5FD_t* file) {
    std::optional<haddr_t>& next = spaces[file].next;
    if (!next) next = own_driver.get_eoa(file, H5FD_MEM_DEFAULT);
    return *next;
}

}  // namespace meld::record
