// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// What a key or a column is, for people: path | example | description. An empty description leaves that of
// the schema.
#include "io/schema/schema_texts.h"

namespace octant::io {
namespace {

constexpr std::string_view kSiteWords = R"(
octant_site | 1 | version of the format
name | hall | name of the site, as results and reports call it; left out: none
motion | planar | planar: the vehicle drives on a floor (x, y, heading); spatial: it flies or dives (6 degrees of freedom)
medium | {"model": "cramer1993", "temperature_degC": 21} | what the signal runs through; may be left out where there are no arrivals
medium.model | cramer1993 | cramer1993: speed of sound in moist air; linear_temperature: 331.3 + 0.606 T; constant: speed_mps (radio, water)
medium.temperature_degC | 21.0 | of the air, where neither run nor arrival says it
medium.relative_humidity | 0.5 | of the air; 50 % is 0.5
medium.pressure_pa | 101325 | of the air; 1013 hPa are 101300
medium.speed_mps | 343.0 | of the constant model: air 343, sea water 1500, radio 299702547; left out with the others
medium.sigma_mps | 3.0 | how far the true speed may be from the model's (one standard deviation); 0: held fixed
medium.offset_per | site | one offset from the model for all recordings (site), or a new one for each (run)
timing | {"clock": "synchronised", "delay_per": "beacon"} | how times of flight were measured; may be left out where there are no arrivals
timing.clock | synchronised | synchronised: radio or a wire marks each firing; cycle_offset: the vehicle's clock is off by an unknown time, new in each epoch
timing.ranging | one_way | one_way: from beacon to receiver; two_way: there and back, the vehicle moves meanwhile
timing.turnaround_s | 0.01 | two_way: from hearing to answering
timing.delay_per | beacon | who has an electronic delay of its own to be found: beacon, receiver, site (one for all), none, or a list
timing.delay_s | 0.0001 | the delay as one expects it: measured time less true time of flight
timing.delay_sigma_s | 0.0002 | how far a delay may be from delay_s (one standard deviation); 0: held fixed
timing.drift_ppm | 20 | 
timing.drift_sigma_ppm | 50 | how far the rate may be from drift_ppm; 0: held fixed
noise | {"tof_sigma_s": 1e-5} | how well each sensor measures; left out: only where there are no arrivals
noise.tof_sigma_s | 1e-5 | standard deviation of one time of flight: ultrasound 1e-5, UWB 3e-10, underwater sound 1e-4; required where there are arrivals; left out: none
noise.amplitude_relative_sigma | 0.05 | standard deviation of an amplitude as a share of it
noise.pair_sigma_s | 3e-10 | standard deviation of a bias that each pair of beacon and receiver keeps (multipath, antennas); left out: found from the residuals
noise.bearing_sigma_rad | 0.01 | standard deviation of one bearing
noise.range_sigma_m | 0.02 | standard deviation of one beam of a scan
attenuation | {"amplitude_1m_v": {"value": 12.5, "sigma": 3}, "absorption_np_per_m": 0.15, "threshold_v": 0.2, "rise_time_s": 4.5e-4} | how loud a pulse arrives, and so how late a threshold notices it (time-walk); leave the block out to switch that off; left out: no time-walk
attenuation.amplitude_1m_v | {"value": 12.5, "sigma": 3.0} | amplitude of the pulse at one metre; a number alone is held fixed
attenuation.absorption_np_per_m | {"value": 0.15, "sigma": 0.1} | loss in the medium beyond spreading; a number alone is held fixed
attenuation.threshold_v | 0.2 | at which the receiver notices a pulse
attenuation.rise_time_s | {"value": 4.5e-4, "sigma": 3e-4} | time constant of the pulse's envelope; a number alone is held fixed
attenuation.half_power_angle_rad | {"value": 0.9, "sigma": 0.3} | 
attenuation.saturation_v | 4.8 | logged amplitudes from here on are not used; left out: all are
beacons | [{"id": "B0", "position_m": [0, 0, 2.5], "sigma_m": 0}] | all beacons, with what is known of each; [] where there are none
beacons[].id | B0 | as recordings name it
beacons[].position_m | [10.0, 0.1, 2.5] | x, y, z in the map; null: that coordinate, or the place, is unknown; left out: nothing is known of it
beacons[].sigma_m | 0.3 | how far off position_m may be (one standard deviation), for all axes or [sx, sy, sz]; 0: a control point, held fixed; left out or null: position_m is a start only
beacons[].delay_s | 0.0001 | this beacon's delay as one expects it, in place of timing.delay_s; needs delay_per: beacon; left out: timing.delay_s
beacons[].delay_sigma_s | 0.00002 | in place of timing.delay_sigma_s; 0: held fixed; left out: timing.delay_sigma_s
vehicles | [{"id": "robot", "receivers": [{"id": "r0", "position_m": [0, 0, 0.3]}]}] | what moves, with its receivers
vehicles[].id | robot | as recordings name it
vehicles[].array | {"radius_sigma_m": 0.002} | + left out: each receiver by itself
vehicles[].array.radius_sigma_m | 0.002 | how far the array's radius may be from the stated one; 0: held fixed
vehicles[].array.turn_sigma_rad | 0.02 | how far the array may be turned from the stated direction; 0: held fixed
vehicles[].motion | {"speed_mps": 0.5} | + left out: how it moves is not stated
vehicles[].motion.speed_mps | 0.5 | usual speed
vehicles[].motion.acceleration_mps2 | 0.5 | 
vehicles[].motion.turn_rate_rad_per_s | 0.5 | usual turn rate
vehicles[].motion.turn_acceleration_rad_per_s2 | 1.0 | change of the turn rate within a second
vehicles[].receivers | {"layout": "octagon", "side_m": 0.05, "height_m": 0.3} | a layout, or a list of receivers; left out: none
vehicles[].receivers.layout | octagon | eight receivers at the corners, r0 forward, counter-clockwise
vehicles[].receivers.side_m | 0.05 | between neighbours
vehicles[].receivers.height_m | 0.3 | above the vehicle's origin
vehicles[].receivers.turn_rad | 0.0 | 
vehicles[].receivers.sigma_m | 0.002 | how far a receiver may be from its corner, for all axes or [sx, sy, sz]; 0 or left out: held fixed
vehicles[].receivers[].id | r0 | as recordings name it
vehicles[].receivers[].position_m | [0.1, 0.0, 0.3] | in the vehicle frame: x forward, y left, z up
vehicles[].receivers[].sigma_m | 0.002 | how far off position_m may be, for all axes or [sx, sy, sz]; 0 or left out: held fixed
vehicles[].receivers[].axis | [1, 0, 0] | direction in which it hears best, in the vehicle frame; left out: all round alike
vehicles[].rail | {"from_m": [0, 1.5], "to_m": [40, 1.5]} | the line that the vehicle runs on; left out: it moves freely
control | {"distances": [{"from": "B0", "to": "B1", "distance_m": 10.012, "sigma_m": 0.003}]} | what was measured with other tools; left out: none
control.distances | [{"from": "B0", "to": "B1", "distance_m": 10.012, "sigma_m": 0.003}] | distances between beacons, by tape or laser; left out: none
control.distances[].from | B0 | id of a beacon
control.distances[].to | B1 | id of another beacon
control.distances[].distance_m | 10.012 | as measured, in a straight line
control.distances[].sigma_m | 0.003 | standard deviation of the tape; 0: exact
gates | {"max_range_m": 15} | 
gates.min_range_m | 0.3 | 
gates.max_range_m | 15 | farther is impossible; left out: nothing is
gates.triangle | true | 
scene | {"floor_m": [[0, 0], [20, 0], [20, 12], [0, 12]]} | + left out: no walls, no routes, everything in sight
tolerance | {"beacon_m": 0.03, "fix_m": 0.05} | what the site must reach; verdicts and gates hold results against it; left out: nothing is held against a limit
tolerance.beacon_m | 0.03 | largest error of a beacon in the plane (95 %); left out: no such gate
tolerance.fix_m | 0.05 | largest RMSE of a fix in the plane; left out: no such gate
validity | {"months": 12} | + left out: no date is told
validity.months | 12 | a recalibration is due after so many months of 30.44 days; left out: not by the calendar
validity.beacon_drift_m_per_month | 0.001 | by how much beacons may settle (one standard deviation): due when one may have left tolerance.beacon_m; left out: they are taken to stay
$rail.from_m | [0, 1.5] | one end of a straight rail; left out: it is an arc
$rail.to_m | [40, 1.5] | its other end, towards which the vehicle heads; left out: it is an arc
$rail.centre_m | [6, 5] | centre of an arc; left out: it is straight
$rail.radius_m | 4 | of an arc; left out: it is straight
$prior.value | 12.5 | as one expects it
$prior.sigma | 3.0 | how far the truth may be from it (one standard deviation); 0: held fixed
)";

constexpr std::string_view kSceneWords = R"(
octant_scene | 1 | version of the format
floor_m | [[0, 0], [20, 0], [20, 12], [0, 12]] | 
walls | [{"points_m": [[5, 0], [5, 4]]}] | + left out: none
walls[].id | W1 | name in messages; left out: it has no name
walls[].points_m | [[5, 0], [5, 4]] | corners of the polyline, in order
walls[].bottom_m | 0 | where it begins above the floor
walls[].top_m | 2.2 | where it ends above the floor; left out: no end
obstacles | [{"points_m": [[8, 2], [9, 2], [9, 4], [8, 4]], "top_m": 1.2}] | + left out: none
obstacles[].id | shelf | name in messages; left out: it has no name
obstacles[].points_m | [[8, 2], [9, 2], [9, 4], [8, 4]] | corners of the polygon, in order
obstacles[].bottom_m | 0 | where it begins above the floor
obstacles[].top_m | 1.2 | where it ends above the floor; left out: no end
obstacles[].blocks_sound | true | nothing is heard through it
obstacles[].blocks_vehicle | true | nobody drives through it
mounts | [{"kind": "wall", "points_m": [[0, 0], [20, 0]], "height_m": [2, 3]}] | + left out: none
mounts[].id | north wall | name in plans; left out: it has no name
mounts[].kind | wall | wall: along the polyline; ceiling: within the polygon; pole: at the one point
mounts[].points_m | [[0, 0], [20, 0]] | corners, or the pole's place
mounts[].height_m | [2.0, 3.0] | lowest and highest place on it
mounts[].axis | [0, 1, 0] | direction in which a beacon there looks; left out: walls look to the left of their polyline, ceilings down, poles all round
patterns | [{"id": "wide", "kind": "half_power", "half_power_angle_rad": 0.9}] | + left out: none
patterns[].id | wide | name by which beacons and receivers refer to it
patterns[].kind | half_power | cone: all within half_angle_rad; cosine_power: cos^exponent; half_power: by half_power_angle_rad; table: angle_rad and gain
patterns[].half_angle_rad | 1.05 | of a cone: nothing is heard farther off the axis; left out: it is no cone
patterns[].exponent | 2 | of cosine_power; left out: it is no cosine_power
patterns[].half_power_angle_rad | 0.9 | + left out: it is no half_power
patterns[].angle_rad | [0, 0.5, 1.0] | + left out: it is no table
patterns[].gain | [1, 0.7, 0.3] | of a table: share of the amplitude on the axis, a number for each angle; left out: it is no table
beacon_pattern | wide | + left out: all round alike
receiver_pattern | wide | 
beacons | [{"id": "B0", "axis": [0, 1, 0]}] | where the site's beacons look; left out: they look all round
beacons[].id | B0 | 
beacons[].axis | [0, 1, 0] | direction in which it looks, in the map; left out: all round
beacons[].pattern | wide | id of its pattern; left out: beacon_pattern
routes | [{"points_m": [[2, 2], [18, 2]]}] | + left out: none
routes[].id | aisle 1 | name in results; left out: it has no name
routes[].points_m | [[2, 2], [18, 2]] | along which vehicles drive
acoustics | {"frequency_hz": 40000, "range_m": 12} | how far one hears; left out: the site's attenuation; without one everything is heard everywhere
acoustics.frequency_hz | 40000 | + left out: absorption_np_per_m has to say it
acoustics.absorption_np_per_m | 0.15 | loss in the air beyond spreading; goes before the standard's; left out: the standard's at frequency_hz, else the site's attenuation's
acoustics.amplitude_1m_v | 12.5 | 
acoustics.threshold_v | 0.2 | at which a receiver notices a pulse; left out: the site's attenuation's
acoustics.range_m | 12 | + left out: as far as the threshold lets
noise | {"sigma_m_per_m": 0.001} | + left out: the same at every range
noise.sigma_m_per_m | 0.001 | part of a range's sigma that grows with the distance
noise.sigma_m_per_sqrt_m | 0.0005 | part of a range's sigma that grows with its root (turbulence)
cell_m | 0.25 | side of the squares that the floor is cut into
headings | 4 | 
vehicle_z_m | 0 | height of the vehicle's origin; spatial motion only
temperature_error_degC | 5 | 
coverage | 4 | 
import | [{"dxf": "hall.dxf", "layers": ["WALLS"]}] | + left out: nothing
import[].dxf | hall.dxf | + left out: it is a ros_map
import[].ros_map | map.yaml | + left out: it is a dxf
import[].unit_m | 0.001 | 
import[].layers | ["WALLS"] | 
import[].obstacle_layers | ["SHELVES"] | + left out: none
import[].floor_layer | FLOOR | + left out: floor_m has to be stated
import[].bottom_m | 0 | where the walls begin above the floor
import[].top_m | 3 | where they end; left out: no end
)";

constexpr std::string_view kRunWords = R"(
octant_run | 1 | version of the format
vehicle | robot | who made the recording, of rows that name none; left out: the site's only vehicle
temperature_degC | 17.5 | of the air during the recording, where an arrival does not say it; left out: the site's
relative_humidity | 0.5 | of the air during the recording; left out: the site's
pressure_pa | 101325 | of the air during the recording; left out: the site's
range_max_m | 30 | scan beams beyond it saw nothing; left out: none are
poses | {"position_sigma_m": 0.005, "heading": "unknown"} | how well poses.tum and points.csv were measured; sigma 0: exact; left out: as the defaults below
poses.position_sigma_m | 0.005 | standard deviation of a position, by axis
poses.heading_sigma_rad | 0.01 | standard deviation of a heading
poses.heading | unknown | the word unknown where headings were not measured (a prism, an antenna); left out: headings were measured
poses.attitude_sigma_rad | 0.01 | + left out: the heading's
poses.max_gap_s | 1 | 
truth | {"position_sigma_m": 0.005} | how well truth.tum and truth.csv were measured; left out: as the defaults below
truth.position_sigma_m | 0.005 | standard deviation of a position, by axis
truth.heading_sigma_rad | 0.01 | standard deviation of a heading
truth.heading | unknown | the word unknown where headings were not measured; left out: headings were measured
truth.attitude_sigma_rad | 0.01 | roll and pitch; the heading's where it is not given; left out: the heading's
odometry | {"distance_sigma_m_per_sqrt_m": 0.02} | + left out: as the defaults below
odometry.distance_sigma_m_per_sqrt_m | 0.02 | standard deviation of the way after one metre; it grows with the root of the way
odometry.heading_sigma_rad_per_sqrt_m | 0.02 | standard deviation of the heading after one metre
odometry.heading_sigma_per_rad | 0.05 | standard deviation of a turn as a share of it
odometry.floor_m | 0.0001 | standard deviation of a step even where nothing moved
odometry.floor_rad | 0.0001 | standard deviation of a turn even where nothing moved
tof.csv:time_s | 12.5 | 
tof.csv:beacon | B0 | 
tof.csv:tof_s | 0.0216 | 
tof.csv:distance_m | 7.41 | 
tof.csv:epoch | 3 | whole number of the stop; left out: the vehicle moves
tof.csv:vehicle | robot | 
tof.csv:receiver | r0 | id of the vehicle's; left out: its only one
tof.csv:amplitude_v | 1.8 | plateau of the received pulse, for time-walk; empty: not measured
tof.csv:level_dbm | -71 | received power, in place of amplitude_v; left out: not measured
tof.csv:temperature_degC | 17.5 | of the air at this instant; else run.yaml's, else the site's
odometry.csv:time_s | 12.5 | 
odometry.csv:dx_m | 0.031 | 
odometry.csv:dy_m | 0.0 | 
odometry.csv:dheading_rad | 0.002 | 
odometry.csv:dz_m | 0.0 | up, of a vehicle in space; left out: 0
odometry.csv:qx | 0.0 | with qy, qz, qw in place of dheading_rad, of a vehicle in space
odometry.csv:qy | 0.0 | see qx
odometry.csv:qz | 0.001 | see qx
odometry.csv:qw | 1.0 | see qx
odometry.csv:vehicle | robot | who moved; else run.yaml's, else robot
bearings.csv:time_s | 12.5 | 
bearings.csv:reflector | R4 | 
bearings.csv:bearing_rad | 1.571 | 
bearings.csv:epoch | 3 | the same number in tof.csv is the same pose; left out: the vehicle moves
bearings.csv:vehicle | robot | who saw it; else run.yaml's, else robot
scans.csv:time_s | 12.5 | 
scans.csv:angle_min_rad | -1.571 | direction of the first beam in the vehicle frame, counter-clockwise from +x
scans.csv:angle_increment_rad | 0.0175 | 
scans.csv:range0_m, range1_m, ... | 4.73 | 
points.csv:epoch | 3 | 
points.csv:x_m | 7.41 | 
points.csv:y_m | 15.6 | 
points.csv:z_m | 0.0 | of the vehicle, in the map; left out: 0
points.csv:heading_rad | 1.571 | of the vehicle, counter-clockwise from +x of the map; left out: not measured
points.csv:sigma_m | 0.005 | 
points.csv:heading_sigma_rad | 0.02 | 
points.csv:vehicle | robot | whose point it is; else run.yaml's, else robot
poses.tum:time_s | 12.5 | 
poses.tum:x y z | 7.41 15.6 0.0 | 
poses.tum:qx qy qz qw | 0 0 0.707 0.707 | 
)";

constexpr std::string_view kScenarioWords = R"(
octant_scenario | 1 | version of the format
site | {"octant_site": 1, "motion": "planar"} | 
hall_m | [20, 12] | 
range_m | 12 | 
hearing_half_angle_rad | 1.05 | 
path | {"kind": "stops", "epochs": 60} | + left out: stops, as the defaults below
heldout_path | {"epochs": 20} | 
echo_fraction | 0.1 | 
echo_delay_s | [0.0003, 0.012] | 
early_fraction | 0.01 | 
quantum_s | 1e-6 | 
true_speed_offset_mps | 0.8 | 
true_temperature_offset_degC | 1.5 | + left out: none
warming_degC | 2 | 
true_delay_s | [0, 2e-4] | 
cycle_offset_s | [0, 0.05] | 
unknown_beacons | true | 
log_amplitude | true | 
log_poses | true | 
bearings | {"range_m": 12} | + left out: none
bearings.range_m | 12 | 
bearings.unlabelled_fraction | 0.5 | 
bearings.period_s | 0.5 | 
scans | {"beams": 181} | + left out: none
scans.period_s | 0.5 | 
scans.angle_min_rad | -1.571 | direction of the first beam
scans.angle_increment_rad | 0.0175 | from beam to beam
scans.beams | 181 | number of beams
scans.range_max_m | 30 | beyond it a beam sees nothing
walls_m | [[0, 0, 20, 0]] | + left out: none
poses | {"position_sigma_m": 0.005} | + left out: none are logged
poses.position_sigma_m | 0.005 | standard deviation of a position, by axis; left out: as in run.yaml
poses.heading_sigma_rad | 0.01 | standard deviation of a heading; left out: as in run.yaml
poses.heading | unknown | the word unknown where headings are not measured; left out: headings are measured
poses.attitude_sigma_rad | 0.01 | standard deviation of roll and pitch; left out: as in run.yaml
poses.max_gap_s | 1 | longest gap over which poses are interpolated; left out: as in run.yaml
odometry | {"distance_sigma_m_per_sqrt_m": 0.02} | + left out: as in run.yaml; of a drive in space none
odometry.distance_sigma_m_per_sqrt_m | 0.02 | as in run.yaml; left out: as in run.yaml
odometry.heading_sigma_rad_per_sqrt_m | 0.02 | as in run.yaml; left out: as in run.yaml
odometry.heading_sigma_per_rad | 0.05 | as in run.yaml; left out: as in run.yaml
odometry.floor_m | 0.0001 | as in run.yaml; left out: as in run.yaml
odometry.floor_rad | 0.0001 | as in run.yaml; left out: as in run.yaml
$path.kind | stops | 
$path.epochs | 120 | number of stops
$path.epoch_period_s | 5 | from stop to stop
$path.slot_s | 0.05 | 
$path.rounds | 2 | 
$path.duration_s | 120 | 
$path.speed_mps | 0.6 | speed of a drive
$path.turn_rate_rad_per_s | 0.7 | how fast it turns
$path.odometry_period_s | 0.05 | between rows of odometry.csv
$path.waypoints_m | [[2, 2], [18, 10]] | corners of a drive; left out: a drive goes between random goals
$path.stations | [[2, 2, 0], [18, 10, 1.57]] | + left out: it is of another kind
)";

constexpr std::string_view kBatchWords = R"(
octant_batch | 1 | version of the format
sites | [{"site": "hall/site.yaml", "runs": ["hall/run"], "output": "hall.json"}] | what to calibrate, one after the other
sites[].name | hall | 
sites[].site | hall/site.yaml | 
sites[].runs | ["hall/run"] | 
sites[].output | hall.json | 
sites[].report | hall.html | report to write, one HTML page; left out: none
)";

constexpr std::string_view kColumnsWords = R"(
octant_columns | 1 | version of the format
columns | {"time_s": "timestamp_ms*1e-3", "beacon": "anchor", "distance_m": "distance_cm*1e-2"} | column of tof.csv: column of the table; one of tof_s and distance_m is needed
columns.time_s | timestamp_ms*1e-3 | time of the arrival
columns.beacon | anchor | id of the beacon
columns.tof_s | tof_ns*1e-9 | time of flight; left out: there is distance_m
columns.distance_m | distance_cm*1e-2 | distance, where the site's speed is constant (radio); left out: there is tof_s
columns.epoch | stop | number of the stop; left out: the vehicle moves all the time
columns.vehicle | robot | id of the vehicle; left out: robot
columns.receiver | antenna | id of the receiver; left out: the vehicle has one
columns.amplitude_v | peak_mv*1e-3 | amplitude of the pulse; left out: not logged
columns.temperature_degC | air | temperature of the air; left out: that of the run or the site
ignore | ["A9"] | beacons whose rows are left out, as those of a neighbour; left out: none
)";

constexpr std::string_view kDefaultsWords = R"(
octant_defaults | 1 | version of the format
threads | 2 | as --threads: how many to use; 0: all cores
progress | plain | as --progress: how it is shown on standard error
quiet | true | as -q: no notes and no progress
verbose | true | as -v: notes, and all tables in results
)";

constexpr std::string_view kTopicsWords = R"(
octant_topics | 1 | version of the format
ranges | [{"topic": "/uwb/{receiver}/{beacon}"}] | topics of sensor_msgs/Range, each message an arrival; left out: the bag has none
ranges[].topic | /uwb/{receiver}/{beacon} | pattern of the topic's name
ranges[].frame | tag_{receiver} | pattern of the header's frame_id; left out: any
ranges[].beacon | A3 | where no pattern tells it; left out: a pattern does
ranges[].receiver | tag0 | where no pattern tells it; left out: a pattern does, or the vehicle has one
ranges[].vehicle | robot | where no pattern tells it; left out: robot
odometry | {"topic": "/odom"} | topic of nav_msgs/Odometry; left out: none
poses | {"topic": "/tf", "parent": "map", "child": "base_link"} | topic of measured poses; left out: none
truth | {"topic": "/mocap/pose"} | topic of reference poses, which only verify opens; left out: none
time | header | header: the time in each message; recorded: when the bag got it
ignore | ["A9"] | beacons whose rows are left out, as those of a neighbour; left out: none
$pose.topic | /odom | its name
$pose.parent | map | frame in which the pose is, of tf; left out: any
$pose.child | base_link | frame whose pose it is, of tf; left out: any
)";

}  // namespace

std::string_view key_words(std::string_view format) {
  if (format == "site") return kSiteWords;
  if (format == "scene") return kSceneWords;
  if (format == "run") return kRunWords;
  if (format == "scenario") return kScenarioWords;
  if (format == "batch") return kBatchWords;
  if (format == "columns") return kColumnsWords;
  if (format == "topics") return kTopicsWords;
  if (format == "defaults") return kDefaultsWords;
  return written_key_words(format);
}

}  // namespace octant::io
