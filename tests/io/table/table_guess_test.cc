// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/table/table_guess.h"

#include <gtest/gtest.h>

#include "io/text/atomic_file.h"
#include "tests/io/io_support.h"
#include "tests/io/table/table_support.h"

namespace octant::io {
namespace table_guess_test {

using test::csv_of;
using Case = test::TableCase;

/// Tables that people export, without any option.
const Case kExported[] = {
    {"German spreadsheet", "",
     "Zeit;Anker;Abstand [m]\r\n11.06.2026 11:33:48,5;A1;5,21\r\n11.06.2026 11:33:49;A2;1.234,5\r\n",
     "time_s,beacon,distance_m\n1781177628.5,A1,5.21\n1781177629,A2,1234.5\n"},
    {"sep= line, units in names", "", "sep=;\nt_ms;anchor;range_mm\n0;A1;5210\n100;A2;6020\n",
     "time_s,beacon,distance_m\n0,A1,5.21\n0.1,A2,6.02\n"},
    {"pandas with an index, zones, other columns", "",
     ",timestamp,anchor_id,distance,rssi\n0,2026-06-11 13:33:48.5+02:00,A1,5.25,-80.1\n1,2026-06-11 "
     "13:33:49+02:00,A2,6,-81\n",
     "time_s,beacon,distance_m\n1781177628.5,A1,5.25\n1781177629,A2,6\n"},
    {"pandas with dates as the index", "",
     ",r_A1,r_A2\n2026-06-11 11:33:48.5,5.2,NaN\n2026-06-11 11:33:49,5.3,6\n",
     "time_s,beacon,distance_m\n1781177628.5,A1,5.2\n1781177629,A1,5.3\n1781177629,A2,6\n"},
    {"MATLAB datetime", "", "Time,d1,d2\n11-Jun-2026 11:33:48.500,5,6\n11-Jun-2026 11:33:49,5,NaN\n",
     "time_s,beacon,distance_m\n1781177628.5,1,5\n1781177628.5,2,6\n1781177629,1,5\n"},
    {"serial dates of Excel", "", "Datum;A1;A2\n46184,25;5,1;6,2\n46184,2500462963;5,2;\n",
     "time_s,beacon,distance_m\n1781157600,A1,5.1\n1781157600,A2,6.2\n1781157604,A1,5.2\n"},
    {"LabVIEW", "",
     "LabVIEW "
     "Measurement\t\nSeparator\tTab\n***End_of_Header***\t\n\nChannels\t2\t\t\nX_Value\tr_A1\tr_"
     "A2\tComment\n0.0\t5.1\t6.1\n0.5\t5.2\t6.2\n",
     "time_s,beacon,distance_m\n0,A1,5.1\n0,A2,6.1\n0.5,A1,5.2\n0.5,A2,6.2\n"},
    {"messages of a device", "",
     "rst:0x1 (POWERON_RESET),boot:0x13\nready\nmillis,anchor,range_cm\n1000,A1,512\n1100,A2,-1\nWDT "
     "reset\n1200,A1,513\n12\n",
     "time_s,beacon,distance_m\n1,A1,5.12\n1.1,A2,\n1.2,A1,5.13\n"},
    {"messages of a device, no header line", "",
     "ready\n1000,A1,5.12\n1100,A2,6.2\n1200,A1,5.13\n1300,A2,6.21\n",
     "time_s,beacon,distance_m\n1,A1,5.12\n1.1,A2,6.2\n1.2,A1,5.13\n1.3,A2,6.21\n"},
    {"a kit without a header line", "",
     "1585909600125,28486,28479,nan,5.213\n1585909600250,28486,28435,nan,4.031\n1585909600500,28486,28479,"
     "nan,5.3\n",
     "time_s,beacon,distance_m\n1585909600.125,28479,5.213\n1585909600.25,28435,4.031\n1585909600.5,28479,"
     "5.3\n"},
    {"columns without names", "", "0.1,5.12,6.23,7.34\n0.2,5.13,6.24,7.35\n",
     "time_s,beacon,distance_m\n0.1,1,5.12\n0.1,2,6.23\n0.1,3,7.34\n0.2,1,5.13\n0.2,2,6.24\n0.2,3,7.35\n"},
    {"a header line in a comment", "", "% kit\n# time, A1, A2\n0.5 5.1 6.1\n1 5.2 6.2\n",
     "time_s,beacon,distance_m\n0.5,A1,5.1\n0.5,A2,6.1\n1,A1,5.2\n1,A2,6.2\n"},
    {"a line of units", "", "Time;A1;A2\n[ms];[mm];[mm]\n0;5100;6100\n100;5200;\n",
     "time_s,beacon,distance_m\n0,A1,5.1\n0,A2,6.1\n0.1,A1,5.2\n"},
    {"row names of R", "", "\"time\" \"anchor\" \"range\"\n\"1\" 0.1 \"A1\" 5.1\n\"2\" 0.2 \"A2\" 6.1\n",
     "time_s,beacon,distance_m\n0.1,A1,5.1\n0.2,A2,6.1\n"},
    {"rostopic echo -p", "",
     "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.range\n1590000000000000000,1,"
     "1590000000000000000,A1,5.2\n"
     "1590000000500000000,2,1590000000500000000,A2,6.2\n",
     "time_s,beacon,distance_m\n1590000000,A1,5.2\n1590000000.5,A2,6.2\n"},
    {"dates and times in two columns, half days, feet", "",
     "Date,Time,Anchor,Range (ft)\n6/11/2026,11:33:48 PM,A1,10\n6/12/2026,12:00:01 AM,A2,20\n",
     "time_s,beacon,distance_m\n1781220828,A1,3.048\n1781222401,A2,6.096\n"},
    {"several tags", "", "time_ms,tag,anchor,distance_cm\n0,T1,A1,512\n0,T2,A1,612\n",
     "time_s,beacon,distance_m,receiver\n0,A1,5.12,T1\n0,A1,6.12,T2\n"},
    {"several tags, a column for each pair", "", "t,T1_A1,T1_A2,T2_A1\n0,5,6,7\n0.5,5,6,\n",
     "time_s,beacon,distance_m,receiver\n0,A1,5,T1\n0,A2,6,T1\n0,A1,7,T2\n0.5,A1,5,T1\n0.5,A2,6,T1\n"},
    {"thousands, a trailing delimiter", "", "t;anchor;distanz_mm;\n0;A1;5'210;\n0.5;A2;16'020;\n",
     "time_s,beacon,distance_m\n0,A1,5.21\n0.5,A2,16.02\n"},
    {"numbers for no measurement", "",
     "timestamp_ms,dist_A1_mm,dist_A2_mm\n0,5100,0\n100,-1,6200\n200,65535,6300\n",
     "time_s,beacon,distance_m\n0,A1,5.1\n0.1,A2,6.2\n0.2,A2,6.3\n"},
    {"the header line again", "", "t,anchor,d\n0,A1,5\n1,A2,6\nt,anchor,d\n2,A1,7\n",
     "time_s,beacon,distance_m\n0,A1,5\n1,A2,6\n2,A1,7\n"},
    {"MATLAB without names of variables", "", "Var1,Var2,Var3\n0.5,A1,5.25\n1,A2,6.5\n1.5,A1,5.5\n",
     "time_s,beacon,distance_m\n0.5,A1,5.25\n1,A2,6.5\n1.5,A1,5.5\n"},
    {"one beacon without a name", "", "t;Abstand [cm]\n0;512,5\n1;513\n",
     "time_s,beacon,distance_m\n0,1,5.125\n1,1,5.13\n"},
    {"parts of a day", "", "Uhrzeit;A1;A2\n0,25;5;6\n0,25000578704;5;k.A.\n0,25001157407;5;6\n",
     "time_s,beacon,distance_m\n21600,A1,5\n21600,A2,6\n21600.5,A1,5\n21601,A1,5\n21601,"
     "A2,6\n"},
    {"units behind a slash", "", "t / ms;d_A1 / cm;d_A2 / cm\n0;500;600\n100;510;\n",
     "time_s,beacon,distance_m\n0,A1,5\n0,A2,6\n0.1,A1,5.1\n"},
    {"rows with numbers, two ends of a range", "",
     "id;timestamp;initiator;responder;distance_mm\n1;10.5;T1;A1;5100\n2;11;T1;A2;6100\n3;11.5;T1;A1;5200\n",
     "time_s,beacon,distance_m\n10.5,A1,5.1\n11,A2,6.1\n11.5,A1,5.2\n"},
    {"from and to", "", "ts,from,to,dist\n0,A1,T1,5.5\n0.5,A2,T1,6.5\n1,A1,T1,5.5\n",
     "time_s,beacon,distance_m\n0,A1,5.5\n0.5,A2,6.5\n1,A1,5.5\n"},
    {"seconds and nanoseconds", "",
     "secs,nsecs,anchor_id,range\n1590000000,250000000,A1,5.5\n1590000000,500000000,A2,6.5\n",
     "time_s,beacon,distance_m\n1590000000.25,A1,5.5\n1590000000.5,A2,6.5\n"},
    {"addresses as names", "", "time;0x1782;0x1783\n0;5,5;6,5\n0,5;5,5;\n",
     "time_s,beacon,distance_m\n0,0x1782,5.5\n0,0x1783,6.5\n0.5,0x1782,5.5\n"},
    {"a row without a time", "", "time,anchor,range\n2026-06-11 11:33:48,A1,5.5\n,A2,6.5\n",
     "time_s,beacon,distance_m\n1781177628,A1,5.5\n"},
    {"Latin-1, blanks between thousands", "",
     "Zeit [s];Sender;Laufzeit [\xB5s]\n0,5;B1;14 520,5\n1;B2;20 100,5\n",
     "time_s,beacon,tof_s\n0.5,B1,0.0145205\n1,B2,0.0201005\n"},
};

TEST(TableGuess, ColumnsAreGuessed) {
  const test::TemporaryFolder box;
  for (const Case& c : kExported) {
    ASSERT_TRUE(write_file(box.path("table.txt"), c.table));
    EXPECT_EQ(csv_of(box.path("table.txt"), {}), c.csv) << c.name;
  }
}

TEST(TableGuess, ClocksThatStartAgainGoOn) {
  const Case cases[] = {
      {"times of day", "", "Uhrzeit;Anker;Abstand\n23:59:59,5;A1;5,5\n00:00:00,5;A2;6,5\n",
       "time_s,beacon,distance_m\n86399.5,A1,5.5\n86400.5,A2,6.5\n"},
      {"milliseconds of the day", "", "ms_of_day,anchor,range_m\n86399500,A1,5\n500,A2,6\n",
       "time_s,beacon,distance_m\n86399.5,A1,5\n86400.5,A2,6\n"},
      {"40 bits under any name", "", "timestamp,anchor,range_m\n1099000000000,A1,5\n12779520000,A2,6\n",
       "time_s,beacon,distance_m\n17.19939403044872,A1,5\n17.407401025641025,A2,6\n"},
      {"40 bits in hexadecimal, with a long gap", "",
       "rx_ticks,anchor,range_m\n0xF000000000,A1,5\n0x1000000000,A2,6\n",
       "time_s,beacon,distance_m\n16.13193846153846,A1,5\n18.28286358974359,A2,6\n"},
  };
  const test::TemporaryFolder box;
  for (const Case& c : cases) {
    ASSERT_TRUE(write_file(box.path("table.txt"), c.table));
    EXPECT_EQ(csv_of(box.path("table.txt"), {}), c.csv) << c.name;
    const auto table = read_table_log(box.path("table.txt"), {});
    ASSERT_TRUE(table);
    EXPECT_NE(table->log.warnings.back().find("starts again"), std::string::npos) << c.name;
  }
}

}  // namespace table_guess_test
}  // namespace octant::io
