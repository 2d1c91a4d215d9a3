// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Information of data and priors, dense and sparse, against one dense elimination of all rows.
#include "calib/adjust/information.h"

#include <vector>

#include <gtest/gtest.h>

#include "calib/adjust/priors.h"
#include "tests/calib/adjust/near_truth.h"

namespace octant::test {
namespace information_test {

TEST(Information, OfDataIsThatOfTheTilesAndOfPriorsThatOfThese) {
  const NearTruth near(some_stops());
  std::vector<Trajectory> trajectories = near.trajectories;
  const calib::Information all = calib::information_at(near.problem, near.layout, trajectories, near.x);
  calib::ReducedSystem here;
  here.H = all.data;
  here.gradient = all.data_gradient;
  here.cost = all.data_cost;
  expect_same_system(here, near.dense(), 1e-6);
  EXPECT_EQ(all.data, all.data.transpose()) << "both triangles";
  EXPECT_EQ(all.prior, calib::prior_information(near.problem, near.layout, near.x));
}

TEST(Information, SparseIsTheSumOfBoth) {
  for (const Scenario& scenario : {some_stops(), short_drive()}) {
    const NearTruth near(scenario);
    std::vector<Trajectory> one = near.trajectories, other = near.trajectories;
    const calib::Information all = calib::information_at(near.problem, near.layout, one, near.x);
    const Eigen::MatrixXd sparse = calib::sparse_information_at(near.problem, near.layout, other, near.x);
    const Eigen::MatrixXd sum = all.data + all.prior;
    const Eigen::VectorXd scale = sum.diagonal().cwiseSqrt().cwiseInverse();
    EXPECT_LT((scale.asDiagonal() * (sparse - sum) * scale.asDiagonal()).cwiseAbs().maxCoeff(), 1e-10);
  }
}

}  // namespace information_test
}  // namespace octant::test
