// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "calib/calibrate.h"
#include "calib/start/progress_monitor.h"
#include "calib/statements/refit.h"
#include "models/changes/known_parameters.h"
#include "models/deployment.h"

namespace octant::calib {

/// Fit of a second visit under a Gaussian prior of what the first one knew.
class VisitFit {
 public:
  /// A fit that can be returned to.
  struct Standing {
    Fit fit;
    ParameterLayout layout;  ///< without the joint prior
    CalibrationStatistics statistics;
    double sigma_s = 0.0;  ///< noise of the arrivals
    [[nodiscard]] double squares() const { return fit.cost * sigma_s * sigma_s; }
  };

  VisitFit(const Deployment& before, const KnownParameters& known, const SolveOptions& options)
      : before_(before), known_(known), options_(options) {}

  /// Places states by what was known: most of it still holds. False where no state finds a place.
  bool start_from_known(const Problem& problem);
  /// Approximate states and parameters, by what the largest consensus of arrivals agrees on.
  /// @return why there are none; status kConverged where there are some
  [[nodiscard]] Solution start_from_consensus(const Problem& problem, ProgressMonitor& monitor);

  /// Whether the noise of the arrivals follows the residuals. It is never less than stated: few arrivals
  /// leave residuals that are as small as the freedom of the parameters makes them.
  enum class Noise { kAsFound, kFixed };
  /// Adjusts with all arrivals admitted. @param P  covariance of the known parameters [SI]
  bool adjust_under(const Eigen::MatrixXd& P, Noise noise = Noise::kAsFound);
  /// Multiplies the noise of the arrivals.
  void scale_noise(double factor);

  /// Places states that have none, by the parameters as they stand. In other air many are missed at first.
  bool place_missing();
  /// Puts beacons most of whose arrivals do not fit where their own ranges place them.
  /// @return whether there were any
  bool locate_lost();
  /// Puts a beacon to a place, with the delay that it had.
  void put(std::size_t beacon, const Eigen::Vector3d& p_map_m);
  /// Solves the states at the parameters as they stand. @param scale  of the loss; 0: plain squares
  void solve_all_states(double scale);
  /// Half the squares of all arrivals and priors where the fit stands.
  [[nodiscard]] double data_cost() const;
  /// Puts the known parameters to some values [SI].
  void move_to(const Eigen::VectorXd& value);
  /// Variances [SI], at least the squares by which the parameters are off what was known.
  [[nodiscard]] Eigen::VectorXd room_around(Eigen::VectorXd room) const;

  [[nodiscard]] std::size_t arrival_count() const;
  Standing now;
  std::string message;  ///< why an adjustment failed

 private:
  void set_start(const Problem& problem, const SharedState& state, std::vector<bool> usable,
                 std::vector<Trajectory> trajectories);
  /// Value of a known parameter [SI] less the value it had; 0 where it is held.
  [[nodiscard]] double shift_of(Eigen::Index parameter) const;

  const Deployment& before_;
  const KnownParameters& known_;
  const SolveOptions& options_;
  double stated_sigma_s_ = 0.0;
};

}  // namespace octant::calib
