// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

#include "calib/adjust/tile_sum.h"
#include "calib/sums/reduced_system.h"

namespace octant::calib {

/// Quadratic model of observations at a point: their cost, gradient and Gauss-Newton matrix. Represents a log
/// without its arrivals.
class QuadraticSum : public SystemSum {
 public:
  /// @param data     at `at`
  /// @param damping  added to the matrix, of its diagonal
  /// @param x        where it is asked for, always the present one; not owned
  QuadraticSum(const SystemParts& data, Eigen::VectorXd at, double damping, const Eigen::VectorXd* x)
      : parts_(data.parts()), costs_(parts_.size()), at_(std::move(at)), x_(x) {
    for (SystemPart& part : parts_) part.system.H.diagonal() *= 1.0 + damping;
  }
  double solve_states(const SharedState& /*state*/, const RobustLoss& /*loss*/) override {
    const Eigen::VectorXd step = *x_ - at_;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const ReducedSystem& system = parts_[i].system;
      const Eigen::VectorXd d = step(parts_[i].columns);
      costs_[i] = system.cost + d.dot(system.gradient) + 0.5 * d.dot(system.H * d);
    }
    return std::accumulate(costs_.begin(), costs_.end(), 0.0);
  }
  void reduce(const SharedState& state, const RobustLoss& loss, ReducedSystem& sum) override {
    SystemParts here;
    for (const SystemPart& part : reduce_each(state, loss)) here.add(part);
    sum = here.whole(static_cast<int>(at_.size()));
  }
  [[nodiscard]] std::vector<SystemPart> reduce_each(const SharedState& state,
                                                    const RobustLoss& loss) override {
    static_cast<void>(solve_states(state, loss));
    const Eigen::VectorXd step = *x_ - at_;
    std::vector<SystemPart> here = parts_;
    for (std::size_t i = 0; i < here.size(); ++i) {
      ReducedSystem& system = here[i].system;
      system.cost = costs_[i];
      system.gradient += system.H * step(here[i].columns);
    }
    return here;
  }
  [[nodiscard]] const std::vector<int>& columns_of(std::size_t part) const override {
    return parts_[part].columns;
  }
  [[nodiscard]] const std::vector<double>& costs() const override { return costs_; }

 private:
  std::vector<SystemPart> parts_;
  std::vector<double> costs_;
  Eigen::VectorXd at_;
  const Eigen::VectorXd* x_;
};

}  // namespace octant::calib
