"""Makes numpy and h5py importable: where this Python lacks them, the script starts again with Debian's, which may have them."""
import importlib.util
import os
import sys

DEBIAN = "/usr/bin/python3"


def need(*names):
    """Call this before importing the names. Ends the script with a way to get what is missing."""
    missing = [name for name in names if importlib.util.find_spec(name) is None]
    if not missing:
        return
    script = sys.argv[0]
    if os.path.exists(DEBIAN) and os.path.realpath(sys.executable) != os.path.realpath(DEBIAN):
        os.execv(DEBIAN, [DEBIAN, *sys.argv])
    packages = " ".join(f"python3-{name}" for name in missing)
    sys.exit(f"{script}: {sys.executable} has no {' and no '.join(missing)}. Run apt-get install {packages} (Debian), "
             f"or {sys.executable} -m pip install {' '.join(missing)}")
