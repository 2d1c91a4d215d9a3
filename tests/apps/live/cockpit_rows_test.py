#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
"""`octant cockpit`: rows with new names, late odometry, clocks that are set back, full disks, refused commands.

    cockpit_rows_test.py OCTANT SOURCE
"""

import json
import os
import resource
import signal
import socket
import subprocess
import sys
import time
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import cockpit_test as base  # noqa: E402

RUN = os.path.join(base.HALL, "run")


def arrivals(beacons, stops, start_s=100.0, receivers=("r0", "r1"), epoch=0):
    return [json.dumps({"time_s": start_s + stop, "beacon": b, "receiver": r, "tof_s": 0.01, "epoch": epoch + stop}) for stop in range(stops) for b in beacons for r in receivers]


class Names(base.Folder):
    def test_beacons_that_come_after_the_description_are_added_to_the_site_file(self):
        later, lines = [], []
        for line in base.lines_of(RUN):
            (later if json.loads(line)["beacon"] == "B7" else lines).append(line)
        half = len(lines) // 2
        with base.Cockpit(self.folder, site=None) as cockpit:
            cockpit.send(['{"time_s": 1, "beacon": "B0", "receiver": "ghost"}', '{"time_s": 1, "beacon": " lead", "tof_s": 0.01}', *lines[:half]])
            cockpit.until(lambda s: s["recording"]["arrivals"] == half, "rows")
            self.assertEqual(cockpit.command("set_site", kind="smoke")[0], 422)
            self.assertEqual(cockpit.command("set_site", height_m="tall")[0], 422)
            self.assertFalse(os.path.exists(cockpit.run + "/site.yaml"), "a refused description leaves no file")
            status, answer = cockpit.command("set_site", kind="ultrasound")
            self.assertEqual(status, 200, answer)
            cockpit.send(base.lines_of(RUN))  # all beacons
            state = cockpit.until(lambda s: len(s["beacons"]) == 8 and s["recording"]["arrivals"] + s["recording"]["late"] + s["recording"]["stop_is_over"] == half + len(lines) + len(later), "all rows")
            self.assertEqual(len(state["receivers"]), 8, "no receiver of an invalid row")
            with open(cockpit.run + "/site.yaml", encoding="utf-8") as file:
                self.assertIn("- {id: B7}", file.read())
        self.assertIn("B7", {row["beacon"] for row in base.rows_of(cockpit.run + "/tof.csv")})

    def test_rows_of_beacons_that_a_given_site_does_not_have_are_kept_apart(self):
        with base.Cockpit(self.folder) as cockpit:
            cockpit.send(arrivals(("B0", "B99"), 5))
            state = cockpit.until(lambda s: s["recording"]["unknown"] == 10 and s["recording"]["arrivals"] == 10, "rows")
            self.assertEqual(state["unknown_beacons"], {"B99": 10})
            self.assertEqual([b["id"] for b in state["beacons"]], [f"B{i}" for i in range(8)])
        self.assertEqual([(row["beacon"], row["reason"]) for row in base.rows_of(cockpit.run + "/unused.csv")], [("B99", "unknown_beacon")] * 10)


class Rows(base.Folder):
    def test_a_sender_that_begins_again_gets_new_stops(self):
        first, again = arrivals(("B0", "B1"), 20), arrivals(("B0", "B1"), 20, start_s=1.0)
        with base.Cockpit(self.folder) as cockpit:
            cockpit.send(first + again)
            state = cockpit.until(lambda s: s["recording"]["arrivals"] + s["recording"]["late"] == len(first + again), "all rows")
            self.assertEqual((state["recording"]["clock_steps"], state["recording"]["stop_is_over"]), (1, 0))
            self.assertLess(state["recording"]["late"], 20)
        epochs = [int(row["epoch"]) for row in base.rows_of(cockpit.run + "/tof.csv")]
        self.assertEqual(epochs, sorted(epochs))
        self.assertEqual(epochs[-1], 39)

    def test_arrivals_of_a_stop_that_is_over_are_counted_by_themselves(self):
        with base.Cockpit(self.folder) as cockpit:
            cockpit.send(arrivals(("B0",), 3) + arrivals(("B0",), 1, start_s=104.0))
            cockpit.until(lambda s: s["recording"]["stop_is_over"] == 2 and s["recording"]["between_stops"] == 0, "rows")

    def test_late_odometry_is_added_to_the_next_row(self):
        def step(n, dx):
            return json.dumps({"time_s": 100 + n / 10, "dx_m": dx, "dy_m": 0, "dheading_rad": 0})

        with base.Cockpit(self.folder) as cockpit:
            cockpit.send(step(n, 0.01) for n in range(30) if n != 10)
            cockpit.until(lambda s: s["recording"]["odometry_rows"] == 29, "rows")
            cockpit.send([step(10, 0.5), step(31, 0.01)])
            state = cockpit.until(lambda s: s["recording"]["odometry_rows"] == 30, "the late row")
            self.assertEqual((state["recording"]["late_odometry"], state["recording"]["late"]), (1, 0))
        rows = base.rows_of(cockpit.run + "/odometry.csv")
        self.assertAlmostEqual(float(rows[-1]["dx_m"]), 0.51)

    def test_rows_that_cannot_be_written_are_not_counted(self):
        def limited():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (12288, 12288))

        with base.Cockpit(self.folder, preexec=limited) as cockpit:
            cockpit.send(arrivals(("B0", "B1"), 500))
            state = cockpit.until(lambda s: s["recording"]["error"], "a full disk")
            self.assertLess(state["recording"]["arrivals"], 2000)
            self.assertIn("Recording failed", state["light"]["words"])


class Commands(base.Folder):
    def test_a_finish_without_a_deployment_goes_on_recording(self):
        lines = list(base.lines_of(RUN))
        with base.Cockpit(self.folder) as cockpit:
            cockpit.send(lines[:40])
            cockpit.until(lambda s: s["recording"]["arrivals"] == 40, "rows")
            self.assertEqual(cockpit.command("finish")[0], 200)
            state = cockpit.until(lambda s: s["finish_failure"], "a reason")
            self.assertIsNone(state["finished"])
            cockpit.send(lines[40:])
            cockpit.until(lambda s: s["recording"]["arrivals"] == len(lines), "the other rows")
            cockpit.until(lambda s: s["light"]["colour"] == "good", "good")
            self.assertEqual(cockpit.command("finish")[0], 200)
            state = cockpit.until(lambda s: s["finished"], "finished")
            self.assertEqual((state["finished"]["status"], state["finish_failure"]), ("ok", ""))

    def test_control_points_need_a_sigma_and_arrivals(self):
        with base.Cockpit(self.folder) as cockpit:
            self.assertEqual(cockpit.command("begin_stop")[0], 200)
            self.assertEqual(cockpit.command("control_point", x_m=1, y_m=2, sigma_m=0)[0], 422)
            self.assertEqual(cockpit.command("control_point", x_m=1, y_m=2)[0], 200)
            self.assertFalse(os.path.exists(cockpit.run + "/points.csv"), "no row of a stop without arrivals")
            self.assertEqual(cockpit.command("end_stop")[0], 422)
            cockpit.send(arrivals(("B0",), 1))
            cockpit.until(lambda s: s["stops"], "a stop")
            self.assertEqual(cockpit.command("end_stop")[0], 200)
            with open(cockpit.run + "/points.csv", encoding="utf-8") as file:
                self.assertEqual(file.read(), "epoch,x_m,y_m,sigma_m\n0,1,2,0.005\n")


    def test_a_drive_whose_rows_cannot_be_moved_has_no_first_stop(self):
        with base.Cockpit(self.folder) as cockpit:
            cockpit.send(base.lines_of(RUN, epoch=False))
            state = cockpit.until(lambda s: s["recording"]["arrivals"] == 2161, "a drive")
            os.makedirs(cockpit.run + "/moving.csv/in-the-way")
            self.assertEqual(cockpit.command("begin_stop")[0], 422)
            state = cockpit.state()
            self.assertEqual((state["recording"]["stop_mode"], state["recording"]["arrivals"], state["open_stop"]), ("drive", 2161, None))
            os.removedirs(cockpit.run + "/moving.csv/in-the-way")
            self.assertEqual(cockpit.command("begin_stop")[0], 200)
            cockpit.until(lambda s: (s["recording"]["between_stops"], s["recording"]["arrivals"]) == (2161, 0), "unused rows")


class Visitors(base.Folder):
    def test_idle_connections_do_not_shut_others_out(self):
        with base.Cockpit(self.folder) as cockpit:
            idle = [socket.create_connection(("127.0.0.1", cockpit.port)) for _ in range(100)]
            self.assertEqual(cockpit.ask("GET", "/api/state")[0].status, 200)
            began = time.monotonic()
            idle[-1].settimeout(base.PATIENCE_S)
            self.assertEqual(idle[-1].recv(1), b"", "no request")
            self.assertLess(time.monotonic() - began, 9)
            for connection in idle:
                connection.close()

    def test_sixteen_pages_are_served_at_a_time(self):
        with base.Cockpit(self.folder) as cockpit:
            pages, answers = [], []
            for n in range(17):
                pages.append(socket.create_connection(("127.0.0.1", cockpit.port), timeout=base.PATIENCE_S, source_address=(f"127.0.0.{2 + n // 6}", 0)))
                pages[-1].sendall(f"GET /api/events HTTP/1.1\r\nHost: 127.0.0.1:{cockpit.port}\r\n\r\n".encode())
                answers.append(pages[-1].recv(12))
            self.assertEqual(answers, [b"HTTP/1.1 200"] * 16 + [b"HTTP/1.1 503"])
            self.assertEqual(cockpit.ask("GET", "/api/state")[0].status, 200)
            for page in pages:
                page.close()

    def test_short_secrets_are_refused_and_all_addresses_are_named(self):
        for secret, code in (("secret", 2), ("secret; Path=/evil-1", 2), ("0123456789abcdef", 0)):
            out = os.path.join(self.folder, secret[:7].replace(";", "-") + str(code))
            done = subprocess.run([base.OCTANT, "cockpit", "--listen", "0.0.0.0:0", "--token", secret, "-o", out, "--finish"], capture_output=True, text=True, timeout=base.PATIENCE_S, stdin=subprocess.DEVNULL)
            self.assertEqual(done.returncode == 2, code == 2, done.stderr)
            self.assertNotIn("//0.0.0.0", done.stderr)
        self.assertIn("http://127.0.0.1:", done.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
