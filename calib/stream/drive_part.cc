// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/drive_part.h"

#include <algorithm>
#include <map>
#include <utility>

#include "calib/problem/thin.h"
#include "calib/stream/long_log.h"

namespace octant::calib {
namespace {

/// Stretches of units of a chain.
struct Stretches {
  std::vector<bool> units;
  double stretch_s = 0.0;  ///< of each, from its begin
};

/// At most so many arrivals of each pair, evenly.
void keep_some_of_pairs(std::size_t per_pair, std::vector<Arrival>& arrivals) {
  using Pair = std::pair<int, int>;
  const auto pair_of = [](const Arrival& a) { return Pair(a.beacon.value, a.receiver.value); };
  std::map<Pair, std::size_t> all, met;
  for (const Arrival& a : arrivals) ++all[pair_of(a)];
  std::erase_if(arrivals, [&](const Arrival& a) {
    const std::size_t count = all[pair_of(a)], i = met[pair_of(a)]++;
    return count > per_pair && i * per_pair / count == (i + 1) * per_pair / count;
  });
}

class PartReader {
 public:
  PartReader(const ArrivalSource& source, const DriveIndex& index, MeasurementLog& few)
      : source_(source), index_(index), few_(few) {}

  /// The begins of evenly spread units, then whole ones where a beacon has too little.
  Result<void> read(const DriveChain& chain, const ThinOptions& options) {
    if (chain.arrivals == 0) return {};
    const double drive_s = chain.until_s - chain.units.front().from_s,
                 each = static_cast<double>(chain.arrivals) * options.stretch_s / std::max(drive_s, 1e-9);
    const auto wanted = static_cast<std::size_t>(
        std::max(30.0, static_cast<double>(options.drive_arrivals) / std::max(each, 1e-3)));
    const std::vector<bool> even = evenly_chosen(chain.units.size(), wanted);
    kept_.assign(index_.beacons(), 0);
    if (auto ok = read(chain, {even, options.stretch_s}, options.per_pair); !ok) return ok;
    GroupsHearing hearing;
    hearing.kept = kept_;
    hearing.more.resize(index_.beacons());
    for (std::size_t u = 0; u < chain.units.size(); ++u)
      for (std::size_t b = 0; b < index_.beacons() && !even[u]; ++b)
        if (heard(chain, u, b) > 0) hearing.more[b].push_back(u);
    hearing.for_each_heard = [&](std::size_t unit, const auto& visit) {
      for (std::size_t b = 0; b < index_.beacons(); ++b)
        for (std::uint32_t i = 0; i < heard(chain, unit, b); ++i) visit(b);
    };
    std::vector<bool> more = even;
    choose_more(hearing, options.per_beacon, more);
    for (std::size_t u = 0; u < more.size(); ++u) more[u] = more[u] && !even[u];
    return read(chain, {more, INFINITY}, options.per_pair);
  }

  [[nodiscard]] const std::vector<std::pair<double, double>>& spans() const { return spans_; }

 private:
  [[nodiscard]] std::uint32_t heard(const DriveChain& chain, std::size_t unit, std::size_t beacon) const {
    return chain.heard[unit * index_.beacons() + beacon];
  }

  Result<void> read(const DriveChain& chain, const Stretches& stretches, std::size_t per_pair) {
    std::vector<Arrival> rows;
    for (std::size_t u = 0; u < stretches.units.size(); ++u) {
      if (!stretches.units[u] || chain.units[u].arrivals == 0) continue;
      if (auto ok = index_.read(source_, chain, u, u + 1, rows); !ok) return ok;
      const double until_s = rows.empty() ? 0.0 : rows.front().time_s + stretches.stretch_s;
      std::erase_if(rows, [until_s](const Arrival& a) { return a.time_s > until_s; });
      if (rows.empty()) continue;
      keep_some_of_pairs(per_pair, rows);
      spans_.emplace_back(rows.front().time_s, rows.back().time_s);
      for (const Arrival& a : rows) ++kept_[a.beacon.index()];
      few_.arrivals.insert(few_.arrivals.end(), rows.begin(), rows.end());
    }
    return {};
  }

  const ArrivalSource& source_;
  const DriveIndex& index_;
  MeasurementLog& few_;
  std::vector<std::size_t> kept_;
  std::vector<std::pair<double, double>> spans_;
};

}  // namespace

Result<Problem> part_of(const Site& site, const ArrivalSource& source, const DriveIndex& index, int threads) {
  std::vector<MeasurementLog> runs;
  for (std::size_t run = 0; run < source.runs(); ++run) {
    MeasurementLog few = without_lists(source.log(run));
    few.rejected = source.log(run).rejected;
    std::vector<OdometryStep> odometry;
    for (const DriveChain& chain : index.chains()) {
      if (chain.run != run) continue;
      PartReader reader(source, index, few);
      if (auto ok = reader.read(chain, kPartOfLongLog); !ok) return fail(ok.error());
      std::vector<std::pair<double, double>> spans = reader.spans();
      std::sort(spans.begin(), spans.end());
      const std::vector<OdometryStep> some = thinned_odometry(source.log(run).odometry, chain.vehicle, spans);
      odometry.insert(odometry.end(), some.begin(), some.end());
    }
    std::stable_sort(odometry.begin(), odometry.end(),
                     [](const OdometryStep& a, const OdometryStep& b) { return a.time_s < b.time_s; });
    std::stable_sort(few.arrivals.begin(), few.arrivals.end(), [](const Arrival& a, const Arrival& b) {
      return a.time_s != b.time_s ? a.time_s < b.time_s : a.line < b.line;
    });
    few.odometry = std::move(odometry);
    runs.push_back(std::move(few));
  }
  return make_problem(site, std::move(runs), threads);
}

}  // namespace octant::calib
