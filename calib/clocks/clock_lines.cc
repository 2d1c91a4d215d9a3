// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/clocks/clock_lines.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace octant::calib {
namespace {

constexpr int kLineRounds = 12;
/// Floor of residuals, relative to their median, which keeps the weights finite.
constexpr double kLineFloor = 0.1;

/// Normal equations of the lines, with the times of transmission eliminated.
class LineFit {
 public:
  LineFit(const std::vector<const Transmission*>& transmissions, const ClockModel& clocks, int reference)
      : all_(transmissions), clocks_(clocks), reference_(reference) {
    lines_.line.assign(clocks.names.size(), Eigen::Vector2d::Zero());
    double first = INFINITY, last = -INFINITY;
    for (const Transmission* t : all_) first = std::min(first, t->time_s), last = std::max(last, t->time_s);
    if (!all_.empty()) lines_.middle_s = 0.5 * (first + last), half_s_ = std::max(0.5 * (last - first), 1e-9);
    for (const Transmission* t : all_) {
      lines_.time_s.push_back(t->time_s);
      weights_.emplace_back(t->receptions.size(), 1.0);
    }
    lines_.after_s.assign(all_.size(), 0.0);
  }

  ClockLines fit() {
    for (int round = 0; round < kLineRounds; ++round) {
      if (clocks_.is_free) solve();
      update();
    }
    return std::move(lines_);
  }

 private:
  [[nodiscard]] int clock(const TimeStamp& r) const { return clocks_.of_device[r.device.index()]; }
  [[nodiscard]] double residual(std::size_t e, const TimeStamp& r) const {
    return r.after_s - lines_.after_s[e] - lines_.offset_s(clock(r), lines_.time_s[e]);
  }

  void solve() {
    const auto n = static_cast<Eigen::Index>(2 * clocks_.names.size());
    Eigen::MatrixXd N = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(n);
    for (std::size_t e = 0; e < all_.size(); ++e) {
      const double u = (lines_.time_s[e] - lines_.middle_s) / half_s_;
      Eigen::VectorXd sum = Eigen::VectorXd::Zero(n);
      double weight = 0.0, sum_s = 0.0;
      for (std::size_t i = 0; i < all_[e]->receptions.size(); ++i) {
        const TimeStamp& r = all_[e]->receptions[i];
        const Eigen::Index c = 2 * clock(r);
        const double w = weights_[e][i];
        const Eigen::Vector2d a(1.0, u);
        N.block<2, 2>(c, c) += w * a * a.transpose();
        const double after_s = r.after_s - lines_.offset_s(clock(r), lines_.time_s[e]);
        g.segment<2>(c) += w * after_s * a;
        sum.segment<2>(c) += w * a;
        weight += w, sum_s += w * after_s;
      }
      for (Eigen::Index i = 0; i < n; ++i)
        if (sum[i] != 0.0) N.col(i) -= sum * (sum[i] / weight);
      g -= sum * (sum_s / weight);
    }
    for (int k = 0; k < 2; ++k) {  // the reference clock is the time base
      const Eigen::Index c = 2 * reference_ + k;
      N.row(c).setZero(), N.col(c).setZero(), N(c, c) = 1.0, g[c] = 0.0;
    }
    // Clocks that are not connected, or that have one reception, have no line of their own.
    N.diagonal().array() += 1e-9 * std::max(N.diagonal().maxCoeff(), 1e-300);
    const Eigen::VectorXd x = N.ldlt().solve(g);
    for (std::size_t c = 0; c < lines_.line.size(); ++c) {
      const auto at = static_cast<Eigen::Index>(2 * c);
      lines_.line[c] += Eigen::Vector2d(x[at], x[at + 1] / half_s_);
    }
  }

  /// Times of transmission and weights by the lines.
  void update() {
    std::vector<double> sizes;
    for (std::size_t e = 0; e < all_.size(); ++e) {
      double weight = 0.0, sum_s = 0.0;
      lines_.after_s[e] = 0.0;
      for (std::size_t i = 0; i < all_[e]->receptions.size(); ++i) {
        weight += weights_[e][i];
        sum_s += weights_[e][i] * residual(e, all_[e]->receptions[i]);
      }
      lines_.after_s[e] = sum_s / weight;
      if (!all_[e]->is_difference) lines_.time_s[e] = all_[e]->time_s + lines_.after_s[e];
      for (const TimeStamp& r : all_[e]->receptions) sizes.push_back(std::abs(residual(e, r)));
    }
    if (sizes.empty()) return;
    const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
    std::ranges::nth_element(sizes, middle);
    if (!(*middle > 0.0)) return;
    for (std::size_t e = 0; e < all_.size(); ++e)
      for (std::size_t i = 0; i < all_[e]->receptions.size(); ++i)
        weights_[e][i] = 1.0 / std::max(std::abs(residual(e, all_[e]->receptions[i])) / *middle, kLineFloor);
  }

  const std::vector<const Transmission*>& all_;
  const ClockModel& clocks_;
  int reference_;
  double half_s_ = 1.0;
  ClockLines lines_;
  std::vector<std::vector<double>> weights_;
};

}  // namespace

ClockLines clock_lines(const std::vector<const Transmission*>& transmissions, const ClockModel& clocks,
                       int reference_clock) {
  return LineFit(transmissions, clocks, reference_clock).fit();
}

}  // namespace octant::calib
