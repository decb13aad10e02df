#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The include ladder: platform <- perception <- plan <- ctrl; hil sees only the wire and
the reader of configurations.

Prints every include that breaks it as file:line and exits with 1.
"""

import pathlib
import re
import subprocess
import sys

MAY_INCLUDE = {
    "platform": ("platform/",),
    "perception": ("platform/", "perception/"),
    "plan": ("platform/", "perception/", "plan/"),
    "ctrl": ("platform/", "perception/", "plan/", "ctrl/"),
    # platform/toml: how a text is read, and what an operator says of a place; nothing of the robot.
    "hil": ("platform/core/", "platform/can/", "platform/toml/", "hil/", "embedded/"),
}
JOINS_BOTH_SIDES = "hil/cli/"
SYSTEM_HEADER = re.compile(
    r"^(linux/.*|sys/.*|net/.*|unistd\.h|fcntl\.h|poll\.h|sched\.h|pthread\.h|signal\.h|time\.h|thread|mutex"
    r"|condition_variable|future|semaphore)$"
)
MAY_USE_SYSTEM = ("platform/linux/", "hil/", "tests/")
INCLUDE = re.compile(r'^\s*#\s*include\s*(["<])([^">]+)[">]')


def complaints(path: str):
    room = path.split("/")[0]
    for number, line in enumerate(pathlib.Path(path).read_text().splitlines(), 1):
        match = INCLUDE.match(line)
        if not match:
            continue
        quote, target = match.groups()
        if quote == "<":
            if SYSTEM_HEADER.match(target) and not path.startswith(MAY_USE_SYSTEM):
                yield number, f"<{target}> outside platform/linux and hil"
        elif room in MAY_INCLUDE and not path.startswith(JOINS_BOTH_SIDES):
            if not target.startswith(MAY_INCLUDE[room]):
                yield number, f'{room} may not include "{target}"'


def main() -> int:
    files = subprocess.run(
        ["git", "ls-files", "*.h", "*.cc"], check=True, capture_output=True, text=True
    ).stdout.split()
    bad = 0
    for path in files:
        for number, what in complaints(path):
            print(f"{path}:{number}: {what}", file=sys.stderr)
            bad += 1
    print(f"ladder: {len(files)} files, {bad} bad includes")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
