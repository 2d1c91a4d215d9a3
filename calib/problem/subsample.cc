// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/problem/subsample.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace octant::calib {
namespace {

/// Step to which odometry between segments is summed: long enough to save time, short enough for a straight
/// chord.
constexpr double kStepM = 0.5, kStepRad = 0.3;
/// Number of steps of a gap above which they become longer, because odometry over such a distance is
/// inaccurate.
constexpr double kMostSteps = 32;

/// Group that is kept or omitted as a whole: an epoch, a moment, or a segment of a drive of one vehicle.
struct Group {
  std::vector<std::size_t> arrivals, bearings;  ///< indices into the log
  double first_s = INFINITY, last_s = -INFINITY;
};

std::uint64_t pair_of(const Arrival& a) {
  return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(a.beacon.value)) << 32U) |
         static_cast<std::uint32_t>(a.receiver.value);
}

class Subsampler {
 public:
  Subsampler(const MeasurementLog& run, const Site& site, const SubsampleOptions& options)
      : run_(run),
        site_(site),
        options_(options),
        stretch_s_(drive_stretches(site).length_s),
        drive_(!run.has_epochs && (run.odometry.size() >= 2 || run.poses.empty())) {}

  MeasurementLog subsample() {
    make_groups();
    const std::size_t budget = budgeted();
    if (groups_.size() <= budget && !crowded()) return run_;
    chosen_ = chosen_groups(groups_.size(), site_.beacons.size(), budget, options_.per_beacon,
                            [this](std::size_t g, const auto& visit) { for_each_heard(groups_[g], visit); });
    return assemble();
  }

 private:
  void make_groups() {
    std::map<std::pair<VehicleId, std::int64_t>, std::size_t> of_key;
    auto latest = of_key.end();  // rows of a group mostly follow each other
    const double begin_s = run_.arrivals.empty() ? 0.0 : run_.arrivals.front().time_s;
    double last_time_s = NAN;
    std::int64_t instant = 0;
    const auto group = [&](VehicleId vehicle, std::int64_t epoch, double time_s) -> Group& {
      std::int64_t key = epoch;
      if (drive_) key = static_cast<std::int64_t>(std::floor((time_s - begin_s) / stretch_s_));
      if (!drive_ && !run_.has_epochs) {
        if (time_s != last_time_s) ++instant;
        last_time_s = time_s;
        key = instant;
      }
      if (latest == of_key.end() || latest->first != std::pair{vehicle, key}) {
        const std::size_t before = of_key.size();
        latest = of_key.try_emplace(of_key.end(), {vehicle, key}, groups_.size());
        if (of_key.size() > before) groups_.emplace_back();
      }
      Group& g = groups_[latest->second];
      g.first_s = std::min(g.first_s, time_s);
      g.last_s = std::max(g.last_s, time_s);
      return g;
    };
    // In the order of time, as without epochs the same time means the same instant: bearings between two
    // arrivals before the second of them, those of an arrival's time behind it.
    std::size_t b = 0;
    const auto group_bearings = [&](double before_s) {
      for (; b < run_.bearings.size() && run_.bearings[b].time_s < before_s; ++b)
        group(run_.bearings[b].vehicle, run_.bearings[b].epoch, run_.bearings[b].time_s)
            .bearings.push_back(b);
    };
    for (std::size_t a = 0; a < run_.arrivals.size(); ++a) {
      group_bearings(run_.arrivals[a].time_s);
      group(run_.arrivals[a].vehicle, run_.arrivals[a].epoch, run_.arrivals[a].time_s).arrivals.push_back(a);
      if (a + 1 == run_.arrivals.size() || run_.arrivals[a + 1].time_s != run_.arrivals[a].time_s)
        group_bearings(std::nextafter(run_.arrivals[a].time_s, INFINITY));
    }
    group_bearings(INFINITY);
  }

  [[nodiscard]] std::size_t budgeted() const {
    return drive_ ? stretches_kept(site_, options_, run_.arrivals.size(), groups_.size()) : options_.instants;
  }

  /// A long stop: one epoch with more repetitions than necessary.
  [[nodiscard]] bool crowded() const {
    return std::ranges::any_of(groups_, [this](const Group& g) {
      if (g.arrivals.size() <= options_.per_pair) return false;
      std::map<std::uint64_t, std::size_t> count;
      return std::ranges::any_of(
          g.arrivals, [&](std::size_t a) { return ++count[pair_of(run_.arrivals[a])] > options_.per_pair; });
    });
  }

  /// Calls visit(beacon) for each observation of a group.
  template <class Visit>
  void for_each_heard(const Group& g, Visit&& visit) const {
    for (const std::size_t a : g.arrivals) visit(run_.arrivals[a].beacon.index());
    for (const std::size_t b : g.bearings)
      if (run_.bearings[b].reflector.valid()) visit(run_.bearings[b].reflector.index());
  }

  MeasurementLog assemble() const {
    MeasurementLog sample = without_lists(run_);
    sample.rejected = run_.rejected;
    if (!drive_) sample.odometry = run_.odometry;
    std::vector<std::size_t> arrivals, bearings;
    std::vector<std::pair<double, double>> spans;
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      if (!chosen_[g]) continue;
      add_some(groups_[g].arrivals, arrivals);
      bearings.insert(bearings.end(), groups_[g].bearings.begin(), groups_[g].bearings.end());
      double asked_s = 0.0;  // before the first of them
      for (const std::size_t a : groups_[g].arrivals)
        if (drive_) asked_s = std::max(asked_s, asked_before_s(site_, run_.arrivals[a]));
      spans.emplace_back(groups_[g].first_s - asked_s, groups_[g].last_s);
    }
    std::ranges::sort(arrivals);
    std::ranges::sort(bearings);
    for (const std::size_t a : arrivals) sample.arrivals.push_back(run_.arrivals[a]);
    for (const std::size_t b : bearings) sample.bearings.push_back(run_.bearings[b]);
    std::ranges::sort(spans);
    sample.poses = poses_near(run_.poses, spans);
    if (drive_) sample.odometry = subsampled_odometry(run_.odometry, spans);
    return sample;
  }

  void add_some(const std::vector<std::size_t>& from, std::vector<std::size_t>& to) const {
    std::vector<const Arrival*> rows;
    for (const std::size_t a : from) rows.push_back(&run_.arrivals[a]);
    for (const std::size_t i : some_of_pairs(rows, options_.per_pair)) to.push_back(from[i]);
  }

  const MeasurementLog& run_;
  const Site& site_;
  const SubsampleOptions& options_;
  double stretch_s_;
  bool drive_;
  std::vector<Group> groups_;
  std::vector<bool> chosen_;
};

double way_m(const OdometryStep& s) { return std::hypot(s.dx_m, s.dy_m, s.dz_m); }
double turn_rad(const OdometryStep& s) { return std::hypot(s.dheading_rad, s.turn_x_rad, s.turn_y_rad); }

/// Rows of one vehicle, and whether each is near a span: it lies in it or is the next one on either side.
struct VehicleRows {
  std::vector<const OdometryStep*> rows;
  std::vector<bool> near;
};

VehicleRows rows_of(const std::vector<OdometryStep>& odometry, VehicleId vehicle,
                    const std::vector<std::pair<double, double>>& spans) {
  VehicleRows of;
  for (const OdometryStep& s : odometry)
    if (s.vehicle == vehicle) of.rows.push_back(&s);
  of.near.resize(of.rows.size());
  auto span = spans.begin();
  for (std::size_t i = 0; i < of.rows.size(); ++i) {
    while (span != spans.end() && i > 0 && span->second < of.rows[i - 1]->time_s) ++span;
    of.near[i] = span != spans.end() && (i + 1 == of.rows.size() || of.rows[i + 1]->time_s > span->first);
  }
  return of;
}

/// Steps to which the rows of a gap are summed up.
struct GapSteps {
  double way_m = kStepM, turn_rad = kStepRad;
  bool are_long = false;  ///< so that their ways are not their chords
};

/// Steps of a gap. A gap of any length has about the same number of them, so a sample has no more states for
/// a longer log.
GapSteps steps_of_gap(const VehicleRows& of, std::size_t row) {
  double all_m = 0.0, all_rad = 0.0;
  for (; row < of.rows.size() && !of.near[row]; ++row) {
    all_m += way_m(*of.rows[row]);
    all_rad += turn_rad(*of.rows[row]);
  }
  GapSteps steps = {std::max(kStepM, all_m / kMostSteps), std::max(kStepRad, all_rad / kMostSteps)};
  steps.are_long = steps.way_m > kStepM || steps.turn_rad > kStepRad;
  return steps;
}

/// Adds the subsampled odometry of one vehicle.
void add_subsampled(const VehicleRows& of, std::vector<OdometryStep>& sample) {
  sample.push_back(*of.rows.front());
  Pose sum;
  double sum_m = 0.0, sum_rad = 0.0;
  GapSteps steps;
  for (std::size_t i = 1; i < of.rows.size(); ++i) {
    const OdometryStep& step = *of.rows[i];
    if (!of.near[i] && (i == 1 || of.near[i - 1])) steps = steps_of_gap(of, i);
    sum = sum * step.pose();
    sum_m += way_m(step);
    sum_rad += turn_rad(step);
    const bool last = i + 1 == of.rows.size();
    if (!of.near[i] && !last && sum_m < steps.way_m && sum_rad < steps.turn_rad) continue;
    sample.push_back({.time_s = step.time_s, .vehicle = step.vehicle});
    sample.back().set_pose(sum);
    if (steps.are_long && (!of.near[i] || !of.near[i - 1])) sample.back().way_m = sum_m;
    sum = Pose();
    sum_m = sum_rad = 0.0;
  }
}

}  // namespace

std::vector<OdometryStep> subsampled_odometry(const std::vector<OdometryStep>& odometry,
                                              const std::vector<std::pair<double, double>>& spans) {
  std::set<VehicleId> vehicles;
  for (const OdometryStep& s : odometry) vehicles.insert(s.vehicle);
  std::vector<OdometryStep> sample;
  for (const VehicleId vehicle : vehicles) add_subsampled(rows_of(odometry, vehicle, spans), sample);
  std::ranges::stable_sort(sample, {}, &OdometryStep::time_s);
  return sample;
}

std::vector<TimedPose> poses_near(const std::vector<TimedPose>& poses,
                                  const std::vector<std::pair<double, double>>& spans) {
  std::vector<bool> near(poses.size(), false);
  const auto before = [](double t, const TimedPose& pose) { return t < pose.time_s; };
  for (const auto& [first_s, last_s] : spans) {
    const auto after = std::upper_bound(poses.begin(), poses.end(), first_s, before) - poses.begin();
    for (auto i = static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - 1, 0)); i < poses.size(); ++i) {
      near[i] = true;
      if (poses[i].time_s > last_s) break;
    }
  }
  std::vector<TimedPose> chosen;
  for (std::size_t i = 0; i < poses.size(); ++i)
    if (near[i]) chosen.push_back(poses[i]);
  return chosen;
}

std::vector<bool> evenly_chosen(std::size_t groups, std::size_t budget) {
  std::vector<bool> chosen(groups, false);
  const std::size_t count = std::min(budget, groups);
  for (std::size_t i = 0; i < count; ++i) chosen[i * groups / count] = true;
  return chosen;
}

void choose_more(GroupsHearing& hearing, std::size_t per_beacon, std::vector<bool>& chosen) {
  std::vector<std::size_t>& kept = hearing.kept;
  for (std::size_t b = 0; b < kept.size(); ++b) {
    const std::vector<std::size_t>& more = hearing.more[b];
    // Evenly spaced again: every 2nd, 4th, ... of the rest, halves first.
    for (std::size_t step = std::max<std::size_t>(1, more.size() / 16); kept[b] < per_beacon; step /= 2) {
      for (std::size_t i = 0; i < more.size() && kept[b] < per_beacon; i += step) {
        if (chosen[more[i]]) continue;
        chosen[more[i]] = true;
        hearing.for_each_heard(more[i], [&](std::size_t beacon) { ++kept[beacon]; });
      }
      if (step == 1) break;
    }
  }
}

std::vector<bool> chosen_groups(std::size_t groups, std::size_t beacons, std::size_t budget,
                                std::size_t per_beacon,
                                decltype(GroupsHearing::for_each_heard) for_each_heard) {
  std::vector<bool> chosen = evenly_chosen(groups, budget);
  GroupsHearing hearing;
  hearing.kept.assign(beacons, 0);
  hearing.more.resize(beacons);
  for (std::size_t g = 0; g < groups; ++g)
    for_each_heard(g, [&](std::size_t beacon) {
      if (chosen[g])
        ++hearing.kept[beacon];
      else if (hearing.more[beacon].empty() || hearing.more[beacon].back() != g)
        hearing.more[beacon].push_back(g);
    });
  hearing.for_each_heard = std::move(for_each_heard);
  choose_more(hearing, per_beacon, chosen);
  return chosen;
}

std::vector<std::size_t> some_of_pairs(const std::vector<const Arrival*>& arrivals, std::size_t per_pair) {
  std::map<std::uint64_t, std::vector<std::size_t>> by_pair;
  for (std::size_t i = 0; i < arrivals.size(); ++i) by_pair[pair_of(*arrivals[i])].push_back(i);
  std::vector<std::size_t> some;
  for (const auto& [pair, all] : by_pair) {
    const std::size_t count = std::min(per_pair, all.size());
    for (std::size_t i = 0; i < count; ++i) some.push_back(all[i * all.size() / count]);
  }
  std::ranges::sort(some);
  return some;
}

void sort_by_time(std::vector<Arrival>& arrivals) {
  std::ranges::stable_sort(arrivals, [](const Arrival& a, const Arrival& b) {
    return a.time_s != b.time_s ? a.time_s < b.time_s : a.line < b.line;
  });
}

MeasurementLog without_lists(const MeasurementLog& run) {
  MeasurementLog bare;
  bare.path = run.path;
  bare.vehicle = run.vehicle;
  bare.temperature_degC = run.temperature_degC;
  bare.relative_humidity = run.relative_humidity;
  bare.pressure_pa = run.pressure_pa;
  bare.pose_accuracy = run.pose_accuracy;
  bare.truth_accuracy = run.truth_accuracy;
  bare.odometry_accuracy = run.odometry_accuracy;
  bare.has_epochs = run.has_epochs;
  bare.rows = run.rows;
  bare.warnings = run.warnings;
  return bare;
}

DriveStretches drive_stretches(const Site& site) {
  if (site.motion == Motion::kSpatial) return {.length_s = 40.0, .fewest = 5};
  return {};
}

std::size_t stretches_kept(const Site& site, const SubsampleOptions& options, std::size_t arrivals,
                           std::size_t stretches) {
  if (stretches == 0) return options.instants;
  const double each = static_cast<double>(arrivals) / static_cast<double>(stretches);
  return static_cast<std::size_t>(
      std::max(static_cast<double>(std::min(drive_stretches(site).fewest, options.fewest_stretches)),
               static_cast<double>(options.drive_arrivals) / std::max(each, 1e-3)));
}

double asked_before_s(const Site& site, const Arrival& arrival) {
  return site.timing.ranging == Ranging::kTwoWay ? arrival.tof_s : 0.0;
}

MeasurementLog subsample(const MeasurementLog& run, const Site& site, const SubsampleOptions& options) {
  return Subsampler(run, site, options).subsample();
}

}  // namespace octant::calib
