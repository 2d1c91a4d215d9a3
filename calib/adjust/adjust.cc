// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/adjust/adjust.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <ceres/ceres.h>
#include <fmt/format.h>

#include "calib/adjust/evaluation_point.h"
#include "calib/adjust/priors.h"
#include "calib/adjust/tile_sum.h"

namespace octant::calib {
namespace {

/// Residuals as Ceres wants them, over parameter blocks that cover their columns in order.
void hand_over(const SystemResiduals& from, const ParameterLayout& layout, const std::vector<int>& blocks,
               double* residuals, double** jacobians) {
  const Eigen::Index n = from.z.size();
  Eigen::Map<Eigen::VectorXd> out(residuals, n + 1);
  out.head(n) = from.z;
  out[n] = from.rest;
  Eigen::Index column = 0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const int size = layout.blocks[static_cast<std::size_t>(blocks[i])].size;
    if (jacobians[i] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> J(jacobians[i],
                                                                                           n + 1, size);
      J.topRows(n) = from.R.middleCols(column, size);
      J.row(n).setZero();
    }
    column += size;
  }
}

/// All observations (part < 0) or a part of them.
class PartCost : public ceres::CostFunction {
 public:
  PartCost(const EvaluationPoint* point, int part, std::vector<int> blocks)
      : point_(point), part_(part), blocks_(std::move(blocks)) {
    int columns = 0;
    for (const int b : blocks_) {
      const int size = point->layout->blocks[static_cast<std::size_t>(b)].size;
      mutable_parameter_block_sizes()->push_back(size);
      columns += size;
    }
    set_num_residuals(columns + 1);
  }

  bool Evaluate(double const* const*, double* residuals, double** jacobians) const override {
    const double cost =
        part_ < 0 ? point_->cost : point_->observations->costs()[static_cast<std::size_t>(part_)];
    if (jacobians == nullptr) {
      // Only the cost is requested, so it may be one residual. Where it is almost zero, rounding may make it
      // negative.
      std::fill(residuals, residuals + num_residuals() - 1, 0.0);
      residuals[num_residuals() - 1] = std::sqrt(2.0 * std::max(0.0, cost));
    } else {
      hand_over(point_->residuals[static_cast<std::size_t>(std::max(part_, 0))], *point_->layout, blocks_,
                residuals, jacobians);
    }
    return std::isfinite(cost);
  }

 private:
  const EvaluationPoint* point_;
  int part_;
  std::vector<int> blocks_;
};

/// Priors and taped distances that touch the same parameter blocks.
class PriorCost : public ceres::CostFunction {
 public:
  /// @param first, count  of the point's rows
  PriorCost(const EvaluationPoint* point, std::size_t first, std::size_t count, std::vector<int> blocks)
      : point_(point), first_(first), count_(count), blocks_(std::move(blocks)) {
    for (const int b : blocks_)
      mutable_parameter_block_sizes()->push_back(point->layout->blocks[static_cast<std::size_t>(b)].size);
    set_num_residuals(static_cast<int>(count));
  }
  bool Evaluate(double const* const*, double* residuals, double** jacobians) const override {
    for (std::size_t r = 0; r < count_; ++r) {
      const PriorRow& row = point_->priors[first_ + r];
      residuals[r] = row.residual;
      for (std::size_t i = 0; jacobians != nullptr && i < blocks_.size(); ++i) {
        if (jacobians[i] == nullptr) continue;
        const ParameterBlock& block = point_->layout->blocks[static_cast<std::size_t>(blocks_[i])];
        double* const by_block = jacobians[i] + r * static_cast<std::size_t>(block.size);
        std::fill(by_block, by_block + block.size, 0.0);
        for (const auto& [column, value] : row.entries)
          if (column >= block.first && column < block.first + block.size)
            by_block[column - block.first] += value;
      }
    }
    return true;
  }

 private:
  const EvaluationPoint* point_;
  std::size_t first_, count_;
  std::vector<int> blocks_;
};

/// The parameter blocks of some columns, in order. @param columns  ascending
std::vector<int> blocks_of(const std::vector<int>& columns, const ParameterLayout& layout) {
  std::vector<int> blocks;
  std::size_t k = 0;
  for (const int column : columns) {
    while (layout.blocks[k].first + layout.blocks[k].size <= column) ++k;
    if (blocks.empty() || blocks.back() != static_cast<int>(k)) blocks.push_back(static_cast<int>(k));
  }
  return blocks;
}

std::vector<int> blocks_of(const PriorRow& row, const ParameterLayout& layout) {
  std::vector<int> columns;
  columns.reserve(row.entries.size());
  for (const auto& [column, derivative] : row.entries) columns.push_back(column);
  std::ranges::sort(columns);
  return blocks_of(columns, layout);
}

struct IterationWatch : ceres::IterationCallback {
  const AdjustOptions* options = nullptr;
  const EvaluationPoint* point = nullptr;
  bool interrupted = false;
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    if (options->on_iteration && !options->on_iteration(summary.iteration, summary.cost)) {
      interrupted = true;
      return ceres::SOLVER_ABORT;
    }
    return point->at_rest ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }
};

ceres::Solver::Options solver_options(const AdjustOptions& options, bool dense) {
  ceres::Solver::Options ceres_options;
  ceres_options.minimizer_progress_to_stdout = false;
  ceres_options.logging_type = ceres::SILENT;
  ceres_options.max_num_iterations = options.max_iterations;
  // EvaluationPoint does the work. With more threads, Ceres would add costs in the order of their completion.
  ceres_options.num_threads = 1;
  ceres_options.function_tolerance = options.function_tolerance;
  ceres_options.gradient_tolerance = 1e-9;
  ceres_options.parameter_tolerance = 1e-12;
  ceres_options.max_num_consecutive_invalid_steps = 10;
  ceres_options.linear_solver_type = dense ? ceres::DENSE_NORMAL_CHOLESKY : ceres::SPARSE_NORMAL_CHOLESKY;
  ceres_options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  return ceres_options;
}

/// Returns true if the second half of the iterations of an adjustment gained less than a hundredth of the
/// square of one sigma. It follows a bent valley, but is practically converged.
bool crawls(const ceres::Solver::Summary& summary) {
  constexpr double kNegligibleGain = 0.005;
  if (summary.termination_type != ceres::NO_CONVERGENCE || summary.iterations.size() < 20) return false;
  return summary.iterations[summary.iterations.size() / 2].cost - summary.final_cost < kNegligibleGain;
}

double* address_of(const ParameterLayout& layout, int block, Eigen::VectorXd& x) {
  return x.data() + layout.blocks[static_cast<std::size_t>(block)].first;
}

/// All blocks with their bounds.
void add_parameters(const ParameterLayout& layout, Eigen::VectorXd& x, ceres::Problem& to) {
  for (std::size_t k = 0; k < layout.blocks.size(); ++k) {
    const ParameterBlock& block = layout.blocks[k];
    double* const address = address_of(layout, static_cast<int>(k), x);
    to.AddParameterBlock(address, block.size);
    for (int i = 0; i < block.size; ++i) {
      const Parameter& parameter =
          layout.parameters[static_cast<std::size_t>(block.first) + static_cast<std::size_t>(i)];
      if (std::isfinite(parameter.lower)) to.SetParameterLowerBound(address, i, parameter.lower);
      if (std::isfinite(parameter.upper)) to.SetParameterUpperBound(address, i, parameter.upper);
    }
  }
}

AdjustResult adjust_all(const Problem& problem, const ParameterLayout& layout, SystemSum& observations,
                        Eigen::VectorXd& x, const AdjustOptions& options) {
  AdjustResult result;
  EvaluationPoint point(problem, &observations, &layout, &x, options);
  point.state = layout.state_of(x);
  point.priors = prior_rows(problem, layout, x);
  if (layout.size() == 0) {  // everything is held: only the vehicle states move
    result.cost = observations.solve_states(point.state, options.loss);
    result.converged = true;
    return result;
  }
  ceres::Problem::Options problem_options;
  problem_options.evaluation_callback = &point;
  ceres::Problem ceres_problem(problem_options);
  add_parameters(layout, x, ceres_problem);
  const auto add = [&](ceres::CostFunction* cost, const std::vector<int>& blocks) {
    std::vector<double*> addresses;
    addresses.reserve(blocks.size());
    for (const int b : blocks) addresses.push_back(address_of(layout, b, x));
    ceres_problem.AddResidualBlock(cost, nullptr, addresses);
  };
  const auto add_priors = [&](std::size_t first, std::size_t last) {
    for (std::size_t next = first; first < last; first = next) {
      const std::vector<int> blocks = blocks_of(point.priors[first], layout);
      while (next < last && blocks_of(point.priors[next], layout) == blocks) ++next;
      if (!blocks.empty()) add(new PriorCost(&point, first, next - first, blocks), blocks);
    }
  };
  add_priors(0, static_cast<std::size_t>(layout.size()));
  if (point.dense) {
    std::vector<int> all(layout.blocks.size());
    std::iota(all.begin(), all.end(), 0);
    add(new PartCost(&point, -1, all), all);
  } else {
    for (std::size_t i = 0; i < observations.costs().size(); ++i)
      if (const std::vector<int> blocks = blocks_of(observations.columns_of(i), layout); !blocks.empty())
        add(new PartCost(&point, static_cast<int>(i), blocks), blocks);
  }
  add_priors(static_cast<std::size_t>(layout.size()), point.priors.size());
  IterationWatch iteration_watch;
  iteration_watch.options = &options;
  iteration_watch.point = &point;
  ceres::Solver::Options ceres_options = solver_options(options, point.dense);
  ceres_options.callbacks.push_back(&iteration_watch);
  ceres::Solver::Summary summary;
  ceres::Solve(ceres_options, &ceres_problem, &summary);
  result.converged = point.at_rest || summary.termination_type == ceres::CONVERGENCE || crawls(summary);
  result.interrupted = iteration_watch.interrupted;
  result.iterations = static_cast<int>(summary.iterations.size()) - 1;
  result.cost = summary.final_cost;
  if (point.at_rest)
    result.message = "converged: the predicted decrease is below the tolerance";
  else if (!result.converged)
    result.message = summary.termination_type == ceres::NO_CONVERGENCE
                         ? fmt::format("the estimate still changed after {} iterations", result.iterations)
                         : "the normal equations could not be solved";
  if (point.dense && point.reduced_at.size() == layout.size() && point.rays_are_the_same())
    result.data = SystemParts({all_columns(layout.size()), std::move(point.sum)});
  return result;
}

}  // namespace

AdjustResult adjust(const Problem& problem, const ParameterLayout& layout,
                    std::vector<Trajectory>& trajectories, Eigen::VectorXd& x, const AdjustOptions& options) {
  TileSum tiles(trajectories, layout, options.workers);
  AdjustResult result = adjust_all(problem, layout, tiles, x, options);
  if (layout.size() == 0) tiles.commit();  // else every accepted point was reduced, and so committed
  tiles.share_states();
  return result;
}

AdjustResult adjust(const Problem& problem, const ParameterLayout& layout, SystemSum& observations,
                    Eigen::VectorXd& x, const AdjustOptions& options) {
  return adjust_all(problem, layout, observations, x, options);
}

}  // namespace octant::calib
