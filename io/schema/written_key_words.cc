// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// What a key or a column is that Octant writes: the deployment, fixes, live lines. See key_words.cc.
#include "io/schema/schema_texts.h"

namespace octant::io {
namespace {

// Examples hold parentheses and quotes, hence the delimiter.
constexpr std::string_view kDeploymentWords = R"words(
type | octant_deployment | tells this file from others
version | 1 | version of the format; a reader refuses one that it does not know
site | hall | name of the site, from its site file; empty where that states none
created | 2026-11-22T19:28:46Z | when it was calibrated: ISO 8601, UTC
motion | planar | planar: the vehicle drives on a floor (x, y, heading); spatial: it flies or dives
datum | {"description": "position by control points (B0, B3, B6)"} | how position, orientation and scale of the map were fixed
datum.description | position by control points (B0, B3, B6), orientation by control points | in a sentence; left out: not told
datum.position | control points | what fixed the position; left out: not told
datum.orientation | control points | what fixed the orientation; left out: not told
datum.scale | control points, receiver array, medium (speed prior) | what fixed the scale; left out: not told
datum.control_points | ["B0", "B3", "B6"] | ids of the beacons that were held fixed; left out: none
medium | {"model": "cramer1993", "speed_mps": 345.485, "sigma_mps": 0.037, "reference_temperature_degC": 21.0} | what the signal runs through, and how fast
medium.model | cramer1993 | cramer1993: speed of sound in moist air; linear_temperature: 331.3 + 0.606 T; constant
medium.speed_mps | 345.485 | 
medium.sigma_mps | 0.037 | standard deviation of speed_mps
medium.reference_temperature_degC | 21.0 | temperature at which speed_mps holds
medium.relative_humidity | 0.5 | of the air; 50 % is 0.5; left out: 0.5
medium.pressure_pa | 101325 | of the air; left out: 101325
medium.constant_speed_mps | 343.0 | + left out: speed_mps
medium.offset_mps | 0.873 | + left out: speed_mps less the model's speed
timing | {"clock": "synchronised", "delay_per": "beacon"} | how times of flight were measured, as in the site file
timing.clock | synchronised | synchronised: each firing is marked; cycle_offset: the vehicle's clock is off by an unknown time, new in each epoch
timing.ranging | one_way | one_way: from beacon to receiver; two_way: there and back; left out: one_way
timing.turnaround_s | 0.01 | two_way: from hearing to answering; left out: 0
timing.delay_per | beacon | who has an electronic delay of its own
timing.delay_s | 0.0001 | the delay as it was expected before the calibration; left out: 0
timing.delay_sigma_s | 5e-05 | standard deviation of delay_s before the calibration; left out: 0
timing.drift_ppm | 20 | rate of the vehicle's clock as it was expected; left out: 0
timing.drift_sigma_ppm | 50 | standard deviation of drift_ppm before the calibration; left out: 0
noise | {"tof_sigma_s": 1e-5} | how well each sensor measures
noise.tof_sigma_s | 1e-05 | standard deviation of one time of flight
noise.amplitude_relative_sigma | 0.05 | standard deviation of an amplitude as a share of it; left out: 0.05
noise.pair_sigma_s | 3e-10 | standard deviation of a bias that each pair of beacon and receiver keeps, as stated; null or left out: not stated
noise.correlated | {"sigma_s": 4e-6, "time_s": 3.5, "pair_sigma_s": 2e-6} | 
noise.correlated.sigma_s | 4e-06 | + left out: 0
noise.correlated.time_s | 3.5 | + left out: 0
noise.correlated.pair_sigma_s | 2e-06 | + left out: 0
noise.bearing_sigma_rad | 0.01 | standard deviation of one bearing; left out: 0.01
noise.range_sigma_m | 0.02 | standard deviation of one beam of a scan; left out: 0.02
attenuation | {"amplitude_1m_v": 12.5, "absorption_np_per_m": 0.15, "threshold_v": 0.2, "rise_time_s": 4.5e-4} | how loud a pulse arrives, and so how late a threshold notices it; null: no time-walk
attenuation.amplitude_1m_v | 12.5 | amplitude of the pulse at one metre
attenuation.absorption_np_per_m | 0.15 | loss in the medium beyond spreading
attenuation.threshold_v | 0.2 | at which the receiver notices a pulse
attenuation.rise_time_s | 0.00045 | time constant of the pulse's envelope
attenuation.half_power_angle_rad | 0.39 | off a receiver's axis, where the amplitude is 3 dB down; null or left out: all round alike
attenuation.saturation_v | 4.7 | logged amplitudes from here on are not used; null or left out: all are
beacons | [{"id": "B1", "position_m": [11.849, 0.05, 2.454], "status": "calibrated"}] | all beacons of the site, in its order
beacons[].id | B1 | as recordings name it
beacons[].position_m | [11.849, 0.05, 2.454] | x, y, z in the map
beacons[].covariance_m2 | [[8.6e-7, -6.1e-7, 0], [-6.1e-7, 2.3e-6, 0], [0, 0, 5.3e-6]] | covariance of position_m; all zero for a control point, which is held fixed
beacons[].delay_s | 0.0001057 | its electronic delay: measured time less true time of flight
beacons[].delay_sigma_s | 4.3e-06 | standard deviation of delay_s; 0: held fixed
beacons[].gain | 0.8 | of its amplitude over the attenuation's, where dirt or age dampen it; left out: 1
beacons[].status | calibrated | calibrated; control_point: held where the site file has it; undetermined: localizers leave it out
vehicles | [{"id": "robot", "receivers": [{"id": "r0"}]}] | what moves, with its receivers
vehicles[].id | robot | as recordings name it
vehicles[].clock_drift_ppm | 21.3 | + left out: 0
vehicles[].clock_drift_sigma_ppm | 0.4 | standard deviation of clock_drift_ppm; left out: 0
vehicles[].motion | {"speed_mps": 0.5} | + left out: not stated
vehicles[].receivers | [{"id": "r0", "position_m": [0.064, 0, 0.3], "sigma_m": [6e-4, 6e-4, 6e-4], "delay_s": 0}] | its receivers; empty where it has none
vehicles[].receivers[].id | r0 | as recordings name it
vehicles[].receivers[].position_m | [0.064, 0.0, 0.3] | in the vehicle frame: x forward, y left, z up
vehicles[].receivers[].sigma_m | [0.0006, 0.0006, 0.0006] | standard deviations of position_m; 0: held fixed
vehicles[].receivers[].delay_s | 0.0 | its electronic delay, which adds to the beacon's
vehicles[].receivers[].delay_sigma_s | 0.0 | standard deviation of delay_s; left out: 0
vehicles[].receivers[].axis | [1, 0, 0] | direction in which it hears best, in the vehicle frame; null or left out: all round alike
vehicles[].receivers[].hearing_cosine | 0.35 | cosine of the farthest angle off its axis at which the calibration heard anything; null or left out: not known
vehicles[].rail | {"from_m": [0, 1.5], "to_m": [40, 1.5]} | the line that the vehicle runs on; null or left out: it moves freely
covariance | {"parameters": ["medium/speed_mps"], "upper_triangle": [0.0014]} | 
covariance.parameters | ["beacon/B1/x_m", "beacon/B1/delay_s", "medium/speed_mps"] | names, in the order of the matrix; each in the unit of its name
covariance.upper_triangle | [8.6e-7, -6.1e-7, 2.3e-6] | row by row, the diagonal first in each
statistics | {"arrivals": 2161, "rejected": 0, "variance_factor": 0.98} | of the adjustment as a whole
statistics.arrivals | 2161 | times of flight that were used
statistics.rejected | 12 | times of flight that were left out
statistics.unknowns | 498 | numbers that were found: parameters and poses
statistics.redundancy | 1711 | observations beyond what the unknowns need
statistics.variance_factor | 0.98 | squared residuals over what the stated sigmas expect: 1 where these are right
statistics.chi2_p | 0.61 | 
statistics.rms_s | 8.7e-06 | usual size of a residual
statistics.converged | true | whether the adjustment came to its end
tolerance | {"beacon_m": 0.03, "fix_m": 0.05} | what the site must reach, as its site file states; left out: nothing is stated
tolerance.beacon_m | 0.03 | largest error of a beacon in the plane (95 %); null or left out: no such gate
tolerance.fix_m | 0.05 | largest RMSE of a fix in the plane; null or left out: no such gate
validity | {"temperature_degC": [17.0, 23.5], "area": [[1, 1], [9, 1], [9, 7]]} | where the calibration holds
validity.temperature_degC | [17.0, 23.5] | lowest and highest of the recordings; null or left out: it does not matter
validity.area | [[1, 1], [9, 1], [9, 7]] | convex hull of the calibrated poses, counter-clockwise; left out: not known
validity.reach_m | 16.2 | distance beyond which the vehicle heard nothing though it was there often enough; left out: the recordings do not tell
validity.months | 12 | after which a recalibration is due, as the site file states; null or left out: not stated
validity.beacon_drift_m_per_month | 0.001 | by how much beacons may settle, as the site file states; null or left out: not stated
validity.until | 2027-05-01T08:00:00Z | when a recalibration is due by these: ISO 8601, UTC; null or left out: no date
inputs | [{"path": "hall/site.yaml", "sha256": "d5e7c8ed6b60dc40cf3e00273bc23cbf5ba3e646f935e0d7e219b2cc0e65e9e7"}] | files that it was made of
inputs[].path | hall/site.yaml | as the command named it
inputs[].sha256 | d5e7c8ed6b60dc40cf3e00273bc23cbf5ba3e646f935e0d7e219b2cc0e65e9e7 | digest of the file's content, hexadecimal
program | {"name": "octant", "version": "0.2.0"} | what made it
program.name | octant | always that; left out: not told
program.version | 0.2.0 | its version; left out: not told
program.command | octant calibrate hall/site.yaml hall/run -o hall/deployment.json | as it was typed; left out: not told
warnings | ["beacon B6 is undetermined: it was not heard"] | what the calibration warned of; left out: nothing
previous | {"created": "2026-05-01T08:00:00Z", "changes": []} | + left out: it is no recalibration
previous.sha256 | 1b2e71a7c36630b5a045574f9fc7404240686a6a883657f85b4f929d787a02c5 | 
previous.created | 2026-05-01T08:00:00Z | when the earlier one was calibrated: ISO 8601, UTC
previous.drift | {"beacon_m": 0.001, "delay_s": 1e-6, "receiver_m": 5e-4, "speed_mps": 0.1, "log_gain": 0.05, "attenuation": 0.02} | 
previous.drift.beacon_m | 0.001 | of each coordinate of a beacon
previous.drift.delay_s | 1e-06 | of each delay
previous.drift.receiver_m | 0.0005 | of each coordinate of a receiver
previous.drift.speed_mps | 0.1 | of the medium's speed at the same temperature
previous.drift.log_gain | 0.05 | 
previous.drift.attenuation | 0.02 | 
previous.released | ["beacon/B3/x_m"] | 
previous.changes | [{"kind": "beacon_moved", "subject": "B3", "size": 0.041, "sigma": 0.003, "unit": "m", "p": 1e-20}] | what is held to have changed
previous.changes[].kind | beacon_moved | what kind of change
previous.changes[].subject | B3 | what changed: a beacon, vehicle/receiver, two beacons, speed
previous.changes[].size | 0.041 | 
previous.changes[].sigma | 0.003 | standard deviation of size
previous.changes[].unit | m | of size and sigma
previous.changes[].p | 1e-20 | 
verdict | {"grade": "Contradicted", "contradictions": [{"kind": "control_point", "subject": "B3"}]} | + left out: nothing is contradicted
verdict.grade | Contradicted | localizers warn of such a file
verdict.contradictions | [{"kind": "control_point", "subject": "B3", "sigmas": 8.0}] | what the data speak against
verdict.contradictions[].kind | control_point | what kind of statement
verdict.contradictions[].subject | B3 | what it is of: a beacon, vehicle/receiver, medium
verdict.contradictions[].stated | at (29.700, 0.200, 4.200) m, held fixed | what the site file says
verdict.contradictions[].found | at (29.803, 0.175, 4.200) m, 106.1 mm away | what the data say
verdict.contradictions[].sigmas | 11.0 | how far apart these are, in standard deviations; 0: not a matter of degree
verdict.contradictions[].remedy | survey control point A2 again | what to do
digest | 1b2e71a7c36630b5a045574f9fc7404240686a6a883657f85b4f929d787a02c5 | + left out: alterations are not noticed
signature | {"algorithm": "ed25519", "public_key": "d75a98...", "value": "e55643..."} | + left out: not signed
signature.algorithm | ed25519 | the only one
signature.public_key | d75a980182b10ab7d54bfed3c964073a0ee172f3daa62325af021a68f707511a | 
signature.value | e5564300c360ac729086e2cc806e828a84877f1eb8e5d974d873e065224901555fb8821590a33bacc61e39701cf9b46bd25bf5f0595bbe24655141438e7a100b | 
$rail.from_m | [0, 1.5] | one end of a straight rail; left out: it is an arc
$rail.to_m | [40, 1.5] | its other end, towards which the vehicle heads; left out: it is an arc
$rail.centre_m | [6, 5] | centre of an arc; left out: it is straight
$rail.radius_m | 4 | of an arc; left out: it is straight
)words";

constexpr std::string_view kLiveWords = R"(
$arrival.time_s | 12.5 | 
$arrival.beacon | B0 | id of the deployment's; text or number
$arrival.tof_s | 0.0216 | time of flight; left out: distance_m has to say it
$arrival.distance_m | 7.41 | + left out: tof_s has to say it
$arrival.epoch | 3 | + null or left out: the vehicle moves
$arrival.vehicle | robot | + left out: none
$arrival.receiver | r0 | + left out: none
$arrival.amplitude_v | 1.8 | plateau of the received pulse, for time-walk; null or left out: not measured
$arrival.temperature_degC | 17.5 | of the air at this instant; null or left out: that of the deployment
$odometry.time_s | 12.5 | on the clock of the arrivals
$odometry.dx_m | 0.031 | forward, in the frame of the row before
$odometry.dy_m | 0.0 | left, in the frame of the row before
$odometry.dheading_rad | 0.002 | turn, counter-clockwise
$odometry.dz_m | 0.0 | up, of a vehicle in space; left out: 0
$odometry.qx | 0.0 | with qy, qz, qw in place of dheading_rad, of a vehicle in space; left out: dheading_rad says it
$odometry.qy | 0.0 | see qx; left out: with qx
$odometry.qz | 0.001 | see qx; left out: with qx
$odometry.qw | 1.0 | see qx; left out: with qx
$odometry.vehicle | robot | who moved; left out: the only one, or robot
$fix.type | fix | tells it from an alarm
$fix.time_s | 12.5 | instant of the fix, on the clock of the arrivals
$fix.vehicle | robot | whose fix it is
$fix.status | ok | ok, or why there is no fix
$fix.epoch | 3 | of its arrivals; left out: they had none
$fix.x_m | 7.41 | of the vehicle in the map; left out: no fix
$fix.y_m | 15.6 | of the vehicle in the map; left out: no fix
$fix.z_m | 0.0 | of the vehicle in the map; left out: no fix
$fix.heading_rad | 1.571 | counter-clockwise from +x of the map; left out: no fix
$fix.quaternion_xyzw | [0, 0, 0.707, 0.707] | rotation of the vehicle in the map; left out: no fix
$fix.sigma_x_m | 0.0031 | standard deviation of x_m; left out: no fix
$fix.sigma_y_m | 0.0028 | standard deviation of y_m; left out: no fix
$fix.sigma_heading_rad | 0.012 | standard deviation of the heading; pi: not known; left out: no fix
$fix.protection_level_m | 0.041 | bound that the error exceeds only once in very many times, undetected echoes included; left out: not told
$fix.arrivals_used | 12 | arrivals that the fix was made of
$fix.arrivals_rejected | 1 | arrivals that did not agree with it
$fix.integrity | ok | whether the protection level bounds its error
$fix.integrity_reason | not_protected | why it does not; empty where it does
$alarm.type | alarm | tells it from a fix
$alarm.kind | beacon_moved | what no longer fits
$alarm.beacon | B3 | which one; left out: it is a receiver
$alarm.receiver | robot/r0 | + left out: it is a beacon
$alarm.axis | x | along which it moved; left out: it is late
$alarm.size_m | 0.041 | how far off it is, as a length
$alarm.sigma_m | 0.004 | standard deviation of size_m
$alarm.since_s | 1200.5 | since when, on the clock of the arrivals
$alarm.time_s | 1212.0 | when it was noticed
)";

constexpr std::string_view kFixesWords = R"(
fixes.csv:time_s | 12.5 | 
fixes.csv:vehicle | robot | 
fixes.csv:x_m | 7.41 | 
fixes.csv:y_m | 15.6 | 
fixes.csv:z_m | 0.0 | 
fixes.csv:heading_rad | 1.571 | 
fixes.csv:sigma_x_m | 0.0031 | 
fixes.csv:sigma_y_m | 0.0028 | 
fixes.csv:sigma_heading_rad | 0.012 | 
fixes.csv:protection_level_m | 0.041 | 
fixes.csv:arrivals_used | 12 | 
fixes.csv:arrivals_rejected | 1 | 
fixes.csv:status | ok | 
fixes.csv:integrity | ok | 
fixes.csv:integrity_reason | not_protected | 
fixes.tum:time_s | 12.5 | 
fixes.tum:x y z | 7.41 15.6 0.0 | 
fixes.tum:qx qy qz qw | 0 0 0.707 0.707 | 
)";

constexpr std::string_view kSurveyWords = R"(
cells.csv:x_m | 0.125 | 
cells.csv:y_m | 0.125 | 
cells.csv:sigma_m | 0.0048 | 
cells.csv:total_m | 0.0051 | 
cells.csv:calibration_m | 0.0017 | 
cells.csv:speed_part_m | 0.013 | 
cells.csv:temperature_m | 0.135 | 
cells.csv:sigma_heading_rad | 0.031 | 
cells.csv:hdop | 1.3 | 
cells.csv:pdop | 1.7 | 
cells.csv:vdop | 1.1 | 
cells.csv:tdop | 0.9 | 
cells.csv:gdop | 1.9 | 
cells.csv:heading_dop_rad_per_m | 8.1 | 
cells.csv:beacons_heard | 4 | 
cells.csv:detectable_bias_m | 0.031 | 
cells.csv:protection_m | 0.095 | 
cells.csv:mirror | 0 | 
cells.csv:loss_one_m | 0.015 | 
cells.csv:loss_one_beacon | C1 | 
cells.csv:loss_two_m | 0.011 | 
cells.csv:heard | C0;C1;C4 | 
routes.csv:route | aisle1 | 
routes.csv:x_m | 1.5 | 
routes.csv:y_m | 1.7 | 
routes.csv:heading_rad | 0 | 
NAME.yaml:image | hdop.pgm | 
NAME.yaml:mode | scale | 
NAME.yaml:resolution | 0.25 | 
NAME.yaml:origin | [0, 0, 0.0] | 
NAME.yaml:negate | 0 | 
NAME.yaml:occupied_thresh | 0.65 | 
NAME.yaml:free_thresh | 0.196 | 
)";

}  // namespace

std::string_view written_key_words(std::string_view format) {
  if (format == "deployment") return kDeploymentWords;
  if (format == "live") return kLiveWords;
  if (format == "fixes") return kFixesWords;
  if (format == "survey") return kSurveyWords;
  return {};
}

}  // namespace octant::io
