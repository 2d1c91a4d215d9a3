// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/clocks/clock_files.h"

#include <fmt/format.h>

#include "io/clocks/counter.h"
#include "io/run/run_folder.h"
#include "io/site/site_yaml.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace clock_files_test {

const NameTable kNames{
    .beacons = {"A0", "A1", "A2"}, .vehicles = {"tag"}, .receivers = {{"t", VehicleId(0)}}};

TEST(ClockFiles, DifferencesReadBackAsWritten) {
  const test::TemporaryFolder folder;
  const std::string text = "time_s,epoch,beacon_a,beacon_b,tdoa_s\n0.5,3,A0,A2,-1e-09\n1,4,A1,A2,2e-09\n";
  folder.write("tdoa.csv", text);
  EXPECT_TRUE(has_clock_log(folder.path()));
  const ClockLog log = read_clock_log(folder.path(), kNames).value();
  ASSERT_EQ(log.differences.size(), 2U);
  EXPECT_EQ(log.differences[0].b, BeaconId(2));
  EXPECT_EQ(log.differences[1].epoch, 4);
  EXPECT_EQ(differences_to_csv(log.differences, kNames), text);
}

TEST(ClockFiles, NamesWhatIsWrong) {
  const test::TemporaryFolder folder;
  folder.write("tdoa.csv", "time_s,beacon_a,beacon_b,tdoa_s\n0.5,A0,A0,1\n");
  test::expect_error(read_clock_log(folder.path(), kNames), 2, "itself", "tdoa.csv");
  folder.write("tdoa.csv", "time_s,beacon_a,beacon_b,tdoa_s\n0.5,A0,A9,1\n");
  test::expect_error(read_clock_log(folder.path(), kNames), 2, "A9", "tdoa.csv");
  folder.write("tdoa.csv", "time_s,beacon_a,beacon_b,tdoa_s\n0.5,A0,A1,nan\n");
  EXPECT_EQ(read_clock_log(folder.path(), kNames).value().warnings.size(), 1U);
  folder.write("toa.csv", "time_s,transmitter,receiver,toa_s,sequence\n0.5,A0,drone,1,1\n");
  test::expect_error(read_clock_log(folder.path(), kNames), 2, "drone", "toa.csv");
  test::expect_error(read_run(folder.path(), kNames, Timing{}), 0, "synchronised", "tdoa.csv");
}

TEST(ClockFiles, ContinuesCountersThatBeginAgain) {
  for (const double period_s : kCounterPeriods_s) {
    const test::TemporaryFolder folder;
    std::string text = "time_s,transmitter,receiver,toa_s,sequence\n";
    const double step_s = 0.3 * period_s;
    for (int k = 0; k < 20; ++k)
      for (const char* receiver : {"A0", "A1"}) {
        const double toa_s = k * step_s + (receiver[1] == '1' ? 0.5 * period_s : 0.0);
        text += fmt::format("{},tag,{},{:.15g},{}\n", 1000.0 + k * step_s, receiver,
                            std::fmod(toa_s, period_s), k % 4);
      }
    folder.write("toa.csv", text);
    const ClockLog log = read_clock_log(folder.path(), kNames).value();
    ASSERT_EQ(log.transmissions.size(), 20U);
    for (const Transmission& t : log.transmissions) {
      ASSERT_EQ(t.receptions.size(), 2U);
      EXPECT_NEAR(t.receptions[1].after_s - t.receptions[0].after_s, 0.5 * period_s, 1e-9);
      EXPECT_NEAR(t.receptions[0].after_s, 0.0, 1e-9);
    }
    ASSERT_EQ(log.warnings.size(), 1U);
    EXPECT_THAT(log.warnings[0], testing::HasSubstr("begin again"));
  }
}

TEST(ClockFiles, ReadsTheClocksOfASite) {
  const test::TemporaryFolder folder;
  folder.write("site.yaml",
               "octant_site: 1\nmotion: spatial\nmedium: {model: constant, speed_mps: 340, sigma_mps: 0}\n"
               "timing: {clock: free, oscillator: crystal}\nnoise: {tof_sigma_s: 1.0e-4}\n"
               "beacons: [{id: A0, clock: left}, {id: A1}, {id: A2, clock: left}]\n"
               "vehicles: [{id: tag, receivers: [{id: t, position_m: [0, 0, 0], sigma_m: 0}]}]\n");
  const std::string path = folder.path("site.yaml");
  const Site site = read_site(path).value();
  EXPECT_EQ(site.timing.clock, Clock::kCycleOffset);
  const ClockModel clocks = read_clock_model(path, site).value();
  EXPECT_TRUE(clocks.is_free);
  EXPECT_EQ(clocks.allan_deviation, kCrystalDeviation);
  EXPECT_EQ(clocks.of_device, (std::vector<int>{0, 1, 0, 2}));
}

}  // namespace clock_files_test
}  // namespace octant::io
