"""Runs the tests of the given sources, and the check of types with `--types`, as CTest wants it: 77 when something
that `deploy/setup.sh --ci` installs is missing, which is noted in the file that TESSERA_SKIPS names."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
import unittest
from pathlib import Path

_SKIPPED = 77
_HERE = Path(__file__).resolve().parent


def _skip(name: str, what: str) -> int:
    line = f"{name}: needs {what}"
    print(line)
    if os.environ.get("TESSERA_SKIPS"):
        with open(os.environ["TESSERA_SKIPS"], "a", encoding="utf-8") as file:
            file.write(line + "\n")
    return _SKIPPED


def _check_types() -> int:
    mypy = shutil.which("mypy", path="/usr/bin")
    if mypy is None:
        return _skip("python types", "mypy")
    package = os.environ["PYTHONPATH"].split(":")[0]
    others = [*_HERE.parent.glob("blender/tessera_blender/*.py"), *_HERE.parent.glob("examples/*.py")]
    result = 0
    for what in (["-p", "tessera"], others):
        command = [mypy, "--config-file", _HERE.parent / "mypy.ini", "--cache-dir", "/dev/null", *what]
        result |= subprocess.run(command, cwd=package, check=False).returncode
    return result


def main(sources: list[str]) -> int:
    if sources == ["--types"]:
        return _check_types()
    for module in ("numpy", "grpc", "zstandard", "google.protobuf"):
        if importlib.util.find_spec(module) is None:
            return _skip("python", f"the module {module} of Debian's packages")
    if "blender_test.py" in sources and shutil.which("blender") is None:
        return _skip("blender add-on", "Debian's blender")
    sys.path.insert(0, str(_HERE))
    suite = unittest.TestSuite(
        unittest.defaultTestLoader.loadTestsFromName(Path(source).stem) for source in sources
    )
    return 0 if unittest.TextTestRunner(verbosity=2).run(suite).wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
