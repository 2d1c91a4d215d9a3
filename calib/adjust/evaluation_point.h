// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <ceres/evaluation_callback.h>
#include <Eigen/Core>

#include "calib/adjust/adjust_options.h"
#include "calib/adjust/priors.h"
#include "calib/adjust/tile_sum.h"

namespace octant::calib {

/// A reduced system as residuals: H = R'R, g = R'z, and one row more so that half their squares are the cost.
struct SystemResiduals {
  Eigen::MatrixXd R;
  Eigen::VectorXd z;
  double rest = 0.0;
};

/// All observations at the point that Ceres evaluates, computed once for all users. The states of a candidate
/// are solved; only if it is accepted, its reduction is added.
struct EvaluationPoint : ceres::EvaluationCallback {
  EvaluationPoint(const Problem& problem_of_all, SystemSum* all, const ParameterLayout* layout_of_all,
                  const Eigen::VectorXd* x_of_all, const AdjustOptions& options_of_all)
      : problem(&problem_of_all),
        observations(all),
        layout(layout_of_all),
        x(x_of_all),
        options(&options_of_all),
        dense(is_dense(*layout_of_all)) {}

  const Problem* problem;
  SystemSum* observations;
  const ParameterLayout* layout;
  const Eigen::VectorXd* x;
  const AdjustOptions* options;
  bool dense;
  SharedState state;
  std::vector<PriorRow> priors;  ///< see prior_rows()
  double cost = 0.0;
  bool is_solved = false;
  bool at_rest = false;                    ///< the last step was the last significant one
  ReducedSystem sum;                       ///< dense
  Eigen::VectorXd reduced_at;              ///< where that was formed
  std::vector<SystemResiduals> residuals;  ///< residuals of the sum; otherwise of each part

  void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override;

  /// Returns true if rays of some metres and lever arms of some centimetres have the same directions as when
  /// the system was formed, to a thousandth: then its matrix is accurate enough for a covariance here.
  [[nodiscard]] bool rays_are_the_same() const;

 private:
  /// The system at this point; it is not needed if almost no gain is left.
  void evaluate_system();

  /// The gain of a step is half its square in the matrix. Gauss-Newton steps leave a few hundredths of the
  /// distance for lever arms as short as an octagon's, a tenth at most, and the square of this share of the
  /// gain. The matrix changes by some times the error of the predicted gain, which must remain negligible in
  /// a covariance.
  [[nodiscard]] bool nothing_left_to_gain() const;

  /// The last system as it looks from here.
  void move_last_residuals();
};

}  // namespace octant::calib
