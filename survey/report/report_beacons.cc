// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include <fmt/format.h>

#include "models/support/decompositions.h"
#include "survey/geometry/quantity.h"
#include "survey/report/report_sections.h"

namespace octant::survey {
namespace {

constexpr double kFarMoved = 4.0;  // times the stated sigma: no chance in three dimensions (p = 0.001)
constexpr double kCoverage = 2.0;  // U = k sigma, some 95 %

double sigma_m(const DeploymentBeacon& beacon, int axis) {
  return std::sqrt(std::max(0.0, beacon.covariance_m2(axis, axis)));
}

/// Units of the columns, each chosen by the column's largest number.
struct ColumnUnits {
  Unit length, time, mdb, shift, late;
};

ColumnUnits units_of(const ReportInput& input) {
  double length_m = 0.0, time_s = 0.0, mdb_s = 0.0, shift_m = 0.0, late_s = 0.0;
  for (const auto& b : input.plan.deployment.beacons) {
    if (b.status == BeaconStatus::kUndetermined) continue;
    for (int i = 0; i < 3; ++i) length_m = std::max(length_m, kCoverage * sigma_m(b, i));
    time_s = std::max({time_s, std::abs(b.delay_s), kCoverage * b.delay_sigma_s});
  }
  for (const auto& n : input.beacons) {
    mdb_s = std::max({mdb_s, n.mdb_s.value_or(0.0), n.rms_s.value_or(0.0)});
    shift_m = std::max({shift_m, n.influence_m.value_or(0.0), n.lateness_influence_m.value_or(0.0)});
    late_s = std::max(late_s, n.lateness_mdb_s.value_or(0.0));
  }
  return {length_unit(length_m), time_unit(time_s), time_unit(mdb_s), length_unit(shift_m),
          time_unit(late_s)};
}

/// Least well known first where not all have room, otherwise in their order.
std::vector<std::size_t> rows_of(const Deployment& d) {
  std::vector<std::size_t> order(d.beacons.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (order.size() <= kMaxRows) return order;
  const auto badness = [&](std::size_t i) {
    return d.beacons[i].status == BeaconStatus::kUndetermined ? INFINITY : d.beacons[i].covariance_m2.trace();
  };
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return badness(a) > badness(b); });
  order.resize(kMaxRows);
  return order;
}

std::vector<ReportText> row_of(const DeploymentBeacon& b, const BeaconNote* note, const ColumnUnits& units,
                               bool delays) {
  std::vector<ReportText> row = {{b.name}};
  const bool known = b.status != BeaconStatus::kUndetermined;
  for (int i = 0; i < 3; ++i) row.push_back({known ? fmt::format("{:.4f}", b.position_m[i]) : "-"});
  for (int i = 0; i < 3; ++i)
    row.push_back({!known ? "-"
                   : sigma_m(b, i) == 0.0
                       ? "fixed"
                       : fmt::format("{:.2f}", units.length.per_si * kCoverage * sigma_m(b, i))});
  if (delays) {
    row.push_back({known ? fmt::format("{:.3f}", units.time.per_si * b.delay_s) : "-"});
    row.push_back({known ? fmt::format("{:.3f}", units.time.per_si * kCoverage * b.delay_sigma_s) : "-"});
  }
  const bool seen = note != nullptr && note->used > 0;
  row.push_back(number_cell(seen ? std::optional<double>(note->redundancy) : std::nullopt, 1, 2));
  row.push_back(number_cell(seen ? note->mdb_s : std::nullopt, units.mdb.per_si, 1));
  row.push_back({note != nullptr ? std::to_string(note->used) : "-"});
  row.push_back({note != nullptr ? std::to_string(note->rejected) : "-"});
  row.push_back({in_words(b.status), known ? Tone::kPlain : Tone::kBad});
  return row;
}

/// Error of the measured position.
ReportTable moved_table(const ReportInput& input) {
  const Unit unit = length_unit(input.moved.front().distance_m);
  const std::string in = " [" + std::string(unit.symbol) + "]";
  ReportTable table{
      "moved",
      "Moved from the site file: found less stated, farthest first. Up to twice what was stated is as "
      "expected; far beyond it is a slip of the tape, or an exchanged label.",
      {{"beacon", true}, {"dx" + in}, {"dy" + in}, {"dz" + in}, {"known to" + in}, {"stated within" + in}}};
  for (std::size_t i = 0; i < std::min(kMaxRows, input.moved.size()); ++i) {
    const MovedNote& m = input.moved[i];
    const bool far = m.stated_sigma_m && m.distance_m > kFarMoved * *m.stated_sigma_m;
    table.rows.push_back({{m.beacon, far ? Tone::kAttention : Tone::kPlain},
                          number_cell(m.shift_m[0], unit.per_si, 1),
                          number_cell(m.shift_m[1], unit.per_si, 1),
                          number_cell(m.shift_m[2], unit.per_si, 1),
                          number_cell(m.sigma_m, unit.per_si, 1),
                          number_cell(m.stated_sigma_m, unit.per_si, 1)});
  }
  return table;
}

ReportTable reliability_table(const ReportInput& input, const std::vector<std::size_t>& rows,
                              const std::map<std::string, const BeaconNote*>& notes,
                              const ColumnUnits& units) {
  ReportTable table{"reliability",
                    "Residuals of each beacon, and what an error that nobody notices would do. Variance: of "
                    "the residuals over the stated one. "
                    "Lateness: of all arrivals of the beacon alike, smallest that is noticed.",
                    {{"beacon", true},
                     {fmt::format("RMS [{}]", units.mdb.symbol)},
                     {"variance"},
                     {fmt::format("one arrival moves it [{}]", units.shift.symbol)},
                     {fmt::format("lateness [{}]", units.late.symbol)},
                     {fmt::format("that moves it [{}]", units.shift.symbol)},
                     {"95 % ellipse a [mm]"},
                     {"b [mm]"},
                     {"azimuth [deg]"}}};
  for (const std::size_t i : rows) {
    const auto& b = input.plan.deployment.beacons[i];
    const auto at = notes.find(b.name);
    if (at == notes.end() || at->second->used == 0) continue;
    const BeaconNote& n = *at->second;
    std::vector<ReportText> row = {{b.name},
                                   number_cell(n.rms_s, units.mdb.per_si, 2),
                                   number_cell(n.variance_factor, 1, 2),
                                   number_cell(n.influence_m, units.shift.per_si, 2),
                                   number_cell(n.lateness_mdb_s, units.late.per_si, 1),
                                   number_cell(n.lateness_influence_m, units.shift.per_si, 2)};
    if (b.status == BeaconStatus::kCalibrated) {
      const SymmetricEigen<Eigen::Matrix2d> flat(b.covariance_m2.topLeftCorner<2, 2>());
      const Eigen::Vector2d half_mm = 1e3 * kEllipse95 * flat.eigenvalues().cwiseMax(0.0).cwiseSqrt();
      double azimuth = std::atan2(flat.eigenvectors()(1, 1), flat.eigenvectors()(0, 1)) * 180 / M_PI;
      azimuth = azimuth > 90 ? azimuth - 180 : azimuth <= -90 ? azimuth + 180 : azimuth;
      row.insert(row.end(), {{fmt::format("{:.2f}", half_mm[1])},
                             {fmt::format("{:.2f}", half_mm[0])},
                             {fmt::format("{:.0f}", azimuth)}});
    }
    row.resize(table.columns.size(), {"-"});
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace

std::optional<ReportSection> beacons_section(const ReportInput& input) {
  const Deployment& d = input.plan.deployment;
  if (d.beacons.empty()) return {};
  ReportSection section{"beacons", "Beacons"};
  if (input.beacons.empty() &&
      std::ranges::all_of(d.beacons, [](const auto& b) { return b.status == BeaconStatus::kUndetermined; })) {
    section.blocks.emplace_back(ReportText{
        fmt::format("Of none of the {} beacons is the place known.", d.beacons.size()), Tone::kBad});
    return section;
  }
  const ColumnUnits units = units_of(input);
  const bool delays =
      std::ranges::any_of(d.beacons, [](const auto& b) { return b.delay_s != 0.0 || b.delay_sigma_s > 0.0; });
  std::map<std::string, const BeaconNote*> notes;
  for (const auto& note : input.beacons) notes[note.name] = &note;
  const std::string u = units.length.symbol;
  ReportTable table{
      "beacon-table",
      "Positions in the map with their expanded uncertainty U (k = 2, some 95 %); fixed: held where the site "
      "file has it, so its error is not among these figures; r: mean "
      "redundancy number of the arrivals, 0 to 1; "
      "MDB: smallest bias of one arrival that is found (0.1 %, power 80 %).",
      {{"beacon", true},
       {"x [m]"},
       {"y [m]"},
       {"z [m]"},
       {"U x [" + u + "]"},
       {"U y [" + u + "]"},
       {"U z [" + u + "]"}}};
  if (delays)
    table.columns.insert(table.columns.end(),
                         {{"delay [" + units.time.symbol + "]"}, {"U delay [" + units.time.symbol + "]"}});
  table.columns.insert(
      table.columns.end(),
      {{"r"}, {"MDB [" + units.mdb.symbol + "]"}, {"arrivals"}, {"rejected"}, {"status", true}});
  const std::vector<std::size_t> rows = rows_of(d);
  for (const std::size_t i : rows) {
    const auto note = notes.find(d.beacons[i].name);
    table.rows.push_back(row_of(d.beacons[i], note == notes.end() ? nullptr : note->second, units, delays));
  }
  if (rows.size() < d.beacons.size())
    section.blocks.emplace_back(ReportText{
        fmt::format("The {} of {} beacons that are known least well; all are in the deployment file.",
                    rows.size(), d.beacons.size())});
  section.blocks.emplace_back(std::move(table));
  if (!input.moved.empty()) section.blocks.emplace_back(moved_table(input));
  if (ReportTable more = reliability_table(input, rows, notes, units); !more.rows.empty())
    section.blocks.emplace_back(std::move(more));
  return section;
}

}  // namespace octant::survey
