#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
"""Draws where in a hall a vehicle is positioned how well: the horizontal sigma that a survey expects.

    survey_map.py [FIGURE.png [SITE.yaml|DEPLOYMENT.json]]
"""

import sys

import matplotlib.pyplot as plt
import numpy as np

import octant

place = sys.argv[2] if len(sys.argv) > 2 else octant.simulate(seed=1).truth
survey = octant.survey(place, bins=80)
sigma = survey["maps"]["sigma_m"]
values = np.array(sigma["rows"], dtype=float)  # None, where there is no fix, is nan
(x, y), size = sigma["origin_m"], sigma["bin_m"]

figure, axes = plt.subplots(figsize=(9, 6))
extent = [x, x + size * values.shape[1], y, y + size * values.shape[0]]
image = axes.imshow(1e3 * values, origin="lower", extent=extent, cmap="cividis")
figure.colorbar(image, label="expected standard deviation [mm]")
axes.set(title=f"{100 * survey['covered_fraction']:.1f} % of the floor has a fix", xlabel="x [m]", ylabel="y [m]")
if len(sys.argv) > 1:
    figure.savefig(sys.argv[1], dpi=120)
else:
    plt.show()
