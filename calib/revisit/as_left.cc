// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/revisit/as_left.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calib/problem/ranges.h"
#include "calib/verdict/validity.h"
#include "models/changes/deployment_number.h"
#include "models/support/decompositions.h"

namespace octant::calib {
namespace {

/// Known parameters after the visit; rows of fixed parameters are zero.
struct Posterior {
  Eigen::VectorXd value;
  Eigen::MatrixXd covariance;
  std::vector<int> free;
};

Posterior posterior_of(const KnownParameters& known, const Eigen::VectorXd& drift,
                       const Eigen::MatrixXd& released, const VisitInformation& visit) {
  Posterior out{known.value, Eigen::MatrixXd::Zero(known.size(), known.size()), {}};
  for (Eigen::Index i = 0; i < known.size(); ++i)
    if (known.covariance(i, i) > 0 || released(i, i) > 0) out.free.push_back(static_cast<int>(i));
  if (out.free.empty()) return out;
  Eigen::MatrixXd P = known.covariance + released;
  P.diagonal() += drift;
  const Updated updated =
      updated_by(P(out.free, out.free), visit.N(out.free, out.free), visit.gradient(out.free));
  out.covariance(out.free, out.free) = updated.covariance;
  out.value(out.free) += updated.step;
  return out;
}

void write_parameters(const KnownParameters& known, const Posterior& posterior, Deployment& d) {
  for (Eigen::Index i = 0; i < known.size(); ++i) {
    const ParameterId& p = known.parameters[static_cast<std::size_t>(i)];
    set_number(p, {posterior.value[i], std::sqrt(std::max(0.0, posterior.covariance(i, i)))}, d);
    if (p.kind == ParameterKind::kBeaconPosition && p.component == 0)
      d.beacons[p.owner].covariance_m2 = posterior.covariance.block<3, 3>(i, i);
  }
  d.covariance.parameters.clear();
  for (const int i : posterior.free)
    d.covariance.parameters.push_back(known.parameters[static_cast<std::size_t>(i)]);
  d.covariance.matrix = posterior.covariance(posterior.free, posterior.free);
}

/// Removes control points that moved from the datum.
void write_datum(Deployment& d) {
  std::vector<std::string> still;
  for (const DeploymentBeacon& b : d.beacons)
    if (b.status == BeaconStatus::kControlPoint) still.push_back(b.name);
  if (still == d.datum.control_points) return;
  const std::string was = d.datum.description;
  d.datum.control_points = still;
  d.datum.description = fmt::format("as found earlier ({}), held by the control points that stayed: {}", was,
                                    fmt::join(still, ", "));
}

}  // namespace

AsLeft as_left(const Deployment& before, const KnownParameters& known, const Eigen::VectorXd& drift,
               const Comparison& comparison, const VisitInformation& visit, double tolerance_m) {
  AsLeft out;
  Deployment& d = out.deployment;
  d = before;
  const Eigen::MatrixXd released =
      released_covariance(known, changed_parameters(comparison, known), before.motion);
  const Posterior posterior = posterior_of(known, drift, released, visit);
  for (Eigen::Index i = 0; i < known.size(); ++i) {
    const ParameterId& p = known.parameters[static_cast<std::size_t>(i)];
    if (p.kind == ParameterKind::kBeaconPosition && released(i, i) > 0)
      d.beacons[p.owner].status = BeaconStatus::kCalibrated;
    if (p.kind == ParameterKind::kBeaconDelay && posterior.covariance(i, i) > 0)
      d.timing.delay_per.beacon = true;
    if (p.kind == ParameterKind::kSpeed)
      out.speed_change_sigma_mps = std::sqrt(std::max(0.0, posterior.covariance(i, i)));
  }
  d.timing.delay_per.site = d.timing.delay_per.site && !d.timing.delay_per.beacon;
  write_parameters(known, posterior, d);
  for (DeploymentBeacon& b : d.beacons) {
    if (b.status != BeaconStatus::kCalibrated) continue;
    const double worst_m =
        std::sqrt(std::max(0.0, SymmetricEigen<Eigen::Matrix3d>(b.covariance_m2).eigenvalues()[2]));
    if (worst_m <= tolerance_m) continue;
    b.status = BeaconStatus::kUndetermined;
    out.warnings.push_back(
        fmt::format("beacon {} changed, and this visit determines its position to {:.2g} m only, the "
                    "tolerance is {:.2g} m: localizers leave it out; record more stops on all sides of it",
                    b.name, worst_m, tolerance_m));
  }
  write_datum(d);
  return out;
}

MediumFound thermometer_of(const Deployment& d, const std::vector<MeasurementLog>& runs) {
  MediumFound out;
  double sum = 0.0;
  std::size_t count = 0, all = 0;
  for (const MeasurementLog& run : runs)
    for (const Arrival& a : run.arrivals) {
      ++all;
      const std::optional<double> degC = measured_temperature_degC(a, run);
      if (!degC) continue;
      sum += *degC;
      ++count;
    }
  out.temperature_known = d.medium.model == MediumModel::kConstant || count == all;
  out.temperature_degC = count > 0 ? sum / static_cast<double>(count) : d.medium.temperature_degC;
  return out;
}

void extend_validity(Deployment& d, const std::vector<Trajectory>& trajectories, const Problem& problem,
                     bool temperature_known) {
  LogExtent extent{d.validity_area_m};
  if (d.validity_heights_m) {
    extent.lowest_m = d.validity_heights_m->front();
    extent.highest_m = d.validity_heights_m->back();
  }
  for (const Trajectory& t : trajectories) extent.include(extent_of(t, problem.runs[t.run], problem.site));
  if (d.validity_temperature_degC && temperature_known) {
    auto& [coldest, hottest] = *d.validity_temperature_degC;
    coldest = std::min(coldest, extent.coldest_degC);
    hottest = std::max(hottest, extent.hottest_degC);
  }
  set_valid_space(std::move(extent), d);
  if (const auto now_m = heard_reach_m(trajectories, d.beacons))
    d.validity_reach_m = std::max(*now_m, d.validity_reach_m.value_or(0.0));
}

}  // namespace octant::calib
