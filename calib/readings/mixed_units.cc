// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/readings/mixed_units.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "calib/problem/ranges.h"
#include "calib/problem/unit_check.h"

namespace octant::calib {
namespace {

constexpr double kOnePlaceS = 0.25, kQuickestMps = 5.0;
constexpr std::size_t kRowsOfOnePlace = 40;  ///< consecutive arrivals that may belong to one place
constexpr std::size_t kBracketPairs = 10;    ///< pairs of ranges for a bracket
/// Quantiles of sums and differences that exclude echoes and early arrivals.
constexpr double kEarlySums = 0.05, kLateDifferences = 0.2;
/// Share of the distance, because positions, speed and delays are approximate
constexpr double kStatedSlack = 0.03;
/// Share of the distance; a larger violation of a bracket counts the same
constexpr double kWorstBreak = 0.25;
constexpr double kFarBetter = 0.3;          ///< share of the violation with metres for all
constexpr double kIndifferentShare = 0.05;  ///< share of it; a beacon that changes less may be in either unit
constexpr std::size_t kMostShares = 8;
/// Number of beacons above which the search has two starting points only, because its cost is cubic.
constexpr std::size_t kMostStarts = 40;

/// Bounds on the distance of two beacons by ranges from the same places.
struct Bracket {
  std::size_t a, b;
  double least_m, most_m;
};

/// Sums and differences of two beacons' ranges, corrected for the possible distance of the places.
struct Ranges {
  std::vector<double> sums, differences;
};

void add_pairs(const Site& site, const MeasurementLog& run,
               std::map<std::pair<std::size_t, std::size_t>, Ranges>& of) {
  double array_m = 0.0;
  for (const SiteReceiver& r : site.receivers) array_m = std::max(array_m, r.position_m.head<2>().norm());
  for (std::size_t i = 0; i < run.arrivals.size(); ++i)
    for (std::size_t j = i + 1; j < std::min(run.arrivals.size(), i + kRowsOfOnePlace); ++j) {
      const Arrival &a = run.arrivals[i], &b = run.arrivals[j];
      if (a.vehicle != b.vehicle || a.beacon == b.beacon) continue;
      if (run.has_epochs ? a.epoch != b.epoch : b.time_s - a.time_s > kOnePlaceS) break;
      const double apart_m = (a.receiver == b.receiver ? 0.0 : 2 * array_m) +
                             (run.has_epochs ? 0.0 : kQuickestMps * (b.time_s - a.time_s));
      const double ra_m = stated_range_m(site, run, a), rb_m = stated_range_m(site, run, b);
      if (!std::isfinite(ra_m) || !std::isfinite(rb_m)) continue;
      Ranges& ranges = of[std::minmax(a.beacon.index(), b.beacon.index())];
      ranges.sums.push_back(ra_m + rb_m + apart_m);
      ranges.differences.push_back(std::abs(ra_m - rb_m) - apart_m);
    }
}

/// Assignments of beacons to units, and their violations of the brackets.
class Shares {
 public:
  Shares(const Site& site, const std::vector<MeasurementLog>& runs, const LengthUnit& unit)
      : places_(site.beacons.size()), placed_(site.beacons.size(), false), unit_(unit) {
    for (std::size_t b = 0; b < placed_.size(); ++b) {
      const auto place = site.beacons[b].place_m();
      placed_[b] = place.has_value();
      places_[b] = place.value_or(Eigen::Vector3d::Zero());
    }
    std::map<std::pair<std::size_t, std::size_t>, Ranges> of;
    for (const MeasurementLog& run : runs) add_pairs(site, run, of);
    for (const auto& [pair, ranges] : of)
      if (ranges.sums.size() >= kBracketPairs && placed_[pair.first] && placed_[pair.second])
        brackets_.push_back({pair.first, pair.second, quantile(ranges.differences, 1 - kLateDifferences),
                             quantile(ranges.sums, kEarlySums)});
    of_beacon_.resize(placed_.size());
    for (std::size_t k = 0; k < brackets_.size(); ++k)
      for (const std::size_t b : {brackets_[k].a, brackets_[k].b}) of_beacon_[b].push_back(k);
  }

  [[nodiscard]] const std::vector<bool>& placed() const { return placed_; }

  /// Total violation; each bracket counts at most one.
  [[nodiscard]] double broken(const std::vector<bool>& in_unit) const {
    double sum = 0.0;
    for (const Bracket& k : brackets_) sum += broken(k, in_unit);
    return sum;
  }

  /// Descent from an assignment, one beacon at a time.
  [[nodiscard]] std::vector<bool> descended(std::vector<bool> in_unit) const {
    for (;;) {
      std::size_t flip = in_unit.size();
      double best = 0.0;
      for (std::size_t b = 0; b < in_unit.size(); ++b) {
        if (!placed_[b]) continue;
        const double as_is = broken_of(b, in_unit);
        in_unit[b] = !in_unit[b];
        if (const double gain = as_is - broken_of(b, in_unit); gain > best + 1e-9) {
          best = gain;
          flip = b;
        }
        in_unit[b] = !in_unit[b];
      }
      if (flip == in_unit.size()) return in_unit;
      in_unit[flip] = !in_unit[flip];
    }
  }

  /// Best descent from several starts: all in metres, all in the unit, and at small sites each beacon alone
  /// in either unit.
  [[nodiscard]] std::vector<bool> best() const {
    const std::vector<bool> none(placed_.size(), false);
    std::vector<std::vector<bool>> starts = {none, placed_};
    for (std::size_t b = 0; b < none.size() && none.size() <= kMostStarts; ++b)
      for (const std::vector<bool>& start : {none, placed_}) {
        starts.push_back(start);
        if (placed_[b]) starts.back()[b] = !starts.back()[b];
      }
    std::vector<bool> best = none;
    for (std::vector<bool>& start : starts)
      if (std::vector<bool> found = descended(std::move(start)); broken(found) < broken(best) - 1e-9)
        best = std::move(found);
    return best;
  }

 private:
  [[nodiscard]] double broken(const Bracket& k, const std::vector<bool>& in_unit) const {
    const auto place = [&](std::size_t b) -> Eigen::Vector3d {
      return (in_unit[b] ? unit_.metres : 1.0) * places_[b];
    };
    const double d_m = (place(k.a) - place(k.b)).norm();
    const double off_m =
        std::max({0.0, d_m * (1 - kStatedSlack) - k.most_m, k.least_m - d_m * (1 + kStatedSlack)});
    return std::min(1.0, off_m / (kWorstBreak * std::max(k.most_m, 1e-9)));
  }
  /// Brackets of one beacon.
  [[nodiscard]] double broken_of(std::size_t beacon, const std::vector<bool>& in_unit) const {
    double sum = 0.0;
    for (const std::size_t k : of_beacon_[beacon]) sum += broken(brackets_[k], in_unit);
    return sum;
  }

  std::vector<Eigen::Vector3d> places_;
  std::vector<bool> placed_;
  LengthUnit unit_;
  std::vector<Bracket> brackets_;
  std::vector<std::vector<std::size_t>> of_beacon_;  ///< indices of the brackets of each beacon
};

}  // namespace

std::vector<std::vector<bool>> beacons_in_unit_by_ranges(const Site& site,
                                                         const std::vector<MeasurementLog>& runs,
                                                         const LengthUnit& unit) {
  const Shares shares(site, runs, unit);
  const std::vector<bool> none(site.beacons.size(), false);
  const double as_stated = shares.broken(none);
  if (as_stated == 0.0) return {};
  const std::vector<bool> best = shares.best();
  const double least = shares.broken(best);
  if (least > kFarBetter * as_stated || best == none || best == shares.placed()) return {};
  std::vector<std::vector<bool>> all = {best};
  for (std::size_t b = 0; b < best.size() && all.size() < kMostShares; ++b) {
    std::vector<bool> other = best;
    other[b] = !other[b];
    if (!shares.placed()[b] || shares.broken(other) > least + kIndifferentShare * as_stated) continue;
    for (std::size_t k = 0, known = all.size(); k < known; ++k) {
      all.push_back(all[k]);
      all.back()[b] = !all.back()[b];
    }
  }
  std::erase_if(all,
                [&](const std::vector<bool>& share) { return share == none || share == shares.placed(); });
  return all;
}

bool are_all_in_unit_by_ranges(const Site& site, const std::vector<MeasurementLog>& runs,
                               const LengthUnit& unit) {
  const Shares shares(site, runs, unit);
  return shares.broken(shares.placed()) <
         kFarBetter * shares.broken(std::vector<bool>(site.beacons.size(), false));
}

}  // namespace octant::calib
