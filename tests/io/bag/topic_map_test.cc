// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/bag/topic_map.h"

#include "tests/io/io_support.h"

namespace octant::io::test {
namespace topic_map_test {

TEST(TopicMap, WhatIsWrittenReadsBack) {
  const auto mapping = topics_from_words(
      "range=/uwb/{receiver}/{beacon},range:B3:r1=/kit/range_3,range=/all@a_{beacon},odometry=/odom,poses=/"
      "tf@map>base_link,"
      "truth=/gt,time=recorded");
  ASSERT_TRUE(mapping) << mapping.error().message();
  TopicMapping with_ignored = *mapping;
  with_ignored.ignore = {"N1", "no"};
  const TemporaryFolder box;
  const auto again = read_topics(box.write("topics.yaml", topics_to_yaml(with_ignored)));
  ASSERT_TRUE(again) << again.error().message();
  ASSERT_EQ(again->ranges.size(), 3U);
  EXPECT_EQ(again->ranges[1].topic, "/kit/range_3");
  EXPECT_EQ(again->ranges[1].beacon, "B3");
  EXPECT_EQ(again->ranges[1].receiver, "r1");
  EXPECT_EQ(again->ranges[2].frame, "a_{beacon}");
  EXPECT_EQ(again->odometry->topic, "/odom");
  EXPECT_EQ(again->poses->child, "base_link");
  EXPECT_EQ(again->truth->topic, "/gt");
  EXPECT_TRUE(again->recorded_time);
  EXPECT_EQ(again->ignore, with_ignored.ignore);
}

TEST(TopicMap, FaultsAreNamed) {
  for (const auto& [words, found] : {std::pair("range=/r", "does not say of which beacon"),
                                     {"range=/r/{anchor}", "'{anchor}' where a name is to stand"},
                                     {"range=/r/{beacon", "where a name is to stand"},
                                     {"speed=/r", "'speed=/r' is none of a bag's topics"},
                                     {"odometry", "names no topic"},
                                     {"odometry=/a,odometry=/b", "twice"},
                                     {"time=never", "none of a bag's"},
                                     {"range=*********{beacon}", "more than 8"}}) {
    const auto mapping = topics_from_words(words);
    ASSERT_FALSE(mapping) << words;
    EXPECT_THAT(mapping.error().message(), testing::HasSubstr(found));
    EXPECT_EQ(mapping.error().code, Errc::kUsage);
  }
  const TemporaryFolder box;
  expect_error(read_topics(box.write("a.yaml", "octant_topics: 1\nranges: [{topic: /r}]\n")), 0,
               "of which beacon");
  expect_error(read_topics(box.write("b.yaml", "octant_topics: 2\n")), 1, "octant_topics");
  expect_error(read_topics(box.write("c.yaml", "octant_topics: 1\ntime: never\n")), 2, "never");
}

}  // namespace topic_map_test
}  // namespace octant::io::test
