// How the library reads and writes a recording on the disk: its own driver, except for how space is allocated. Private to runtime/results,
// and included by sources alone.
#pragma once

#include "runtime/results/hdf5/hdf5_library.h"

namespace meld::record {

// No address is allocated twice, so nothing to which the file on the disk refers is overwritten; and the end of the file is ahead of the
// allocated space, see Hdf5File::extend(). Negative if the library does not answer.
hid_t append_driver();

// The file that was opened last with this driver.
H5FD_t* last_opened();
// Where the next allocated space will be: from the start in a new file, from its end in one that was there.
haddr_t next_address(H5FD_t* file);

}  // namespace meld::record
