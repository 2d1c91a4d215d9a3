// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/chain/chain_reduction.h"

#include <cmath>
#include <numeric>
#include <ostream>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/SparseCholesky>

#include "calib/adjust/tile.h"
#include "calib/problem/shared_entries.h"
#include "calib/stream/drives/end_chain.h"
#include "models/trajectory/linearise.h"
#include "models/trajectory/solve_states.h"
#include "models/trajectory/stretches.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace chain_reduction_test {

struct Kind {
  const char* name;
  Motion motion = Motion::kPlanar;
  bool cycle_offset = false, attenuation = false, pair_bias = false, motion_prior = false;
  std::size_t nodes = 1800;
  bool others = true;           ///< bearings and measured poses
  std::size_t heard_every = 1;  ///< one of this number of states receives
};

/// A drive among the beacons of the hall whose observations have noise, and whose states have larger errors.
struct Chain {
  calib::Problem problem;
  SharedState state;
  calib::ParameterLayout layout;
  Trajectory t;
  std::mt19937 random{7};
  std::normal_distribution<double> n;

  explicit Chain(const Kind& kind) {
    Scenario s = hall_scenario();
    s.site.motion = kind.motion;
    if (kind.attenuation) add_attenuation(s);
    if (kind.pair_bias) s.site.noise.pair_sigma_s = 1e-6;
    if (kind.cycle_offset) s.site.timing.clock = Clock::kCycleOffset;
    problem.site = s.site;
    problem.runs.resize(1);
    state = prior_state(problem.site);
    layout = calib::make_layout(problem, state);
    t.motion = kind.motion;
    t.moving = true;
    t.has_cycle_offset = kind.cycle_offset;
    if (kind.motion_prior) t.motion_prior = MotionPrior{};
    make_states(kind);
    for (std::size_t k = 0; k < kind.nodes; ++k) observe(kind, k);
    t.segments.push_back({0, kind.nodes, 0, t.arrivals.size(), 0, t.bearings.size(), 0, t.poses.size(), 0,
                          t.odometry.size(), 0, t.motion_steps.size()});
    for (Node& node : t.nodes)
      node.T_map_vehicle = retract(
          node.T_map_vehicle,
          1e-3 * Eigen::VectorXd::NullaryExpr(pose_dof(t.motion), [&] { return n(random); }), t.motion);
  }

  void make_states(const Kind& kind) {
    for (std::size_t k = 0; k < kind.nodes; ++k) {
      const double a = 0.01 * static_cast<double>(k);
      Node node;
      node.time_s = 0.05 * static_cast<double>(k);
      node.placed = true;
      node.T_map_vehicle = Pose::planar(10 + 6 * std::cos(a), 6 + 4 * std::sin(a), a + 1.5);
      if (kind.motion == Motion::kSpatial)
        node.T_map_vehicle.rotation = node.T_map_vehicle.rotation * exp_rotation({0.1 * n(random), 0.1, 0.0});
      if (kind.motion_prior) node.velocity = {0.3 * n(random), 0.3, 0.1};
      t.nodes.push_back(node);
    }
  }

  void observe(const Kind& kind, std::size_t k) {
    const bool last = k + 1 == kind.nodes;
    for (int i = 0; i < (kind.nodes == 1 ? 8 : 2) && k % kind.heard_every == 0; ++i) {
      ArrivalObservation a;
      a.node = static_cast<std::uint32_t>(k);
      a.alpha = last || kind.motion_prior ? 0.0 : 0.2 + 0.3 * i;
      a.time_s = t.nodes[k].time_s + 0.05 * a.alpha;
      a.beacon = BeaconId((k + static_cast<std::size_t>(3 * i)) % state.beacon_p_map_m.size());
      a.receiver = ReceiverId((k / 3 + static_cast<std::size_t>(i)) % state.receiver_p_vehicle_m.size());
      a.sigma_s = 1e-5;
      a.model_speed_mps = 343.0;
      if (kind.attenuation) a.log_amplitude_sigma = 0.05;
      if (k % 11 == 5 && i == 0) a.rejection = Rejection::kLate;
      t.arrivals.push_back(a);
      t.arrivals.back().tof_s = -a.sigma_s * (arrival_residual(t, a, state) + n(random));
    }
    if (kind.others && k % 50 == 7 && !last) {
      t.poses.push_back({k, 0.3, t.nodes[k].T_map_vehicle, 0.05, 0.05, 0.05});
      if (kind.motion == Motion::kPlanar)
        t.bearings.push_back({k, 0.5, t.bearings.size(), BeaconId(1), 0.7, 0.5, Rejection::kUsed});
    }
    if (kind.motion_prior) {
      if (k == 0) t.motion_steps.push_back({0, 0.0});
      if (!last) t.motion_steps.push_back({k, 0.05});
    } else if (!last) {
      const Pose step = t.nodes[k].T_map_vehicle.inverse() * t.nodes[k + 1].T_map_vehicle;
      t.odometry.push_back({k, step, 0.002, 0.003});
    }
  }
};

/// Reference by sparse factors of all rows at once.
calib::ReducedSystem by_sparse_factors(const Chain& chain, const RobustLoss& loss) {
  const Eigen::Index size = chain.t.block_size(),
                     states = size * static_cast<Eigen::Index>(chain.t.nodes.size()), m = chain.layout.size();
  std::vector<Eigen::Triplet<double>> of_states;
  Eigen::MatrixXd B = Eigen::MatrixXd::Zero(states, m + 1), H = Eigen::MatrixXd::Zero(m, m);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(m);
  double cost = 0.0;
  for_each_row(chain.t, chain.t.segments[0], chain.state, [&](const ObservationRow& row) {
    double rho = row.residual * row.residual, w = 1.0;
    if (is_robust(row.kind)) loss.evaluate(row.residual, rho, w);
    cost += 0.5 * rho;
    std::vector<std::pair<Eigen::Index, double>> x, s;
    for (Eigen::Index i = 0; i < size; ++i) {
      x.emplace_back(static_cast<Eigen::Index>(row.node) * size + i, row.by_node[i]);
      if (row.has_next) x.emplace_back(static_cast<Eigen::Index>(row.node + 1) * size + i, row.by_next[i]);
    }
    const calib::RowEntries e = calib::row_entries(row, 0, chain.layout, chain.state);
    for (std::size_t i = 0; i < static_cast<std::size_t>(e.count); ++i)
      s.emplace_back(e.column[i], e.value[i]);
    for (const auto& [i, a] : x) {
      for (const auto& [j, b] : x) of_states.emplace_back(i, j, w * a * b);
      for (const auto& [j, b] : s) B(i, j) += w * a * b;
      B(i, m) += w * a * row.residual;
    }
    for (const auto& [i, a] : s) {
      for (const auto& [j, b] : s) H(i, j) += w * a * b;
      g[i] += w * a * row.residual;
    }
  });
  Eigen::SparseMatrix<double> A(states, states);
  A.setFromTriplets(of_states.begin(), of_states.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(A);
  EXPECT_EQ(factor.info(), Eigen::Success);
  const Eigen::MatrixXd X = factor.solve(B);
  calib::ReducedSystem out;
  out.H = H - B.leftCols(m).transpose() * X.leftCols(m);
  out.gradient = g - B.leftCols(m).transpose() * X.col(m);
  out.cost = cost - 0.5 * B.col(m).dot(X.col(m));
  return out;
}

calib::ReducedSystem by_chain(const Chain& chain, const RobustLoss& loss, int threads) {
  const calib::ChainReduction reduction(chain.t, chain.layout, {0});
  std::vector<int> place(static_cast<std::size_t>(chain.layout.size()));
  std::iota(place.begin(), place.end(), 0);
  calib::ReducedSystem out;
  out.H.setZero(chain.layout.size(), chain.layout.size());
  out.gradient.setZero(chain.layout.size());
  out.cost = reduction.reduce(chain.t.segments[0], chain.state, loss, place, threads, out);
  out.H = out.H.selfadjointView<Eigen::Lower>();
  return out;
}

/// As ctest names it.
void PrintTo(const Kind& kind, std::ostream* out) { *out << kind.name; }

class ChainReductionOf : public testing::TestWithParam<Kind> {};

TEST_P(ChainReductionOf, IsTheSchurComplementOfAllRows) {
  const Chain chain(GetParam());
  for (const RobustLoss& loss : {RobustLoss{}, RobustLoss{.late_scale = 1.5, .early_scale = 2.5}}) {
    const calib::ReducedSystem dense = by_sparse_factors(chain, loss), here = by_chain(chain, loss, 1);
    // Both lose some digits if states absorb nearly all information on a parameter.
    const Eigen::VectorXd scale = dense.H.diagonal().cwiseMax(1e-9).cwiseSqrt();
    const Eigen::MatrixXd off =
        scale.cwiseInverse().asDiagonal() * (here.H - dense.H) * scale.cwiseInverse().asDiagonal();
    EXPECT_LT(off.cwiseAbs().maxCoeff(), 1e-7);
    EXPECT_LT((here.gradient - dense.gradient).cwiseQuotient(scale).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_NEAR(here.cost, dense.cost, 1e-9 * dense.cost);
  }
}

TEST_P(ChainReductionOf, DoesNotDependOnTheNumberOfThreads) {
  const Chain chain(GetParam());
  const calib::ReducedSystem one = by_chain(chain, {}, 1), three = by_chain(chain, {}, 3);
  EXPECT_EQ(one.H, three.H);
  EXPECT_EQ(one.gradient, three.gradient);
  EXPECT_EQ(one.cost, three.cost);
}

/// The chain in pieces that share their ends.
struct Pieces {
  Chain& chain;
  std::vector<std::size_t> ends;
  std::vector<Trajectory> parts{};

  void cut() {
    const Segment& all = chain.t.segments[0];
    for (std::size_t first = 0, k = 0; k <= ends.size(); ++k) {
      const std::size_t last = k < ends.size() ? ends[k] : all.last_node - 1;
      Segment s = stretch_of(chain.t, all, first, last + 1);
      if (k == ends.size()) s.last_arrival = all.last_arrival;  // those at the last state as well
      parts.push_back(pick_segments(chain.t, {s}));
      first = last;
    }
  }
  /// @param held  solves the inner states first
  calib::EndChain joined(bool held) {
    std::vector<int> place(static_cast<std::size_t>(chain.layout.size()));
    std::iota(place.begin(), place.end(), 0);
    calib::EndChain join(chain.layout.size(), chain.t.block_size());
    for (std::size_t k = 0; k < parts.size(); ++k) {
      calib::OpenChain piece;
      piece.has_left = k > 0;
      piece.has_right = k + 1 < parts.size();
      if (held)
        solve_states(parts[k], parts[k].segments[0], chain.state, {},
                     {.hold_first = piece.has_left, .hold_last = piece.has_right});
      calib::ChainReduction(parts[k], chain.layout, {0})
          .reduce_open(parts[k].segments[0], chain.state, {}, place, place.size(), piece);
      join.append(piece);
    }
    return join;
  }
};

class OpenChainsOf : public testing::TestWithParam<Kind> {};

TEST_P(OpenChainsOf, JoinToTheWhole) {
  Chain chain(GetParam());
  const calib::ReducedSystem whole = by_sparse_factors(chain, {});
  Pieces pieces{chain, {300, 301, 900, 1500}};
  pieces.cut();
  calib::ReducedSystem here;
  here.H.setZero(chain.layout.size(), chain.layout.size());
  here.gradient.setZero(chain.layout.size());
  pieces.joined(false).add_to(here);
  const Eigen::VectorXd scale = whole.H.diagonal().cwiseMax(1e-9).cwiseSqrt();
  const Eigen::MatrixXd off =
      scale.cwiseInverse().asDiagonal() * (here.H - whole.H) * scale.cwiseInverse().asDiagonal();
  EXPECT_LT(off.cwiseAbs().maxCoeff(), 1e-7);
  EXPECT_LT((here.gradient - whole.gradient).cwiseQuotient(scale).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_NEAR(here.cost, whole.cost, 1e-9 * whole.cost);
}

// With unchanged parameters, the steps of the ends lead to the solution of the whole chain.
TEST_P(OpenChainsOf, EndsStepToWhereTheWholeRests) {
  Kind kind = GetParam();
  kind.others = kind.motion == Motion::kSpatial;  // whose arrivals alone leave states loose
  Chain chain(kind);
  Pieces pieces{chain, {300, 301, 900, 1500}};
  pieces.cut();
  for (int round = 0; round < 4; ++round) {
    const std::vector<NodeVector> steps =
        pieces.joined(true).steps(Eigen::VectorXd::Zero(chain.layout.size()));
    ASSERT_EQ(steps.size(), pieces.ends.size());
    for (std::size_t k = 0; k < steps.size(); ++k) {
      Node& end = pieces.parts[k].nodes.back();
      step_node(chain.t, steps[k], end);
      pieces.parts[k + 1].nodes.front() = end;
    }
  }
  solve_states(chain.t, chain.t.segments[0], chain.state, {});
  for (std::size_t k = 0; k < pieces.ends.size(); ++k) {
    const Node &here = pieces.parts[k].nodes.back(), &there = chain.t.nodes[pieces.ends[k]];
    EXPECT_LT((here.T_map_vehicle.translation_m - there.T_map_vehicle.translation_m).norm(), 1e-7) << k;
    EXPECT_LT(here.T_map_vehicle.rotation.angularDistance(there.T_map_vehicle.rotation), 1e-7) << k;
    EXPECT_LT(std::abs(here.cycle_offset_s - there.cycle_offset_s) * chain.t.nominal_speed_mps, 1e-7) << k;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, OpenChainsOf,
    testing::Values(Kind{.name = "with_others"}, Kind{.name = "cycle_offset", .cycle_offset = true},
                    Kind{.name = "spatial", .motion = Motion::kSpatial},
                    Kind{.name = "spatial_offset", .motion = Motion::kSpatial, .cycle_offset = true}),
    [](const auto& kind) { return std::string(kind.param.name); });

INSTANTIATE_TEST_SUITE_P(
    Kinds, ChainReductionOf,
    testing::Values(
        Kind{.name = "plain", .others = false}, Kind{.name = "with_others"},
        Kind{.name = "one_state", .nodes = 1, .others = false},
        Kind{.name = "one_state_in_space", .motion = Motion::kSpatial, .nodes = 1, .others = false},
        Kind{.name = "short", .nodes = 40}, Kind{.name = "seldom_heard", .others = false, .heard_every = 7},
        Kind{.name = "seldom_heard_with_others", .heard_every = 70},
        Kind{.name = "seldom_heard_in_space", .motion = Motion::kSpatial, .heard_every = 4},
        Kind{.name = "first_cut", .nodes = 1025}, Kind{.name = "pair_bias", .pair_bias = true},
        Kind{.name = "cycle_offset", .cycle_offset = true}, Kind{.name = "attenuation", .attenuation = true},
        Kind{.name = "motion_prior", .motion_prior = true, .others = false},
        Kind{.name = "spatial", .motion = Motion::kSpatial},
        Kind{.name = "spatial_offset", .motion = Motion::kSpatial, .cycle_offset = true}),
    [](const auto& kind) { return std::string(kind.param.name); });

}  // namespace chain_reduction_test
}  // namespace octant::test
