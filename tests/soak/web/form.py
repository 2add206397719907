"""The form in which the test runs, and times that are promised."""

import os
import sys
import time

from farm import check

LONG = os.environ.get("TESSERA_TEST_FORM") == "long"
TIMES = "--times" in sys.argv
PROMISED = 2.0  # seconds


def within_promise(began, what):
    took = time.monotonic() - began
    print(f"  {what}: {took:.2f} s")
    if TIMES:
        check(took <= PROMISED, f"{what} took {took:.2f} s")
