#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
"""`octant localize --follow --format mavlink`, read by a parser of its own and compared with the truth.

    mavlink_test.py OCTANT SOURCE
"""

import csv
import json
import math
import os
import struct
import subprocess
import sys
import tempfile
import unittest

OCTANT, SOURCE = (os.path.abspath(word) for word in sys.argv[1:3])

# Message id: CRC extra, layout of the payload.
MESSAGES = {102: (158, "<Q3f3f21fB"), 331: (91, "<Q3f4f6f21f21f4Bb"), 232: (151, "<QIii9fHHBBBH")}
DRONE = """octant_scenario: 1
site:
  octant_site: 1
  name: drone
  motion: spatial
  medium: {model: linear_temperature, temperature_degC: 20.0, sigma_mps: 1.0}
  timing: {clock: synchronised, delay_per: beacon, delay_s: 1.0e-4, delay_sigma_s: 5.0e-5}
  noise: {tof_sigma_s: 1.0e-5}
  beacons:
    - {id: D0, position_m: [0.0, 0.0, 4.5], sigma_m: 0.0}
    - {id: D1, position_m: [8.0, 0.0, 0.3], sigma_m: 0.2}
    - {id: D2, position_m: [16.0, 0.0, 4.2], sigma_m: 0.2}
    - {id: D3, position_m: [16.0, 10.0, 0.4], sigma_m: 0.0}
    - {id: D4, position_m: [8.0, 10.0, 4.6], sigma_m: 0.2}
    - {id: D5, position_m: [0.0, 10.0, 0.2], sigma_m: 0.0}
  vehicles:
    - id: robot
      receivers:
        - {id: r0, position_m: [0.30, 0.00, 0.00]}
        - {id: r1, position_m: [-0.20, 0.30, 0.00]}
        - {id: r2, position_m: [-0.20, -0.30, 0.00]}
hall_m: [16.0, 10.0]
range_m: 20.0
path: {kind: stops, epochs: 10, epoch_period_s: 2.0, slot_s: 0.02}
heldout_path: {epochs: 60}
"""


def crc_mcrf4xx(data):
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x8408 if crc & 1 else 0)
    return crc


def frames_of(stream):
    """(sequence, system, message id, numbers) of each frame; every byte belongs to a frame."""
    while stream:
        assert stream[0] == 0xFD, stream[:12]
        size = stream[1]
        body, checksum, stream = stream[1:10 + size], stream[10 + size:12 + size], stream[12 + size:]
        message = int.from_bytes(body[6:9], "little")
        extra, layout = MESSAGES[message]
        assert crc_mcrf4xx(body + bytes([extra])) == int.from_bytes(checksum, "little")
        assert body[1:3] == b"\0\0" and (size == 1 or body[-1] != 0)
        payload = body[9:].ljust(struct.calcsize(layout), b"\0")
        yield body[3], body[4], message, struct.unpack(layout, payload)


def simulate(folder, scenario):
    path = os.path.join(folder, "scenario.yaml")
    with open(path, "w", encoding="utf-8") as file:
        file.write(scenario)
    world = os.path.join(folder, "world")
    subprocess.run([OCTANT, "simulate", path, "-o", world, "-q"], check=True, capture_output=True, timeout=120)
    return world


def rows(world, run):
    """Live lines of a recording in the order of time."""
    lines = []
    with open(os.path.join(world, run, "tof.csv"), encoding="utf-8") as file:
        for row in csv.DictReader(file):
            lines.append({"time_s": float(row["time_s"]), "beacon": row["beacon"], "tof_s": float(row["tof_s"]),
                          "receiver": row["receiver"]} | ({"epoch": int(row["epoch"])} if row.get("epoch") else {}))
    odometry = os.path.join(world, run, "odometry.csv")
    if os.path.exists(odometry):
        with open(odometry, encoding="utf-8") as file:
            lines += [{key: float(row[key]) for key in ("time_s", "dx_m", "dy_m", "dheading_rad")} for row in csv.DictReader(file)]
    return sorted(lines, key=lambda row: (row["time_s"], "dx_m" not in row))


def truth(world, run):
    """Position in the map and direction of the vehicle's x axis by time."""
    poses = []
    with open(os.path.join(world, run, "truth.tum"), encoding="utf-8") as file:
        for line in file:
            if not line.startswith("#"):
                t, x, y, z, qx, qy, qz, qw = map(float, line.split())
                poses.append((t, x, y, z, math.atan2(2 * (qx * qy + qw * qz), 1 - 2 * (qy * qy + qz * qz))))
    return poses


def follow(world, lines, *words):
    data = "".join(json.dumps(row) + "\n" for row in lines).encode()
    done = subprocess.run([OCTANT, "localize", os.path.join(world, "deployment.true.json"), "--follow", *words], input=data,
                          capture_output=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr.decode()
    return list(frames_of(done.stdout))


def off_deg(a_rad, b_rad):
    return abs((math.degrees(a_rad - b_rad) + 180) % 360 - 180)


class Mavlink(unittest.TestCase):
    def compare(self, world, run, frames, north_rad, yaw_of):
        poses = truth(world, run)
        for _, _, _, numbers in frames:
            time_s, x, y, z, heading = min(poses, key=lambda pose: abs(pose[0] - numbers[0] * 1e-6))
            self.assertLess(abs(time_s - numbers[0] * 1e-6), 0.11)
            north = x * math.cos(north_rad) + y * math.sin(north_rad)
            east = x * math.sin(north_rad) - y * math.cos(north_rad)
            self.assertLess(math.dist(numbers[1:4], (north, east, -z)), 0.1)
            self.assertLess(off_deg(yaw_of(numbers), north_rad - heading), 2.0)
        self.assertEqual([frame[0] for frame in frames], [i % 256 for i in range(len(frames))])

    def test_drone_with_three_receivers(self):
        with tempfile.TemporaryDirectory() as folder:
            world = simulate(folder, DRONE)
            lines = rows(world, "heldout")
            frames = follow(world, lines, "--format", "mavlink")
            self.assertGreaterEqual(len(frames), 55)
            self.assertEqual({frame[2] for frame in frames}, {102})
            self.compare(world, "heldout", frames, math.pi / 2, lambda numbers: numbers[6])
            for _, _, _, numbers in frames:
                variances = [numbers[7 + i] for i in (0, 6, 11, 15, 18, 20)]
                self.assertTrue(all(0 < variance < 1 for variance in variances), variances)
            # The same fixes as ODOMETRY, in a map whose north is 20 degrees from +x.
            frames = follow(world, lines, "--output", "mavlink", "--mavlink-message", "odometry", "--north", "20")
            self.assertEqual({frame[2] for frame in frames}, {331})

            def yaw(numbers):
                w, x, y, z = numbers[4:8]
                return math.atan2(2 * (x * y + w * z), 1 - 2 * (y * y + z * z))

            self.compare(world, "heldout", frames, math.radians(20), yaw)
            self.assertEqual({frame[3][-5:-3] for frame in frames}, {(1, 12)})  # LOCAL_NED, BODY_FRD
            self.assertTrue(all(1 <= frame[3][-1] <= 100 for frame in frames))

    def test_a_lost_track_counts_as_a_reset(self):
        with tempfile.TemporaryDirectory() as folder:
            world = simulate(folder, DRONE)
            lines = [row for row in rows(world, "heldout") if row["epoch"] != 30 or row["beacon"] == "D0"]
            frames = follow(world, lines, "--format", "mavlink")
            resets = [frame[3][-1] for frame in frames]
            self.assertEqual(resets[0], 0)
            self.assertEqual(resets, sorted(resets))
            whole = follow(world, rows(world, "heldout"), "--format", "mavlink")
            self.assertEqual(resets[-1], whole[-1][3][-1] + 1)
            self.assertEqual(len(frames), len(whole) - 1)

    def test_drive_with_velocity_and_gps_input(self):
        with open(os.path.join(SOURCE, "datasets", "hall", "scenario.yaml"), encoding="utf-8") as file:
            scenario = file.read()
        path = next(line for line in scenario.splitlines() if line.startswith("path: "))
        with tempfile.TemporaryDirectory() as folder:
            world = simulate(folder, scenario.replace(path, "path: {kind: drive, duration_s: 20.0}"))
            lines = rows(world, "run")
            frames = follow(world, lines, "--format", "mavlink", "--mavlink-message", "odometry")[20:]
            self.assertGreater(len(frames), 50)
            self.assertEqual({frame[3][-5:-3] for frame in frames}, {(20, 12)})  # LOCAL_FRD, BODY_FRD
            speeds = [frame[3][8] for frame in frames if not math.isnan(frame[3][8])]
            poses = truth(world, "run")
            self.assertGreater(len(speeds), 50)
            fastest = max(math.dist(a[1:3], b[1:3]) / (b[0] - a[0]) for a, b in zip(poses, poses[1:]))
            self.assertLess(max(map(abs, speeds)), 1.5 * fastest + 0.1)
            origin = (48.14816, 17.10674)
            gps = follow(world, lines, "--format", "mavlink", "--mavlink-message", "gps", "--origin", "%s,%s" % origin)[20:]
            self.assertEqual(len(gps), len(frames))
            for (_, _, message, numbers), frame in zip(gps, frames):
                self.assertEqual((message, numbers[0]), (232, frame[3][0]))
                # By a sphere of the ellipsoid's radii there; the unit of 1e-7 degrees is 11 mm.
                self.assertAlmostEqual((numbers[2] * 1e-7 - origin[0]) * 111200, frame[3][1], delta=0.03)
                self.assertAlmostEqual((numbers[3] * 1e-7 - origin[1]) * 74400, frame[3][2], delta=0.03)
                w, z = frame[3][4], frame[3][7]
                self.assertLess(off_deg(math.radians(numbers[-1] / 100), 2 * math.atan2(z, w)), 0.02)

    def test_gps_input_needs_the_origin(self):
        done = subprocess.run([OCTANT, "localize", os.path.join(SOURCE, "datasets", "hall", "deployment.true.json"), "--follow",
                               "--format", "mavlink", "--mavlink-message", "gps"], input=b"", capture_output=True, check=False, timeout=60)
        self.assertEqual(done.returncode, 2)
        self.assertIn(b"--origin", done.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
