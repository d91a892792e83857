"""The preset tsan sees a race inside a parallel body, and reports none where oneTBB keeps the order.

planted_race_test.py PROGRAM: planted_race, built with the thread sanitizer. TSAN_OPTIONS are those of the other tests, so
that a suppression which hides too much is found here.
"""

import re
import subprocess
import sys

SANITIZER_EXIT = 66


def run(mode):
    done = subprocess.run([sys.argv[1], mode], capture_output=True, text=True, timeout=240, check=False)
    return done.returncode, done.stdout + done.stderr


def check(condition, what, output):
    if not condition:
        sys.exit(f"{what}; the program said:\n{output}")


code, said = run("race")
check(
    code == SANITIZER_EXIT and re.search(r"SUMMARY: ThreadSanitizer: data race \S*planted_race\.cpp", said),
    f"the planted race was not reported (exit code {code})",
    said,
)

code, said = run("in_order")
check(code == 0 and "ThreadSanitizer" not in said, f"a race was reported where none is (exit code {code})", said)
check(said.startswith("met: 6 + 6"), "the bodies did not run as they should", said)
