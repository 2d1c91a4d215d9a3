// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/stream/pass_sum.h"

#include <algorithm>
#include <set>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

namespace octant::test {
namespace pass_sum_test {

RC_GTEST_PROP(OrderedParts, AreTakenInTheirOrderWhicheverIsReadyFirst, ()) {
  const auto count = static_cast<std::size_t>(*rc::gen::inRange(1, 30));
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < count; ++i) order.push_back(i + 4);
  for (std::size_t i = count; i > 1; --i)
    std::swap(order[i - 1], order[static_cast<std::size_t>(*rc::gen::inRange(0, static_cast<int>(i)))]);
  calib::OrderedParts<int> parts(4);
  std::vector<std::size_t> taken;
  for (const std::size_t k : order) {
    parts.add(k, static_cast<int>(10 * k), [&](std::size_t part, int value) {
      RC_ASSERT(value == static_cast<int>(10 * part));
      taken.push_back(part);
    });
    // As soon as all previous parts are complete: all before the first missing one.
    std::set<std::size_t> ready(order.begin(), std::find(order.begin(), order.end(), k) + 1);
    std::size_t first_missing = 4;
    while (ready.contains(first_missing)) ++first_missing;
    RC_ASSERT(taken.size() == first_missing - 4);
  }
  RC_ASSERT(std::is_sorted(taken.begin(), taken.end()) && taken.size() == count);
}

TEST(PassCounts, GoThroughTheirNumbersAndAddUp) {
  calib::PassCounts a;
  a.cost_before = 1.25;
  a.changed = 7;
  a.of_log.used = 100;
  a.of_log.rejected = 5;
  a.of_log.observations = 321;
  a.of_log.states = 60;
  a.poses = {12.5, 33.75, 3.5, 44.0};
  const auto numbers_of = [](const calib::PassCounts& counts) {
    std::vector<double> numbers;
    calib::BufferWriter writer(numbers);
    exchange(writer, counts);
    return numbers;
  };
  const std::vector<double> numbers = numbers_of(a);
  calib::BufferReader reader(numbers);
  calib::PassCounts back;
  exchange(reader, back);
  EXPECT_TRUE(reader.ended());
  EXPECT_EQ(numbers_of(back), numbers);
  EXPECT_EQ(std::set<double>(numbers.begin(), numbers.end()).size(), numbers.size()) << "each its own place";
  calib::PassCounts twice = a;
  twice.add(back);
  for (std::size_t i = 0; i < numbers.size(); ++i) EXPECT_EQ(numbers_of(twice)[i], 2 * numbers[i]);
}

}  // namespace pass_sum_test
}  // namespace octant::test
