#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
"""False statements get the same findings from every entry: command line, log in chunks, two ranks, `check`, Python.

    entries_test.py OCTANT OCTANT_MPI SOURCE        (OCTANT_MPI may be empty; PYTHONPATH may hold the Python module)

tests/calib/calibrate_test.cc has the entries of C++ and sites of many parameters.
"""

import csv
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

OCTANT, OCTANT_MPI, SOURCE = sys.argv[1:4]
try:
    import octant
except ImportError:
    octant = None


def replaced(path, old, new):
    with open(path, encoding="utf-8") as file:
        text = file.read()
    assert re.search(old, text), old
    with open(path, "w", encoding="utf-8") as file:
        file.write(re.sub(old, new, text))


def with_rows(path, change):
    with open(path, encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        change(row, (float(rows[0]["time_s"]) + float(rows[-1]["time_s"])) / 2)
    with open(path, "w", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def control_point(world):
    replaced(f"{world}/site.yaml", r"\[19\.95, 8\.15, 2\.48\]", "[19.45, 8.15, 2.48]")


def control_points_exchanged(world):
    replaced(f"{world}/site.yaml", r"(id: B0, position_m: )(\[.*?\])(.*\n[^#]*?id: B3, position_m: )(\[.*?\])", r"\1\4\3\2")


def thermometer(world):
    replaced(f"{world}/site.yaml", r"sigma_mps: 2\n", "sigma_mps: 0.3\n")
    replaced(f"{world}/site.yaml", r"temperature_degC: 21", "temperature_degC: 41")


def receivers_exchanged(world):
    replaced(f"{world}/site.yaml", r"(id: r1, position_m: )(\[.*?\])(.*\n.*id: r2, position_m: )(\[.*?\])", r"\1\4\3\2")


def receiver_position(world):
    replaced(f"{world}/site.yaml", r"id: r3, position_m: \[-0.046", "id: r3, position_m: [-0.096")


def delay_of_a_beacon(world):
    replaced(f"{world}/site.yaml", r"(id: B4.*sigma_m: 0.3)", r"\1, delay_s: 0.0006, delay_sigma_s: 0.00001")


def clock_jumped(world):
    def change(row, middle):
        row["tof_s"] = float(row["tof_s"]) + (1e-3 if float(row["time_s"]) > middle else 0.0)
    with_rows(f"{world}/run/tof.csv", change)


def two_way(world):
    def change(row, _):
        row["tof_s"] = 2 * float(row["tof_s"])
    with_rows(f"{world}/run/tof.csv", change)


def height_of_a_control_point(world):
    replaced(f"{world}/site.yaml", r"\[0\.05, 11\.5, 2\.43\]", "[0.05, 11.5, 2.93]")


def no_delay(world):
    replaced(f"{world}/site.yaml", r"delay_per: beacon\n  delay_s: .*\n  delay_sigma_s: .*\n", "delay_per: none\n")


STATEMENTS = [control_point, control_points_exchanged, thermometer, receivers_exchanged, receiver_position, delay_of_a_beacon,
              clock_jumped, two_way, height_of_a_control_point, no_delay]


def culprits(answer):
    """What is contradicted, and what to do, without numbers that depend on the order of sums."""
    verdict = answer.get("verdict") or {}
    return sorted((c["kind"], c["subject"], c["remedy"]) for c in verdict.get("contradictions", []))


def run(*words):
    done = subprocess.run(words, capture_output=True, text=True, timeout=300, check=False)
    return done.returncode, json.loads(done.stdout)


class Entries(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        scenario = os.path.join(self.folder.name, "scenario.yaml")
        shutil.copy(os.path.join(SOURCE, "datasets", "hall", "scenario.yaml"), scenario)
        replaced(scenario, "epochs: 150", "epochs: 800")  # two megabytes in memory, so that --memory-mb 1 reads it in chunks
        self.world = os.path.join(self.folder.name, "world")
        subprocess.run([OCTANT, "simulate", scenario, "-o", self.world, "-q"], check=True, timeout=60, stdout=subprocess.DEVNULL)

    def answers(self):
        site, run_folder = f"{self.world}/site.yaml", f"{self.world}/run"
        words = ["calibrate", site, run_folder, "-o", f"{self.world}/d.json", "--json", "--progress", "none", "--threads", "1"]
        yield "in memory", run(OCTANT, *words)
        yield "in chunks", run(OCTANT, *words, "--memory-mb", "1")
        if OCTANT_MPI:
            yield "two ranks", run("env", "OMPI_ALLOW_RUN_AS_ROOT=1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1", "mpirun",
                                   "--oversubscribe", "-n", "2", OCTANT_MPI, *words)
        code, checked = run(OCTANT, "check", site, run_folder, "--json", "--progress", "none", "--threads", "1")
        yield "check", (code, checked)
        if octant:
            try:
                yield "Python", (0, octant.calibrate(site, run_folder, threads=1).result)
            except octant.Error as error:
                yield "Python", (error.exit, error.result)

    def expect_the_same(self, falsify):
        falsify(self.world)
        answers = dict(self.answers())
        code, expected = answers.pop("in memory")
        self.assertNotEqual(code, 0, falsify.__name__)
        self.assertTrue(culprits(expected), expected.get("error"))
        if falsify is not two_way:  # a log in the wrong unit is not read in chunks
            self.assertTrue(answers["in chunks"][1].get("streamed"))
        for entry, (found_code, found) in answers.items():
            self.assertEqual(culprits(found), culprits(expected), entry)
            if entry != "check":  # which exports nothing and thus refuses nothing
                self.assertEqual(found_code, code, entry)


for statement in STATEMENTS:
    setattr(Entries, f"test_{statement.__name__}_is_named_by_every_entry", lambda self, s=statement: self.expect_the_same(s))

if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[4:])
