#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
"""Calibrates a simulated hall and draws beacons with their error ellipses and the vehicle's fixes.

    calibrate_and_plot.py [FIGURE.png]
"""

import sys

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Ellipse

import octant

EXAGGERATION = 100

world = octant.simulate(seed=1)
deployment, result = octant.calibrate(world.site, world.run)
fixes = octant.localize(deployment, world.heldout).table

figure, axes = plt.subplots(figsize=(9, 6))
for name, position, covariance in zip(deployment.beacons, deployment.beacon_positions_m, deployment.beacon_covariances_m2):
    values, vectors = np.linalg.eigh(covariance[:2, :2])
    width, height = 2 * 2.45 * EXAGGERATION * np.sqrt(np.maximum(values, 0))  # 95 %
    angle = np.degrees(np.arctan2(vectors[1, 0], vectors[0, 0]))
    axes.add_patch(Ellipse(position[:2], width, height, angle=angle, alpha=0.3))
    axes.annotate(name, position[:2], textcoords="offset points", xytext=(5, 5))
axes.plot(*deployment.beacon_positions_m[:, :2].T, "^", label="beacons")
axes.quiver(fixes["x_m"], fixes["y_m"], np.cos(fixes["heading_rad"]), np.sin(fixes["heading_rad"]), width=0.003)
axes.plot(fixes["x_m"], fixes["y_m"], "o", markersize=3, label="fixes")
axes.set(title=f"{deployment.site}: {result['verdict']['grade'] if 'verdict' in result else 'calibrated'}; ellipses 95 %, "
         f"{EXAGGERATION} times", xlabel="x [m]", ylabel="y [m]", aspect="equal")
axes.legend()
if len(sys.argv) > 1:
    figure.savefig(sys.argv[1], dpi=120)
else:
    plt.show()
