// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/adjust/information.h"

#include <utility>
#include <vector>

#include "calib/adjust/priors.h"
#include "calib/adjust/tile_sum.h"

namespace octant::calib {
namespace {

/// Adds up elements of a sparse matrix in portions, so that the list of them stays short.
class SparseSum {
 public:
  explicit SparseSum(int size) : sum_(size, size) {}
  void add(int i, int j, double value) {
    elements_.emplace_back(i, j, value);
    if (elements_.size() >= kPortion) add_elements();
  }
  [[nodiscard]] Eigen::SparseMatrix<double> result() {
    add_elements();
    sum_.makeCompressed();
    Eigen::SparseMatrix<double> result;
    result.swap(sum_);
    return result;
  }

 private:
  static constexpr std::size_t kPortion = 1'000'000;
  void add_elements() {
    Eigen::SparseMatrix<double> portion(sum_.rows(), sum_.cols());
    portion.setFromTriplets(elements_.begin(), elements_.end());
    sum_ += portion;
    elements_.clear();
  }
  Eigen::SparseMatrix<double> sum_;
  std::vector<Eigen::Triplet<double>> elements_;
};

}  // namespace

Eigen::SparseMatrix<double> sparse_information(const Problem& problem, const ParameterLayout& layout,
                                               const Eigen::VectorXd& x, std::vector<SystemPart> data) {
  SparseSum sum(layout.size());
  for (SystemPart& part : data) {
    const std::vector<int>& columns = part.columns;
    for (std::size_t j = 0; j < columns.size(); ++j)
      for (std::size_t i = 0; i < columns.size(); ++i)
        if (const double h = part.system.H(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
            h != 0.0)
          sum.add(columns[i], columns[j], h);
    part = {};  // their memory is that of the sum from here on
  }
  // The whole diagonal is stored, also zeros.
  for (int i = 0; i < layout.size(); ++i) sum.add(i, i, 0.0);
  for_each_of_prior(problem, layout, x, [&](int i, int j, double value) { sum.add(i, j, value); });
  return sum.result();
}

Eigen::SparseMatrix<double> sparse_information_at(const Problem& problem, const ParameterLayout& layout,
                                                  std::vector<Trajectory>& trajectories,
                                                  const Eigen::VectorXd& x, const Workers& workers) {
  const SharedState state = layout.state_of(x);
  TileSum tiles(trajectories, layout, workers);
  static_cast<void>(tiles.solve_states(state, {}));
  std::vector<SystemPart> data = tiles.reduce_each(state, {});
  tiles.share_states();
  return sparse_information(problem, layout, x, std::move(data));
}

Information information_at(const Problem& problem, const ParameterLayout& layout,
                           std::vector<Trajectory>& trajectories, const Eigen::VectorXd& x,
                           const Workers& workers) {
  Information info;
  const SharedState state = layout.state_of(x);
  TileSum tiles(trajectories, layout, workers);
  static_cast<void>(tiles.solve_states(state, {}));
  ReducedSystem sum;
  tiles.reduce(state, {}, sum);
  info.data_cost = sum.cost;
  tiles.share_states();
  info.data = std::move(sum.H);
  info.data_gradient = std::move(sum.gradient);
  info.prior = prior_information(problem, layout, x);
  return info;
}

}  // namespace octant::calib
