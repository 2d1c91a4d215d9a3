// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/run/run_stream.h"

#include "tests/io/io_support.h"

namespace octant::io {
namespace run_stream_test {

using test::expect_error;
using test::TemporaryFolder;

const NameTable kNames{.beacons = {"B0", "B1"},
                       .vehicles = {"a", "b"},
                       .receivers = {{"r0", VehicleId(0)}, {"r0", VehicleId(1)}}};
const std::string kHeader = "time_s,beacon,tof_s,vehicle,epoch,temperature_degC\n";

std::string rows(int count) {
  std::string text;
  for (int i = 0; i < count; ++i) {
    text += std::to_string(i) + (i % 2 == 0 ? ",B0," : ",B1,") + (i % 10 == 9 ? "nan" : "0.01") + ",b," +
            std::to_string(i / 7) + ",20.5\n";
  }
  return text;
}

bool same(const Arrival& a, const Arrival& b) {
  return a.time_s == b.time_s && a.tof_s == b.tof_s && a.beacon == b.beacon && a.receiver == b.receiver &&
         a.vehicle == b.vehicle && a.epoch == b.epoch && std::isnan(a.amplitude_v) &&
         std::isnan(b.amplitude_v) && a.temperature_degC == b.temperature_degC && a.line == b.line;
}

TEST(RunStream, IsTheWholeRun) {
  const TemporaryFolder folder;
  folder.write("run/tof.csv", kHeader + rows(5000));
  folder.write("run/poses.tum", "");
  folder.write("run/bearings.csv", "time_s,reflector,bearing_rad,colour,vehicle\n1,B0,0.5,red,b\n");
  const auto whole = read_run(folder.path("run"), kNames, {}).value();
  for (const int threads : {1, 2}) {
    auto stream = RunStream::open(folder.path("run"), kNames, {}, {.threads = threads}).value();
    EXPECT_EQ(stream.log().bearings.size(), 1u);
    std::vector<Arrival> all, block;
    while (stream.next(block).value()) all.insert(all.end(), block.begin(), block.end());
    EXPECT_FALSE(stream.next(block).value()) << "the end stays the end";
    EXPECT_TRUE(block.empty());
    EXPECT_TRUE(std::equal(all.begin(), all.end(), whole.arrivals.begin(), whole.arrivals.end(), same));
    const MeasurementLog& log = stream.log();
    EXPECT_TRUE(log.arrivals.empty());
    EXPECT_EQ(log.rows, 5000u);
    EXPECT_EQ(log.rejected.size(), whole.rejected.size());
    EXPECT_EQ(log.sha256, whole.sha256);
    EXPECT_EQ(log.vehicle, VehicleId(1)) << "named by the rows alone";
    EXPECT_THAT(log.warnings, testing::UnorderedElementsAreArray(whole.warnings));
    EXPECT_TRUE(log.has_epochs);
  }
}

TEST(RunStream, GivesAnyBlockAgain) {
  const TemporaryFolder folder;
  // In quotes far behind, so that the last pieces are read the general way.
  folder.write("run/tof.csv",
               kHeader + rows(40000) +
                   "40000,\"B0\",0.01,b,6000,20.5\n40001,B0,nan,b,6000,20.5\n40002,B1,0.02,b,6000,20.5\n");
  const auto whole = read_run(folder.path("run"), kNames, {}).value();
  for (const int threads : {1, 2}) {
    auto stream = RunStream::open(folder.path("run"), kNames, {}, {.threads = threads}).value();
    EXPECT_GE(stream.rows_estimate(), 40000u);
    std::vector<std::vector<Arrival>> pieces;
    std::vector<Arrival> block;
    while (stream.next(block).value()) pieces.push_back(block);
    ASSERT_EQ(stream.blocks(), pieces.size());
    ASSERT_GT(pieces.size(), 5u);
    EXPECT_EQ(stream.log().sha256, whole.sha256);
    EXPECT_EQ(stream.log().rejected.size(), whole.rejected.size());
    for (std::size_t first = 0; first < pieces.size(); ++first)
      for (const std::size_t last : {first, first + 1, pieces.size()}) {
        std::vector<Arrival> expected, again;
        for (std::size_t i = first; i < last; ++i)
          expected.insert(expected.end(), pieces[i].begin(), pieces[i].end());
        ASSERT_TRUE(stream.read_blocks(first, last, again).has_value());
        EXPECT_TRUE(std::equal(expected.begin(), expected.end(), again.begin(), again.end(), same))
            << first << " to " << last;
      }
    std::vector<Arrival> all;
    ASSERT_TRUE(stream.read_blocks(0, pieces.size(), all).has_value());
    EXPECT_TRUE(std::equal(all.begin(), all.end(), whole.arrivals.begin(), whole.arrivals.end(), same));
  }
}

TEST(RunStream, SaysWhatReadRunSays) {
  struct Bad {
    std::string name, text;
  };
  for (const auto& [name, text] :
       {Bad{"tof.csv", ""}, Bad{"tof.csv", kHeader}, Bad{"tof.csv", kHeader + "1,B0,nan,b,1,\n"},
        Bad{"tof.csv", "time_s\n"}, Bad{"tof.csv", kHeader + rows(3000) + "5,B0,0.01,b,9999,20\n"},
        Bad{"tof.csv", kHeader + rows(30) + "x"}, Bad{"run.yaml", "octant_run: 1\n"},
        Bad{"bearings.csv", "x\n"}}) {
    const TemporaryFolder folder;
    folder.write("run/" + name, text);
    const auto whole = read_run(folder.path("run"), kNames, {});
    ASSERT_FALSE(whole.has_value());
    auto stream = RunStream::open(folder.path("run"), kNames, {});
    std::string message = stream ? "" : stream.error().message();
    std::vector<Arrival> block;
    while (message.empty()) {
      const auto more = stream->next(block);
      ASSERT_TRUE(!more || *more) << text.substr(0, 100);
      if (!more) message = more.error().message();
    }
    EXPECT_EQ(message, whole.error().message());
    if (stream) EXPECT_FALSE(stream->next(block).value()) << "nothing comes after an error";
  }
}

}  // namespace run_stream_test
}  // namespace octant::io
