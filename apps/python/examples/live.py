#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
"""Feeds a recording to a follower row by row, as a robot's driver would, and draws each fix with its sigma.

    live.py [FIGURE.png]
"""

import sys

import matplotlib.pyplot as plt

import octant

world = octant.simulate(seed=1)
deployment, heard = world.truth, world.heldout.arrivals
follower = octant.Follower(deployment, watch=True)

figure, axes = plt.subplots(figsize=(9, 6))


def draw(fixes):
    for fix in fixes.table:
        if fix["ok"]:
            axes.errorbar(fix["x_m"], fix["y_m"], 100 * fix["sigma_y_m"], 100 * fix["sigma_x_m"], fmt="o", color="C0")


for row in heard:
    follower.hear(row["time_s"], deployment.beacons[row["beacon"]], row["tof_s"],
                  receiver=deployment.receivers[row["receiver"]][1], epoch=int(row["epoch"]))
    draw(follower.take())
follower.flush()  # nothing more is coming of the last stop
draw(follower.take())
axes.plot(world.heldout.truth[:, 1], world.heldout.truth[:, 2], "+", color="C1", label="truth")
axes.set(title="fixes as they came; bars 100 times", xlabel="x [m]", ylabel="y [m]", aspect="equal")
axes.legend()
if len(sys.argv) > 1:
    figure.savefig(sys.argv[1], dpi=120)
else:
    plt.show()
