// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/errors/non_negative.h"

#include <algorithm>
#include <vector>

#include <Eigen/QR>

namespace octant::calib {

Eigen::VectorXd non_negative_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
  const Eigen::Index n = A.cols();
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
  std::vector<bool> passive(static_cast<std::size_t>(n), false);
  const Eigen::MatrixXd G = A.transpose() * A;
  const Eigen::VectorXd h = A.transpose() * b;
  const double tolerance = 1e-10 * std::max(1e-300, h.cwiseAbs().maxCoeff());
  for (Eigen::Index round = 0; round < 3 * n + 10; ++round) {
    const Eigen::VectorXd w = h - G * x;
    Eigen::Index best = -1;
    for (Eigen::Index i = 0; i < n; ++i)
      if (!passive[static_cast<std::size_t>(i)] && w[i] > tolerance && (best < 0 || w[i] > w[best])) best = i;
    if (best < 0) break;
    passive[static_cast<std::size_t>(best)] = true;
    while (true) {
      std::vector<Eigen::Index> in;
      for (Eigen::Index i = 0; i < n; ++i)
        if (passive[static_cast<std::size_t>(i)]) in.push_back(i);
      if (in.empty()) break;
      Eigen::MatrixXd columns(A.rows(), static_cast<Eigen::Index>(in.size()));
      for (std::size_t k = 0; k < in.size(); ++k) columns.col(static_cast<Eigen::Index>(k)) = A.col(in[k]);
      const Eigen::VectorXd z = columns.colPivHouseholderQr().solve(b);
      double step = 1.0;
      for (std::size_t k = 0; k < in.size(); ++k)
        if (const double to = z[static_cast<Eigen::Index>(k)]; to <= 0)
          step = std::min(step, x[in[k]] / std::max(x[in[k]] - to, 1e-300));
      for (std::size_t k = 0; k < in.size(); ++k)
        x[in[k]] += step * (z[static_cast<Eigen::Index>(k)] - x[in[k]]);
      if (step >= 1.0) break;
      for (const Eigen::Index i : in)
        if (x[i] <= 1e-14 * std::max(1e-300, x.maxCoeff())) {
          x[i] = 0.0;
          passive[static_cast<std::size_t>(i)] = false;
        }
    }
  }
  return x;
}

}  // namespace octant::calib
