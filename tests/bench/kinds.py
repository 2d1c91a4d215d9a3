#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
"""Time and memory of `octant calibrate` and `octant localize` on each kind of world of ../shared/check, as a Markdown table.

    python3 tests/bench/kinds.py --octant build/release/bin/octant [--worlds ../shared/check/worlds.py] [--repeats 3] [KIND...]

The smallest of the repeats counts (others use these machines too); memory is the largest resident set.
"""
import argparse
import os
import pathlib
import subprocess
import sys
import tempfile
import time

KINDS = ("stop_and_go cycle_offset cycle_offset_half rail_pair head_tail moving cold cold_free time_walk time_walk_blind echoes_10 "
         "echoes_30 swapped degenerate_line degenerate_scale degenerate_few").split()


def measure(command, repeats):
    """Smallest wall-clock time [s], largest resident set [MB] and the exit status of a command."""
    seconds, megabytes, code = float("inf"), 0.0, 0
    for _ in range(repeats):
        began = time.perf_counter()
        child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        _, status, usage = os.wait4(child.pid, 0)
        seconds = min(seconds, time.perf_counter() - began)
        megabytes = max(megabytes, usage.ru_maxrss / 1024)
        code = os.waitstatus_to_exitcode(status)
        child.returncode = code
    return seconds, megabytes, code


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kinds", nargs="*", default=KINDS)
    parser.add_argument("--octant", default="build/release/bin/octant")
    parser.add_argument("--worlds", default="../shared/check/worlds.py")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--size", default="small")
    options = parser.parse_args()
    if not pathlib.Path(options.worlds).exists():
        print(f"{options.worlds} is not here: nothing to measure", file=sys.stderr)
        return 0
    print("| kind | arrivals | calibrate | memory | localize | memory | exit |\n|---|---|---|---|---|---|---|")
    for kind in options.kinds:
        with tempfile.TemporaryDirectory() as folder:
            world = pathlib.Path(folder, "world")
            subprocess.run([sys.executable, options.worlds, "make", kind, "--seed", str(options.seed), "--size", options.size, "-o", world],
                           check=True, stdout=subprocess.DEVNULL)
            with open(world / "run" / "tof.csv", encoding="utf-8") as rows:
                arrivals = sum(1 for row in rows if not row.startswith("#")) - 1
            deployment = pathlib.Path(folder, "deployment.json")
            seconds, megabytes, code = measure([options.octant, "calibrate", world / "site.yaml", world / "run", "-o", deployment, "-q"], options.repeats)
            row = f"| {kind} | {arrivals:,} | {seconds:.2f} s | {megabytes:.0f} MB |"
            if deployment.exists():
                seconds, megabytes, _ = measure([options.octant, "localize", deployment, world / "heldout", "-o", pathlib.Path(folder, "fixes.tum"), "-q"],
                                                options.repeats)
                row += f" {seconds:.2f} s | {megabytes:.0f} MB |"
            else:
                row += " | |"
            print(row + f" {code} |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
