# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
"""Octant calibrates time-of-flight beacon positioning and locates vehicles.

    import octant
    calibration = octant.calibrate("site.yaml", "run")
    print(calibration.beacons["B1"].sigma_m)
    deployment = calibration.deployment
    run = octant.read_run("heldout", deployment)
    fixes = octant.localize(deployment, run).table
    print(fixes["x_m"], fixes["y_m"])

SI units, radians; map with z up, vehicle with x forward, y left. Arrays are NumPy's; those of a run and of a deployment are
views, without a copy. All failures are `octant.Error` or one of its subclasses, one for each exit code of the command line.
"""

import contextlib as _contextlib
import os as _os
import tempfile as _tempfile
import weakref as _weakref
from types import SimpleNamespace as _SimpleNamespace
from typing import NamedTuple as _NamedTuple

from numpy import array as _array

from . import _octant
from ._octant import (Deployment, Fixes, Follower, Run, Site, World, __version__, localize, make_run, read_site,
                      simulate)
from .errors import (Contradicted, Error, InputError, Interrupted, NotConverged, Undetermined, UsageError)
from .errors import raise_failure as _raise_failure

__all__ = [
    "Calibration", "Contradicted", "Deployment", "Error", "Fixes", "Follower", "InputError", "Interrupted", "NotConverged", "Run",
    "Site", "Undetermined", "UsageError", "World", "calibrate", "check", "localize", "make_run", "monitor",
    "read_deployment", "read_run", "read_site", "simulate", "survey", "verify"
]


_read_from = _weakref.WeakKeyDictionary()  # a Deployment's path, where it was read from one


def _own_name(thing):
    """Name of an object for messages: the path from which it was read, otherwise its type."""
    path = _read_from.get(thing, "") if isinstance(thing, Deployment) else thing.path
    return path or f"({type(thing).__name__})"


def _renamed(value, names):
    """Replaces names in all texts of a JSON value."""
    if isinstance(value, str):
        for written, own in names.items():
            value = value.replace(written, own)
        return value
    if isinstance(value, dict):
        return {key: _renamed(one, names) for key, one in value.items()}
    if isinstance(value, list):
        return [_renamed(one, names) for one in value]
    return value


@_contextlib.contextmanager
def _paths(*things):
    """Yields (*paths, rename) for arguments that may be paths or objects.

    Objects are written to temporary files; rename() restores the caller's names in results and exceptions.
    """
    with _tempfile.TemporaryDirectory(prefix="octant-") as folder:
        names = {}

        def path_of(thing):
            if isinstance(thing, (str, _os.PathLike)):
                return _os.fspath(thing)
            path = _os.path.join(folder, f"{len(names):06d}")
            if isinstance(thing, Site):
                path += ".yaml"
                with open(path, "w", encoding="utf-8") as file:
                    file.write(thing.to_yaml())
            elif isinstance(thing, (Deployment, Run)):
                thing.write(path)
            else:
                raise TypeError(f"a path, Site, Run or Deployment is expected, not {type(thing).__name__}")
            names[path] = _own_name(thing)
            return path

        paths = [path_of(t) if not isinstance(t, list) else [path_of(one) for one in t] for t in things]
        try:
            yield (*paths, lambda result: _renamed(result, names))
        except Error as error:
            _raise_failure(_renamed(error.result, names))


def _listed(runs):
    return list(runs) if isinstance(runs, (list, tuple)) else [runs]


def read_deployment(path):
    """Reads a Deployment from its file."""
    deployment = _octant.read_deployment(_os.fspath(path))
    _read_from[deployment] = _os.fspath(path)
    return deployment


def read_run(folder, names, truth=False):
    """Reads a run folder as a Run. `names`: the Site or Deployment with its beacons. `truth`: also reads the reference."""
    return _octant.read_run(_os.fspath(folder), names, truth)


def _given(thing, kind):
    """A path as text, or the object itself."""
    return thing if isinstance(thing, kind) else _os.fspath(thing)


def _given_runs(runs):
    return [_given(run, Run) for run in _listed(runs)]


def check(site, runs, strict=False, threads=0):
    """Checks recordings: data quality, and which parameters they can determine. A dict as from `octant check --json`."""
    return _octant.check(_given(site, Site), _given_runs(runs), strict, threads)


class Calibration(_NamedTuple):
    """Result of calibrate(): `deployment, result = calibration`, or by attributes.

    result: a dict as from `octant calibrate --json`.
    """

    deployment: Deployment
    result: dict

    @property
    def beacons(self):
        """Beacons by name, with position_m, sigma_m, white_sigma_m (arrays), delay_s, delay_sigma_s and status."""
        return {beacon["id"]: _value(beacon) for beacon in self.result["beacons"]}

    @property
    def receivers(self):
        """Receivers by (vehicle, name), with position_m."""
        return {(receiver["vehicle"], receiver["id"]): _value(receiver) for receiver in self.result["receivers"]}

    @property
    def warnings(self):
        """Warnings, one sentence or more each."""
        return self.result["warnings"]


def _value(entry):
    """Attributes for the keys of an entry; lists of numbers are arrays."""
    return _SimpleNamespace(**{key: _array(value) if isinstance(value, list) else value for key, value in entry.items()})


def calibrate(site, runs, strict=False, accept=False, threads=0):
    """Calibrates a site from its recordings, given as paths or objects.

    Raises Undetermined if the data do not determine the site, and Contradicted if they contradict the site file
    (unless `accept`).
    """
    return Calibration(*_octant.calibrate(_given(site, Site), _given_runs(runs), strict, accept, threads))


def verify(deployment, runs, method="auto", threads=0):
    """Compares fixes of recordings with their reference: a dict as from `octant verify --json`."""
    with _paths(deployment, _listed(runs)) as (path, folders, rename):
        return rename(_octant.verify(path, folders, method, threads))


def survey(site_or_deployment, scene="", bins=0, failures=2, threads=0):
    """Predicts the accuracy of a geometry: a dict as from `octant survey --json`. `bins`: adds maps, with bins along the longer side."""
    with _paths(site_or_deployment) as (path, rename):
        return rename(_octant.survey(path, _os.fspath(scene), bins, failures, threads))


def monitor(deployment, runs, threads=0):
    """Checks that a calibration is still valid: a dict as from `octant monitor --json`; `action`: an action is required."""
    with _paths(deployment, _listed(runs)) as (path, folders, rename):
        return rename(_octant.monitor(path, folders, threads))
