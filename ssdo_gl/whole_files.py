"""Files that are replaced whole, in one step, or not at all."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path


def replace_whole(path: Path, data: bytes) -> None:
    """Replace `path` by `data`; a failure leaves the old file untouched.

    Raises
    ------
    OSError
    """
    temporary = None
    try:
        # Not after the file: a name may be as long as the file system allows.
        with tempfile.NamedTemporaryFile(dir=path.parent, prefix=".ssdo-gl-", delete=False) as file:
            temporary = Path(file.name)
            file.write(data)
        # NamedTemporaryFile makes files private; give what a plain open() would.
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)
        temporary.replace(path)
    finally:
        if temporary is not None and temporary.exists():
            temporary.unlink()
