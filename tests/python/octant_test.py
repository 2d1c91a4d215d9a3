# SPDX-FileCopyrightText: 2026 Octant developers
# SPDX-License-Identifier: Apache-2.0
"""The Python module, by pytest: PYTHONPATH=build/release/python pytest tests/python"""

import os
import signal
import threading
import time

import numpy as np
import pytest

import octant

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
HALL = os.path.join(SOURCE, "datasets", "hall")


def hall(name):
    return os.path.join(HALL, name)


@pytest.fixture(scope="module")
def world():
    return octant.simulate(hall("scenario.yaml"), seed=1)


@pytest.fixture(scope="module")
def calibrated(world):
    return octant.calibrate(world.site, world.run)


def test_reads_what_is_written(tmp_path):
    site = octant.read_site(hall("site.yaml"))
    deployment = octant.read_deployment(hall("deployment.true.json"))
    assert site.beacons == deployment.beacons == [f"B{i}" for i in range(8)]
    run = octant.read_run(hall("run"), site)
    assert len(run) == len(run.arrivals) > 1000 and run.has_epochs
    deployment.write(str(tmp_path / "d.json"))
    run.write(str(tmp_path / "run"))
    again = octant.read_deployment(str(tmp_path / "d.json"))
    assert np.array_equal(again.beacon_positions_m, deployment.beacon_positions_m)
    assert np.array_equal(octant.read_run(tmp_path / "run", again).arrivals["tof_s"], run.arrivals["tof_s"])
    assert octant.read_run(hall("heldout"), site, truth=True).truth.shape[1] == 8
    assert octant.read_run(hall("heldout"), site).truth.shape == (0, 8)


def test_arrays_are_views(world):
    run = world.heldout
    arrivals = run.arrivals
    assert arrivals.base is not None and arrivals.dtype.names[:3] == ("time_s", "tof_s", "beacon")
    before = arrivals["tof_s"][0]
    arrivals["tof_s"][0] += 1.0
    assert run.arrivals["tof_s"][0] == before + 1.0
    del run
    assert arrivals["tof_s"][0] == before + 1.0  # the array keeps its list
    deployment = octant.read_deployment(hall("deployment.true.json"))
    positions = deployment.beacon_positions_m
    positions[0, 0] = 99.0
    assert deployment.beacon_positions_m[0, 0] == 99.0 and deployment.beacon_positions_m.shape == (8, 3)
    assert deployment.receiver_positions_m.shape == (8, 3) and deployment.receivers[0] == ("robot", "r0")


def test_the_road(world, calibrated):
    deployment, result = calibrated
    assert result["status"] == "ok" and result["converged"]
    truth = world.truth.beacon_positions_m
    assert np.abs(deployment.beacon_positions_m - truth).max() < 0.01
    assert deployment.covariance.shape == (len(deployment.covariance_parameters),) * 2
    assert np.allclose(deployment.covariance, deployment.covariance.T)
    fixes = octant.localize(deployment, world.heldout)
    table = fixes.table
    assert len(fixes) == 40 and table["ok"].all() and set(fixes.status) == {"ok"}
    reference = world.heldout.truth
    error = [np.hypot(row["x_m"] - x, row["y_m"] - y) for row in table
             for _, x, y, *_ in [reference[np.abs(reference[:, 0] - row["time_s"]).argmin()]]]
    assert np.sqrt(np.mean(np.square(error))) < 0.01
    assert len(fixes.to_tum().splitlines()) == 41
    verified = octant.verify(deployment, hall("heldout"))
    assert verified["matched"] == 40 and verified["gates"][0]["pass"]
    assert octant.check(world.site, world.run)["health"]
    assert octant.survey(deployment)["covered_fraction"] > 0.9
    assert octant.monitor(deployment, world.heldout)["action"] is False


def test_names_what_it_was_given(world, tmp_path):
    world.truth.write(str(tmp_path / "d.json"))
    deployment = octant.read_deployment(str(tmp_path / "d.json"))
    world.heldout.write(str(tmp_path / "run"))
    run = octant.read_run(tmp_path / "run", deployment)
    assert octant.monitor(deployment, run)["deployment"]["path"] == str(tmp_path / "d.json")
    assert octant.monitor(world.truth, run)["deployment"]["path"] == "(Deployment)"
    assert octant.check(octant.read_site(hall("site.yaml")), run)["health"]["runs"][0]["path"] == str(tmp_path / "run")
    run.arrivals["tof_s"] *= 1e3
    with pytest.raises(octant.InputError, match="milliseconds") as raised:
        octant.monitor(deployment, run)
    assert raised.value.file == str(tmp_path / "run" / "tof.csv") and str(raised.value).startswith(raised.value.file)


def test_results_are_attributes(world, calibrated):
    beacon = calibrated.beacons["B1"]
    assert np.allclose(beacon.position_m, calibrated.deployment.beacon_positions_m[world.site.beacons.index("B1")])
    assert beacon.sigma_m.shape == (3,) and (beacon.sigma_m >= 0).all()
    assert {vehicle for vehicle, _ in calibrated.receivers} == set(world.site.vehicles)
    assert calibrated.warnings == calibrated.result["warnings"]


def test_objects_stay_in_memory(world, monkeypatch):
    """Objects are calibrated and checked without a file, and texts name them as the caller does."""
    monkeypatch.setattr(octant._tempfile, "TemporaryDirectory", lambda **_: pytest.fail("a temporary folder"))
    result = octant.calibrate(world.site, world.run).result
    assert "octant-" not in str(result)
    assert octant.check(world.site, world.run)["health"]["runs"][0]["arrivals"] == result["arrivals"] + result["rejected"]
    other = octant.make_run(octant.simulate(seed=2).truth, [0.0], [0], [0.03], receiver=[0], epoch=[0])
    assert octant.check(world.site, [world.run, other])["health"]["runs"][1]["path"] == "(Run)"


def test_the_same_as_the_command_line(calibrated):
    by_path, result = octant.calibrate(hall("site.yaml"), [hall("run")], threads=1)
    assert result["arrivals"] == calibrated[1]["arrivals"]
    assert np.allclose(by_path.beacon_positions_m, calibrated[0].beacon_positions_m, atol=1e-7)


def test_odometry_in_space(world):
    half = np.sqrt(0.5)
    rows = np.array([[0, 0, 0, 0, 0, 0, 0, 1], [1, 0.1, 0.2, 0.3, 0, half, 0, half]])
    run = octant.make_run(world.truth, [0.5], [0], [0.01], receiver=[0], odometry=rows)
    assert run.odometry["dz_m"].tolist() == [0.0, 0.3] and run.odometry["dx_m"][1] == 0.1
    assert np.isclose(run.odometry["turn_y_rad"][1], np.pi / 2) and abs(run.odometry["dheading_rad"][1]) < 1e-12
    with pytest.raises(ValueError, match="qx, qy, qz, qw"):
        octant.make_run(world.truth, [0.5], [0], [0.01], receiver=[0], odometry=rows[:, :5])
    with pytest.raises(ValueError, match="no length"):
        octant.make_run(world.truth, [0.5], [0], [0.01], receiver=[0], odometry=0 * rows)


def test_arrays_in(world):
    deployment, heldout = world.truth, world.heldout
    rows = heldout.arrivals
    run = octant.make_run(deployment, time_s=rows["time_s"], beacon=rows["beacon"], tof_s=rows["tof_s"],
                          receiver=rows["receiver"], epoch=rows["epoch"])
    ours, theirs = octant.localize(deployment, run).table, octant.localize(deployment, heldout).table
    assert np.array_equal(ours["x_m"], theirs["x_m"])
    wrong = np.array(rows["beacon"])
    wrong[::7] = 99
    receiver = np.array(rows["receiver"])
    receiver[::5] = -4
    run = octant.make_run(deployment, rows["time_s"], wrong, rows["tof_s"], receiver=receiver, epoch=rows["epoch"])
    octant.localize(deployment, run)  # wrong, never undefined
    with pytest.raises(ValueError, match="tof_s"):
        octant.make_run(deployment, [0.0, 1.0], [0, 1], [0.01])
    with pytest.raises(ValueError, match="decreases"):
        octant.make_run(deployment, [1.0, 0.0], [0, 1], [0.01, 0.01], receiver=[0, 0])


def test_arrays_are_refused_where_files_are(world):
    deployment, rows = world.truth, world.heldout.arrivals

    def run_of(**other):
        arrays = dict(time_s=rows["time_s"], beacon=rows["beacon"], tof_s=rows["tof_s"], receiver=rows["receiver"],
                      epoch=rows["epoch"])
        return octant.make_run(deployment, **{**arrays, **other})

    odometry = np.array([[0.0, 0.0, 0.0, 0.0], [1.0, 0.1, 0.0, 0.0], [2.0, 0.1, 0.0, 0.0]])
    for column, wrong in ((0, np.nan), (0, np.inf), (1, np.nan), (1, 1e160), (2, -1e12), (3, np.inf)):
        strange = odometry.copy()
        strange[-1, column] = wrong
        with pytest.raises(ValueError, match="odometry"):
            run_of(odometry=strange)
    late = np.array(rows["time_s"])
    late[-1] = np.nan
    with pytest.raises(ValueError, match="time_s"):
        run_of(time_s=late)
    with pytest.raises(ValueError, match="293 K"):
        run_of(temperature_degC=np.full(len(rows), 294.15))
    for number in (-1, 1, 99):
        with pytest.raises(ValueError, match="vehicle"):
            run_of(vehicle=number)


def test_an_impossible_time_harms_no_other(world):
    deployment, rows = world.truth, world.heldout.arrivals
    for wrong in (1e20, 1e160, 1e308, np.inf, np.nan):
        tof = np.array(rows["tof_s"])
        tof[::10] = wrong
        run = octant.make_run(deployment, rows["time_s"], rows["beacon"], tof, receiver=rows["receiver"],
                              epoch=rows["epoch"])
        run.arrivals["time_s"][-1] = np.nan  # a view: who changes it is not asked
        fixes = octant.localize(deployment, run)
        assert np.all(fixes.table["ok"]), wrong


def test_a_run_is_read_by_the_names_of_its_deployment(world, tmp_path):
    text = world.truth.to_json()
    (tmp_path / "site.yaml").write_text(world.site.to_yaml().replace("id: B0,", "id: B9,"), encoding="utf-8")
    other = octant.read_site(str(tmp_path / "site.yaml"))
    assert other.beacons != world.site.beacons and "B0" in text
    rows = world.heldout.arrivals
    run = octant.make_run(other, rows["time_s"], rows["beacon"], rows["tof_s"], receiver=rows["receiver"], epoch=rows["epoch"])
    with pytest.raises(ValueError, match="other names"):
        octant.localize(world.truth, run)
    assert len(octant.localize(world.truth, octant.make_run(world.site, [0.0], [0], [0.01], receiver=[0]))) == 1


def test_follows(world):
    deployment, rows = world.truth, world.heldout.arrivals
    follower = octant.Follower(deployment)
    for row in rows:
        assert follower.hear(row["time_s"], deployment.beacons[row["beacon"]], row["tof_s"],
                             receiver=deployment.receivers[row["receiver"]][1], epoch=int(row["epoch"]))
    follower.flush()
    assert np.array_equal(follower.take().table["x_m"], octant.localize(deployment, world.heldout).table["x_m"])
    assert len(follower.take()) == 0
    with pytest.raises(octant.InputError, match="nobody"):
        follower.hear(0.0, "nobody", 0.01, receiver="r0")


def test_follower_of_a_drive_has_velocity_covariance_and_prediction(world):
    deployment = world.truth
    follower = octant.Follower(deployment, method="tracker", watch=True)
    run = world.heldout
    for row in run.arrivals:
        follower.hear(row["time_s"], deployment.beacons[row["beacon"]], row["tof_s"],
                      receiver=deployment.receivers[row["receiver"]][1], amplitude_v=1.0, temperature_degC=20.0)
    table = follower.take().table
    assert table["covariance"].shape == (len(table), 6, 6) and table["velocity_mps"].shape == (len(table), 3)
    missing = table[~table["ok"]]
    assert np.isnan(missing["covariance"]).all() and np.isnan(missing["velocity_mps"]).all()
    assert follower.take_alarms() == []
    assert len(follower.predict(run.arrivals["time_s"][-1] + 0.1)) == 1
    assert follower.predict(0.0, vehicle="nobody").status == ["no_consensus"]


def test_odometry_is_as_good_as_it_is_said_to_be(world):
    follower = octant.Follower(world.truth, odometry_noise={"distance_sigma_m_per_sqrt_m": 0.01, "floor_m": 0.0})
    assert follower.move(0.0, 0.0, 0.0, 0.0)
    assert follower.move(0.1, 0.02, 0.0, dz_m=0.01, quaternion_xyzw=[0.0, 0.1, 0.0, 1.0])
    for wrong in ({"quaternion_xyzw": [0.0, 0.0, 0.0, 0.0]}, {"dheading_rad": 0.1, "quaternion_xyzw": [0.0, 0.0, 0.0, 1.0]}):
        with pytest.raises(ValueError, match="quaternion"):
            follower.move(0.2, 0.0, 0.0, **wrong)
    assert follower.move_to(0.2, 1.0, 2.0, 0.1) and follower.move_to(0.3, 1.0, 2.0, z_m=0.01, quaternion_xyzw=[0.0, 0.0, 0.1, 1.0])
    assert not follower.move_to(-9.0, 1.0, 2.0), "too late"
    with pytest.raises(ValueError, match="quaternion"):
        follower.move_to(0.4, 0.0, 0.0, heading_rad=0.1, quaternion_xyzw=[0.0, 0.0, 0.0, 1.0])
    for wrong in ({"distance": 0.1}, {"floor_m": -1.0}, {"floor_m": float("nan")}):
        with pytest.raises(ValueError, match="odometry_noise"):
            octant.Follower(world.truth, odometry_noise=wrong)


def test_failures_have_their_class(tmp_path, world):
    with pytest.raises(octant.InputError) as bad:
        octant.read_site(str(tmp_path / "none.yaml"))
    assert bad.value.exit == 3 and isinstance(bad.value, octant.Error)
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "tof.csv").write_text("time_s,beacon,tof_s,receiver\n0.1,B99,0.01,r0\n", encoding="utf-8")
    with pytest.raises(octant.InputError) as bad:
        octant.read_run(tmp_path / "run", world.site)
    assert bad.value.line == 2 and "B99" in bad.value.found and bad.value.file.endswith("tof.csv")
    short = octant.make_run(world.site, [0.0], [0], [0.03], receiver=[0], epoch=[0])
    with pytest.raises((octant.Undetermined, octant.InputError, octant.NotConverged)) as bad:
        octant.calibrate(world.site, short)
    assert bad.value.exit in (3, 4, 5) and bad.value.result["error"]["message"]
    with pytest.raises(ValueError, match="no method"):
        octant.localize(world.truth, world.heldout, method="magic")
    with pytest.raises(octant.InputError) as bad:  # as the command line has it
        octant.localize(world.truth, world.heldout, method="rail")
    assert bad.value.exit == 3 and "rail" in bad.value.expected
    with pytest.raises(TypeError):
        octant.calibrate(3, world.run)


def test_contradicted(tmp_path, world):
    text = world.site.to_yaml()
    assert "[3.9, 0.05, 2.52]" in text
    (tmp_path / "site.yaml").write_text(text.replace("[3.9, 0.05, 2.52]", "[4.9, 0.05, 2.52]"), encoding="utf-8")
    with pytest.raises(octant.Contradicted) as bad:
        octant.calibrate(tmp_path / "site.yaml", world.run)
    assert bad.value.exit == 6 and "B0" in str(bad.value)
    deployment, result = octant.calibrate(tmp_path / "site.yaml", world.run, accept=True)
    assert isinstance(deployment, octant.Deployment) and result["status"] in ("ok", "contradicted")


def test_others_run_meanwhile(world):
    """While a calibration works, another thread of Python does too."""
    ticks = []
    done = threading.Event()

    def tick():
        while not done.is_set():
            ticks.append(time.monotonic())
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    try:
        began = time.monotonic()
        octant.calibrate(world.site, world.run, threads=1)
        ended = time.monotonic()
    finally:
        done.set()
        thread.join()
    gaps = np.diff([began] + [t for t in ticks if began < t < ended] + [ended])
    assert gaps.max() < 0.7 * (ended - began)


def test_is_documented():
    for name in octant.__all__:
        assert getattr(octant, name).__doc__, name
    stub = os.path.join(os.path.dirname(octant.__file__), "__init__.pyi")
    with open(stub, encoding="utf-8") as file:
        text = file.read()
    for name in octant.__all__:
        assert f"def {name}(" in text or f"class {name}" in text, name


@pytest.mark.parametrize("example", ["calibrate_and_plot.py", "survey_map.py", "live.py"])
def test_examples_draw(example, tmp_path):
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    import runpy
    import sys
    before = sys.argv
    sys.argv = [example, str(tmp_path / "figure.png")]
    try:
        runpy.run_path(os.path.join(SOURCE, "apps", "python", "examples", example), run_name="__main__")
    finally:
        sys.argv = before
    assert (tmp_path / "figure.png").stat().st_size > 10000


def test_ctrl_c_stops_a_call(world):
    """A call on another thread ends as interrupted; the main thread, as ever, gets KeyboardInterrupt."""
    ended = []

    def calibrate_until_stopped():
        try:
            while not ended:
                octant.calibrate(world.site, world.run)
        except octant.Interrupted as stop:
            ended.append(stop)

    thread = threading.Thread(target=calibrate_until_stopped)
    thread.start()
    interrupts = 0
    for _ in range(1000):  # one may come while it writes its files, between two calls
        try:
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(1)  # until Python looks, at once
        except KeyboardInterrupt:
            interrupts += 1
        thread.join(0.05)
        if ended:
            break
    ended.append(None)
    thread.join()
    assert isinstance(ended[0], octant.Interrupted) and interrupts > 0
    octant.calibrate(world.site, world.run)  # forgotten afterwards
