// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/adjust/adjust.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numeric>
#include <utility>

#include <ceres/ceres.h>
#include <Eigen/Cholesky>
#include <Eigen/SparseCore>

#include "calib/adjust/tile_sum.h"
#include "models/support/parallel.h"
#include "models/trajectory/decompositions.h"

namespace octant::calib {
namespace {

/// A reduced system as residuals: H = R'R, g = R'z, and one row more so that half their squares are the cost.
struct Residuals {
  Eigen::MatrixXd R;
  Eigen::VectorXd z;
  double rest = 0.0;
};

Residuals residuals_of(const ReducedSystem& system) {
  constexpr double kLeastPivot = 1e-13, kLeastInformation = 1e-300;
  Residuals out;
  // What is left of a parameter that nothing sees is rounding, which may be below zero: it takes no part.
  const Eigen::VectorXd diagonal = system.H.diagonal();
  const Eigen::VectorXd scale = diagonal.cwiseMax(0.0).cwiseSqrt();
  const Eigen::VectorXd inverse = (diagonal.array() > kLeastInformation).select(scale.cwiseInverse(), 0.0);
  const DenseLdlt ldlt((inverse.asDiagonal() * system.H * inverse.asDiagonal()).eval());
  const Eigen::VectorXd d = ldlt.vectorD();
  // P' L D L' P: rank-deficient directions (nothing in this tile sees them) get a zero row.
  Eigen::VectorXd y = ldlt.transpositionsP() * (inverse.asDiagonal() * system.gradient).eval();
  ldlt.matrixL().solveInPlace(y);
  const Eigen::MatrixXd L = ldlt.matrixL();
  out.R = (ldlt.transpositionsP().transpose() * L).transpose();  // (P' L)' = L' P
  out.z.setZero(d.size());
  for (Eigen::Index i = 0; i < d.size(); ++i) {
    const double root = d[i] > kLeastPivot ? std::sqrt(d[i]) : 0.0;
    out.R.row(i) *= root;
    if (root > 0) out.z[i] = y[i] / root;
  }
  out.R = out.R * scale.asDiagonal();
  out.rest = std::sqrt(std::max(0.0, 2.0 * system.cost - out.z.squaredNorm()));
  return out;
}

/// All observations at the point that Ceres asks about, evaluated once for whoever wants to know: a candidate
/// is settled, and where it is taken only its reduction is added.
struct EvaluationPoint : ceres::EvaluationCallback {
  EvaluationPoint(SystemSum* all, TileSum* all_tiles, const ParameterLayout* its_layout,
                  const Eigen::VectorXd* its_x, const AdjustOptions& its_options)
      : observations(all),
        tiles(all_tiles),
        layout(its_layout),
        x(its_x),
        options(&its_options),
        dense(tiles == nullptr || is_dense(*its_layout)) {}

  SystemSum* observations;
  TileSum* tiles;  ///< the same, where each may be asked for its own
  const ParameterLayout* layout;
  const Eigen::VectorXd* x;
  const AdjustOptions* options;
  bool dense;
  SharedState state;
  double cost = 0.0;
  bool settled = false;
  bool at_rest = false;              ///< the step that led here was the last worth taking
  ReducedSystem sum;                 ///< dense
  Eigen::VectorXd reduced_at;        ///< where that was formed
  std::vector<Residuals> residuals;  ///< of the sum; else of each tile

  void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override {
    if (new_evaluation_point || !settled) {
      state = layout->state_of(*x);
      cost = observations->settle(state, options->loss);
      settled = true;
    }
    if (!evaluate_jacobians) return;
    if (dense) {
      look();
      return;
    }
    std::vector<ReducedSystem> systems;
    tiles->reduce_each(state, options->loss, systems);
    residuals.resize(systems.size());
    for_each_parallel(systems.size(), options->workers.threads, [&](std::size_t i) {
      residuals[i] = residuals_of(systems[i]);
      systems[i] = {};
    });
  }

  /// The system here, which is not even needed where nothing worth while is left to gain.
  void look() {
    at_rest = reduced_at.size() > 0 && nothing_left_to_gain();
    if (at_rest) {
      look_from_last();
      return;
    }
    observations->reduce(state, options->loss, sum);
    reduced_at = *x;
    residuals.assign(1, residuals_of(sum));
  }

  /// A step gains half of its square in the matrix. Steps of Gauss and Newton leave a few hundredths of the
  /// way behind where lever arms are as short as an octagon's, a tenth at most, and the square of that of the
  /// gain. The matrix changes by some times what the foretold gain was off, and as rays turn: both have to
  /// stay below what anybody reads in a covariance.
  [[nodiscard]] bool nothing_left_to_gain() const {
    constexpr double kAlike = 3e-4, kLeftBehind = 0.01;
    const Eigen::VectorXd step = *x - reduced_at;
    const double gain = 0.5 * step.dot(sum.H * step);
    const double off = std::abs(cost - sum.cost - step.dot(sum.gradient) - gain);
    return off < kAlike * gain && rays_are_the_same() &&
           kLeftBehind * gain < options->function_tolerance * cost;
  }

  /// Whether rays of some metres and lever arms of some centimetres point where they did, to a thousandth.
  [[nodiscard]] bool rays_are_the_same() const {
    constexpr double kBeaconM = 1e-3, kReceiverM = 5e-5;
    const auto moved = [&](const std::vector<std::array<int, 3>>& columns, double by_m) {
      return std::any_of(columns.begin(), columns.end(), [&](const std::array<int, 3>& place) {
        return std::any_of(place.begin(), place.end(),
                           [&](int c) { return c >= 0 && std::abs((*x)[c] - reduced_at[c]) > by_m; });
      });
    };
    return !moved(layout->beacon, kBeaconM) && !moved(layout->receiver, kReceiverM);
  }

  /// The last system as it looks from here.
  void look_from_last() {
    Residuals& r = residuals[0];
    r.z += r.R * (*x - reduced_at);
    r.rest = std::sqrt(std::max(0.0, 2.0 * cost - r.z.squaredNorm()));
    observations->commit();
  }
};

/// Residuals as Ceres wants them, over parameter blocks that cover their columns in order.
void hand_over(const Residuals& from, const ParameterLayout& layout, const std::vector<int>& blocks,
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

/// All tiles (tile < 0) or one of them.
class TileCost : public ceres::CostFunction {
 public:
  TileCost(const EvaluationPoint* point, int tile, std::vector<int> blocks)
      : point_(point), tile_(tile), blocks_(std::move(blocks)) {
    int columns = 0;
    for (const int b : blocks_) {
      const int size = point->layout->blocks[static_cast<std::size_t>(b)].size;
      mutable_parameter_block_sizes()->push_back(size);
      columns += size;
    }
    set_num_residuals(columns + 1);
  }

  bool Evaluate(double const* const*, double* residuals, double** jacobians) const override {
    const double cost = tile_ < 0 ? point_->cost : point_->tiles->costs()[static_cast<std::size_t>(tile_)];
    if (jacobians == nullptr) {
      // Only the cost is asked for: it may stand in one row. Where nothing is left of it, what rounds may be
      // below zero.
      std::fill(residuals, residuals + num_residuals() - 1, 0.0);
      residuals[num_residuals() - 1] = std::sqrt(2.0 * std::max(0.0, cost));
    } else {
      hand_over(point_->residuals[static_cast<std::size_t>(std::max(tile_, 0))], *point_->layout, blocks_,
                residuals, jacobians);
    }
    return std::isfinite(cost);
  }

 private:
  const EvaluationPoint* point_;
  int tile_;
  std::vector<int> blocks_;
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
      const Parameter& p =
          layout_->parameters[static_cast<std::size_t>(block_.first) + static_cast<std::size_t>(i)];
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

/// What is known of parameters together, over the blocks that hold them.
class JointPriorCost : public ceres::CostFunction {
 public:
  JointPriorCost(const ParameterLayout* layout, const Eigen::VectorXd* x, std::vector<int> blocks)
      : layout_(layout), x_(x), blocks_(std::move(blocks)) {
    for (const int b : blocks_)
      mutable_parameter_block_sizes()->push_back(layout->blocks[static_cast<std::size_t>(b)].size);
    set_num_residuals(static_cast<int>(layout->joint_prior->mean.size()));
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const JointPrior& prior = *layout_->joint_prior;
    Eigen::VectorXd x = *x_;
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      const ParameterBlock& block = layout_->blocks[static_cast<std::size_t>(blocks_[i])];
      x.segment(block.first, block.size) = Eigen::Map<const Eigen::VectorXd>(parameters[i], block.size);
    }
    Eigen::Map<Eigen::VectorXd>(residuals, prior.mean.size()) = prior.residual(x);
    if (jacobians == nullptr) return true;
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      if (jacobians[i] == nullptr) continue;
      const ParameterBlock& block = layout_->blocks[static_cast<std::size_t>(blocks_[i])];
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> J(
          jacobians[i], prior.mean.size(), block.size);
      J.setZero();
      for (std::size_t k = 0; k < prior.columns.size(); ++k)
        if (const int c = prior.columns[k] - block.first; c >= 0 && c < block.size)
          J.col(c) = prior.root.col(static_cast<Eigen::Index>(k));
    }
    return true;
  }

 private:
  const ParameterLayout* layout_;
  const Eigen::VectorXd* x_;  ///< what no block of these holds does not matter
  std::vector<int> blocks_;
};

/// Weighted misfit of a taped distance and its derivative by the free coordinates of both beacons, in layout
/// order.
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
    if (column >= layout.blocks[k].first && column < layout.blocks[k].first + layout.blocks[k].size)
      return static_cast<int>(k);
  return -1;
}

class DistanceCost : public ceres::CostFunction {
 public:
  DistanceCost(const ControlDistance& d, const EvaluationPoint* point, const ParameterLayout* layout,
               std::vector<int> blocks)
      : distance_(d), point_(point), layout_(layout), blocks_(std::move(blocks)) {
    for (const int b : blocks_)
      mutable_parameter_block_sizes()->push_back(layout->blocks[static_cast<std::size_t>(b)].size);
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
        if (column >= block.first && column < block.first + block.size)
          jacobians[i][column - block.first] += value;
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
  // The work is in EvaluationPoint. With more threads Ceres adds costs up in the order in which these come to
  // them.
  ceres_options.num_threads = 1;
  ceres_options.function_tolerance = options.function_tolerance;
  ceres_options.gradient_tolerance = 1e-9;
  ceres_options.parameter_tolerance = 1e-12;
  ceres_options.max_num_consecutive_invalid_steps = 10;
  ceres_options.linear_solver_type = dense ? ceres::DENSE_NORMAL_CHOLESKY : ceres::SPARSE_NORMAL_CHOLESKY;
  ceres_options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  return ceres_options;
}

/// Whether an adjustment that came to the end of its iterations gained nothing in their second half that
/// anybody could see: a hundredth of the square of one sigma. It creeps along a valley that is bent, but is
/// as good as at rest.
bool crawls(const ceres::Solver::Summary& summary) {
  constexpr double kUnseen = 0.005;
  if (summary.termination_type != ceres::NO_CONVERGENCE || summary.iterations.size() < 20) return false;
  return summary.iterations[summary.iterations.size() / 2].cost - summary.final_cost < kUnseen;
}

AdjustResult adjust_all(const Problem& problem, const ParameterLayout& layout, SystemSum& observations,
                        TileSum* tiles, Eigen::VectorXd& x, const AdjustOptions& options) {
  AdjustResult result;
  EvaluationPoint point(&observations, tiles, &layout, &x, options);
  point.state = layout.state_of(x);
  if (layout.size() == 0) {  // everything is held: only the vehicle states move
    result.cost = observations.settle(point.state, options.loss);
    result.converged = true;
    return result;
  }
  ceres::Problem::Options problem_options;
  problem_options.evaluation_callback = &point;
  ceres::Problem ceres_problem(problem_options);
  const auto address = [&](int block) {
    return x.data() + layout.blocks[static_cast<std::size_t>(block)].first;
  };
  for (std::size_t k = 0; k < layout.blocks.size(); ++k) {
    ceres_problem.AddParameterBlock(address(static_cast<int>(k)), layout.blocks[k].size);
    for (int i = 0; i < layout.blocks[k].size; ++i) {
      const Parameter& parameter =
          layout.parameters[static_cast<std::size_t>(layout.blocks[k].first) + static_cast<std::size_t>(i)];
      if (std::isfinite(parameter.lower))
        ceres_problem.SetParameterLowerBound(address(static_cast<int>(k)), i, parameter.lower);
      if (std::isfinite(parameter.upper))
        ceres_problem.SetParameterUpperBound(address(static_cast<int>(k)), i, parameter.upper);
    }
    ceres_problem.AddResidualBlock(new PriorCost(&layout, layout.blocks[k]), nullptr,
                                   address(static_cast<int>(k)));
  }
  const auto add = [&](ceres::CostFunction* cost, const std::vector<int>& blocks) {
    std::vector<double*> addresses;
    addresses.reserve(blocks.size());
    for (const int b : blocks) addresses.push_back(address(b));
    ceres_problem.AddResidualBlock(cost, nullptr, addresses);
  };
  if (point.dense) {
    std::vector<int> all(layout.blocks.size());
    std::iota(all.begin(), all.end(), 0);
    add(new TileCost(&point, -1, all), all);
  } else {
    for (std::size_t i = 0; i < tiles->tiles().size(); ++i)
      if (const std::vector<int>& blocks = tiles->tiles()[i].blocks(); !blocks.empty())
        add(new TileCost(&point, static_cast<int>(i), blocks), blocks);
  }
  for (const ControlDistance& d : problem.site.distances) {
    std::vector<int> blocks;
    for (const auto& [column, value] : distance_row(d, layout, point.state).entries) {
      const int b = block_of(layout, column);
      if (blocks.empty() || (blocks[0] != b && blocks.back() != b)) blocks.push_back(b);
    }
    if (!blocks.empty()) add(new DistanceCost(d, &point, &layout, blocks), blocks);
  }
  if (layout.joint_prior) {
    std::vector<int> blocks;
    for (const int column : layout.joint_prior->columns)
      if (const int b = block_of(layout, column); blocks.empty() || blocks.back() != b) blocks.push_back(b);
    add(new JointPriorCost(&layout, &x, blocks), blocks);
  }
  Watch watch;
  watch.options = &options;
  watch.point = &point;
  ceres::Solver::Options ceres_options = solver_options(options, point.dense);
  ceres_options.callbacks.push_back(&watch);
  ceres_options.update_state_every_iteration = false;
  ceres::Solver::Summary summary;
  ceres::Solve(ceres_options, &ceres_problem, &summary);
  result.converged = point.at_rest || summary.termination_type == ceres::CONVERGENCE || crawls(summary);
  result.interrupted = watch.interrupted;
  result.iterations = static_cast<int>(summary.iterations.size()) - 1;
  result.cost = summary.final_cost;
  result.message =
      point.at_rest ? "converged: the predicted decrease is below the tolerance" : summary.message;
  if (point.dense && point.reduced_at.size() == layout.size())
    result.data_information = std::move(point.sum.H);
  return result;
}

}  // namespace

AdjustResult adjust(const Problem& problem, const ParameterLayout& layout,
                    std::vector<Trajectory>& trajectories, Eigen::VectorXd& x, const AdjustOptions& options) {
  TileSum tiles(trajectories, layout, options.workers);
  AdjustResult result = adjust_all(problem, layout, tiles, &tiles, x, options);
  if (layout.size() == 0) tiles.commit();  // else every accepted point was reduced, and so committed
  tiles.share_states();
  return result;
}

AdjustResult adjust(const Problem& problem, const ParameterLayout& layout, SystemSum& observations,
                    Eigen::VectorXd& x, const AdjustOptions& options) {
  return adjust_all(problem, layout, observations, nullptr, x, options);
}

double prior_cost(const Problem& problem, const ParameterLayout& layout, const Eigen::VectorXd& x) {
  double cost = 0.0;
  for (int i = 0; i < layout.size(); ++i) {
    const Parameter& p = layout.parameters[static_cast<std::size_t>(i)];
    if (std::isfinite(p.prior_sigma)) cost += 0.5 * std::pow((x[i] - p.prior_mean) / p.prior_sigma, 2);
  }
  if (layout.joint_prior) cost += 0.5 * layout.joint_prior->residual(x).squaredNorm();
  const SharedState state = layout.state_of(x);
  for (const ControlDistance& d : problem.site.distances)
    cost += 0.5 * std::pow(distance_row(d, layout, state).residual, 2);
  return cost;
}

namespace {

/// Visits the elements of the information of priors and control distances, some of them several times.
template <class Visit>
void for_each_of_prior(const Problem& problem, const ParameterLayout& layout, const Eigen::VectorXd& x,
                       Visit&& visit) {
  for (int i = 0; i < layout.size(); ++i) {
    const Parameter& p = layout.parameters[static_cast<std::size_t>(i)];
    if (std::isfinite(p.prior_sigma)) visit(i, i, 1.0 / (p.prior_sigma * p.prior_sigma));
  }
  if (layout.joint_prior) {
    const JointPrior& prior = *layout.joint_prior;
    const Eigen::MatrixXd N = prior.root.transpose() * prior.root;
    for (std::size_t i = 0; i < prior.columns.size(); ++i)
      for (std::size_t j = 0; j < prior.columns.size(); ++j)
        visit(prior.columns[i], prior.columns[j],
              N(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)));
  }
  const SharedState state = layout.state_of(x);
  for (const ControlDistance& d : problem.site.distances) {
    const DistanceRow row = distance_row(d, layout, state);
    for (const auto& [i, a] : row.entries)
      for (const auto& [j, b] : row.entries) visit(i, j, a * b);
  }
}

/// Adds up elements of a sparse matrix in portions, so that the list of them stays short.
class SparseSum {
 public:
  explicit SparseSum(int size) : sum_(size, size) {}
  void add(int i, int j, double value) {
    elements_.emplace_back(i, j, value);
    if (elements_.size() >= kPortion) take();
  }
  [[nodiscard]] Eigen::SparseMatrix<double> result() {
    take();
    sum_.makeCompressed();
    Eigen::SparseMatrix<double> result;
    result.swap(sum_);
    return result;
  }

 private:
  static constexpr std::size_t kPortion = 1'000'000;
  void take() {
    Eigen::SparseMatrix<double> portion(sum_.rows(), sum_.cols());
    portion.setFromTriplets(elements_.begin(), elements_.end());
    sum_ += portion;
    elements_.clear();
  }
  Eigen::SparseMatrix<double> sum_;
  std::vector<Eigen::Triplet<double>> elements_;
};

}  // namespace

Eigen::MatrixXd prior_information(const Problem& problem, const ParameterLayout& layout,
                                  const Eigen::VectorXd& x) {
  Eigen::MatrixXd prior = Eigen::MatrixXd::Zero(layout.size(), layout.size());
  for_each_of_prior(problem, layout, x, [&](int i, int j, double value) { prior(i, j) += value; });
  return prior;
}

Eigen::SparseMatrix<double> sparse_information_at(const Problem& problem, const ParameterLayout& layout,
                                                  std::vector<Trajectory>& trajectories,
                                                  const Eigen::VectorXd& x, const RobustLoss& loss,
                                                  const Workers& workers) {
  const SharedState state = layout.state_of(x);
  TileSum tiles(trajectories, layout, workers);
  static_cast<void>(tiles.settle(state, loss));
  std::vector<ReducedSystem> systems;
  tiles.reduce_each(state, loss, systems);
  tiles.share_states();
  SparseSum sum(layout.size());
  for (std::size_t t = 0; t < systems.size(); ++t) {
    const std::vector<int>& columns = tiles.tiles()[t].columns();
    for (std::size_t j = 0; j < columns.size(); ++j)
      for (std::size_t i = 0; i < columns.size(); ++i)
        if (const double h = systems[t].H(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
            h != 0.0)
          sum.add(columns[i], columns[j], h);
    systems[t] = {};
  }
  // The whole diagonal is there, whatever it holds.
  for (int i = 0; i < layout.size(); ++i) sum.add(i, i, 0.0);
  for_each_of_prior(problem, layout, x, [&](int i, int j, double value) { sum.add(i, j, value); });
  return sum.result();
}

Information information_at(const Problem& problem, const ParameterLayout& layout,
                           std::vector<Trajectory>& trajectories, const Eigen::VectorXd& x,
                           const RobustLoss& loss, const Workers& workers) {
  Information info;
  const SharedState state = layout.state_of(x);
  TileSum tiles(trajectories, layout, workers);
  info.data_cost = tiles.settle(state, loss);
  ReducedSystem sum;
  tiles.reduce(state, loss, sum);
  tiles.share_states();
  info.data = std::move(sum.H);
  info.data_gradient = std::move(sum.gradient);
  info.prior = prior_information(problem, layout, x);
  return info;
}

}  // namespace octant::calib
