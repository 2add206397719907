"""The command line `tessera`, for what it can and the package cannot: reading scene files, measuring."""

from __future__ import annotations

import shutil
import subprocess
import warnings
from collections.abc import Sequence

from tessera._wire import TesseraError


def run_program(program: str | None, words: Sequence[str]) -> subprocess.CompletedProcess[str]:
    """Runs it, by default that of the PATH, and waits for its end. TesseraError where there is none."""
    program = program or shutil.which("tessera")
    if program is None:
        raise TesseraError("the program tessera is not on the PATH: program=...")
    return subprocess.run([program, *words], capture_output=True, text=True, check=False)


def repeat_warnings(text: str, stacklevel: int) -> None:
    """Warnings among the lines of its standard error become Python's, of the caller's caller by 3."""
    for line in text.splitlines():
        if line.startswith("warning: "):
            warnings.warn(line.removeprefix("warning: "), stacklevel=stacklevel)
