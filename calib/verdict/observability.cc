// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/verdict/observability.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "calib/adjust/information.h"
#include "calib/adjust/priors.h"
#include "calib/problem/ranges.h"
#include "calib/verdict/datum.h"
#include "calib/verdict/fix_shift.h"
#include "calib/verdict/undetermined_words.h"
#include "calib/verdict/weak_directions.h"
#include "models/support/decompositions.h"

namespace octant::calib {
namespace {

/// Standard deviation of the worst direction of a beacon, in metres.
double worst_sigma_m(const Eigen::Matrix3d& covariance_m2) {
  return std::sqrt(
      std::max(0.0, SymmetricEigen<Eigen::Matrix3d>(covariance_m2, Eigen::EigenvaluesOnly).eigenvalues()[2]));
}

double sigma_of(const Covariance& C, int column) {
  return column < 0 ? 0.0 : std::sqrt(std::max(0.0, C(column, column)));
}

class Judge {
 public:
  Judge(const Problem& problem, const Estimate& estimate, const Covariance& C,
        const std::vector<Trajectory>& trajectories, Solution& solution)
      : problem_(problem),
        site_(problem.site),
        estimate_(estimate),
        layout_(estimate.layout),
        C_(C),
        trajectories_(trajectories),
        solution_(solution),
        limit_m_(tolerance_m(problem)),
        fix_limit_m_(site_.tolerance.fix_m.value_or(limit_m_)) {}

  void beacons() {
    std::vector<std::size_t> heard(site_.beacons.size(), 0);
    for (const Trajectory& t : trajectories_) {
      for (const ArrivalObservation& a : t.arrivals) ++heard[a.beacon.index()];
      for (const BearingObservation& b : t.bearings)
        if (b.reflector.valid()) ++heard[b.reflector.index()];
    }
    for (std::size_t b = 0; b < site_.beacons.size(); ++b) {
      BeaconStatus status = BeaconStatus::kCalibrated;
      const double sigma_m = worst_sigma_m(C_.block(layout_.beacon[b]));
      const int delay = layout_.column_of(parameters::beacon_delay(b));
      if (site_.beacons[b].is_control_point()) {
        status = BeaconStatus::kControlPoint;
      } else {
        ++asked_;
        if (heard[b] == 0) {
          status =
              undetermined(b, "it was not heard", "drive within its range, or check that it sends", INFINITY);
        } else if (!estimate_.beacon_usable[b]) {
          status = undetermined(b, "too few arrivals agree on a place for it",
                                "record it from more positions, or give its approximate position", INFINITY);
        } else if (sigma_m > limit_m_) {
          status = uncertain(b, sigma_m);
        } else if (sigma_of(C_, delay) > limit_m_ && is_felt(delay)) {
          status = undetermined(b,
                                fmt::format("its delay is known to {} of range only, the tolerance is {}",
                                            length_in_words(sigma_of(C_, delay)), length_in_words(limit_m_)),
                                "record it from near and from far, or measure its delay at a known distance",
                                sigma_of(C_, delay));
        } else if (estimate_.beacon_mirrored[b]) {
          status = undetermined(b, "a mirror image explains the arrivals as well",
                                "give its position more accurately (its height, or its side of the line "
                                "driven), or record stops off that line",
                                sigma_m);
        }
      }
      solution_.beacon_status.push_back(status);
    }
    for (std::string& warning : warnings_of(undetermined_, limit_m_))
      solution_.warnings.push_back(std::move(warning));
  }

  void common_parameters() {
    const double range_m = typical_range_m(problem_);
    for (const int column : layout_.speed) {
      const double sigma_m = sigma_of(C_, column) * range_m;
      if (sigma_m > limit_m_)
        weigh(
            {"speed of sound and overall scale",
             {name_of(column)},
             sigma_m,
             sigma_m,
             "tape the distance between two beacons, or state the temperature and a smaller medium.sigma_mps",
             true},
            Eigen::VectorXd::Unit(layout_.size(), column));
    }
    const int common_delay = layout_.column_of(parameters::site_delay());
    if (const double sigma_m = sigma_of(C_, common_delay); sigma_m > limit_m_)
      weigh({"the common delay",
             {name_of(common_delay)},
             sigma_m,
             sigma_m,
             "record the beacons from near and from far, or measure the delay at a known distance",
             true},
            Eigen::VectorXd::Unit(layout_.size(), common_delay));
    for (std::size_t r = 0; r < layout_.receiver.size(); ++r) receiver(r);
  }

  void verdict(bool strict) {
    const auto count =
        static_cast<std::size_t>(std::ranges::count(solution_.beacon_status, BeaconStatus::kUndetermined));
    const bool too_many = count > 0 && 2 * count >= asked_;
    if (!blocked_ && !too_many && !(strict && count > 0)) return;  // status remains: converged or not
    solution_.status = SolveStatus::kUndetermined;
    std::vector<std::string> what, remedies;
    if (too_many || strict) what = in_groups(undetermined_, limit_m_);
    for (const WeakDirection& w : solution_.weak) {
      if (!w.blocking && !(w.lone_beacon && (too_many || strict))) continue;
      if (!w.lone_beacon) what.push_back(w.description);
      if (std::ranges::find(remedies, w.remedy) == remedies.end()) remedies.push_back(w.remedy);
    }
    solution_.message = fmt::format("the data do not determine {}; nothing is exported. To resolve this: {}",
                                    fmt::join(what, "; "), fmt::join(remedies, "; "));
  }

 private:
  [[nodiscard]] std::string name_of(int column) const {
    return parameter_name(layout_.parameter(column).id, names_of(site_));
  }

  /// A position that is not known to the tolerance, or only its height.
  BeaconStatus uncertain(std::size_t b, double sigma_m) {
    const std::array<int, 3>& columns = layout_.beacon[b];
    const bool is_height =
        columns[2] >= 0 && worst_sigma_m(C_.block(std::array{columns[0], columns[1], -1})) <= limit_m_;
    return undetermined(
        b,
        fmt::format(
            "its {} is {}, the tolerance is {}", is_height ? "height" : "position",
            sigma_m < kNothingM ? "known to " + length_in_words(sigma_m) + " only" : "hardly known at all",
            length_in_words(limit_m_)),
        is_height ? "measure its height and state it with a sigma_m, or record at places close to it as well"
                  : "record more stops on all sides of it, or tape its distance to a control point",
        sigma_m);
  }

  BeaconStatus undetermined(std::size_t b, const std::string& why, const std::string& remedy,
                            double sigma_m) {
    const std::string name = owner_name(parameters::beacon_delay(b), names_of(site_));
    const std::string& beacon = site_.beacons[b].name;
    solution_.undetermined.push_back(name);
    undetermined_.push_back(
        {beacon, why, remedy, std::isfinite(sigma_m) && sigma_m > limit_m_ ? sigma_m : 0.0});
    solution_.weak.push_back(
        {fmt::format("beacon {} ({})", beacon, why), {name}, sigma_m, 0.0, remedy, false, true});
    return BeaconStatus::kUndetermined;
  }

  /// Returns true if the uncertainty of a parameter, with all correlated parameters, moves fixes by more than
  /// their tolerance. Delays that beacons and receivers can exchange have no effect.
  [[nodiscard]] bool is_felt(int column) const {
    const Eigen::VectorXd with_it = C_.times(Eigen::VectorXd::Unit(layout_.size(), column));
    if (!(sigma_of(C_, column) < typical_range_m(problem_))) return true;
    const std::optional<double> fix_m =
        fix_shift_m(layout_, estimate_.x, estimate_.x + with_it / std::sqrt(with_it[column]), trajectories_);
    return !fix_m || *fix_m > fix_limit_m_;
  }

  void block(WeakDirection direction) {
    blocked_ = true;
    for (const std::string& name : direction.parameters) solution_.undetermined.push_back(name);
    solution_.weak.push_back(std::move(direction));
  }

  /// Refuses a direction whose sigma exceeds the tolerance if it affects the site: it moves a beacon or a
  /// typical fix, together with all correlated parameters, by more than its tolerance. A direction without
  /// such an effect is only reported.
  void weigh(WeakDirection direction, const Eigen::VectorXd& v) {
    const Eigen::VectorXd with_it = C_.times(v);
    const double variance = v.dot(with_it);
    direction.consequence_m = INFINITY;
    // Larger deviations cannot be predicted
    if (direction.sigma_m < typical_range_m(problem_) && variance > 0) {
      const Eigen::VectorXd step = with_it / std::sqrt(variance);
      const std::optional<double> fix_m =
          fix_shift_m(layout_, estimate_.x, estimate_.x + step, trajectories_);
      if (fix_m && *fix_m <= fix_limit_m_ && largest_beacon_shift_m(step) <= limit_m_) {
        direction.consequence_m = *fix_m;
        direction.blocking = false;
        solution_.weak.push_back(std::move(direction));
        return;
      }
      if (fix_m) direction.consequence_m = *fix_m;
    }
    if (!std::isfinite(direction.consequence_m)) direction.consequence_m = direction.sigma_m;
    block(std::move(direction));
  }

  [[nodiscard]] double largest_beacon_shift_m(const Eigen::VectorXd& step) const {
    double largest_m = 0.0;
    for (std::size_t b = 0; b < layout_.beacon.size(); ++b) {
      if (solution_.beacon_status[b] == BeaconStatus::kUndetermined) continue;  // localizers do not use it
      Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();
      for (std::size_t i = 0; i < 3; ++i)
        if (layout_.beacon[b][i] >= 0) shift_m[static_cast<int>(i)] = step[layout_.beacon[b][i]];
      largest_m = std::max(largest_m, shift_m.norm());
    }
    return largest_m;
  }

  /// Directions of an array whose prior alone would be insufficient and that the data did not improve.
  void receiver(std::size_t r) {
    std::vector<int> columns;
    for (const int column : layout_.receiver[r]) columns.push_back(column);
    const std::size_t vehicle = site_.receivers[r].vehicle.index();
    columns.push_back(layout_.column_of(parameters::array_radius(vehicle)));
    columns.push_back(layout_.column_of(parameters::array_turn(vehicle)));
    columns.push_back(layout_.column_of(parameters::receiver_delay(r)));
    columns.erase(std::remove_if(columns.begin(), columns.end(), [](int c) { return c < 0; }), columns.end());
    const double limit_m = std::max(limit_m_, fix_limit_m_);
    const bool known = std::ranges::all_of(columns, [&](int c) { return sigma_of(C_, c) <= limit_m; });
    if (known || columns.empty()) return;
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(C_.block(columns));
    const SiteReceiver& receiver = site_.receivers[r];
    for (Eigen::Index k = eigen.eigenvalues().size(); k-- > 0;) {
      const double sigma_m = std::sqrt(std::max(0.0, eigen.eigenvalues()[k]));
      if (sigma_m <= limit_m) break;
      Eigen::VectorXd v = Eigen::VectorXd::Zero(layout_.size());
      for (std::size_t i = 0; i < columns.size(); ++i)
        v[columns[i]] = eigen.eigenvectors()(static_cast<Eigen::Index>(i), k);
      weigh({fmt::format("receiver {} of {}", receiver.name, site_.vehicles[receiver.vehicle.index()].name),
             {owner_name(parameters::receiver_delay(r), names_of(site_))},
             sigma_m,
             sigma_m,
             "measure its place on the vehicle, or turn the vehicle on the spot among the beacons",
             true},
            v);
    }
  }

  const Problem& problem_;
  const Site& site_;
  const Estimate& estimate_;
  const ParameterLayout& layout_;
  const Covariance& C_;
  const std::vector<Trajectory>& trajectories_;
  Solution& solution_;
  double limit_m_, fix_limit_m_;
  std::size_t asked_ = 0;
  std::vector<UndeterminedBeacon> undetermined_;
  bool blocked_ = false;
};

}  // namespace

namespace {

/// Marginals of a covariance that is not formed as a whole: the parameters of each beacon, and all others
/// together.
MarginalCovariance marginals_of(const ParameterLayout& layout, const Covariance& C) {
  MarginalCovariance out;
  std::vector<std::vector<int>> groups(layout.beacon.size() + 1);
  std::vector<bool> of_beacon(static_cast<std::size_t>(layout.size()), false);
  for (std::size_t b = 0; b < layout.beacon.size(); ++b)
    for (const int column : layout.columns_of_beacon(b))
      if (column >= 0) {
        groups[b].push_back(column);
        of_beacon[static_cast<std::size_t>(column)] = true;
      }
  // Biases of pairs are separate, because there are as many as pairs with arrivals.
  for (int column = 0; column < layout.size(); ++column)
    if (layout.parameter(column).id.kind == ParameterKind::kPairBias) {
      groups.push_back({column});
      of_beacon[static_cast<std::size_t>(column)] = true;
    }
  for (int column = 0; column < layout.size(); ++column) {
    out.parameters.push_back(layout.parameter(column).id);
    if (!of_beacon[static_cast<std::size_t>(column)]) groups[layout.beacon.size()].push_back(column);
  }
  std::vector<Eigen::Triplet<double>> elements;
  for (const std::vector<int>& group : groups)
    for (const int i : group)
      for (const int j : group)
        elements.emplace_back(i, j,
                              layout.parameter(i).si_per_unit * C(i, j) * layout.parameter(j).si_per_unit);
  out.matrix.resize(layout.size(), layout.size());
  out.matrix.setFromTriplets(elements.begin(), elements.end());
  return out;
}

/// Covariance from data and priors. Notes an undefined datum.
template <class Matrix>
Covariance covariance_of(const Problem& problem, const ParameterLayout& layout, const Matrix& information,
                         Solution& solution) {
  const Eigen::MatrixXd datum = free_datum(problem, layout, solution.state, information);
  if (datum.cols() > 0) set_free_network(solution.datum);
  return Covariance(information, datum);
}

Covariance covariance_at(const Problem& problem, const SolveOptions& options, const Estimate& estimate,
                         std::vector<Trajectory>& trajectories, Solution& solution) {
  const ParameterLayout& layout = estimate.layout;
  if (!is_dense(layout)) {
    Covariance C = covariance_of(
        problem, layout,
        estimate.last.data
            ? sparse_information(problem, layout, estimate.x, estimate.last.data->parts())
            : sparse_information_at(problem, layout, trajectories, estimate.x, options.workers()),
        solution);
    solution.marginals = marginals_of(layout, C);
    solution.warnings.push_back(
        fmt::format("the joint covariance of {} parameters is left out of the deployment, which holds each "
                    "beacon's own; sigmas of fixes by least "
                    "squares leave the calibration's part out",
                    layout.size()));
    return C;
  }
  const Eigen::MatrixXd data =
      estimate.last.data ? estimate.last.data->whole(layout.size()).H
                         : information_at(problem, layout, trajectories, estimate.x, options.workers()).data;
  Covariance C = covariance_of(
      problem, layout, Eigen::MatrixXd(data + prior_information(problem, layout, estimate.x)), solution);
  const Eigen::VectorXd si = layout.si_per_unit();
  for (const Parameter& p : layout.parameters) solution.covariance.parameters.push_back(p.id);
  solution.covariance.matrix = si.asDiagonal() * *C.matrix() * si.asDiagonal();
  return C;
}

}  // namespace

Covariance judge(const Problem& problem, const SolveOptions& options, const Estimate& estimate,
                 std::vector<Trajectory>& trajectories, Solution& solution) {
  Covariance C = covariance_at(problem, options, estimate, trajectories, solution);
  Judge judge(problem, estimate, C, trajectories, solution);
  judge.beacons();
  judge.common_parameters();
  std::vector<bool> known;
  for (const BeaconStatus status : solution.beacon_status)
    known.push_back(status != BeaconStatus::kUndetermined);
  for (WeakDirection& w :
       weak_directions(estimate.layout, names_of(problem.site), estimate.x, C, known, trajectories,
                       {.limit_m = tolerance_m(problem), .typical_range_m = typical_range_m(problem)}))
    solution.weak.push_back(std::move(w));
  judge.verdict(options.strict);
  return C;
}

}  // namespace octant::calib
