#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
"""`octant localize --follow` as a process: streams, sockets, a serial line, signals, rubbish.

    follow_test.py OCTANT SOURCE
"""

import csv
import json
import os
import pty
import random
import re
import signal
import socket
import subprocess
import sys
import tempfile
import termios
import time
import unittest

OCTANT, SOURCE = (os.path.abspath(word) for word in sys.argv[1:3])
HALL = os.path.join(SOURCE, "datasets", "hall")
DEPLOYMENT = os.path.join(HALL, "deployment.true.json")


def heldout_lines():
    """datasets/hall/heldout as live lines: 40 stops, each with its epoch."""
    with open(os.path.join(HALL, "heldout", "tof.csv"), encoding="utf-8") as file:
        for row in csv.DictReader(file):
            yield json.dumps({"time_s": float(row["time_s"]), "beacon": row["beacon"], "tof_s": float(row["tof_s"]),
                              "epoch": int(row["epoch"]), "receiver": row["receiver"]})


LINES = list(heldout_lines())
STREAM = "".join(line + "\n" for line in LINES).encode()


def follow(*words, deployment=DEPLOYMENT, **more):
    return subprocess.Popen([OCTANT, "localize", deployment, "--follow", *words], stdin=subprocess.PIPE,
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE, **more)


def whole(data, *words, **more):
    process = follow(*words, **more)
    out, err = process.communicate(data, timeout=120)
    return process.returncode, out.decode(), err.decode()


def fixes_of(out):
    return [fix for fix in map(json.loads, out.splitlines()) if fix["type"] == "fix" and fix["status"] == "ok"]


def offline():
    done = subprocess.run([OCTANT, "localize", DEPLOYMENT, os.path.join(HALL, "heldout"), "-o", "-", "-q", "--method",
                           "least_squares"], capture_output=True, text=True, timeout=60, check=True)
    return [list(map(float, line.split())) for line in done.stdout.splitlines() if not line.startswith("#")]


def later(line, times):
    """The same row so many recordings later."""
    row = json.loads(line)
    row["time_s"] += 1000 * times
    row["epoch"] += 100 * times
    return json.dumps(row).encode() + b"\n"


def resident_mb(process):
    with open(f"/proc/{process.pid}/status", encoding="utf-8") as status:
        return int(re.search(r"VmRSS:\s+(\d+)", status.read()).group(1)) / 1024


class Streams(unittest.TestCase):
    def test_gives_the_fixes_of_the_recording(self):
        code, out, err = whole(STREAM)
        self.assertEqual(code, 0, err)
        expected = offline()
        fixes = fixes_of(out)
        self.assertEqual(len(fixes), len(expected))
        for fix, row in zip(fixes, expected):
            self.assertAlmostEqual(fix["x_m"], row[1], 5)
            self.assertAlmostEqual(fix["y_m"], row[2], 5)
        self.assertIn("fixes            40", err)

    def test_arrivals_tell_the_speed_of_air_at_an_unknown_temperature(self):
        with open(DEPLOYMENT, encoding="utf-8") as file:
            colder = json.load(file)
        del colder["digest"]
        colder["medium"]["offset_mps"] -= 5.0  # eight degrees
        colder["medium"]["speed_mps"] -= 5.0
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "colder.json")
            with open(path, "w", encoding="utf-8") as file:
                json.dump(colder, file)
            process = follow(deployment=path)
            out, err = process.communicate(b"".join(later(line, again) for again in range(3) for line in LINES), timeout=120)
        self.assertEqual(process.returncode, 0, err)
        self.assertIn("the temperature is not known; from here on the speed is that of", err.decode())
        fixes, expected = fixes_of(out.decode())[-len(offline()):], offline()
        off_m = [((fix["x_m"] - row[1]) ** 2 + (fix["y_m"] - row[2]) ** 2) ** 0.5 for fix, row in zip(fixes, expected)]
        self.assertLess(sorted(off_m)[len(off_m) // 2], 0.005)

    def test_odometry_is_as_good_as_the_robot_says(self):
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(HALL, "scenario.yaml"), encoding="utf-8") as file:
                scenario = re.sub(r"\npath: .*", "\npath: {kind: drive, duration_s: 40.0}", file.read())
            path = os.path.join(folder, "drive.yaml")
            with open(path, "w", encoding="utf-8") as file:
                file.write(scenario)
            world = os.path.join(folder, "world")
            subprocess.run([OCTANT, "simulate", path, "-o", world, "-q"], check=True, timeout=60)
            rows = []
            with open(os.path.join(world, "run", "odometry.csv"), encoding="utf-8") as file:
                steps = [{key: float(row[key]) for key in ("time_s", "dx_m", "dy_m", "dheading_rad")} for row in csv.DictReader(file)]
            with open(os.path.join(world, "run", "tof.csv"), encoding="utf-8") as file:
                arrivals = [{"time_s": float(row["time_s"]), "beacon": row["beacon"], "tof_s": float(row["tof_s"]),
                             "receiver": row["receiver"]} for row in csv.DictReader(file)]
            # Fifteen seconds of arrivals, then odometry alone, then one more arrival.
            heard = [a for a in arrivals if a["time_s"] < 15.0]
            last = next(a for a in arrivals if a["time_s"] > 25.0)
            driven_m = sum((s["dx_m"] ** 2 + s["dy_m"] ** 2) ** 0.5 for s in steps if heard[-1]["time_s"] < s["time_s"] <= 25.0)
            self.assertGreater(driven_m, 2.0)
            rows = sorted(heard + [last] + steps, key=lambda row: (row["time_s"], "dx_m" not in row))
            data = "".join(json.dumps(row) + "\n" for row in rows).encode()

            def across_m(*words):
                code, out, err = whole(data, *words, deployment=os.path.join(world, "deployment.true.json"))
                self.assertEqual(code, 0, err)
                fix = fixes_of(out)[-1]
                self.assertAlmostEqual(fix["time_s"], last["time_s"], 6)
                return (fix["sigma_x_m"] ** 2 + fix["sigma_y_m"] ** 2) ** 0.5

            # The one range tells the place along itself; across it the odometry's noise has grown with the root of the way.
            for sigma in (0.1, 0.2):
                accuracy = os.path.join(folder, "run.yaml")
                with open(accuracy, "w", encoding="utf-8") as file:
                    file.write(f"octant_run: 1\nodometry: {{distance_sigma_m_per_sqrt_m: {sigma}, heading_sigma_rad_per_sqrt_m: 0.0, floor_rad: 0.0}}\n")
                self.assertAlmostEqual(across_m("--odometry", accuracy) / (sigma * driven_m ** 0.5), 1.0, delta=0.1)
            stated = across_m("--odometry", os.path.join(world, "run"))
            self.assertLess(stated, across_m("--odometry", accuracy))
            silent = os.path.join(folder, "silent.yaml")
            with open(silent, "w", encoding="utf-8") as file:
                file.write("octant_run: 1\n")
            code, _, err = whole(b"", "--odometry", silent)
            self.assertEqual(code, 3)
            self.assertIn("nothing is said of the odometry", err)

    def test_methods_without_levels_say_so(self):
        self.assertIn("have no protection level: it averages triples", whole(b"", "--method", "kleeman")[2])

    def test_formats(self):
        code, out, err = whole(STREAM, "--format", "ros")
        self.assertEqual(code, 0, err)
        first = json.loads(out.splitlines()[0])
        self.assertEqual(first["header"]["frame_id"], "map")
        self.assertEqual(first["child_frame_id"], "base_link")
        self.assertAlmostEqual(first["pose"]["pose"]["position"]["x"], 4.517, 2)
        self.assertEqual(len(first["pose"]["covariance"]), 36)
        code, out, err = whole(STREAM, "--format", "nmea", "--origin", "48.14816,17.10674,152", "--north", "90")
        self.assertEqual(code, 0, err)
        for sentence in out.splitlines():
            body, stated = re.fullmatch(r"\$(.*)\*([0-9A-F]{2})", sentence.rstrip("\r")).groups()
            total = 0
            for letter in body:
                total ^= ord(letter)
            self.assertEqual(f"{total:02X}", stated)
        gga = out.splitlines()[0].split(",")
        self.assertEqual(gga[0], "$GPGGA")
        # 4.517 m east and 10.644 m north of the origin, by a sphere of the ellipsoid's radii there.
        self.assertAlmostEqual((float(gga[2][:2]) + float(gga[2][2:]) / 60 - 48.14816) * 111200, 10.644, delta=0.02)
        self.assertAlmostEqual((float(gga[4][:3]) + float(gga[4][3:]) / 60 - 17.10674) * 74400, 4.517, delta=0.02)
        self.assertEqual(whole(b"", "--format", "nmea")[0], 2)

    def test_a_fix_comes_without_the_next_stop(self):
        process = follow()
        process.stdin.write("".join(line + "\n" for line in LINES[:14]).encode())
        process.stdin.flush()
        self.assertEqual(json.loads(process.stdout.readline())["status"], "ok")  # after some quiet
        process.stdin.close()
        self.assertEqual(process.wait(20), 0)

    def test_rubbish_is_counted_and_costs_no_fix(self):
        rng = random.Random(20261122)
        rubbish = [b"", b"#", b"not JSON", b"{}", b"[1, 2]", b"null", b"\x00\xff\xfe", b'{"time_s": 1e999, "beacon": "B0", "tof_s": 1}',
                   b'{"time_s": 1, "beacon": "nobody", "tof_s": 1}', b'{"time_s": 0, "beacon": "B0", "receiver": "r0", "tof_s": "x"}',
                   b'{"time_s": 12, "beacon": "B0", "receiver": "r99", "tof_s": 0.01}', b'{"time_s":', b"[" * 60000,
                   b'{"time_s": 3, "vehicle": {"a": 1}, "beacon": "B0"}', b'{"time_s": 1, "dx_m": null, "dheading_rad": "a"}',
                   b"x" * (1 << 20), b'{"beacon": "' + b"y" * 70000 + b'"}']
        data = bytearray()
        for line in LINES:
            data += line.encode() + b"\n"
            bad = rng.choice(rubbish) if rng.random() < 0.5 else rng.randbytes(rng.randrange(200)).replace(b"\n", b" ")
            data += bad + b"\n"
        data += b'{"time_s": 1'  # half a line, then the end
        code, out, err = whole(bytes(data))
        self.assertEqual(code, 0, err)
        self.assertEqual(len(fixes_of(out)), 40)
        self.assertRegex(err, r"bad lines +\d+: ")
        self.assertIn("a line of more than 65536 bytes", err)
        self.assertLess(len(err), 20000)

    def test_says_what_may_be_wrong_where_nothing_gives_a_fix(self):
        def changed(change):
            return "".join(json.dumps(change(json.loads(line))) + "\n" for line in LINES).encode()

        for change, words in (
                (lambda row: row | {"tof_s": 1e3 * row["tof_s"]}, "looks like milliseconds"),
                (lambda row: row | {"tof_s": 1e6 * row["tof_s"]}, "looks like microseconds"),
                (lambda row: {key: row[key] for key in row if key != "epoch"}, "no epoch, and no two beacons"),
                (lambda row: row | {"epoch": 7}, "all have epoch 7: an epoch is one stop")):
            code, _, err = whole(changed(change))
            self.assertEqual(code, 0, err)
            self.assertEqual(err.count("not a single fix so far"), 1, err)
            self.assertIn(words, err)
        self.assertNotIn("not a single fix", whole(STREAM)[2])

    def test_random_bytes_alone(self):
        code, out, _ = whole(random.Random(1).randbytes(3 << 20))
        self.assertEqual((code, out), (0, ""))

    def test_memory_is_flat_and_a_slow_reader_makes_the_sender_wait(self):
        process = follow("-q")
        os.set_blocking(process.stdin.fileno(), False)
        sent, before, waiting, again = 0, None, b"", 0
        began = time.monotonic()
        blocked = 0
        while blocked < 20 and time.monotonic() - began < 60:  # nobody reads
            if not waiting:
                again += 1
                waiting = b"".join(later(line, again) for line in LINES)
            try:
                count = os.write(process.stdin.fileno(), waiting[:4096])
                sent, waiting = sent + count, waiting[count:]
            except BlockingIOError:
                time.sleep(0.05)
                blocked += 1
                if sent > 1 << 17:  # more than the pipe holds: it is at work, not still being loaded
                    before = before or resident_mb(process)
        self.assertLess(sent, 1 << 22)
        self.assertIsNotNone(before)
        # The address sanitizer keeps what was freed, up to 256 MB.
        self.assertLess(resident_mb(process) - before, 300.0 if os.environ.get("OCTANT_SANITIZED") else 1.0)
        process.kill()
        process.communicate()

    def test_what_runs_backwards_is_refused_until_it_is_a_clock_set_back(self):
        code, out, err = whole(STREAM + STREAM)
        self.assertEqual((code, len(fixes_of(out))), (0, 79), err)
        self.assertIn("19 rows more than 0.2 s behind later ones", err)
        self.assertIn("began anew       1 times", err)

    def test_usage(self):
        self.assertEqual(whole(b"", "--from", "ftp:1")[0], 2)
        self.assertEqual(whole(b"", "--method", "reflectors")[0], 2)
        self.assertEqual(whole(b"", "--json")[0], 2)
        self.assertEqual(whole(b"", "-o", "x.tum")[0], 2)
        process = follow(deployment="missing.json")
        self.assertEqual((process.communicate()[0], process.returncode), (b"", 3))


class Signals(unittest.TestCase):
    def test_stops_at_a_signal(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            process = follow()
            process.stdin.write(STREAM)
            process.stdin.flush()
            for _ in range(40):
                process.stdout.readline()
            process.send_signal(number)
            _, err = process.communicate(timeout=20)
            self.assertEqual(process.returncode, 0, err)
            self.assertIn(b"fixes", err)

    def test_hangup_reads_the_deployment_anew_and_keeps_the_old_one_if_it_is_bad(self):
        with tempfile.TemporaryDirectory() as box:
            path = os.path.join(box, "d.json")
            with open(DEPLOYMENT, encoding="utf-8") as file:
                good = file.read()
            with open(path, "w", encoding="utf-8") as file:
                file.write(good)
            process = follow(deployment=path)
            stops = {}
            for line in LINES:
                stops.setdefault(json.loads(line)["epoch"], []).append(line + "\n")

            def stop(epoch):
                process.stdin.write("".join(stops[epoch]).encode() + b'{"flush": true}\n')
                process.stdin.flush()
                return json.loads(process.stdout.readline())

            def told(what):
                line = process.stderr.readline()
                while what not in line:
                    self.assertNotEqual(line, b"", what)
                    line = process.stderr.readline()

            self.assertEqual(stop(0)["status"], "ok")
            with open(path, "w", encoding="utf-8") as file:
                file.write(good[:2000])
            process.send_signal(signal.SIGHUP)
            told(b"the deployment that is in use is kept")
            self.assertEqual(stop(1)["status"], "ok")
            with open(path, "w", encoding="utf-8") as file:
                file.write(good)
            process.send_signal(signal.SIGHUP)
            told(b"was read anew")
            self.assertEqual(stop(2)["status"], "ok")
            out, err = process.communicate(timeout=20)
            self.assertEqual((process.returncode, out), (0, b""))
            self.assertRegex(err, rb"fixes +3,")

    def test_a_reader_that_is_gone_ends_it(self):
        process = follow()
        process.stdout.close()
        process.stdin.write(STREAM)
        try:
            process.stdin.close()
        except BrokenPipeError:
            pass
        self.assertEqual(process.wait(20), 3)
        process.stderr.close()


class Lines(unittest.TestCase):
    def listening(self, kind):
        process = follow("--from", f"{kind}:0")
        port = int(re.search(rb"127\.0\.0\.1:(\d+)", process.stderr.readline()).group(1))
        return process, port

    def finish(self, process, fixes):
        for _ in range(fixes):
            self.assertEqual(json.loads(process.stdout.readline())["status"], "ok")
        process.send_signal(signal.SIGTERM)
        _, err = process.communicate(timeout=20)
        self.assertEqual(process.returncode, 0, err)
        return err

    def test_tcp_with_senders_that_come_and_go(self):
        process, port = self.listening("tcp")
        half = len(STREAM) // 2
        for part in (STREAM[:half], STREAM[half:]):  # the cut is within a line
            with socket.create_connection(("127.0.0.1", port)) as sender:
                sender.sendall(part)
            time.sleep(0.2)
        time.sleep(0.5)
        process.send_signal(signal.SIGTERM)
        out, err = process.communicate(timeout=20)
        self.assertEqual(process.returncode, 0, err)
        self.assertGreaterEqual(len(fixes_of(out)), 39)  # the stop at the cut is told in two halves
        self.assertRegex(err, rb"bad lines +2: 2 not JSON")

    def test_udp(self):
        process, port = self.listening("udp")
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            for line in LINES[:60]:
                sender.sendto(line.encode(), ("127.0.0.1", port))  # without line ends
                time.sleep(0.001)
            sender.sendto(b"", ("127.0.0.1", port))
        self.finish(process, 4)

    def test_a_serial_line(self):
        try:
            ours, theirs = pty.openpty()
        except OSError:
            self.skipTest("no pseudo-terminals here")
        process = follow("--from", os.ttyname(theirs) + ":115200")
        time.sleep(0.3)
        while termios.tcgetattr(theirs)[3] & termios.ECHO:  # until it has made the line its own
            time.sleep(0.05)
        for line in LINES[:60]:
            os.write(ours, line.encode() + b"\r\n")
            time.sleep(0.001)
        self.finish(process, 4)
        os.close(ours)
        os.close(theirs)
        self.assertEqual(whole(b"", "--from", "/dev/null:12345")[0], 2)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], warnings="ignore")
