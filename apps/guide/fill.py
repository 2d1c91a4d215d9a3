#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
"""Writes the outputs of the guide's commands anew: python3 apps/guide/fill.py build/release/bin/octant"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile

GUIDE = pathlib.Path(__file__).resolve().parent
BLOCKS = re.compile(r"```sh\n(.*?)```\n(```text\n(.*?)```\n)?", re.DOTALL)


def fill(page: pathlib.Path, octant: pathlib.Path) -> None:
    with tempfile.TemporaryDirectory() as folder:
        # The folder of the sources, its build done: what would install or compile does nothing.
        for name in ("datasets", "apps", "CMakePresets.json"):
            os.symlink(GUIDE.parent.parent / name, f"{folder}/{name}")
        os.makedirs(f"{folder}/build/release/bin")
        os.symlink(octant, f"{folder}/build/release/bin/octant")
        os.makedirs(f"{folder}/shims")
        for name in ("cmake", "apt-get", "sudo"):
            os.symlink("/bin/true", f"{folder}/shims/{name}")
        environment = {**os.environ, "PATH": f"{folder}/shims:{octant.parent}:{os.environ['PATH']}", "NO_COLOR": "1", "OCTANT_DEFAULTS": ""}

        def run(block: re.Match) -> str:
            done = subprocess.run(["sh", "-c", block[1]], cwd=folder, env=environment, text=True, stdout=subprocess.PIPE,
                                  stderr=subprocess.DEVNULL)
            if block[2] is None:
                return block[0]
            printed = done.stdout
            if "..." in (block[3] or "").splitlines():  # what the page leaves out stays left out
                lines, kept = printed.splitlines(), block[3].splitlines()
                at = kept.index("...")
                after = len(kept) - at - 1
                printed = "\n".join(lines[:at] + ["..."] + (lines[-after:] if after else [])) + "\n"
            return f"```sh\n{block[1]}```\n```text\n{printed}```\n"

        page.write_text(BLOCKS.sub(run, page.read_text()))


if __name__ == "__main__":
    program = pathlib.Path(sys.argv[1]).resolve()
    words = subprocess.run([program, "explain", "--page"], capture_output=True, text=True, check=True).stdout
    (GUIDE / "4-words.md").write_text(words)
    for path in sorted(GUIDE.glob("[123567]-*.md")):
        fill(path, program)
