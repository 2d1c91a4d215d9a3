// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/clocks/clock_log.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <span>
#include <tuple>

#include <Eigen/Cholesky>

namespace octant {
namespace {

/// Time in which a vehicle moves little, compared with a wild difference [s].
constexpr double kEarlier_s = 0.5;

using Rows = std::span<const TimeDifference* const>;

/// Beacons that a set of differences connects, with their arrival times relative to the first of them.
struct Potentials {
  std::vector<BeaconId> beacons;
  std::vector<double> after_s;
  std::size_t rows = 0;
};

/// Arrival times by beacon.
using BeaconTimes = std::map<BeaconId, double>;

/// Weights of rows that agree with earlier arrival times are larger: where a few rows form one circle, these
/// decide which of them is wild.
std::vector<double> first_weights(const std::vector<const TimeDifference*>& rows,
                                  const BeaconTimes& earlier) {
  std::vector<double> weight(rows.size(), 1.0), size;
  for (const TimeDifference* row : rows) {
    const auto a = earlier.find(row->a), b = earlier.find(row->b);
    const bool known = a != earlier.end() && b != earlier.end();
    size.push_back(known ? std::abs(row->tdoa_s - (b->second - a->second)) : 0.0);
  }
  std::vector<double> sorted = size;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::ranges::nth_element(sorted, middle);
  if (!(*middle > 0.0)) return weight;
  for (std::size_t i = 0; i < rows.size(); ++i) weight[i] = 1.0 / std::max(size[i] / *middle, 1.0);
  return weight;
}

/// Arrival times from the differences of connected beacons: least sum of absolute residuals, by iteratively
/// reweighted least squares, so that a wild difference has no effect where others contradict it.
void solve_potentials(const std::vector<const TimeDifference*>& rows, const BeaconTimes& earlier,
                      Potentials& p) {
  constexpr int kRounds = 20;
  constexpr double kRelativeFloor = 1e-3;  // of the median residual: keeps the weights finite
  const auto n = static_cast<Eigen::Index>(p.beacons.size());
  const auto index = [&p](BeaconId id) {
    return std::ranges::lower_bound(p.beacons, id) - p.beacons.begin();
  };
  std::vector<double> weight = first_weights(rows, earlier), size(rows.size());
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
  for (int round = 0; round < kRounds; ++round) {
    Eigen::MatrixXd N = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(n);
    N(0, 0) = 1.0;  // the first arrival is the origin
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const Eigen::Index a = index(rows[i]->a), b = index(rows[i]->b);
      N(a, a) += weight[i], N(b, b) += weight[i], N(a, b) -= weight[i], N(b, a) -= weight[i];
      g[a] -= weight[i] * rows[i]->tdoa_s, g[b] += weight[i] * rows[i]->tdoa_s;
    }
    x = N.ldlt().solve(g);
    x.array() -= x[0];
    for (std::size_t i = 0; i < rows.size(); ++i)
      size[i] = std::abs(rows[i]->tdoa_s - (x[index(rows[i]->b)] - x[index(rows[i]->a)]));
    std::vector<double> sorted = size;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::ranges::nth_element(sorted, middle);
    if (!(*middle > 0.0) || static_cast<std::size_t>(n) > rows.size()) break;
    for (std::size_t i = 0; i < rows.size(); ++i)
      weight[i] = 1.0 / std::max(size[i] / *middle, kRelativeFloor);
  }
  p.after_s.assign(x.begin(), x.end());
  p.rows = rows.size();
}

/// One set of arrival times for each connected set of beacons, the largest one first.
std::vector<Potentials> potentials_of(Rows rows, std::size_t beacons, const BeaconTimes& earlier = {}) {
  std::vector<std::size_t> root(beacons);
  std::iota(root.begin(), root.end(), std::size_t{0});
  const auto find = [&root](std::size_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  for (const TimeDifference* row : rows) root[find(row->b.index())] = find(row->a.index());
  std::map<std::size_t, std::vector<const TimeDifference*>> parts;
  for (const TimeDifference* row : rows) parts[find(row->a.index())].push_back(row);
  std::vector<Potentials> all;
  for (const auto& [first, part] : parts) {
    Potentials& p = all.emplace_back();
    for (const TimeDifference* row : part) p.beacons.insert(p.beacons.end(), {row->a, row->b});
    std::ranges::sort(p.beacons);
    p.beacons.erase(std::ranges::unique(p.beacons).begin(), p.beacons.end());
    solve_potentials(part, earlier, p);
  }
  std::ranges::stable_sort(all, {}, [](const Potentials& p) { return -static_cast<int>(p.beacons.size()); });
  return all;
}

/// Calls visit(rows) for each group of consecutive rows of a vehicle that same(first, row) joins.
template <class Same, class Visit>
void for_each_group(const std::vector<TimeDifference>& rows, const Same& same, Visit&& visit) {
  std::vector<const TimeDifference*> order;
  for (const TimeDifference& row : rows) order.push_back(&row);
  std::ranges::stable_sort(order, {}, [](const TimeDifference* r) {
    return std::tuple(r->vehicle, r->receiver, r->epoch, r->time_s);
  });
  for (std::size_t first = 0; first < order.size();) {
    std::size_t last = first + 1;
    const TimeDifference& begin = *order[first];
    while (last < order.size() && order[last]->vehicle == begin.vehicle &&
           order[last]->receiver == begin.receiver && order[last]->epoch == begin.epoch &&
           same(begin, *order[last]))
      ++last;
    visit(Rows(order).subspan(first, last - first));
    first = last;
  }
}

}  // namespace

std::vector<Transmission> transmissions_of(const std::vector<TimeDifference>& rows, std::size_t beacons) {
  std::vector<Transmission> all;
  const auto same = [](const TimeDifference& a, const TimeDifference& b) { return a.time_s == b.time_s; };
  for_each_group(rows, same, [&](Rows group) {
    for (const Potentials& p : potentials_of(group, beacons)) {
      Transmission t{
          group.front()->time_s, group.front()->epoch, device_of(group.front()->receiver, beacons), {}, true};
      for (std::size_t i = 0; i < p.beacons.size(); ++i)
        t.receptions.push_back({device_of(p.beacons[i]), p.after_s[i]});
      all.push_back(std::move(t));
    }
  });
  std::ranges::stable_sort(all, {}, &Transmission::time_s);
  return all;
}

std::vector<Arrival> arrivals_of(const std::vector<TimeDifference>& rows, std::size_t& left_out) {
  std::size_t beacons = 0;
  for (const TimeDifference& row : rows) beacons = std::max({beacons, row.a.index() + 1, row.b.index() + 1});
  std::vector<Arrival> arrivals;
  std::int64_t epoch = 0;
  const auto same = [](const TimeDifference& a, const TimeDifference& b) {
    return a.epoch != kNoEpoch || b.time_s - a.time_s < kDifferenceWindow_s;
  };
  left_out = 0;
  BeaconTimes earlier;
  double earlier_s = -INFINITY;
  for_each_group(rows, same, [&](Rows group) {
    if (std::abs(group.front()->time_s - earlier_s) > kEarlier_s) earlier.clear();
    const Potentials p = potentials_of(group, beacons, earlier).front();
    earlier.clear();
    for (std::size_t i = 0; i < p.beacons.size(); ++i) earlier[p.beacons[i]] = p.after_s[i];
    earlier_s = group.back()->time_s;
    left_out += group.size() - p.rows;
    double time_s = 0.0;
    for (const TimeDifference* row : group) time_s += row->time_s / static_cast<double>(group.size());
    const std::int64_t number = group.front()->epoch != kNoEpoch ? group.front()->epoch : epoch++;
    for (std::size_t i = 0; i < p.beacons.size(); ++i) {
      Arrival a;
      a.time_s = time_s, a.tof_s = p.after_s[i], a.beacon = p.beacons[i], a.epoch = number;
      a.receiver = group.front()->receiver, a.vehicle = group.front()->vehicle, a.line = group.front()->line;
      arrivals.push_back(a);
    }
  });
  std::ranges::stable_sort(arrivals, {}, &Arrival::time_s);
  return arrivals;
}

}  // namespace octant
