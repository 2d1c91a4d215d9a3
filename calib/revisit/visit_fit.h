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

/// Fit of a second visit under the Gaussian prior of the first one.
class VisitFit {
 public:
  /// A saved fit.
  struct Standing {
    Fit fit;
    ParameterLayout layout;  ///< without the joint prior
    CalibrationStatistics statistics;
    double sigma_s = 0.0;  ///< noise of the arrivals
    [[nodiscard]] double squares() const { return fit.cost * sigma_s * sigma_s; }
  };

  VisitFit(const Deployment& before, const KnownParameters& known, const SolveOptions& options)
      : before_(before), known_(known), options_(options) {}

  /// Solves the states with the earlier parameters, most of which are still correct. False if no state has a
  /// solution.
  bool start_from_known(const Problem& problem);
  /// Approximate states and parameters by the largest consensus of arrivals.
  /// @return the reason if there are none; status kConverged otherwise
  [[nodiscard]] Solution start_from_consensus(const Problem& problem, ProgressMonitor& monitor);

  /// Noise of the arrivals: estimated from the residuals, or fixed. It is never below the expected one,
  /// because the residuals of few arrivals are reduced by the free parameters.
  enum class Noise { kAsFound, kFixed };
  /// Adjusts with all arrivals admitted.
  /// @param P  covariance of the known parameters [SI]
  bool adjust_under(const Eigen::MatrixXd& P, Noise noise = Noise::kAsFound);
  /// Multiplies the noise of the arrivals.
  void scale_noise(double factor);

  /// Solves states without a solution again at the current parameters. At another speed of sound many are
  /// missing at first.
  bool place_missing();
  /// Moves beacons most of whose arrivals disagree to the position given by their own ranges.
  /// @return true if there were any
  bool locate_lost();
  /// Moves a beacon to a position, with its earlier delay.
  void put(std::size_t beacon, const Eigen::Vector3d& p_map_m);
  /// Solves the states at the current parameters.
  /// @param scale  scale of the loss; 0: least squares
  void solve_all_states(double scale);
  /// Half the squares of all arrivals and priors at the current fit.
  [[nodiscard]] double data_cost() const;
  /// Sets the known parameters [SI].
  void move_to(const Eigen::VectorXd& value);
  /// Variances [SI], at least the squared deviations of the parameters from their earlier values.
  [[nodiscard]] Eigen::VectorXd room_around(Eigen::VectorXd room) const;

  [[nodiscard]] std::size_t arrival_count() const;
  Standing now;
  std::string message;  ///< why an adjustment failed

 private:
  void set_start(const Problem& problem, const SharedState& state, std::vector<bool> usable,
                 std::vector<Trajectory> trajectories);
  /// Value of a known parameter [SI] minus its earlier value; 0 if it is fixed.
  [[nodiscard]] double shift_of(Eigen::Index parameter) const;

  const Deployment& before_;
  const KnownParameters& known_;
  const SolveOptions& options_;
  double stated_sigma_s_ = 0.0;
};

}  // namespace octant::calib
