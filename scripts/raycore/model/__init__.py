# SPDX-License-Identifier: Apache-2.0 WITH SHL-2.1
"""Golden model of the RTL: the specification that every unit is compared with, bit for bit."""

import contextlib
from pathlib import Path


def _drop_stale_code():
    """Forget compiled functions that call what has changed since: numba looks only at the file that a function is in.

    All of the package calls `fp24`; `frame` calls all of it.
    """
    folder = Path(__file__).parent
    with contextlib.suppress(OSError):
        changed = {path.stem: path.stat().st_mtime for path in folder.glob("*.py")}
        changed["frame"] = max(changed.values())
        for index in (folder / "__pycache__").glob("*.nbi"):
            if index.stat().st_mtime < max(changed["fp24"], changed.get(index.name.split(".")[0], 0.0)):
                index.unlink(missing_ok=True)


_drop_stale_code()
