"""What stands under a name on the disk: a program that opens a named pipe waits for whoever is at its other end."""

import os
import stat

_KINDS = {stat.S_ISFIFO: "a named pipe", stat.S_ISSOCK: "a socket", stat.S_ISCHR: "a device", stat.S_ISBLK: "a device"}


def not_a_file(path: str | os.PathLike) -> str | None:
    """What stands there in place of a file or a folder, such as "a named pipe"; None where nothing does."""
    try:
        mode = os.stat(path).st_mode
    except (OSError, ValueError):
        return None
    return next((kind for is_kind, kind in _KINDS.items() if is_kind(mode)), None)
