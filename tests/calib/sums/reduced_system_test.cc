// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Sums of systems that touch some of the parameters, against dense matrices of all.
#include "calib/sums/reduced_system.h"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Dense>

namespace octant::test {
namespace reduced_system_test {

constexpr int kParameters = 400;

/// System of about twenty neighbouring parameters of a long hall.
calib::SystemPart some_part(std::mt19937& random, int parameters = kParameters) {
  std::uniform_int_distribution<int> first(0, parameters - 24);
  std::bernoulli_distribution touched(0.8);
  std::vector<int> columns;
  const int from = first(random);
  for (int c = from; c < from + 24; ++c)
    if (touched(random)) columns.push_back(c);
  calib::SystemPart part = calib::empty_part(columns);
  std::normal_distribution<double> value;
  part.system.cost = value(random);
  for (double& g : part.system.gradient) g = value(random);
  const Eigen::MatrixXd J = part.system.H.unaryExpr([&](double) { return value(random); });
  part.system.H = J.transpose() * J;
  return part;
}

TEST(SystemParts, AddUpToTheDenseMatrix) {
  std::mt19937 random(3);
  calib::SystemParts sum;
  double cost = 0.0;
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(kParameters), of_parts = gradient;
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(kParameters, kParameters);
  for (int i = 0; i < 3000; ++i) {
    const calib::SystemPart part = some_part(random);
    cost += part.system.cost;
    gradient(part.columns) += part.system.gradient;
    H(part.columns, part.columns) += part.system.H;
    sum.add(part);
  }
  EXPECT_NEAR(sum.cost(), cost, 1e-9);
  EXPECT_LT((sum.whole(kParameters).H - H).cwiseAbs().maxCoeff(), 1e-9);
  std::size_t numbers = 0;
  for (const calib::SystemPart& part : sum.parts()) {
    EXPECT_TRUE(std::ranges::is_sorted(part.columns));
    of_parts(part.columns) += part.system.gradient;
    numbers += part.columns.size() * part.columns.size();
  }
  EXPECT_LT((of_parts - gradient).cwiseAbs().maxCoeff(), 1e-9);
  // A band of 24 next to its diagonal has about 19,000 numbers; the whole has 160,000.
  EXPECT_LT(numbers, 60000U);
  EXPECT_GT(sum.parts().size(), 4U);
}

TEST(SystemParts, OfALongListAreJoined) {
  std::mt19937 random(4);
  calib::SystemParts sum;
  constexpr int kMany = 40000;
  for (int i = 0; i < 2000; ++i) sum.add(some_part(random, kMany));
  EXPECT_LE(sum.parts().size(), 256U);
}

TEST(SystemParts, OfAllColumnsAreOne) {
  std::mt19937 random(5);
  calib::SystemParts sum;
  sum.add(calib::empty_part(calib::all_columns(kParameters)));
  for (int i = 0; i < 20; ++i) sum.add(some_part(random));
  ASSERT_EQ(sum.parts().size(), 1U);
  calib::SystemParts twice;
  twice.add(sum);
  twice.add(sum);
  const double cost = sum.cost();
  EXPECT_EQ(twice.whole(kParameters).H, 2 * sum.whole(kParameters).H);
  sum.scale(2.0);
  EXPECT_EQ(sum.cost(), 2 * cost);
  EXPECT_EQ(twice.whole(kParameters).H, sum.whole(kParameters).H);
}

}  // namespace reduced_system_test
}  // namespace octant::test
