// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to the track of a vehicle in space: its filter and smoother.

#include <cstddef>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "models/localizers/space/space_ranges.h"

namespace octant {

/// Mean and covariance of position, velocity and biases, and the sensitivity of the mean to the calibrated
/// parameters.
struct SpaceBelief {
  Eigen::VectorXd x;
  Eigen::MatrixXd P, M;
};
struct SpaceStep {
  SpaceBelief predicted, updated, smoothed;
  Eigen::MatrixXd F;
};

/// Extended Kalman filter and smoother (Rauch, Tung and Striebel 1965) over consecutive instants, with
/// white-noise acceleration.
class SpaceFilter {
 public:
  /// @param density  spectral density of the acceleration [m^2/s^3]
  SpaceFilter(SpaceRanges& ranges, const SpaceSetting& setting, std::size_t first, const SpaceStart& start,
              double density);

  /// Filters up to the instant `end`, or until the track is lost, and marks the ranges. Linearises at the
  /// smoothed track if there is one, else at the prediction.
  /// @return one past the last filtered instant
  std::size_t filter(std::size_t end);
  void smooth();
  /// Filters up to `end` and smooths repeatedly, each time linearised at the previous track.
  /// @return log likelihood of the arrivals; -infinity if the track was lost
  double iterate(std::size_t end);
  /// Widens the sigma of a beacon's lasting error where the median of its errors beside the smoothed track
  /// exceeds two sigmas, rejected arrivals included: the sigma becomes half of the median, as that of single
  /// epochs does (CorrelatedArrivals::widen_tails). A path that is late for seconds then moves the track
  /// little.
  /// @return true if a sigma has changed by more than a tenth
  bool widen_tails(double power);
  /// Sets the steps at which the next filter() linearises.
  void linearise_at(const std::vector<SpaceStep>& steps);

  [[nodiscard]] double likelihood() const { return likelihood_; }
  [[nodiscard]] const std::vector<SpaceStep>& steps() const { return steps_; }

 private:
  struct TrackError {
    double time_s, error_m;  ///< measured minus geometric range
    SpaceRange* range;
  };
  [[nodiscard]] std::vector<std::vector<TrackError>> errors_by_beacon();
  [[nodiscard]] Eigen::MatrixXd predict(double dt);
  void hold_within_site(double dt);
  void correct(const Eigen::VectorXd& H, double innovation, double variance,
               const Eigen::VectorXd& by_calibration);
  bool update(SpaceRange& range, std::size_t step);
  [[nodiscard]] Eigen::VectorXd by_calibration(const SpaceRange& range, const Eigen::Vector3d& u) const;

  SpaceRanges& ranges_;
  const SpaceSetting& setting_;
  std::size_t first_;
  double density_, height_m_ = 0.0, likelihood_ = 0.0;
  double since_held_s_ = std::numeric_limits<double>::infinity();
  SpaceBelief start_, now_;
  std::vector<SpaceStep> steps_;
  std::vector<Eigen::VectorXd> about_;  ///< smoothed states to linearise at
  bool about_own_ = false;              ///< they are those of this filter
};

}  // namespace octant
