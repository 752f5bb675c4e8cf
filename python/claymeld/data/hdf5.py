"""h5py from several threads."""

import threading
from typing import Any

from h5py import h5

# h5py keeps one thread at a time in the HDF5 library by this lock, but lets go of it while it turns text of any length into Python's; then
# another thread that enters the library ends the process (h5py/h5py issues 1764 and 2920). Who holds it himself keeps it, so all that
# reads HDF5 here holds it. A version of h5py without it would have to be safe in another way.
LOCK: Any = getattr(h5, "phil", None) or threading.RLock()
