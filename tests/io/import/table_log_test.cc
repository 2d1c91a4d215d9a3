// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/import/table_log.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "io/text/atomic_file.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace {

struct Case {
  const char *name, *words, *table, *csv;
};

TEST(TableMappingWords, AreUtf8) {
  const auto mapping = mapping_from_words("time=t,beacon=b,distance=d_\x89");
  ASSERT_FALSE(mapping);
  EXPECT_EQ(mapping.error().code, Errc::kUsage);
  EXPECT_TRUE(mapping_from_words("time=t,beacon=b,distance=L\xC3\xA4nge"));
}

TEST(TableLog, TablesAsTheyCome) {
  const Case cases[] = {
      {"a radio kit's", "time=timestamp_ms*1e-3,beacon=anchor,distance=distance_cm*1e-2",
       "timestamp_ms;anchor;distance_cm\n1500;A1;612\n1600;A2;633.5\n",
       "time_s,beacon,distance_m\n1.5,A1,6.12\n1.6,A2,6.335\n"},
      {"units by suffix", "time=timestamp_ms,beacon=anchor,distance=distance_cm",
       "anchor,distance_cm,timestamp_ms\nA1,612,1500\n", "time_s,beacon,distance_m\n1.5,A1,6.12\n"},
      {"decimal commas", "time=t,beacon=b,tof=tof_s", "t;b;tof_s\n0,5;\"B;1\";0,25\n",
       "time_s,beacon,tof_s\n0.5,B;1,0.25\n"},
      {"tabulators, byte-order mark, CRLF", "time=t,beacon=b,tof=d",
       "\xEF\xBB\xBF# words\r\nt\tb\td\r\n1\tB 1\t2\r\n", "time_s,beacon,tof_s\n1,B 1,2\n"},
      {"blanks", "time=t,beacon=b,tof=d,receiver=r", "t   b  r d\n1   B1 0 2\n",
       "time_s,beacon,tof_s,receiver\n1,B1,2,0\n"},
      {"out of order, empty cells", "time=t,beacon=b,tof=d", "t,b,d\n2,B1,0.1\n1,B2,\n3,,0.1\n",
       "time_s,beacon,tof_s\n1,B2,\n2,B1,0.1\n"},
  };
  const test::TemporaryFolder box;
  for (const Case& c : cases) {
    ASSERT_TRUE(write_file(box.path("table.txt"), c.table));
    const auto mapping = mapping_from_words(c.words);
    ASSERT_TRUE(mapping) << c.name;
    const auto table = convert_table(box.path("table.txt"), *mapping);
    ASSERT_TRUE(table) << c.name << ": " << table.error().message();
    EXPECT_EQ(table->csv, c.csv) << c.name;
  }
}

TEST(TableLog, BeaconsOfANeighbourAreIgnored) {
  const test::TemporaryFolder box;
  ASSERT_TRUE(write_file(box.path("t.csv"), "t,b,d\n1,B1,1\n1,X7,1\n2,B1,1\n"));
  auto mapping = mapping_from_words("time=t,beacon=b,tof=d");
  ASSERT_TRUE(mapping);
  mapping->ignore = {"X7", "X8"};
  const auto table = convert_table(box.path("t.csv"), *mapping);
  ASSERT_TRUE(table);
  EXPECT_EQ(table->rows, 2u);
  EXPECT_EQ(table->ignored, 1u);
}

TEST(TableLog, MappingsAreKept) {
  const test::TemporaryFolder box;
  auto mapping = mapping_from_words("time=timestamp_ms,beacon=anchor id,distance=\"d\"*0.3048,epoch=stop");
  ASSERT_TRUE(mapping);
  mapping->ignore = {"A9", "8"};
  ASSERT_TRUE(write_file(box.path("m.yaml"), mapping_to_yaml(*mapping)));
  const auto again = read_mapping(box.path("m.yaml"));
  ASSERT_TRUE(again) << again.error().message();
  ASSERT_EQ(again->columns.size(), 4u);
  for (const ColumnRule& rule : mapping->columns) {
    const auto same = [&](const ColumnRule& r) {
      return r.target == rule.target && r.source == rule.source && r.factor == rule.factor;
    };
    EXPECT_EQ(std::count_if(again->columns.begin(), again->columns.end(), same), 1) << rule.target;
  }
  EXPECT_EQ(again->ignore, mapping->ignore);
}

TEST(TableLog, FaultsAreNamed) {
  const auto found = [](const char* words) {
    const auto mapping = mapping_from_words(words);
    return mapping ? std::string() : mapping.error().message();
  };
  EXPECT_NE(found("when=t,beacon=b,tof=d").find("'when' is no column of tof.csv"), std::string::npos);
  EXPECT_NE(found("time=t,beacon=b").find("do not say what was heard when"), std::string::npos);
  EXPECT_NE(found("time=t,beacon=b,tof=d,distance=e").find("do not say"), std::string::npos);
  EXPECT_NE(found("time=t,time=u,beacon=b,tof=d").find("twice"), std::string::npos);
  EXPECT_NE(found("time=t*fast,beacon=b,tof=d").find("'fast' is no factor"), std::string::npos);
  EXPECT_NE(found("time=,beacon=b,tof=d").find("has no column"), std::string::npos);

  const test::TemporaryFolder box;
  const auto mapping = mapping_from_words("time=t,beacon=b,tof=d");
  ASSERT_TRUE(mapping);
  const auto fault = [&](const char* table) {
    EXPECT_TRUE(write_file(box.path("t.csv"), table));
    const auto converted = convert_table(box.path("t.csv"), *mapping);
    return converted ? std::string() : converted.error().message();
  };
  EXPECT_NE(fault("t,b,dist\n1,B1,2\n").find("no column 'd'"), std::string::npos);
  EXPECT_NE(fault("t,b,d\n1,B1,far\n").find("t.csv:2"), std::string::npos);
  EXPECT_NE(fault("t,b,d\n,B1,1\n").find("without a time"), std::string::npos);
  EXPECT_NE(fault("").find("empty"), std::string::npos);
  EXPECT_NE(fault("t,b,d\n").find("no rows under its header"), std::string::npos);
  EXPECT_NE(fault("t,b,d\n1,\"B1,2\n2,B2,1\n").find("t.csv:2: a quote that does not end"), std::string::npos);
  EXPECT_NE(fault("t,\"b,d\n1,B1,2\n").find("t.csv:1: a quote that does not end"), std::string::npos);
  EXPECT_NE(fault("t,b,d\n\"1,5\",B1,2\n").find("decimal comma"), std::string::npos);
  EXPECT_EQ(fault("t,b,d\n1,5,B1,2\n").find("decimal comma"), std::string::npos);
  EXPECT_NE(fault("t,b,d\n1,\xFF,1\n").find("t.csv"), std::string::npos);
}

}  // namespace
}  // namespace octant::io
