// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/chunks/chunk_index.h"

#include <map>
#include <random>

#include <gtest/gtest.h>

#include "calib/stream/chunks/chunk_subsample.h"
#include "calib/stream/long_log.h"
#include "tests/calib/calib_support.h"
#include "tests/calib/memory_source.h"

namespace octant::test {
namespace chunk_index_test {

using Key = std::pair<std::int32_t, std::int64_t>;  // vehicle, epoch

/// Rows of three vehicles alternately, each with epochs of one to twenty rows; the third pauses within an
/// epoch.
MeasurementLog interleaved(int rows, unsigned seed) {
  std::mt19937 random(seed);
  MeasurementLog log;
  log.has_epochs = true;
  std::int64_t epoch[3] = {100, 50, -7};
  int left[3] = {3, 5, 4};
  for (int i = 0; i < rows; ++i) {
    auto v = static_cast<std::int32_t>(random() % 3);
    if (v == 2 && i > rows / 5 && i < rows / 2) v = 0;
    if (left[v]-- == 0) {
      epoch[v] += v == 1 ? -1 : 1 + static_cast<std::int64_t>(random() % 3);
      left[v] = static_cast<int>(random() % 20);
    }
    Arrival a;
    a.time_s = i;
    a.line = i + 2;
    a.vehicle = VehicleId(v);
    a.beacon = BeaconId(static_cast<std::int32_t>(random() % 5));
    a.receiver = ReceiverId(v);
    a.epoch = epoch[v];
    log.arrivals.push_back(a);
  }
  return log;
}

calib::ChunkIndex scanned(MemorySource& source, std::size_t vehicles, std::size_t beacons, std::size_t chunk,
                          StateKind kind = StateKind::kStops) {
  calib::ChunkIndex index(calib::StateKinds(source.runs(), std::vector<StateKind>(vehicles, kind)), beacons,
                          chunk);
  static_cast<void>(source.scan([&](std::size_t run, const std::vector<Arrival>& block) {
    index.add(run, block);
    return true;
  }));
  index.end(source.runs());
  return index;
}

TEST(ChunkIndex, EachEpochIsInOneStretchAndWhole) {
  for (const unsigned seed : {1U, 2U, 3U})
    for (const std::size_t block : {std::size_t{1}, std::size_t{7}, std::size_t{64}, std::size_t{5000}}) {
      const MeasurementLog log = interleaved(2000, seed);
      std::map<Key, std::vector<int>> lines;
      for (const Arrival& a : log.arrivals) lines[{a.vehicle.value, a.epoch}].push_back(a.line);
      MemorySource source({log, log}, block);
      const calib::ChunkIndex index = scanned(source, 3, 5, 150);
      EXPECT_EQ(index.arrivals(), 4000U);
      EXPECT_EQ(index.states(1), lines.size());
      std::size_t epochs = 0, arrivals = 0;
      std::map<Key, std::vector<int>> found[2];
      for (const calib::Chunk& chunk : index.chunks()) {
        std::vector<Arrival> rows;
        must(index.read(source, chunk.run, chunk.first_block, chunk.last_block, rows).map([] { return 0; }));
        std::map<Key, std::vector<int>> of_chunk;
        for (const Arrival& a : rows) of_chunk[{a.vehicle.value, a.epoch}].push_back(a.line);
        for (auto& [key, list] : of_chunk)
          EXPECT_TRUE(found[chunk.run].emplace(key, list).second) << "an epoch in two stretches";
        EXPECT_EQ(rows.size(), chunk.all_arrivals());
        for (std::size_t v = 0; v < 3; ++v) {
          EXPECT_EQ(chunk.states[v], static_cast<std::size_t>(
                                         std::count_if(of_chunk.begin(), of_chunk.end(), [&](const auto& e) {
                                           return e.first.first == static_cast<std::int32_t>(v);
                                         })));
          epochs += chunk.states[v];
        }
        arrivals += rows.size();
      }
      EXPECT_EQ(found[0], lines);
      EXPECT_EQ(found[1], lines);
      EXPECT_EQ(epochs, 2 * lines.size());
      EXPECT_EQ(arrivals, 4000U);
      if (block < 100) EXPECT_GT(index.chunks().size(), 8U);
    }
}

// Without epochs, rows are connected if they follow each other within the time that links states.
TEST(ChunkIndex, EachGroupBetweenPausesIsInOneChunkAndWhole) {
  for (const StateKind kind : {StateKind::kMotion, StateKind::kMoments, StateKind::kChainedStops})
    for (const std::size_t block : {std::size_t{1}, std::size_t{7}, std::size_t{64}, std::size_t{5000}}) {
      MeasurementLog log = interleaved(2000, 4);
      std::mt19937 random(5);
      double time_s = 0.0;
      std::map<std::int32_t, std::pair<double, std::size_t>> last;  // of a vehicle: time, group
      std::map<int, std::pair<std::int32_t, std::size_t>> group_of_line;
      for (Arrival& a : log.arrivals) {
        const unsigned what = random() % 8;
        time_s += what < 4 ? 0.0 : what < 6 ? 0.002 : what < 7 ? 0.5 : 12.0;
        a.time_s = time_s;
        auto& [before_s, group] = last.try_emplace(a.vehicle.value, -1e9, 0).first->second;
        const double tie_s = kind == StateKind::kMotion ? 10.0 : kind == StateKind::kMoments ? 0.01 : 1e9;
        if (time_s - before_s > tie_s) ++group;
        before_s = time_s;
        group_of_line[a.line] = {a.vehicle.value, kind == StateKind::kChainedStops ? 0 : group};
      }
      MemorySource source({log}, block);
      const calib::ChunkIndex index = scanned(source, 3, 5, 150, kind);
      std::map<std::pair<std::int32_t, std::size_t>, const calib::Chunk*> chunk_of;
      std::size_t rows_of_all = 0;
      for (const calib::Chunk& chunk : index.chunks()) {
        std::vector<Arrival> rows;
        must(index.read(source, chunk.run, chunk.first_block, chunk.last_block, rows).map([] { return 0; }));
        for (const Arrival& a : rows)
          EXPECT_EQ(chunk_of.try_emplace(group_of_line.at(a.line), &chunk).first->second, &chunk);
        EXPECT_EQ(rows.size(), chunk.all_arrivals());
        rows_of_all += rows.size();
      }
      EXPECT_EQ(rows_of_all, 2000U);
      if (kind != StateKind::kChainedStops && block < 100) EXPECT_GT(index.chunks().size(), 5U);
    }
}

TEST(ChunkIndex, DrivesAreNoneOfIt) {
  const MeasurementLog log = interleaved(500, 6);
  MemorySource source({log}, 50);
  calib::ChunkIndex index({{StateKind::kStops, StateKind::kDrive, StateKind::kStops}}, 5, 100);
  static_cast<void>(source.scan([&](std::size_t run, const std::vector<Arrival>& block) {
    index.add(run, block);
    return true;
  }));
  index.end(1);
  std::size_t of_drive = 0;
  for (const Arrival& a : log.arrivals) of_drive += a.vehicle == VehicleId(1);
  EXPECT_EQ(index.arrivals(), 500 - of_drive);
  for (const calib::Chunk& chunk : index.chunks()) {
    std::vector<Arrival> rows;
    must(index.read(source, 0, chunk.first_block, chunk.last_block, rows).map([] { return 0; }));
    for (const Arrival& a : rows) EXPECT_NE(a.vehicle, VehicleId(1));
  }
}

/// A part of a long log as selected by subsample(), with the log in memory or not.
TEST(LogPart, IsThatOfTheWholeLog) {
  Scenario s = hall_scenario();
  s.path.epochs = 1500;
  s.heldout_path.epochs = 1;
  const World world = must(simulate(s, 4));
  MeasurementLog run = world.run;
  // Beacon 5 is received at every fortieth epoch, beacon 6 at two.
  std::erase_if(run.arrivals, [](const Arrival& a) {
    return (a.beacon.value == 5 && a.epoch % 40 != 3) ||
           (a.beacon.value == 6 && a.epoch != 700 && a.epoch != 1201);
  });
  const calib::Problem whole = must(calib::make_problem(world.site, {run, world.heldout}));
  const calib::Problem expected = must(calib::subsample_of(whole));
  MemorySource source({run, world.heldout}, 100);
  const calib::ChunkIndex index =
      scanned(source, world.site.vehicles.size(), world.site.beacons.size(), 1000);
  const auto stops_of = [&](std::size_t run) {
    return must(calib::subsample_of_stops(run, world.site, source, index, 2));
  };
  const calib::Problem part = must(calib::make_problem(world.site, {stops_of(0), stops_of(1)}));
  for (std::size_t r = 0; r < 2; ++r) {
    const auto &all = expected.runs[r].arrivals, &some = part.runs[r].arrivals;
    ASSERT_EQ(some.size(), all.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
      EXPECT_EQ(some[i].time_s, all[i].time_s);
      EXPECT_EQ(some[i].tof_s, all[i].tof_s);
      EXPECT_EQ(some[i].receiver, all[i].receiver);
    }
  }
  EXPECT_LT(part.runs[0].arrivals.size(), run.arrivals.size());
}

}  // namespace chunk_index_test
}  // namespace octant::test
