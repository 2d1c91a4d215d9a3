#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
"""The firmware edition against the localizer of the program, on simulated worlds.

    firmware_test.py OCTANT SOURCE [--qemu]

With --qemu it is built for a Cortex-M4F and runs in an emulator. Exit 77: a compiler or the emulator is missing."""

import csv
import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

OCTANT, SOURCE = (os.path.abspath(word) for word in sys.argv[1:3])
QEMU = "--qemu" in sys.argv[3:]
HERE = os.path.join(SOURCE, "tests", "apps", "firmware")
STATUS = ("ok", "too_few_arrivals", "poor_geometry", "ambiguous", "no_consensus", "not_converged")
PRECISIONS = (True,) if QEMU else (False, True)
NEAR_M = 1e-3  # issue 47: the same fixes to a millimetre
STRICT = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion", "-Wshadow", "-Werror"]
ARM = ["arm-none-eabi-gcc", "-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16", "-Os",
       "-ffunction-sections", "-fdata-sections"]

DRONE = """octant_scenario: 1
site:
  octant_site: 1
  name: drone
  motion: spatial
  medium: {model: linear_temperature, temperature_degC: 20.0, sigma_mps: 1.0}
  timing: {clock: synchronised, delay_per: beacon, delay_s: 1.0e-4, delay_sigma_s: 5.0e-5}
  noise: {tof_sigma_s: 1.0e-5}
  beacons:
BEACONS
  vehicles:
    - id: robot
      receivers:
        - {id: r0, position_m: [0.20, 0.00, 0.05]}
        - {id: r1, position_m: [-0.15, 0.20, 0.00]}
        - {id: r2, position_m: [-0.15, -0.20, 0.00]}
        - {id: r3, position_m: [0.00, 0.00, 0.15]}
hall_m: [16.0, 10.0]
range_m: 20.0
PATH
""".replace("BEACONS", "\n".join(
    f"    - {{id: D{i}, position_m: [{x}, {y}, {z}], sigma_m: {0.0 if i in (0, 3, 5) else 0.2}}}" for i, (x, y, z) in enumerate(
        [(0.0, 0.0, 4.5), (8.0, 0.0, 0.3), (16.0, 0.0, 4.2), (16.0, 10.0, 0.4), (8.0, 10.0, 4.6), (0.0, 10.0, 0.2)])))


def run(*words, ok=True, **more):
    done = subprocess.run(words, capture_output=True, text=True, timeout=900, check=False, **more)
    if ok and done.returncode != 0:
        raise AssertionError(f"{' '.join(words)}: exit {done.returncode}\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}")
    return done


def hall(stops):
    with open(os.path.join(SOURCE, "datasets", "hall", "scenario.yaml"), encoding="utf-8") as file:
        return file.read().replace("heldout_path: {epochs: 40}", f"heldout_path: {{epochs: {stops}}}\necho_fraction: 0.04")


def greenhouse(stops):
    with open(os.path.join(SOURCE, "datasets", "greenhouse", "scenario.yaml"), encoding="utf-8") as file:
        return file.read().replace("heldout_path: {epochs: 201}", f"heldout_path: {{epochs: {stops}}}")


def drone(stops):
    return DRONE.replace("PATH", f"echo_fraction: 0.02\npath: {{kind: stops, epochs: 60, epoch_period_s: 2.0, slot_s: 0.02}}\n"
                         f"heldout_path: {{epochs: {stops}}}")


class World:
    """A simulated site with its calibration, and the firmware made from it."""

    def __init__(self, folder, name, scenario, single, calibrated=True):
        self.name = name
        self.folder = os.path.join(folder, name)
        os.makedirs(self.folder)
        path = self / "scenario.yaml"
        with open(path, "w", encoding="utf-8") as file:
            file.write(scenario)
        run(OCTANT, "simulate", path, "-o", self / "world", "-q")
        self.deployment = self / "world/deployment.true.json"
        if calibrated:
            self.deployment = self / "deployment.json"
            run(OCTANT, "calibrate", self / "world/site.yaml", self / "world/run", "-o", self.deployment, "-q", "--progress", "none")
        self.run = self / "world/heldout"
        self.c = self / "c"
        run(OCTANT, "export", self.deployment, "--c", self.c, *(["--float"] if single else []))
        with open(self.deployment, encoding="utf-8") as file:
            deployment = json.load(file)
        self.beacons = {b["id"]: i for i, b in enumerate(deployment["beacons"])}
        self.delays = {b["id"]: b["delay_s"] for b in deployment["beacons"]}
        self.receivers = {r["id"]: i for i, r in enumerate(deployment["vehicles"][0]["receivers"])}

    def __truediv__(self, name):
        return os.path.join(self.folder, name)

    def build(self, flags):
        program = self / "driver"
        sources = [os.path.join(self.c, "octant_fix.c"), os.path.join(self.c, "octant_site.c"), os.path.join(HERE, "driver.c")]
        if QEMU:
            run(*ARM, "-std=c99", "-I", self.c, *sources, os.path.join(HERE, "startup.c"), "-nostartfiles", "-T",
                os.path.join(HERE, "cortex_m4.ld"), "--specs=rdimon.specs", "-Wl,--gc-sections", "-o", program, "-lm", "-lc", "-lrdimon")
        else:
            run("cc", *STRICT, *flags, "-I", self.c, *sources, "-o", program, "-lm")
        return program

    def lines(self, commands, flags=("-O1", "-g", "-fsanitize=address,undefined")):
        """What the firmware prints for these commands."""
        program = self.build(flags)
        with open(self / "commands.txt", "w", encoding="utf-8") as file:
            file.write("\n".join(commands) + "\n")
        words = [program]
        if QEMU:
            words = ["qemu-system-arm", "-M", "mps2-an386", "-nographic", "-monitor", "none", "-serial", "none", "-icount", "shift=0",
                     "-semihosting-config", "enable=on,target=native", "-kernel", program]
        done = run(*words, cwd=self.folder, env=dict(os.environ, ASAN_OPTIONS="detect_leaks=0"))
        return done.stdout.splitlines()

    def rewrite(self, change):
        """Changes each row of the recording."""
        path = os.path.join(self.run, "tof.csv")
        with open(path, encoding="utf-8", newline="") as file:
            rows = [change(row) for row in csv.DictReader(file)]
        with open(path, "w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, rows[0].keys())
            writer.writeheader()
            writer.writerows(rows)

    def stops(self):
        stops, last = [], None
        with open(os.path.join(self.run, "tof.csv"), encoding="utf-8", newline="") as file:
            for row in csv.DictReader(file):
                if row["epoch"] != last:
                    stops.append([])
                last = row["epoch"]
                stops[-1].append((self.beacons[row["beacon"]], self.receivers[row.get("receiver") or next(iter(self.receivers))], row["tof_s"] or "nan"))
        return stops

    def expected(self):
        run(OCTANT, "localize", self.deployment, self.run, "--method", "least_squares", "-o", self / "f.tum", "--csv", self / "f.csv", "-q")
        with open(self / "f.csv", encoding="utf-8", newline="") as file:
            return list(csv.DictReader(file))


def of_stop(stop, temperature="nan"):
    return [f"E {len(stop)} {temperature}"] + [f"{b} {r} {tof}" for b, r, tof in stop]


class Fix:
    def __init__(self, line):
        words = line.split()
        self.status = STATUS[int(words[0])]
        numbers = [float(word) for word in words[1:]]
        self.p, self.q = numbers[:3], numbers[3:7]
        self.level, self.used, self.rejected = numbers[7], int(numbers[8]), int(numbers[9])
        self.covariance = numbers[10:]

    def heading(self):
        x, y, z, w = self.q
        return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


class Comparison(unittest.TestCase):
    def setUp(self):
        self.box = tempfile.TemporaryDirectory(prefix="octant-firmware-")
        self.addCleanup(self.box.cleanup)

    def compare(self, world, least_ok, change=lambda row: row, temperature="nan"):
        """Fixes of the firmware and of the program, from the same arrivals, after `change` of each row of tof.csv."""
        world.rewrite(change)
        stops, expected = world.stops(), world.expected()
        lines = world.lines([line for stop in stops for line in of_stop(stop, temperature)])
        self.assertEqual(len(lines) - 1, len(stops))
        self.assertEqual(len(expected), len(stops))
        pairs = [(row, Fix(line)) for row, line in zip(expected, lines)]
        differing = sum(row["status"] != fix.status for row, fix in pairs)
        both = [(row, fix) for row, fix in pairs if row["status"] == fix.status == "ok"]
        worst = max(math.dist([float(row[axis]) for axis in ("x_m", "y_m", "z_m")], fix.p) for row, fix in both)
        print(f"{world.name}: {len(stops)} stops, {len(both)} fixes in common, {differing} with another status, "
              f"largest difference {1e3 * worst:.4f} mm; {lines[-1]}")
        self.assertGreater(len(both), least_ok * len(stops))
        self.assertLess(worst, NEAR_M)
        self.assertLessEqual(differing, 0.01 * len(stops))
        for row, fix in both:
            self.assertLess(abs(math.sqrt(fix.covariance[0]) / float(row["sigma_x_m"]) - 1), 0.02)
            if float(row["sigma_heading_rad"]) < 1:
                self.assertLess(abs(math.remainder(fix.heading() - float(row["heading_rad"]), 2 * math.pi)), 1e-3)
            level = float(row["protection_level_m"])
            if level < 10:  # beyond it, single precision does not determine the fix without a beacon
                self.assertAlmostEqual(fix.level, level, delta=1e-3 + 0.02 * level)
            self.assertEqual((fix.used, fix.rejected), (int(row["arrivals_used"]), int(row["arrivals_rejected"])))
        return both, lines[-1]

    def world(self, name, scenario, single, calibrated=True):
        return World(self.box.name, f"{name}-{'float' if single else 'double'}", scenario, single, calibrated)


class Firmware(Comparison):
    def test_hall(self):
        for single in PRECISIONS:
            self.compare(self.world("hall", hall(500 if single else 100), single), 0.95)

    def test_greenhouse(self):
        for single in PRECISIONS:
            self.compare(self.world("greenhouse", greenhouse(300 if single else 100), single, False), 0.4)

    def test_drone(self):
        for single in PRECISIONS:
            self.compare(self.world("drone", drone(200 if single else 60), single), 0.9)

    def test_position_of_a_drone_with_one_receiver(self):
        one = re.sub(r"        - {id: r[123].*\n", "", drone(60))
        both, _ = self.compare(self.world("antenna", one, True), 0.9)
        self.assertTrue(all(fix.covariance[35] > 3 for _, fix in both), "the rotation is unknown")

    def test_a_faulty_beacon_is_excluded(self):
        """10 mm are within the gate of an arrival, but not those of all eight receivers together."""
        def late(row):
            return dict(row, tof_s=float(row["tof_s"]) + (3.1e-5 if row["beacon"] == "B4" else 0))
        scenario = hall(60).replace("hearing_half_angle_rad: 1.18", "hearing_half_angle_rad: 3.15")
        both, _ = self.compare(self.world("fault", scenario, True), 0.8, late)
        self.assertGreater(sum(row["integrity_reason"] == "beacon_fault" for row, _ in both), 1)

    def test_temperature(self):
        """The speed of sound by Cramer's formula, of which the table has a polynomial."""
        for celsius in (-12.0, 45.0):
            world = self.world(f"at{celsius}", hall(40), True)
            with open(os.path.join(world.c, "octant_site.c"), encoding="utf-8") as file:
                speeds = [float(x) for x in re.search(r"1\.0*f,\s*{([^}]*)}", file.read()).group(1).replace("f", "").split(",")]
            ratio = speeds[0] / sum(c * ((celsius - 21.0) / 50) ** k for k, c in enumerate(speeds))
            def change(row, world=world, celsius=celsius, ratio=ratio):
                delay = world.delays[row["beacon"]]
                return dict(row, temperature_degC=celsius, tof_s=delay + (float(row["tof_s"]) - delay) * ratio)
            self.compare(world, 0.9, change, str(celsius))

    def test_hostile_input(self):
        for scenario in (hall(5), drone(5)):
            world = self.world("hostile" + str(len(scenario)), scenario, True, False)
            good = world.stops()[0]
            limit = len(world.beacons) * len(world.receivers)
            numbers = ("nan", "inf", "-inf", "-1", "0", "1e-30", "1e30", "999", "1e-5")
            stops = [[], [(b, r, "nan") for b, r, _ in good], [(255, 0, "0.01"), (0, 255, "0.01"), (200, 200, "nan")],
                     good * 50, good + [(b, r, x) for b, r, _ in good for x in numbers][:limit - len(good)],
                     [(0, 0, "0.02")] * limit, [(b, r, "0.02") for b, r, _ in good], good[:1], good[:2], good[:3], good]
            stops += [[(b, r, x) for b, r, _ in good] for x in numbers]
            stops = [stop[:3 * limit] for stop in stops]
            lines = world.lines([line for stop in stops for line in of_stop(stop)] + of_stop(good, "inf") + of_stop(good, "-1e30"))
            for stop, line in zip(stops, lines):
                fix = Fix(line)
                self.assertEqual(fix.used + fix.rejected, len(stop))
                self.assertTrue(all(math.isfinite(x) for x in fix.p + fix.q + fix.covariance + [fix.level]) or fix.status != "ok")
            self.assertEqual(Fix(lines[0]).status, "too_few_arrivals")
            for index in (1, 2, 5):
                self.assertNotEqual(Fix(lines[index]).status, "ok")
            self.assertEqual(Fix(lines[len(stops) - len(numbers) - 1]).status, "ok")


@unittest.skipUnless(QEMU, "needs --qemu")
class Budget(Comparison):
    """16 beacons and 8 receivers in single precision: 32 KB of code, 4 KB of RAM, a bounded number of instructions."""

    CODE, RAM = 32 * 1024, 4 * 1024
    INSTRUCTIONS_EACH_TICK = 40  # -icount shift=0: a nanosecond each; SysTick of mps2-an386: 25 MHz
    MOST_INSTRUCTIONS = 60e6     # 0.5 s at 168 MHz and 1.4 cycles each, for a search from nothing

    def budget(self, world):
        objects = [os.path.join(self.box.name, name + ".o") for name in ("fix", "bare")]
        for source, target in zip((os.path.join(world.c, "octant_fix.c"), os.path.join(HERE, "bare.c")), objects):
            run(*ARM, "-std=c99", "-I", world.c, "-c", source, "-o", target)
        site = os.path.join(self.box.name, "site.o")
        run(*ARM, "-std=c99", "-I", world.c, "-c", os.path.join(world.c, "octant_site.c"), "-o", site)
        program = os.path.join(self.box.name, "bare")
        used = run(*ARM, *objects, site, "-nostartfiles", "-T", os.path.join(HERE, "cortex_m4.ld"), "-e", "reset", "--specs=nosys.specs",
                   "-Wl,--gc-sections,--print-memory-usage", "-o", program, "-lm", "-lc").stdout
        flash = int(re.search(r"FLASH:\s+(\d+) B", used).group(1))
        tables = int(run("arm-none-eabi-size", site).stdout.splitlines()[1].split()[0])
        both, last = self.compare(world, 0.9)
        numbers = dict(zip(last.split()[::2], map(int, last.split()[1::2])))
        ram, most = numbers["memory"] + numbers["stack"], numbers["ticks"] * self.INSTRUCTIONS_EACH_TICK
        print(f"{world.name}: {flash - tables} B of code with the mathematical functions, {tables} B of tables, {ram} B of RAM "
              f"({numbers['stack']} B of stack), instructions of a fix: mean {numbers['mean'] * self.INSTRUCTIONS_EACH_TICK}, most {most}")
        self.assertLessEqual(flash - tables, self.CODE)
        self.assertLessEqual(ram, self.RAM)
        self.assertLess(most, self.MOST_INSTRUCTIONS)

    def test_budget_in_the_plane(self):
        more = "".join(f"    - {{id: C{i}, position_m: [{x}, {y}, {z}], sigma_m: 0.2}}\n" for i, (x, y, z) in enumerate(
            [(2, 0, 2.4), (8, 0, 2.6), (16, 0, 2.5), (20, 5, 2.4), (18, 12, 2.6), (12, 12, 2.4), (4, 12, 2.5), (0, 7, 2.6)]))
        scenario = hall(60).replace("  vehicles:", more + "  vehicles:", 1).replace("hearing_half_angle_rad: 1.18", "hearing_half_angle_rad: 1.57")
        self.budget(self.world("plane16", scenario, True))

    def test_budget_in_space(self):
        more = "".join(f"    - {{id: C{i}, position_m: [{1.7 * i}, {(3 * i) % 10}, {0.3 + 0.43 * i}], sigma_m: 0.2}}\n" for i in range(10))
        receivers = "".join(f"        - {{id: s{i}, position_m: [{0.1 * i - 0.2}, {0.05 * i * (-1) ** i}, {0.03 * i}]}}\n" for i in range(4))
        self.budget(self.world("space16", drone(30).replace("  vehicles:", more + "  vehicles:", 1).replace("hall_m", receivers + "hall_m", 1), True))


def missing():
    tools = ["arm-none-eabi-gcc", "qemu-system-arm"] if QEMU else ["cc"]
    return [tool for tool in tools if not shutil.which(tool)]


if __name__ == "__main__":
    if missing():
        print(f"skipped: {' and '.join(missing())} not found")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1] + [word for word in sys.argv[3:] if word != "--qemu"])
