// What all that writes HDF5 needs of the library: handles that close themselves, errors in words. The only header that includes <hdf5.h>,
// which drags in MPI. Private to runtime/results, and included by sources alone.
#pragma once

#define OMPI_SKIP_MPICXX 1
#include <hdf5.h>

#include <string>
#include <utility>

namespace meld::record {

// An HDF5 handle that is given back at the end of its scope.
class Handle {
  public:
    Handle(hid_t id, herr_t (*release)(hid_t)) : id_(id), release_(release) {}
    ~Handle() {
        if (id_ >= 0) release_(id_);
    }
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    operator hid_t() const { return id_; }
    // Negative on failure. Closing a dataset may write what was not written before.
    herr_t close() { return id_ >= 0 ? release_(std::exchange(id_, -1)) : 0; }

  private:
    hid_t id_;
    herr_t (*release_)(hid_t);
};

// Before the first file is made: the library prints nothing, and tries nothing again when the process ends.
void set_up_library_once();

// Opens a file to read it, also while another process writes it: what that process is just writing is read once more until its checksum
// fits. Negative on failure; a file that is damaged costs some milliseconds.
hid_t open_to_read(const std::string& path);

// Why the last call failed, in the system's words where it was the system.
std::string text_of_last_error();

}  // namespace meld::record
