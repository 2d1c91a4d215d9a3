// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/run/run_folder.h"

#include <random>

#include "io/text/atomic_file.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace run_folder_test {

using test::expect_error;
using test::TemporaryFolder;
using testing::ElementsAre;
using testing::HasSubstr;

const NameTable kNames{.beacons = {"B0", "B1"},
                       .vehicles = {"robot", "cart"},
                       .receivers = {{"r0", VehicleId(0)}, {"r1", VehicleId(0)}, {"r0", VehicleId(1)}}};
const NameTable kSingle{
    .beacons = {"B0", "B1"}, .vehicles = {"trolley"}, .receivers = {{"t0", VehicleId(0)}}};

struct File {
  std::string name, text;
};

Result<MeasurementLog> read(const std::vector<File>& files, const NameTable& names = kSingle,
                            Clock clock = Clock::kSynchronised, const ReadRunOptions& options = {}) {
  const TemporaryFolder folder;
  for (const File& file : files) folder.write("run/" + file.name, file.text);
  Timing timing;
  timing.clock = clock;
  return read_run(folder.path("run"), names, timing, options);
}

Result<MeasurementLog> read_tof(const std::string& text, const NameTable& names = kSingle,
                                Clock clock = Clock::kSynchronised) {
  return read({{"tof.csv", text}}, names, clock);
}

const std::string kPlain = "time_s,beacon,tof_s\n";

TEST(RunFolder, ReadsArrivalsWithAllColumns) {
  const auto log = read_tof(
                       "tof_s,time_s,beacon,epoch,vehicle,receiver,amplitude_v,temperature_degC\n"
                       "0.01,1.5,B1,3,robot,r1,0.5,21.5\n0.02,1.5,B0,3,cart,,nan,\n",
                       kNames)
                       .value();
  ASSERT_EQ(log.arrivals.size(), 2u);
  const Arrival &a = log.arrivals[0], &b = log.arrivals[1];
  EXPECT_EQ(a.time_s, 1.5);
  EXPECT_EQ(a.tof_s, 0.01);
  EXPECT_EQ(a.beacon, BeaconId(1));
  EXPECT_EQ(a.receiver, ReceiverId(1));
  EXPECT_EQ(a.epoch, 3);
  EXPECT_EQ(a.amplitude_v, 0.5);
  EXPECT_EQ(a.temperature_degC, 21.5);
  EXPECT_EQ(a.line, 2);
  EXPECT_EQ(b.vehicle, VehicleId(1));
  EXPECT_EQ(b.receiver, ReceiverId(2)) << "the vehicle's only one";
  EXPECT_TRUE(std::isnan(b.amplitude_v) && std::isnan(b.temperature_degC));
  EXPECT_TRUE(log.has_epochs);
  EXPECT_EQ(log.vehicle, VehicleId(0)) << "robot, where there is one";
  EXPECT_EQ(log.sha256.size(), 1u);
}

TEST(RunFolder, LevelsBecomeAmplitudes) {
  const auto log = read_tof("time_s,beacon,tof_s,level_dbm\n1,B0,0.01,-80\n2,B0,0.01,\n").value();
  EXPECT_NEAR(log.arrivals[0].amplitude_v, std::sqrt(0.05 * 1e-8), 1e-18);
  EXPECT_TRUE(std::isnan(log.arrivals[1].amplitude_v));
}

TEST(RunFolder, CountsArrivalsThatAreNoMeasurement) {
  const auto log =
      read_tof(kPlain + "1,B0,0.01\n1,B0,nan\n1,B0,\n1,B0,-0.01\n1,B0,NaN\n1,B0,inf\n1,B0,0\n1,B1,0.02\n")
          .value();
  EXPECT_EQ(log.rows, 8u);
  EXPECT_EQ(log.arrivals.size(), 2u);
  ASSERT_EQ(log.rejected.size(), 6u);
  EXPECT_EQ(log.rejected[0].line, 3);
  EXPECT_EQ(log.rejected[0].reason, "tof_s is not a number");
  EXPECT_EQ(log.rejected[5].reason, "tof_s is not positive");
  EXPECT_THAT(log.warnings, ElementsAre(HasSubstr("tof.csv:4: tof_s is empty; 1 arrival"),
                                        HasSubstr("tof.csv:3: tof_s is not a number (nan); 3"),
                                        HasSubstr("tof.csv:5: tof_s is not positive (-0.01); 2")));
  const auto offset =
      read_tof(kPlain + "1,B0,-0.01\n1,B0,0\n1,B0,nan\n", kSingle, Clock::kCycleOffset).value();
  EXPECT_EQ(offset.arrivals.size(), 2u) << "negative ones are legal where the clock has an offset";
}

TEST(RunFolder, RefusesTimesThatAreImpossiblyLarge) {
  const auto log = read_tof(kPlain + "1,B0,0.01\n1,B0,1e160\n1,B1,1e300\n1,B1,0.02\n").value();
  EXPECT_EQ(log.arrivals.size(), 2u);
  EXPECT_THAT(log.warnings,
              ElementsAre(HasSubstr("tof.csv:3: tof_s is impossibly large (1e160); 2 arrivals")));
}

TEST(RunFolder, RowsThatStandThereTwiceCountOnce) {
  const auto log = read_tof(kPlain + "1,B0,0.01\n1,B1,0.02\n1,B0,0.01\n2,B0,0.01\n2,B0,0.01\n").value();
  EXPECT_EQ(log.rows, 5u);
  EXPECT_EQ(log.arrivals.size(), 3u);
  EXPECT_EQ(log.rejected.size(), 2u);
  EXPECT_THAT(
      log.warnings,
      ElementsAre(HasSubstr("tof.csv:4: the row is a duplicate of another one; 2 arrivals rejected")));
}

TEST(RunFolder, WarnsOnceOfUnknownColumns) {
  const auto log =
      read_tof("time_s,beacon,tof_s,colour,ampltude_v\n1,B0,0.01,red,2\n2,B0,0.01,red,2\n").value();
  EXPECT_THAT(log.warnings,
              ElementsAre(HasSubstr("tof.csv: 2 unknown columns are ignored: colour, ampltude_v")));
}

TEST(RunFolder, SaysWhatIsWrongWithArrivals) {
  struct Bad {
    std::string text;
    int line;
    std::string words;
  };
  const std::string epochs = "time_s,beacon,tof_s,epoch\n";
  const std::vector<Bad> cases = {
      {"", 0, "the file is empty"},
      {kPlain, 0, "no arrivals"},
      {"time_s,beacon\n1,B0\n", 1, "column 'tof_s' is missing"},
      {"beacon,tof_s\n", 1, "column 'time_s' is missing"},
      {"time_s;beacon;tof_s\n1,5;B0;0,01\n", 1, "semicolons"},
      {kPlain + "1,B0,0.01\n1,B9,0.01\n", 3,
       "beacon 'B9' is not in the site; expected a beacon's id; did you mean"},
      {kPlain + "1,B9,0.01\n1,B0,0.01\n2,B8,0.01\n3,C7,0.01\n4,B8,0.01\n", 2,
       "beacon 'B9' is not in the site, nor are B8, C7; expected"},
      {kPlain + "1,Zebra,0.01\n", 2, "or add it to the site's beacons"},
      {kPlain + "1,,0.01\n", 2, "beacon is empty"},
      {kPlain + "1,B0,N/A\n", 2, "tof_s is 'N/A'; expected a number"},
      {kPlain + "1,B0,0.01s\n", 2, "tof.csv:2:6: tof_s is '0.01s'"},
      {kPlain + "x,B0,0.01\n", 2, "tof.csv:2:1: time_s is 'x'"},
      {kPlain + "nan,B0,0.01\n", 2, "time_s is 'nan'; expected a finite"},
      {kPlain + "1,B0,0.01\n2,B0,0.01\n1.5,B0,0.01\n", 4, "time_s goes back from 2 to 1.5"},
      {kPlain + "1,B0,0.01\n2,B", 3, "cut off"},
      {kPlain + "1,B0,nan\n", 2, "no arrival is left"},
      {kPlain + "1,B0,0.01\n1,B\xFF,0.01\n", 3, "0xFF"},
      {epochs + "1,B0,0.01,1.5\n", 2, "epoch is '1.5'; expected a whole number"},
      {epochs + "1,B0,0.01,\n", 2, "epoch is empty"},
      {epochs + "1,B0,0.01,1\n2,B0,0.01,2\n3,B0,0.01,1\n", 4, "epoch 1 comes back after epoch 2"},
      {"time_s,beacon,tof_s,receiver\n1,B0,0.01,t9\n", 2, "receiver 't9' is not on vehicle 'trolley'"},
      {"time_s,beacon,tof_s,vehicle\n1,B0,0.01,robot\n", 2, "vehicle 'robot' is not in the site"},
      {"time_s,beacon,tof_s,temperature_degC\n1,B0,0.01,294\n", 2, "degrees Celsius"},
      {"time_s,beacon,tof_s,amplitude_v\n1,B0,0.01,loud\n", 2, "amplitude_v is 'loud'"},
      {kPlain + "1," + std::string(900'000, 'B') + ",0.01\n", 2, "(900000 characters)"},
  };
  for (const Bad& bad : cases) {
    SCOPED_TRACE(bad.text.substr(0, 200));
    expect_error(read_tof(bad.text), bad.line, bad.words, "tof.csv");
  }
  expect_error(read_tof(kPlain + "1,B0,0.01\n", kNames), 2, "names no receiver, and vehicle 'robot' has 2",
               "tof.csv");
}

TEST(RunFolder, EpochsAreBlocksOfEachVehicle) {
  EXPECT_TRUE(
      read_tof("time_s,beacon,tof_s,epoch,vehicle,receiver\n"
               "1,B0,0.01,1,robot,r0\n1,B0,0.01,1,cart,r0\n2,B0,0.01,2,robot,r0\n3,B0,0.01,1,cart,r0\n",
               kNames));
}

TEST(RunFolder, HeaderAloneIsFineBesideOtherRows) {
  const auto log =
      read({{"tof.csv", kPlain},
            {"bearings.csv", "time_s,reflector,bearing_rad,epoch\n1,B0,0.5,7\n1,,-1,7\n2,B1,nan,8\n"}})
          .value();
  ASSERT_EQ(log.bearings.size(), 2u);
  EXPECT_EQ(log.bearings[0].reflector, BeaconId(0));
  EXPECT_FALSE(log.bearings[1].reflector.valid()) << "unlabelled";
  EXPECT_EQ(log.bearings[1].epoch, 7);
  EXPECT_TRUE(log.has_epochs);
  EXPECT_THAT(log.warnings, ElementsAre(HasSubstr("bearings.csv:4: bearing_rad is not a number; 1 row")));
}

TEST(RunFolder, ReadsScans) {
  const auto log =
      read({{"scans.csv",
             "time_s,angle_min_rad,angle_increment_rad,range1_m,range0_m\n1,-1,0.5,20,2.5\n2,-1,0.5,,nan\n"},
            {"run.yaml", "octant_run: 1\nrange_max_m: 10\n"}})
          .value();
  ASSERT_EQ(log.scans.size(), 2u);
  EXPECT_EQ(log.scans[0].range_m[0], 2.5);
  EXPECT_TRUE(std::isnan(log.scans[0].range_m[1])) << "beyond range_max_m";
  EXPECT_TRUE(std::isnan(log.scans[1].range_m[0]) && std::isnan(log.scans[1].range_m[1]));
}

TEST(RunFolder, SaysWhatIsWrongWithTheOtherFiles) {
  const File tof{"tof.csv", kPlain + "1,B0,0.01\n"};
  struct Bad {
    File file;
    int line;
    std::string words;
  };
  const std::string scans = "time_s,angle_min_rad,angle_increment_rad,range0_m";
  const std::vector<Bad> cases = {
      {{"bearings.csv", "time_s,reflector,bearing_rad\n1,B0,57\n"}, 2, "degrees?"},
      {{"bearings.csv", "time_s,reflector,bearing_rad\n1,X,0.5\n"}, 2, "beacon 'X'"},
      {{"odometry.csv", "time_s,dx_m,dy_m,dheading_rad\n1,0,0,0\n2,0.1,nan,0\n"}, 3, "dy_m is 'nan'"},
      {{"odometry.csv", "time_s,dx_m,dy_m,dheading_rad\n2,0,0,0\n1,0.1,0,0\n"}, 3, "time_s goes back"},
      {{"odometry.csv", "time_s,dx_m,dy_m\n"}, 1, "'dheading_rad' is missing"},
      {{"odometry.csv", "time_s,dx_m,dy_m,dz_m,qx,qy,qz\n"}, 1, "'qw' is missing"},
      {{"odometry.csv", "time_s,dx_m,dy_m,dheading_rad,qx,qy,qz,qw\n1,0,0,0,0,0,0,1\n"},
       1,
       "both a quaternion"},
      {{"odometry.csv", "time_s,dx_m,dy_m,qx,qy,qz,qw\n1,0,0,0,0,0,0\n"}, 2, "a quaternion of no length"},
      {{"odometry.csv", "time_s,dx_m,dy_m,dheading_rad\n1,0,0,0\n2,1e160,0,0\n"},
       3,
       "dx_m is '1e160'; expected metres"},
      {{"scans.csv", scans + ",range2_m\n"}, 1, "'range1_m' is missing"},
      {{"scans.csv", scans + "\n1,0,0,x\n"}, 2, "range0_m is 'x'"},
      {{"scans.csv", "time_s,angle_min_rad,angle_increment_rad\n"}, 1, "range0_m"},
      {{"poses.tum", "1 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n"}, 2, "strictly increasing"},
      {{"run.yaml", "octant_run: 2\n"}, 1, "version '2'"},
      {{"run.yaml", "vehicle: x\n"}, 1, "'octant_run' is missing"},
      {{"run.yaml", "octant_run: 1\nvehicle: troley\n"}, 0, "did you mean 'trolley'?"},
      {{"run.yaml", "octant_run: 1\npressure_pa: 1013\n"}, 2, "pascals"},
      {{"run.yaml", "octant_run: 1\nposes: {position_sigma_m: -1}\n"}, 2, "zero or a positive"},
      {{"run.yaml", "octant_run: 1\nposes: {heading: north}\n"}, 2, "one of unknown"},
      {{"run.yaml", "octant_run: 1\nposes: {heading: unknown, heading_sigma_rad: 1}\n"}, 2, "one of the two"},
  };
  for (const Bad& bad : cases) {
    SCOPED_TRACE(bad.file.text);
    expect_error(read({tof, bad.file}), bad.line, bad.words, bad.file.name.c_str());
  }
}

TEST(RunFolder, ReadsRunYaml) {
  const std::string text =
      "octant_run: 1\nvehicle: cart\ntemperature_degC: 19\nrelative_humidity: 0.4\npressure_pa: 99000\n"
      "poses: {position_sigma_m: 0, heading_sigma_rad: 0.2, max_gap_s: 3}\ntruth: {position_sigma_m: 0.05, "
      "heading: unknown}\n"
      "odometry: {distance_sigma_m_per_sqrt_m: 0.3, heading_sigma_per_rad: 0.1}\nweather: fair\n";
  const auto log = read({{"run.yaml", text}, {"tof.csv", kPlain + "1,B0,0.01\n"}}, kNames).value();
  EXPECT_EQ(log.vehicle, VehicleId(1));
  EXPECT_EQ(log.arrivals[0].receiver, ReceiverId(2));
  EXPECT_EQ(log.temperature_degC, 19.0);
  EXPECT_EQ(log.pressure_pa, 99000.0);
  EXPECT_EQ(log.pose_accuracy.position_sigma_m, 0.0);
  EXPECT_EQ(log.pose_accuracy.attitude_sigma_rad, 0.2) << "the heading's where it is not given";
  EXPECT_EQ(log.pose_accuracy.max_gap_s, 3.0);
  EXPECT_FALSE(log.truth_accuracy.heading_known);
  EXPECT_EQ(log.odometry_accuracy.heading_sigma_per_rad, 0.1);
  EXPECT_THAT(log.warnings, ElementsAre(HasSubstr("run.yaml:9: unknown key 'weather'")));
}

TEST(RunFolder, OpensTheTruthOnlyWhenAsked) {
  const std::vector<File> files = {{"tof.csv", kPlain + "1,B0,0.01\n"}, {"truth.tum", "not a trajectory\n"}};
  const auto log = read(files);
  ASSERT_TRUE(log);
  EXPECT_EQ(log->sha256.size(), 1u);
  expect_error(read(files, kSingle, Clock::kSynchronised, {.read_truth = true}), 1, "'not'", "truth.tum");
}

TEST(RunFolder, SaysWhichFolderIsNoRun) {
  const TemporaryFolder folder;
  expect_error(read_run(folder.path("none"), kSingle, {}), 0, "No such file", "none");
  expect_error(read_run(folder.write("file", ""), kSingle, {}), 0, "this is a file", "file");
  expect_error(read_run(folder.path(), kSingle, {}), 0, "none of tof.csv");
  std::filesystem::create_symlink("tof.csv", folder.path("tof.csv"));
  expect_error(read_run(folder.path(), kSingle, {}), 0, "symbolic link", "tof.csv");
}

TEST(RunFolder, WillNotMixTwoRuns) {
  const TemporaryFolder folder;
  auto log = read_tof(kPlain + "1,B0,0.01\n").value();
  folder.write("run/odometry.csv", "x");
  expect_error(write_run(folder.path("run"), log, kSingle), 0, "not part of this run", "odometry.csv");
  EXPECT_FALSE(std::filesystem::exists(folder.path("run/tof.csv")));
  expect_error(write_run(folder.path("none/run"), log, kSingle), 0, "cannot be made", "run");
}

TEST(RunFolder, TheOrderOfColumnsDoesNotMatter) {
  EXPECT_TRUE(rc::check("columns found by name", [] {
    const std::vector<std::pair<std::string, std::vector<std::string>>> columns = {
        {"time_s", {"1", "2"}},
        {"beacon", {"B0", "B1"}},
        {"tof_s", {"0.01", "0.02"}},
        {"epoch", {"5", "6"}},
        {"junk", {"\"a,b\"", ""}}};
    std::vector<std::size_t> order = {0, 1, 2, 3, 4};
    std::shuffle(order.begin(), order.end(), std::mt19937(*rc::gen::arbitrary<unsigned>()));
    std::string header, first, second;
    for (const std::size_t c : order) {
      header.append(header.empty() ? "" : ",").append(columns[c].first);
      first.append(c == order[0] ? "" : ",").append(columns[c].second[0]);
      second.append(c == order[0] ? "" : ",").append(columns[c].second[1]);
    }
    const auto log = read_tof(header + "\n" + first + "\n" + second + "\n").value();
    RC_ASSERT(log.arrivals.size() == 2u);
    RC_ASSERT(log.arrivals[0].beacon == BeaconId(0) && log.arrivals[0].tof_s == 0.01 &&
              log.arrivals[0].epoch == 5);
    RC_ASSERT(log.arrivals[1].beacon == BeaconId(1) && log.arrivals[1].tof_s == 0.02 &&
              log.arrivals[1].epoch == 6);
  }));
}

MeasurementLog some_log() {
  MeasurementLog log;
  log.vehicle = VehicleId(*rc::gen::element(0, 1));
  log.temperature_degC = test::maybe(test::some_fraction());
  log.relative_humidity = test::maybe(test::some_fraction());
  const bool epochs = *rc::gen::arbitrary<bool>(), amplitude = *rc::gen::arbitrary<bool>(),
             received = *rc::gen::arbitrary<bool>(), in_space = *rc::gen::arbitrary<bool>();
  double time_s = test::some_number();
  for (int i = 0, n = *rc::gen::inRange(1, 8); i < n; ++i) {
    time_s += test::some_positive();
    const ReceiverId receiver(*rc::gen::element(0, 1, 2));
    Arrival a{.time_s = time_s,
              .tof_s = test::some_positive(),
              .beacon = BeaconId(*rc::gen::element(0, 1)),
              .receiver = receiver,
              .vehicle = kNames.receivers[receiver.index()].vehicle};
    if (epochs) a.epoch = i / 2 - 2;
    if (amplitude && i % 2 == 0) a.amplitude_v = test::some_positive();
    if (received && i % 2 == 0) a.received_after_s = static_cast<float>(test::some_fraction());
    log.arrivals.push_back(a);
    Bearing b{
        .time_s = time_s, .bearing_rad = test::some_fraction(), .reflector = {}, .vehicle = VehicleId(1)};
    if (i % 2 == 0) b.reflector = BeaconId(1);
    if (epochs) b.epoch = i;
    log.bearings.push_back(b);
    log.odometry.push_back(
        {time_s, i ? test::some_number() : 0, 0, i ? test::some_fraction() : 0, VehicleId(1)});
    if (i > 0 && in_space) {
      log.odometry.back().dz_m = test::some_number();
      log.odometry.back().turn_x_rad = test::some_fraction();
    }
    log.poses.push_back({i + test::some_fraction() / 2,
                         {{test::some_number(), 1, 2}, exp_rotation({0, test::some_fraction(), 1})}});
    log.scans.push_back({time_s, test::some_fraction(), 0.01, {test::some_positive(), std::nan(""), 3}});
  }
  log.truth = log.poses;
  log.pose_accuracy = {test::some_positive(), test::some_positive(), *rc::gen::arbitrary<bool>(),
                       test::some_positive(), test::some_positive()};
  log.odometry_accuracy = {test::some_positive(), test::some_positive(), test::some_positive(),
                           test::some_positive(), 0};
  log.has_epochs = epochs;
  return log;
}

void assert_same(const MeasurementLog& a, const MeasurementLog& b) {
  RC_ASSERT(a.vehicle == b.vehicle && a.has_epochs == b.has_epochs && a.arrivals.size() == b.arrivals.size());
  RC_ASSERT(a.temperature_degC == b.temperature_degC && a.relative_humidity == b.relative_humidity &&
            a.pressure_pa == b.pressure_pa);
  const auto same = [](double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); };
  for (std::size_t i = 0; i < a.arrivals.size(); ++i) {
    const Arrival &x = a.arrivals[i], &y = b.arrivals[i];
    RC_ASSERT(x.time_s == y.time_s && x.tof_s == y.tof_s && x.beacon == y.beacon && x.receiver == y.receiver);
    RC_ASSERT(x.vehicle == y.vehicle && x.epoch == y.epoch && same(x.amplitude_v, y.amplitude_v));
    RC_ASSERT(std::isnan(x.received_after_s) == std::isnan(y.received_after_s));  // written as a sum
    RC_ASSERT(!(std::abs(x.received_after_s - y.received_after_s) > 1e-6 + 1e-15 * std::abs(x.time_s)));
    const Bearing &p = a.bearings[i], &q = b.bearings[i];
    RC_ASSERT(p.time_s == q.time_s && p.bearing_rad == q.bearing_rad && p.reflector == q.reflector &&
              p.vehicle == q.vehicle);
    RC_ASSERT(p.epoch == q.epoch);
    const OdometryStep &o = a.odometry[i], &r = b.odometry[i];
    RC_ASSERT(o.time_s == r.time_s && o.dx_m == r.dx_m && o.dy_m == r.dy_m && o.dz_m == r.dz_m &&
              o.vehicle == r.vehicle && o.is_planar() == r.is_planar());
    // Converted through a quaternion, which changes the last digit.
    const double off_rad = (o.turn_rad() - r.turn_rad()).norm();
    RC_ASSERT(off_rad <= (o.is_planar() ? 0.0 : 1e-12));
    RC_ASSERT(a.poses[i].time_s == b.poses[i].time_s && b.truth[i].time_s == a.truth[i].time_s);
    RC_ASSERT(a.poses[i].T_map_vehicle.rotation.coeffs() == b.poses[i].T_map_vehicle.rotation.coeffs());
    RC_ASSERT(a.scans[i].angle_min_rad == b.scans[i].angle_min_rad && b.scans[i].range_m.size() == 3u);
    for (std::size_t k = 0; k < 3; ++k) RC_ASSERT(same(a.scans[i].range_m[k], b.scans[i].range_m[k]));
  }
  RC_ASSERT(a.pose_accuracy.position_sigma_m == b.pose_accuracy.position_sigma_m);
  RC_ASSERT(a.pose_accuracy.heading_known == b.pose_accuracy.heading_known &&
            a.pose_accuracy.max_gap_s == b.pose_accuracy.max_gap_s);
  RC_ASSERT(!a.pose_accuracy.heading_known ||
            a.pose_accuracy.heading_sigma_rad == b.pose_accuracy.heading_sigma_rad);
  RC_ASSERT(a.pose_accuracy.attitude_sigma_rad == b.pose_accuracy.attitude_sigma_rad);
  RC_ASSERT(a.odometry_accuracy.distance_sigma_m_per_sqrt_m ==
            b.odometry_accuracy.distance_sigma_m_per_sqrt_m);
  RC_ASSERT(a.odometry_accuracy.heading_sigma_rad_per_sqrt_m ==
            b.odometry_accuracy.heading_sigma_rad_per_sqrt_m);
  RC_ASSERT(a.odometry_accuracy.heading_sigma_per_rad == b.odometry_accuracy.heading_sigma_per_rad);
  RC_ASSERT(a.odometry_accuracy.floor_m == b.odometry_accuracy.floor_m &&
            b.odometry_accuracy.floor_rad == 0.0);
}

TEST(RunFolder, ReadsBackWhatItWrote) {
  EXPECT_TRUE(rc::check("read(write(x)) == x", [] {
    const TemporaryFolder folder;
    const MeasurementLog log = some_log();
    RC_ASSERT(write_run(folder.path("run"), log, kNames).has_value());
    const auto back = read_run(folder.path("run"), kNames, {}, {.read_truth = true});
    if (!back) RC_FAIL(back.error().message());
    RC_ASSERT(back->warnings.empty());
    assert_same(log, *back);
  }));
}

}  // namespace run_folder_test
}  // namespace octant::io
