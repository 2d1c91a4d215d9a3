// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/table/table_log.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "io/table/mapping_text.h"
#include "io/text/atomic_file.h"
#include "tests/io/io_support.h"
#include "tests/io/table/table_support.h"

namespace octant::io {
namespace table_log_test {

using test::csv_of;
using test::message_of;
using Case = test::TableCase;

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
      {"a unit in brackets", "time=t,beacon=b,tof=Laufzeit [ms]", "t;b;Laufzeit [ms]\n1;B1;20,5\n",
       "time_s,beacon,tof_s\n1,B1,0.0205\n"},
      {"dates", "time=when,beacon=b,tof=d",
       "when,b,d\n2026-06-11 11:33:48.5,B1,1\n2026-06-11T11:33:49Z,B1,2\n",
       "time_s,beacon,tof_s\n1781177628.5,B1,1\n1781177629,B1,2\n"},
      {"a counter that starts again", "time=micros,beacon=b,tof=d",
       "micros,b,d\n4294900000,B1,1\n32704,B1,2\n", "time_s,beacon,tof_s\n4294.9,B1,1\n4295,B1,2\n"},
      {"times of reception on the same clock", "time=micros,beacon=b,tof=d,received=logged_us",
       "micros,b,d,logged_us\n4294900000,B1,1,4294950000\n32704,B1,2,157704\n",
       "time_s,beacon,tof_s,received_s\n4294.9,B1,1,4294.95\n4295,B1,2,4295.125\n"},
      {"stamps in nanoseconds", "time=stamp,beacon=b,tof=d", "stamp,b,d\n1585909600500000000,B1,1\n",
       "time_s,beacon,tof_s\n1585909600.5,B1,1\n"},
      {"a column for each beacon", "time=t,distance=r_{beacon},epoch=stop",
       "t,r_A1,r_A2,q,stop\n1,1.5,,7,0\n2,nan,2.5,7,1\n",
       "time_s,beacon,distance_m,epoch\n1,A1,1.5,0\n2,A2,2.5,1\n"},
      {"a column for each beacon and receiver", "time=t,distance=d_{receiver}_{beacon}_cm",
       "t,d_l_A1_cm,d_r_A1_cm\n1,150,160\n", "time_s,beacon,distance_m,receiver\n1,A1,1.5,l\n1,A1,1.6,r\n"},
      {"columns of named beacons", "time=t,tof:A1=one,tof:A2:left=two*1e-3", "t,one,two\n1,0.5,20\n",
       "time_s,beacon,tof_s,receiver\n1,A1,0.5,\n1,A2,0.02,left\n"},
      {"without a header line", "time=#1*1e-3,distance:A1=#3,distance:A2=#2", "500,1.5,nan\n1000,2.5,3.5\n",
       "time_s,beacon,distance_m\n0.5,A2,1.5\n1,A1,3.5\n1,A2,2.5\n"},
      {"numbers of columns under a header", "time=#1,beacon=#2,distance=#3", "ms,id,r (cm)\n500,A1,150\n",
       "time_s,beacon,distance_m\n0.5,A1,1.5\n"},
      {"out of order, empty cells", "time=t,beacon=b,tof=d", "t,b,d\n2,B1,0.1\n1,B2,\n3,,0.1\n",
       "time_s,beacon,tof_s\n1,B2,\n2,B1,0.1\n"},
  };
  const test::TemporaryFolder box;
  for (const Case& c : cases) {
    ASSERT_TRUE(write_file(box.path("table.txt"), c.table));
    const auto mapping = mapping_from_words(c.words);
    ASSERT_TRUE(mapping) << c.name;
    EXPECT_EQ(csv_of(box.path("table.txt"), *mapping), c.csv) << c.name;
  }
}

TEST(TableLog, BeaconsOfANeighbourAreIgnored) {
  const test::TemporaryFolder box;
  ASSERT_TRUE(write_file(box.path("t.csv"), "t,b,d\n1,B1,1\n1,X7,1\n2,B1,1\n"));
  auto mapping = mapping_from_words("time=t,beacon=b,tof=d");
  ASSERT_TRUE(mapping);
  mapping->ignore = {"X7", "X8"};
  const auto table = read_table_log(box.path("t.csv"), *mapping);
  ASSERT_TRUE(table);
  EXPECT_EQ(table->log.arrivals.size(), 2u);
  EXPECT_EQ(table->log.ignored_rows(), 1u);
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
  EXPECT_NE(found("time:A1=t,beacon=b,tof=d").find("'time:A1' is no column"), std::string::npos);
  EXPECT_NE(found("time=t,tof:=d").find("names no beacon"), std::string::npos);
  EXPECT_NE(found("time=t,tof=d_{anchor}").find("'{anchor}' where a name is to stand"), std::string::npos);
  EXPECT_NE(found("time=t,tof=d_{receiver}").find("does not name the beacon"), std::string::npos);
  EXPECT_NE(found("time=t,beacon=b,tof:A1=d").find("both a column of beacons"), std::string::npos);
  EXPECT_NE(found("time=t,tof:A1=d,tof:A1=e").find("several columns for A1"), std::string::npos);
  EXPECT_NE(found("time=t,tof=d_{beacon},tof:A1=e").find("several columns for d_{beacon}"),
            std::string::npos);
  EXPECT_NE(found("time=t,tof=d_{receiver}_{beacon},receiver=r").find("both a column of receivers"),
            std::string::npos);

  const test::TemporaryFolder box;
  const auto mapping = mapping_from_words("time=t,beacon=b,tof=d");
  ASSERT_TRUE(mapping);
  const auto fault = [&](const char* table) {
    EXPECT_TRUE(write_file(box.path("t.csv"), table));
    return message_of(box.path("t.csv"), *mapping);
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

TEST(TableLog, ATableWithoutAHeaderLosesNoRow) {
  const test::TemporaryFolder box;
  ASSERT_TRUE(write_file(box.path("t.csv"), "1000,28486,4.5\n2000,28435,nan\n"));
  const auto by_name = mapping_from_words("time=1000,beacon=28486,distance=4.5");
  ASSERT_TRUE(by_name);
  const std::string refused = message_of(box.path("t.csv"), *by_name);
  EXPECT_NE(refused.find("t.csv:1: the first line holds numbers only"), std::string::npos) << refused;
  EXPECT_NE(refused.find("time=#1,beacon=#2,distance=#3"), std::string::npos) << refused;
  const auto numbered = mapping_from_words("time=#1*1e-3,beacon=#2,distance=#3");
  ASSERT_TRUE(numbered);
  EXPECT_EQ(csv_of(box.path("t.csv"), *numbered), "time_s,beacon,distance_m\n1,28486,4.5\n2,28435,\n");
  // A row is no header because the beacon has a name.
  ASSERT_TRUE(write_file(box.path("t.csv"), "1000,A1,4.5\n2000,A2,5\n"));
  EXPECT_EQ(csv_of(box.path("t.csv"), *numbered), "time_s,beacon,distance_m\n1,A1,4.5\n2,A2,5\n");
  // A first row that looks like a header line is not lost if the table is said to have none.
  auto without = *numbered;
  without.no_header = true;
  ASSERT_TRUE(write_file(box.path("t.csv"), "1000,A1,timeout\n2000,A2,5\n"));
  EXPECT_EQ(csv_of(box.path("t.csv"), without), "time_s,beacon,distance_m\n1,A1,\n2,A2,5\n");
}

TEST(TableLog, MappingsOfOneColumnEachAreKept) {
  const test::TemporaryFolder box;
  for (const char* words : {"time=t,distance=r_{beacon}*1e-2", "time=#1,tof:A1=#2,tof:5:left=two*1e-3"}) {
    const auto mapping = mapping_from_words(words);
    ASSERT_TRUE(mapping) << words;
    ASSERT_TRUE(write_file(box.path("m.yaml"), mapping_to_yaml(*mapping)));
    const auto again = read_mapping(box.path("m.yaml"));
    ASSERT_TRUE(again) << again.error().message();
    ASSERT_EQ(again->columns.size(), mapping->columns.size());
    for (std::size_t i = 0; i < again->columns.size(); ++i) {
      EXPECT_EQ(again->columns[i].source, mapping->columns[i].source);
      EXPECT_EQ(again->columns[i].beacon, mapping->columns[i].beacon);
      EXPECT_EQ(again->columns[i].receiver, mapping->columns[i].receiver);
      EXPECT_EQ(again->columns[i].factor, mapping->columns[i].factor);
    }
  }
}

TEST(TableLog, TheColumnsOfATableAreNamedWithTheWayToReadThem) {
  const test::TemporaryFolder box;
  ASSERT_TRUE(write_file(box.path("t.csv"), "# kit\nwhen;q1;q2\n1;2;3\n"));
  EXPECT_NE(message_of(box.path("t.csv"), {}).find("columns of this one: when, q1, q2"), std::string::npos);
  EXPECT_NE(message_of(box.path("t.csv"), {}).find("--columns time=COLUMN"), std::string::npos);
  ASSERT_TRUE(write_file(box.path("n.csv"), "1,2,3\n"));
  EXPECT_NE(message_of(box.path("n.csv"), {}).find("time=#1"), std::string::npos);
  ASSERT_TRUE(write_file(box.path("words.txt"), "no table\n"));
  EXPECT_NE(message_of(box.path("words.txt"), {}), "");
}

TEST(TableLog, GuessesAreSaidAndOverruled) {
  const test::TemporaryFolder box;
  ASSERT_TRUE(
      write_file(box.path("t.csv"), "time,anchor,dist,valid\n0,A1,0,1\n100,A2,5.5,1\n200,A1,1.234,0\n"));
  TableMapping mapping;
  const auto guessed = read_table_log(box.path("t.csv"), mapping);
  ASSERT_TRUE(guessed) << guessed.error().message();
  ASSERT_EQ(guessed->guessed.size(), 3u) << "columns, unit of the time, cells without a measurement";
  EXPECT_NE(guessed->guessed[0].find("--columns time=time,beacon=anchor,distance=dist"), std::string::npos);
  EXPECT_NE(guessed->guessed[1].find("milliseconds"), std::string::npos);
  EXPECT_EQ(csv_of(box.path("t.csv"), mapping),
            "time_s,beacon,distance_m\n0,A1,\n0.1,A2,5.5\n0.2,A1,1.234\n");
  mapping.time_format = "s";
  mapping.no_value = {"none"};
  EXPECT_EQ(csv_of(box.path("t.csv"), mapping),
            "time_s,beacon,distance_m\n0,A1,0\n100,A2,5.5\n200,A1,1.234\n");
  mapping.no_value = {"5.5"};
  mapping.where = {*condition_from_word("valid=1")};
  EXPECT_EQ(csv_of(box.path("t.csv"), mapping), "time_s,beacon,distance_m\n0,A1,0\n100,A2,\n");
  mapping.where = {*condition_from_word("dist>=1"), *condition_from_word("anchor!=A2")};
  EXPECT_EQ(csv_of(box.path("t.csv"), mapping), "time_s,beacon,distance_m\n200,A1,1.234\n");
  mapping.where = {*condition_from_word("good=1")};
  EXPECT_NE(message_of(box.path("t.csv"), mapping).find("no column 'good'"), std::string::npos);
  EXPECT_FALSE(condition_from_word("valid"));
  EXPECT_FALSE(condition_from_word("=1"));

  ASSERT_TRUE(write_file(box.path("c.csv"), "time,anchor,dist\n\"0,5\",A1,\"1,234\"\n1,A2,6\n"));
  EXPECT_NE(message_of(box.path("c.csv"), {}), "");
  EXPECT_EQ(csv_of(box.path("c.csv"), {.columns = {}, .ignore = {}, .decimal = "comma"}),
            "time_s,beacon,distance_m\n0.5,A1,1.234\n1,A2,6\n");
  ASSERT_TRUE(write_file(box.path("p.csv"), "anchor,dist\nA1,5\nA2,6\n"));
  EXPECT_NE(message_of(box.path("p.csv"), {}), "");
  EXPECT_EQ(csv_of(box.path("p.csv"), {.columns = {}, .ignore = {}, .period_s = 0.5}),
            "time_s,beacon,distance_m\n0,A1,5\n0.5,A2,6\n");
}

TEST(TableLog, MappingsOfRowsAreKept) {
  const test::TemporaryFolder box;
  auto mapping = mapping_from_words("time=Date+Time,beacon=b,distance=d");
  ASSERT_TRUE(mapping);
  mapping->where = {*condition_from_word("valid=1"), *condition_from_word("q>50")};
  mapping->no_header = true;
  mapping->time_format = "mdy";
  mapping->decimal = "comma";
  mapping->no_value = {"-1", "far"};
  mapping->period_s = 0.1;
  ASSERT_TRUE(write_file(box.path("m.yaml"), mapping_to_yaml(*mapping)));
  const auto again = read_mapping(box.path("m.yaml"));
  ASSERT_TRUE(again) << again.error().message();
  ASSERT_EQ(again->where.size(), 2u);
  EXPECT_EQ(again->where[1].relation, ">");
  EXPECT_TRUE(again->no_header);
  EXPECT_EQ(again->time_format, "mdy");
  EXPECT_EQ(again->decimal, "comma");
  EXPECT_EQ(again->no_value, mapping->no_value);
  EXPECT_EQ(again->period_s, mapping->period_s);
}

/// The mapping of a guess reads the table alike, with its unit, order of dates and decimal mark.
TEST(TableLog, TheMappingOfAGuessReadsTheTableAlike) {
  const Case cases[] = {
      {"microseconds", "us", "timestamp,anchor,distance\n0,A1,8.5\n100000,A2,1\n200000,A1,7\n",
       "time_s,beacon,distance_m\n0,A1,8.5\n0.1,A2,1\n0.2,A1,7\n"},
      {"days first", "dmy", "date,time,anchor,distance\n12/04/2026,10:00:00,A1,6\n13/04/2026,10:00:00,A2,4\n",
       "time_s,beacon,distance_m\n1775988000,A1,6\n1776074400,A2,4\n"},
      {"a clock in microseconds that is no date", "us",
       "timestamp,anchor,distance\n200000000000,A1,2\n200000100000,A2,5\n",
       "time_s,beacon,distance_m\n200000,A1,2\n200000.1,A2,5\n"},
      {"a clock that passes 1e11", "ns",
       "timestamp,anchor,distance\n99900000000,A1,2\n100000000000,A2,5\n100100000000,A2,5\n",
       "time_s,beacon,distance_m\n99.9,A1,2\n100,A2,5\n100.1,A2,5\n"},
      {"decimal commas", "", "time;anchor;distance\n0,5;A1;2,25\n1,5;A2;5,5\n",
       "time_s,beacon,distance_m\n0.5,A1,2.25\n1.5,A2,5.5\n"},
  };
  const test::TemporaryFolder box;
  for (const Case& c : cases) {
    ASSERT_TRUE(write_file(box.path("t.csv"), c.table));
    const auto guess = read_table_log(box.path("t.csv"), {});
    ASSERT_TRUE(guess) << c.name << guess.error().message();
    EXPECT_EQ(guess->mapping.time_format, c.words) << c.name;
    EXPECT_EQ(csv_of(box.path("t.csv"), {}), c.csv) << c.name;
    ASSERT_TRUE(write_file(box.path("m.yaml"), mapping_to_yaml(guess->mapping)));
    const auto saved = read_mapping(box.path("m.yaml"));
    ASSERT_TRUE(saved) << c.name << saved.error().message();
    EXPECT_EQ(csv_of(box.path("t.csv"), *saved), c.csv) << c.name;
    const std::string option = " --time-format " + std::string(c.words);
    if (*c.words != 0) EXPECT_NE(guess->guessed.front().find(option), std::string::npos) << c.name;
  }
  EXPECT_NE(read_table_log(box.path("t.csv"), {})->guessed.front().find("--decimal comma"),
            std::string::npos);
}

TEST(TableLog, NoTextIsLessOrMoreThanANumber) {
  const test::TemporaryFolder box;
  ASSERT_TRUE(
      write_file(box.path("t.csv"), "t,b,d,q\n0,A1,8,nan\n1,A2,7,80\n2,A2,6,\n3,A2,6,bad\n4,A1,5,20\n"));
  auto mapping = mapping_from_words("time=t,beacon=b,distance=d");
  ASSERT_TRUE(mapping);
  mapping->where = {*condition_from_word("q>50")};
  EXPECT_EQ(csv_of(box.path("t.csv"), *mapping), "time_s,beacon,distance_m\n1,A2,7\n");
  mapping->where = {*condition_from_word("q<=50")};
  EXPECT_EQ(csv_of(box.path("t.csv"), *mapping), "time_s,beacon,distance_m\n4,A1,5\n");
}

TEST(TableLog, UnitsThatAreInDoubtAreWarnedOf) {
  const test::TemporaryFolder box;
  const auto warnings = [&box](const char* table) {
    EXPECT_TRUE(write_file(box.path("t.csv"), table));
    const auto log = read_table_log(box.path("t.csv"), {});
    EXPECT_TRUE(log) << log.error().message();
    std::string all;
    for (const std::string& warning : log->log.warnings) all += warning + "\n";
    return all;
  };
  EXPECT_NE(warnings("time,anchor,tof\n0,A1,12.5\n1,A2,13\n").find("median of the times of flight is 13"),
            std::string::npos);
  EXPECT_NE(warnings("time,anchor,distance\n0,A1,512.5\n1,A2,613\n").find("median of the distances is 613"),
            std::string::npos);
  EXPECT_EQ(warnings("time,anchor,distance_m\n0,A1,512.5\n1,A2,613\n"), "");
  EXPECT_EQ(warnings("time,anchor,distance\n0,A1,5.5\n1,A2,6\n"), "");
  EXPECT_NE(warnings("time_h,anchor,distance\n0,A1,5.5\n0.1,A2,6\n").find("time=time_h*3600"),
            std::string::npos);
  EXPECT_NE(warnings("time,anchor,distance_in\n0,A1,5.5\n1,A2,6\n").find("distance=distance_in*0.0254"),
            std::string::npos);
}

TEST(TableLog, DatesAndTimesWithoutSeparatorsAreJoined) {
  const test::TemporaryFolder box;
  const char* csv = "time_s,beacon,distance_m\n1781177580,A1,5.5\n1781177581,A2,6\n";
  ASSERT_TRUE(write_file(box.path("t.csv"),
                         "date,time,anchor,distance\n20260611,113300,A1,5.5\n20260611,113301,A2,6\n"));
  EXPECT_EQ(csv_of(box.path("t.csv"), {}), csv);
  EXPECT_EQ(csv_of(box.path("t.csv"), *mapping_from_words("time=date+time,beacon=anchor,distance=distance")),
            csv);
}

/// A table whose rows have more cells than its header is not read with shifted cells.
TEST(TableLog, RowsThatDoNotFitAreRefusedOrCounted) {
  const test::TemporaryFolder box;
  ASSERT_TRUE(write_file(box.path("t.csv"), "t,anchor,d\n0,5,A1,5,2\n1,0,A2,6,1\n"));
  EXPECT_NE(message_of(box.path("t.csv"), {}), "");
  const auto mapping = mapping_from_words("time=t,beacon=anchor,distance=d");
  EXPECT_NE(message_of(box.path("t.csv"), *mapping).find("t.csv:2: a row that does not fit"),
            std::string::npos);
  ASSERT_TRUE(write_file(box.path("t.csv"), "t,anchor,d\n0,A1,5\n1,A2,61,A3,7\n2,A1,5\n"));
  const auto table = read_table_log(box.path("t.csv"), *mapping);
  ASSERT_TRUE(table);
  EXPECT_EQ(table->log.arrivals.size(), 2u);
  EXPECT_NE(table->log.warnings.back().find("t.csv:3: 1 lines are no rows"), std::string::npos);
}

}  // namespace table_log_test
}  // namespace octant::io
