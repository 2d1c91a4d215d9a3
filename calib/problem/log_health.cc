// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/problem/log_health.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include <fmt/format.h>

#include "calib/problem/clock_check.h"
#include "calib/problem/ranges.h"
#include "calib/problem/unit_check.h"
#include "models/repeated_row.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {
namespace {

constexpr double kGapRatio = 10.0, kGapAtLeastS = 1.0;
constexpr std::size_t kConstantNeeds = 20;
constexpr double kSpeedPerDegree = 0.0018;  ///< share of the speed of sound that a degree makes
/// A quantum q has a standard deviation of q / sqrt 12; from half of the stated noise on it matters.
constexpr double kQuantumOfSigma = 0.5 * 3.4641016;

class Examiner {
 public:
  Examiner(const Site& site, const MeasurementLog& run) : site_(site), run_(run) {}

  RunHealth examine() {
    h_.path = run_.path;
    h_.rows = std::max(run_.rows, run_.arrivals.size() + run_.rejected.size());
    h_.arrivals = run_.arrivals.size();
    h_.bearings = run_.bearings.size();
    for (const RejectedRow& row : run_.rejected) {
      ++h_.rejected[row.reason];
      h_.duplicates += row.reason == kRepeatedRow;
    }
    extent_in_time();
    links();
    order_and_gaps();
    duplicates();
    values();
    temperature();
    coverage();
    h_.clock_steps = steps_in_ranges(site_, run_);
    for (const ClockStep& s : h_.clock_steps)
      find("clock_step", fmt::format("the times of {} beacons change together by {:.4g} ms at {:.6g} s, more "
                                     "than the vehicle can have moved: a clock jumped there",
                                     s.beacons, 1e3 * s.step_s, s.time_s));
    for (Finding& f : check_units(site_, run_)) find(f.kind, f.text);
    return std::move(h_);
  }

 private:
  void find(const std::string& kind, const std::string& text) {
    h_.findings.push_back({kind, run_.path + ": " + text});
  }

  void extent_in_time() {
    first_s_ = INFINITY;
    last_s_ = -INFINITY;
    const auto see = [this](double t) {
      first_s_ = std::min(first_s_, t);
      last_s_ = std::max(last_s_, t);
    };
    for (const Arrival& a : run_.arrivals) see(a.time_s);
    for (const Bearing& b : run_.bearings) see(b.time_s);
    h_.duration_s = last_s_ > first_s_ ? last_s_ - first_s_ : 0.0;
  }

  void links() {
    std::vector<std::vector<double>> by_beacon(site_.beacons.size()), by_receiver(site_.receivers.size());
    std::vector<bool> appears(site_.vehicles.size(), false);
    for (const Arrival& a : run_.arrivals) {
      by_beacon[a.beacon.index()].push_back(a.time_s);
      by_receiver[a.receiver.index()].push_back(a.time_s);
      appears[a.vehicle.index()] = true;
    }
    for (const Bearing& b : run_.bearings)
      if (b.reflector.valid()) by_beacon[b.reflector.index()].push_back(b.time_s);
    for (std::size_t b = 0; b < by_beacon.size(); ++b)
      h_.beacons.push_back(link(site_.beacons[b].name, std::move(by_beacon[b])));
    for (std::size_t r = 0; r < by_receiver.size(); ++r) {
      if (appears[site_.receivers[r].vehicle.index()])
        h_.receivers.push_back(link(receiver_path(r, names_of(site_)), std::move(by_receiver[r])));
    }
  }

  [[nodiscard]] LinkHealth link(std::string name, std::vector<double> times) const {
    LinkHealth l{std::move(name), times.size(),
                 h_.duration_s > 0 ? static_cast<double>(times.size()) / h_.duration_s : 0.0, h_.duration_s};
    if (times.empty()) return l;
    times.push_back(first_s_);
    times.push_back(last_s_);
    std::ranges::sort(times);
    l.longest_silence_s = 0.0;
    for (std::size_t i = 1; i < times.size(); ++i)
      l.longest_silence_s = std::max(l.longest_silence_s, times[i] - times[i - 1]);
    return l;
  }

  /// Pauses between epochs, or between distinct times without epochs. With several vehicles, whose rows may
  /// be mixed, the usual interval is that of each vehicle's own epochs.
  void order_and_gaps() {
    std::vector<double> spacing;
    std::vector<Gap> between;
    std::vector<const Arrival*> latest(run_.has_epochs ? site_.vehicles.size() : 1, nullptr);
    for (std::size_t i = 0; i < run_.arrivals.size(); ++i) {
      const Arrival& now = run_.arrivals[i];
      const Arrival*& before = latest[run_.has_epochs ? now.vehicle.index() : 0];
      const bool same =
          before != nullptr && (run_.has_epochs ? now.epoch == before->epoch : now.time_s == before->time_s);
      if (!same) ++h_.instants;
      if (!same && before != nullptr) spacing.push_back(now.time_s - before->time_s);
      before = &now;
      if (i == 0) continue;
      const double row_before_s = run_.arrivals[i - 1].time_s;
      h_.backwards += now.time_s < row_before_s;
      if (!same) between.push_back({row_before_s, now.time_s});
    }
    if (h_.backwards > 0)
      find("time_backwards", fmt::format("time_s runs backwards in {} rows", h_.backwards));
    const double usual_s = spacing.empty() ? INFINITY : median(spacing);
    for (const Gap& g : between)
      if (g.to_s - g.from_s > std::max(kGapRatio * usual_s, usual_s + kGapAtLeastS)) h_.gaps.push_back(g);
    std::ranges::sort(h_.gaps,
                      [](const Gap& a, const Gap& b) { return a.to_s - a.from_s > b.to_s - b.from_s; });
    if (h_.gaps.empty()) return;
    find("gap",
         fmt::format(
             "{} {} without any arrival, the longest {:.3g} s from {:.6g} s on (usual spacing {:.3g} s)",
             h_.gaps.size(), h_.gaps.size() == 1 ? "pause" : "pauses", h_.gaps[0].to_s - h_.gaps[0].from_s,
             h_.gaps[0].from_s, usual_s));
  }

  void duplicates() {
    using Key = std::tuple<int, int, int, std::int64_t, double>;
    std::set<Key> block;
    int first_line = 0;
    std::size_t counted = 0;  // those that the reader did not leave out
    for (std::size_t i = 0; i < run_.arrivals.size(); ++i) {
      const Arrival& a = run_.arrivals[i];
      if (i > 0 && a.time_s != run_.arrivals[i - 1].time_s) block.clear();
      if (block.emplace(a.beacon.value, a.receiver.value, a.vehicle.value, a.epoch, a.tof_s).second) continue;
      if (counted++ == 0) first_line = a.line;
    }
    h_.duplicates += counted;
    if (counted > 0)
      find("duplicate", fmt::format("{} rows repeat another one, the first is line {}; they count twice",
                                    counted, first_line));
  }

  void values() {
    std::vector<double> ranges, tof;
    std::vector<std::pair<double, double>> limits(site_.beacons.size(), {INFINITY, -INFINITY});
    for (const Arrival& a : run_.arrivals) {
      ranges.push_back(stated_range_m(site_, run_, a));
      tof.push_back(a.tof_s);
      auto& [low, high] = limits[a.beacon.index()];
      low = std::min(low, a.tof_s);
      high = std::max(high, a.tof_s);
    }
    h_.median_range_m = median(std::move(ranges));
    for (std::size_t b = 0; b < limits.size(); ++b)
      if (h_.beacons[b].arrivals >= kConstantNeeds && limits[b].first == limits[b].second)
        h_.constant.push_back(site_.beacons[b].name);
    for (const std::string& name : h_.constant)
      find("constant",
           fmt::format("the time of flight of beacon {} never changes: is it a default value?", name));
    h_.resolution_s = h_.constant.empty() ? counter_resolution_s(std::move(tof)) : 0.0;
    if (h_.resolution_s > kQuantumOfSigma * site_.noise.tof_sigma_s)
      find("quantised", fmt::format("times of flight come in steps of {:.4g} us, that alone is a noise of "
                                    "{:.3g} us where the site states {:.3g} us",
                                    1e6 * h_.resolution_s, 1e6 * h_.resolution_s / std::sqrt(12.0),
                                    1e6 * site_.noise.tof_sigma_s));
  }

  void temperature() {
    std::size_t with = 0;
    for (const Arrival& a : run_.arrivals) with += std::isfinite(a.temperature_degC);
    h_.temperature_of_run = run_.temperature_degC.has_value();
    if (h_.arrivals == 0) return;
    h_.temperature_share = static_cast<double>(with) / static_cast<double>(h_.arrivals);
    if (site_.medium.model == MediumModel::kConstant || h_.temperature_of_run || with == h_.arrivals) return;
    if (with > 0) {
      find("temperature",
           fmt::format("{} of {} arrivals have no temperature; the site's {:.4g} degC is used for them",
                       h_.arrivals - with, h_.arrivals, site_.medium.temperature_degC));
    } else if (site_.speed_sigma_mps < kSpeedPerDegree * speed_mps(site_.medium)) {
      find("temperature",
           fmt::format("no temperature is logged and medium.sigma_mps is {:.3g}: each degree off the site's "
                       "{:.4g} degC makes all ranges {:.2g} % wrong",
                       site_.speed_sigma_mps, site_.medium.temperature_degC, 100 * kSpeedPerDegree));
    }
  }

  void coverage() {
    std::size_t on_odometry = 0, on_poses = 0;
    std::vector<std::pair<double, double>> span(site_.vehicles.size(), {INFINITY, -INFINITY});
    std::vector<double> last(site_.vehicles.size(), NAN);
    for (const OdometryStep& s : run_.odometry) {
      const std::size_t v = s.vehicle.index();
      if (std::isfinite(last[v]))
        h_.odometry.longest_gap_s = std::max(h_.odometry.longest_gap_s, s.time_s - last[v]);
      last[v] = s.time_s;
      span[v] = {std::min(span[v].first, s.time_s), std::max(span[v].second, s.time_s)};
    }
    for (std::size_t i = 1; i < run_.poses.size(); ++i)
      h_.poses.longest_gap_s =
          std::max(h_.poses.longest_gap_s, run_.poses[i].time_s - run_.poses[i - 1].time_s);
    Pose unused;
    for (const Arrival& a : run_.arrivals) {
      on_odometry += a.time_s >= span[a.vehicle.index()].first && a.time_s <= span[a.vehicle.index()].second;
      on_poses += a.vehicle == run_.vehicle &&
                  interpolate_poses(run_.poses, a.time_s, run_.pose_accuracy.max_gap_s, unused);
    }
    const double all = std::max<double>(1.0, static_cast<double>(h_.arrivals));
    h_.odometry.rows = run_.odometry.size();
    h_.odometry.share = static_cast<double>(on_odometry) / all;
    h_.poses.rows = run_.poses.size();
    h_.poses.share = static_cast<double>(on_poses) / all;
    for (const auto& [name, c] :
         {std::pair<std::string, const Coverage&>{"odometry.csv", h_.odometry}, {pose_file(run_), h_.poses}})
      if (name != "points.csv" && c.rows > 0 && h_.arrivals > 0 && c.share < 0.9)  // points have no clock
        find("coverage", fmt::format("{} accompanies {:.0f} % of the arrivals only (longest gap {:.3g} s): "
                                     "do both run on the same clock?",
                                     name, 100 * c.share, c.longest_gap_s));
  }

  const Site& site_;
  const MeasurementLog& run_;
  double first_s_ = 0.0, last_s_ = 0.0;
  RunHealth h_;
};

}  // namespace

std::string pose_file(const MeasurementLog& run) {
  const bool points =
      std::ranges::any_of(run.sha256, [](const auto& file) { return file.first.ends_with("points.csv"); });
  return points ? "points.csv" : "poses.tum";
}

RunHealth log_health(const Site& site, const MeasurementLog& run) { return Examiner(site, run).examine(); }

std::vector<Finding> silent_links(const Site& site, const std::vector<RunHealth>& runs) {
  std::vector<Finding> findings;
  for (std::size_t b = 0; b < site.beacons.size(); ++b) {
    const bool heard =
        std::ranges::any_of(runs, [b](const RunHealth& h) { return h.beacons[b].arrivals > 0; });
    if (!heard)
      findings.push_back({"silent_beacon",
                          fmt::format("beacon {} is in the site but was never heard", site.beacons[b].name)});
  }
  std::map<std::string, std::size_t> heard;
  for (const RunHealth& h : runs)
    for (const LinkHealth& r : h.receivers) heard[r.name] += r.arrivals;
  for (const auto& [name, count] : heard)
    if (count == 0)
      findings.push_back({"deaf_receiver", fmt::format("receiver {} never hears anything", name)});
  return findings;
}

double counter_resolution_s(std::vector<double> values_s) {
  constexpr std::size_t kEnough = 5000, kFew = 50;
  if (values_s.size() < kFew) return 0.0;
  std::vector<double> v;
  const std::size_t count = std::min(values_s.size(), kEnough);
  for (std::size_t i = 0; i < count; ++i) v.push_back(values_s[i * values_s.size() / count]);
  std::ranges::sort(v);
  const double rounding_s = 1e-12 * std::max(std::abs(v.front()), std::abs(v.back()));
  double step_s = INFINITY;
  for (std::size_t i = 1; i < v.size(); ++i)
    if (v[i] - v[i - 1] > rounding_s) step_s = std::min(step_s, v[i] - v[i - 1]);
  if (!std::isfinite(step_s)) return 0.0;
  std::size_t fits = 0;
  double sum_steps = 0.0;
  for (std::size_t i = 1; i < v.size(); ++i) {
    const double steps = (v[i] - v[i - 1]) / step_s;
    fits += std::abs(steps - std::round(steps)) < 0.01;
    sum_steps += std::round(steps);
  }
  if (static_cast<double>(fits) < 0.97 * static_cast<double>(v.size() - 1)) return 0.0;
  return sum_steps > 0 ? (v.back() - v.front()) / sum_steps : 0.0;
}

}  // namespace octant::calib
