// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/adjust.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <thread>

#include <Eigen/Cholesky>
#include <ceres/ceres.h>

#include "calib/parallel.h"

namespace octant::calib {
namespace {

/// What all tiles share during one adjustment: the state of the evaluation point, made once for all of them.
struct EvaluationPoint : ceres::EvaluationCallback {
  const ParameterLayout* layout = nullptr;
  const Eigen::VectorXd* x = nullptr;
  SharedState state;

  void PrepareForEvaluation(bool /*evaluate_jacobians*/, bool new_evaluation_point) override {
    if (new_evaluation_point) state = layout->state_of(*x);
  }
};

/// Square root of a positive semidefinite matrix and the matching residual: H = R'R, g = R'z.
void square_root(const Eigen::MatrixXd& H, const Eigen::VectorXd& g, Eigen::MatrixXd& R, Eigen::VectorXd& z) {
  const Eigen::VectorXd scale = H.diagonal().cwiseMax(1e-300).cwiseSqrt();
  const Eigen::VectorXd inverse = scale.cwiseInverse();
  const Eigen::LDLT<Eigen::MatrixXd> ldlt((inverse.asDiagonal() * H * inverse.asDiagonal()).eval());
  const Eigen::VectorXd d = ldlt.vectorD();
  // P' L D L' P: rank-deficient directions (nothing in this tile sees them) get a zero row.
  Eigen::VectorXd y = ldlt.transpositionsP() * (inverse.asDiagonal() * g).eval();
  ldlt.matrixL().solveInPlace(y);
  const Eigen::MatrixXd L = ldlt.matrixL();
  R = (ldlt.transpositionsP().transpose() * L).transpose();  // (P' L)' = L' P
  z.setZero(d.size());
  for (Eigen::Index i = 0; i < d.size(); ++i) {
    const double root = d[i] > 1e-13 ? std::sqrt(d[i]) : 0.0;
    R.row(i) *= root;
    if (root > 0) z[i] = y[i] / root;
  }
  R = R * scale.asDiagonal();
}

class TileCost : public ceres::CostFunction {
 public:
  TileCost(Tile* tile, const EvaluationPoint* point, const ParameterLayout* layout, const RobustLoss* loss)
      : tile_(tile), point_(point), layout_(layout), loss_(loss) {
    for (const int b : tile->blocks()) mutable_parameter_block_sizes()->push_back(layout->blocks[static_cast<std::size_t>(b)].size);
    set_num_residuals(static_cast<int>(tile->columns().size()) + 1);
  }

  bool Evaluate(double const* const*, double* residuals, double** jacobians) const override {
    const auto n = static_cast<Eigen::Index>(tile_->columns().size());
    Eigen::Map<Eigen::VectorXd> out(residuals, n + 1);
    if (jacobians == nullptr) {
      // Only the cost is asked for: it may stand in one row.
      const double cost = tile_->evaluate(point_->state, *loss_, nullptr);
      out.setZero();
      out[n] = std::sqrt(2.0 * cost);
      return std::isfinite(cost);
    }
    ReducedSystem system;
    tile_->evaluate(point_->state, *loss_, &system);
    tile_->commit();
    Eigen::MatrixXd R;
    Eigen::VectorXd z;
    square_root(system.H, system.gradient, R, z);
    out.head(n) = z;
    out[n] = std::sqrt(std::max(0.0, 2.0 * system.cost - z.squaredNorm()));
    Eigen::Index column = 0;
    for (std::size_t i = 0; i < tile_->blocks().size(); ++i) {
      const int size = layout_->blocks[static_cast<std::size_t>(tile_->blocks()[i])].size;
      if (jacobians[i] != nullptr) {
        Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> J(jacobians[i], n + 1, size);
        J.topRows(n) = R.middleCols(column, size);
        J.row(n).setZero();
      }
      column += size;
    }
    return std::isfinite(system.cost);
  }

 private:
  Tile* tile_;
  const EvaluationPoint* point_;
  const ParameterLayout* layout_;
  const RobustLoss* loss_;
};

/// Prior of one parameter block; parameters without a prior give zero rows.
class PriorCost : public ceres::CostFunction {
 public:
  PriorCost(const ParameterLayout* layout, const ParameterBlock& block) : layout_(layout), block_(block) {
    mutable_parameter_block_sizes()->push_back(block.size);
    set_num_residuals(block.size);
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    for (int i = 0; i < block_.size; ++i) {
      const Parameter& p = layout_->parameters[static_cast<std::size_t>(block_.first) + static_cast<std::size_t>(i)];
      const double weight = std::isfinite(p.prior_sigma) ? 1.0 / p.prior_sigma : 0.0;
      residuals[i] = weight * (parameters[0][i] - p.prior_mean);
      if (jacobians != nullptr && jacobians[0] != nullptr)
        for (int j = 0; j < block_.size; ++j) jacobians[0][i * block_.size + j] = i == j ? weight : 0.0;
    }
    return true;
  }

 private:
  const ParameterLayout* layout_;
  ParameterBlock block_;
};

/// Weighted misfit of a taped distance and its derivative by the free coordinates of both beacons, in layout order.
struct DistanceRow {
  double residual = 0.0;
  std::vector<std::pair<int, double>> entries;  ///< (column, derivative)
};

DistanceRow distance_row(const ControlDistance& d, const ParameterLayout& layout, const SharedState& state) {
  DistanceRow row;
  const Eigen::Vector3d v = state.beacon_p_map_m[d.from.index()] - state.beacon_p_map_m[d.to.index()];
  const double length = std::max(v.norm(), 1e-9), weight = 1.0 / d.sigma_m;
  row.residual = weight * (length - d.distance_m);
  for (std::size_t i = 0; i < 3; ++i) {
    const double k = weight * v[static_cast<int>(i)] / length;
    if (layout.beacon[d.from.index()][i] >= 0) row.entries.emplace_back(layout.beacon[d.from.index()][i], k);
    if (layout.beacon[d.to.index()][i] >= 0) row.entries.emplace_back(layout.beacon[d.to.index()][i], -k);
  }
  return row;
}

int block_of(const ParameterLayout& layout, int column) {
  for (std::size_t k = 0; k < layout.blocks.size(); ++k)
    if (column >= layout.blocks[k].first && column < layout.blocks[k].first + layout.blocks[k].size) return static_cast<int>(k);
  return -1;
}

class DistanceCost : public ceres::CostFunction {
 public:
  DistanceCost(const ControlDistance& d, const EvaluationPoint* point, const ParameterLayout* layout, std::vector<int> blocks)
      : distance_(d), point_(point), layout_(layout), blocks_(std::move(blocks)) {
    for (const int b : blocks_) mutable_parameter_block_sizes()->push_back(layout->blocks[static_cast<std::size_t>(b)].size);
    set_num_residuals(1);
  }
  bool Evaluate(double const* const*, double* residuals, double** jacobians) const override {
    const DistanceRow row = distance_row(distance_, *layout_, point_->state);
    residuals[0] = row.residual;
    if (jacobians == nullptr) return true;
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      if (jacobians[i] == nullptr) continue;
      const ParameterBlock& block = layout_->blocks[static_cast<std::size_t>(blocks_[i])];
      std::fill(jacobians[i], jacobians[i] + block.size, 0.0);
      for (const auto& [column, value] : row.entries)
        if (column >= block.first && column < block.first + block.size) jacobians[i][column - block.first] += value;
    }
    return true;
  }

 private:
  ControlDistance distance_;
  const EvaluationPoint* point_;
  const ParameterLayout* layout_;
  std::vector<int> blocks_;
};

struct Watch : ceres::IterationCallback {
  const AdjustOptions* options = nullptr;
  bool interrupted = false;
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    if (options->on_iteration && !options->on_iteration(summary.iteration, summary.cost)) {
      interrupted = true;
      return ceres::SOLVER_ABORT;
    }
    return ceres::SOLVER_CONTINUE;
  }
};

ceres::Solver::Options solver_options(const AdjustOptions& options, int unknowns) {
  ceres::Solver::Options ceres_options;
  ceres_options.minimizer_progress_to_stdout = false;
  ceres_options.logging_type = ceres::SILENT;
  ceres_options.max_num_iterations = options.max_iterations;
  // Ceres grumbles on standard error over more threads than there are cores.
  ceres_options.num_threads = std::clamp(options.threads, 1, std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
  ceres_options.function_tolerance = options.function_tolerance;
  ceres_options.gradient_tolerance = 1e-9;
  ceres_options.parameter_tolerance = 1e-12;
  ceres_options.max_num_consecutive_invalid_steps = 10;
  ceres_options.linear_solver_type = unknowns <= 600 ? ceres::DENSE_NORMAL_CHOLESKY : ceres::SPARSE_NORMAL_CHOLESKY;
  ceres_options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  return ceres_options;
}

}  // namespace

AdjustResult adjust(const Problem& problem, const ParameterLayout& layout, std::vector<Trajectory>& trajectories, Eigen::VectorXd& x,
                    const AdjustOptions& options) {
  AdjustResult result;
  std::vector<Tile> tiles = make_tiles(trajectories, layout, options.threads);
  EvaluationPoint point;
  point.layout = &layout;
  point.x = &x;
  point.state = layout.state_of(x);
  if (layout.size() == 0) {  // everything is held: only the vehicle states move
    for (Tile& tile : tiles) result.cost += tile.evaluate(point.state, options.loss, nullptr);
    result.converged = true;
    return result;
  }
  ceres::Problem::Options problem_options;
  problem_options.evaluation_callback = &point;
  ceres::Problem ceres_problem(problem_options);
  const auto address = [&](int block) { return x.data() + layout.blocks[static_cast<std::size_t>(block)].first; };
  for (std::size_t k = 0; k < layout.blocks.size(); ++k) {
    ceres_problem.AddParameterBlock(address(static_cast<int>(k)), layout.blocks[k].size);
    for (int i = 0; i < layout.blocks[k].size; ++i) {
      const double lower = layout.parameters[static_cast<std::size_t>(layout.blocks[k].first) + static_cast<std::size_t>(i)].lower;
      if (std::isfinite(lower)) ceres_problem.SetParameterLowerBound(address(static_cast<int>(k)), i, lower);
    }
    ceres_problem.AddResidualBlock(new PriorCost(&layout, layout.blocks[k]), nullptr, address(static_cast<int>(k)));
  }
  const auto add = [&](ceres::CostFunction* cost, const std::vector<int>& blocks) {
    std::vector<double*> addresses;
    addresses.reserve(blocks.size());
    for (const int b : blocks) addresses.push_back(address(b));
    ceres_problem.AddResidualBlock(cost, nullptr, addresses);
  };
  for (Tile& tile : tiles)
    if (!tile.blocks().empty()) add(new TileCost(&tile, &point, &layout, &options.loss), tile.blocks());
  for (const ControlDistance& d : problem.site.distances) {
    std::vector<int> blocks;
    for (const auto& [column, value] : distance_row(d, layout, point.state).entries) {
      const int b = block_of(layout, column);
      if (blocks.empty() || (blocks[0] != b && blocks.back() != b)) blocks.push_back(b);
    }
    if (!blocks.empty()) add(new DistanceCost(d, &point, &layout, blocks), blocks);
  }
  Watch watch;
  watch.options = &options;
  ceres::Solver::Options ceres_options = solver_options(options, layout.size());
  ceres_options.callbacks.push_back(&watch);
  ceres_options.update_state_every_iteration = false;
  ceres::Solver::Summary summary;
  ceres::Solve(ceres_options, &ceres_problem, &summary);
  result.converged = summary.termination_type == ceres::CONVERGENCE;
  result.interrupted = watch.interrupted;
  result.iterations = static_cast<int>(summary.iterations.size()) - 1;
  result.cost = summary.final_cost;
  result.message = summary.message;
  const SharedState state = layout.state_of(x);
  for_each_parallel(tiles.size(), options.threads, [&](std::size_t i) { tiles[i].evaluate(state, options.loss, nullptr); });
  return result;
}

double prior_cost(const Problem& problem, const ParameterLayout& layout, const Eigen::VectorXd& x) {
  double cost = 0.0;
  for (int i = 0; i < layout.size(); ++i) {
    const Parameter& p = layout.parameters[static_cast<std::size_t>(i)];
    if (std::isfinite(p.prior_sigma)) cost += 0.5 * std::pow((x[i] - p.prior_mean) / p.prior_sigma, 2);
  }
  const SharedState state = layout.state_of(x);
  for (const ControlDistance& d : problem.site.distances) cost += 0.5 * std::pow(distance_row(d, layout, state).residual, 2);
  return cost;
}

Information information_at(const Problem& problem, const ParameterLayout& layout, std::vector<Trajectory>& trajectories,
                           const Eigen::VectorXd& x, const RobustLoss& loss, int threads) {
  Information info;
  const int n = layout.size();
  info.data.setZero(n, n);
  info.prior.setZero(n, n);
  const SharedState state = layout.state_of(x);
  std::vector<Tile> tiles = make_tiles(trajectories, layout, threads);
  std::vector<ReducedSystem> systems(tiles.size());
  for_each_parallel(tiles.size(), threads, [&](std::size_t i) { tiles[i].evaluate(state, loss, &systems[i]); });
  for (std::size_t k = 0; k < tiles.size(); ++k) {
    const ReducedSystem& system = systems[k];
    info.data_cost += system.cost;
    const std::vector<int>& columns = tiles[k].columns();
    for (std::size_t i = 0; i < columns.size(); ++i)
      for (std::size_t j = 0; j < columns.size(); ++j)
        info.data(columns[i], columns[j]) += system.H(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
  }
  for (int i = 0; i < n; ++i) {
    const Parameter& p = layout.parameters[static_cast<std::size_t>(i)];
    if (!std::isfinite(p.prior_sigma)) continue;
    info.prior(i, i) += 1.0 / (p.prior_sigma * p.prior_sigma);
  }
  for (const ControlDistance& d : problem.site.distances) {
    const DistanceRow row = distance_row(d, layout, state);
    for (const auto& [i, a] : row.entries)
      for (const auto& [j, b] : row.entries) info.prior(i, j) += a * b;
  }
  return info;
}

}  // namespace octant::calib
