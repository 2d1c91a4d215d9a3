// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/run/last_row.h"

#include <algorithm>

#include "io/run/run_folder.h"
#include "io/run/run_stream.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace last_row_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const NameTable kNames{.beacons = {"B0", "B1"}, .vehicles = {"robot"}, .receivers = {{"r0", VehicleId(0)}}};

/// A log of rows with nine decimals.
std::string log_of(int rows) {
  std::string text = "time_s,beacon,tof_s\n";
  for (int i = 0; i < rows; ++i)
    text += std::to_string(i) + ".250000,B" + std::to_string(i % 2) + ",0.0300" + std::to_string(10001 + i) +
            "\n";
  return text;
}

struct Kept {
  std::string text;
  std::vector<std::string> warnings;
};
Kept kept(const std::string& text, const std::string& file = "tof.csv") {
  Kept k;
  k.text = without_cut_row(text, file, k.warnings);
  return k;
}

TEST(LastRow, OfAFileThatIsEndedIsNotLookedAt) {
  for (const char* end : {"", "\r", "99.250000,B0,0.1\n", "\n  ", "# the end"}) {
    const std::string text = log_of(20) + end;
    EXPECT_EQ(kept(text).text, text) << end;
    EXPECT_THAT(kept(text).warnings, IsEmpty()) << end;
  }
  EXPECT_THAT(kept("time_s,beacon,tof_s").warnings, IsEmpty()) << "a header alone";
}

/// For a log that ends anywhere, invalid parts are omitted or reported.
TEST(LastRow, IsLeftOutWhereverItIsCut) {
  const std::string text = log_of(40), whole = log_of(39);
  for (std::size_t size = whole.size() + 1; size + 1 < text.size(); ++size) {
    const Kept cut = kept(text.substr(0, size));
    const std::string row = text.substr(whole.size(), size - whole.size());
    if (std::count(row.begin(), row.end(), ',') < 2) {
      EXPECT_EQ(cut.text, text.substr(0, size)) << "a row of too few fields is refused by its reader";
      EXPECT_THAT(cut.warnings, IsEmpty());
      continue;
    }
    EXPECT_EQ(cut.text, whole) << text.substr(whole.size(), size - whole.size());
    EXPECT_THAT(cut.warnings, ElementsAre(AllOf(HasSubstr("tof.csv:41: the last row is cut off: it "),
                                                HasSubstr("it is left out: copy the file again"))));
  }
  const Kept all = kept(text.substr(0, text.size() - 1));
  EXPECT_EQ(all.text, text.substr(0, text.size() - 1));
  EXPECT_THAT(all.warnings, ElementsAre(AllOf(HasSubstr("tof.csv:41: the last row has no newline"),
                                              HasSubstr("it is used"))));
}

/// However long, and where a line never ends, which the readers refuse.
TEST(LastRow, OfALongFileIsFoundFromItsEnd) {
  const std::string text = log_of(40'000), whole = log_of(39'999);
  const Kept cut = kept(text.substr(0, text.size() - 4));
  EXPECT_EQ(cut.text, whole);
  EXPECT_THAT(cut.warnings, ElementsAre(HasSubstr("tof.csv:40001: the last row is cut off")));
  const std::string endless = log_of(20) + std::string(3 << 20, 'x');
  EXPECT_EQ(kept(endless).text.size(), endless.size());
  EXPECT_THAT(kept(endless).warnings, IsEmpty());
}

TEST(LastRow, OfATableMadeByHandIsUsed) {
  for (const char* text :
       {"epoch,x_m,y_m\n0,1.25,2.5\n1,3.1,4", "epoch,x_m,y_m\n0,1.25,2.55", "a,b\n1,\"x\n2,3\"\n3,\"y\""}) {
    EXPECT_EQ(kept(text, "points.csv").text, text);
  }
  EXPECT_THAT(kept("epoch,x_m,y_m\n0,1.25,2.5\n1,3.1,4", "points.csv").warnings,
              ElementsAre(HasSubstr("points.csv:3: the last row has no newline at its end; it is used")));
}

TEST(LastRow, OfOtherKindsOfColumns) {
  std::string names, counts, missing, poses;
  for (int i = 0; i < 20; ++i) {
    names += "0.5,B" + std::to_string(i % 5) + "\n";
    counts += "B0," + std::to_string(1000 + i) + "\n";
    missing += i % 3 == 0 ? "B0,nan\n" : "B0,0.0123\n";
    poses += std::to_string(i) + " 1.25 2.5 0 0 0 0.6 0.8\n";
  }
  EXPECT_EQ(kept("t,b\n" + names + "0.5,B").text, "t,b\n" + names);
  EXPECT_EQ(kept("t,b\n" + names + "0.5,B3").text, "t,b\n" + names + "0.5,B3");
  EXPECT_EQ(kept("b,n\n" + counts + "B0,10").text, "b,n\n" + counts);
  EXPECT_EQ(kept("b,t\n" + missing + "B0,0.01").text, "b,t\n" + missing);
  EXPECT_EQ(kept("b,t\n" + missing + "B0,nan").text, "b,t\n" + missing + "B0,nan");
  EXPECT_EQ(kept(poses + "20 1.25 2.5 0 0 0 0.6", "poses.tum").text, poses + "20 1.25 2.5 0 0 0 0.6");
  EXPECT_EQ(kept(poses + "20 1.25 2.5 0 0 0 0.6 0.", "poses.tum").text, poses);
  EXPECT_EQ(kept(poses + "20 1.25 2.5 0 0 0 0.6 0.8", "poses.tum").text, poses + "20 1.25 2.5 0 0 0 0.6 0.8");
}

/// As a whole and in blocks; the digest is that of the file.
TEST(LastRow, IsLeftOutOfARun) {
  const test::TemporaryFolder folder;
  const std::string text = log_of(40), cut = text.substr(0, text.size() - 6);
  folder.write("tof.csv", text);
  const std::string digest = read_run(folder.path(), kNames, {})->sha256.begin()->second;
  folder.write("tof.csv", cut);
  const auto log = read_run(folder.path(), kNames, {});
  ASSERT_TRUE(log.has_value());
  EXPECT_EQ(log->arrivals.size(), 39u);
  EXPECT_EQ(log->rows, 39u);
  EXPECT_THAT(log->warnings, ElementsAre(HasSubstr("tof.csv:41: the last row is cut off")));
  EXPECT_NE(log->sha256.begin()->second, digest);

  auto stream = RunStream::open(folder.path(), kNames, {});
  ASSERT_TRUE(stream.has_value());
  std::vector<Arrival> block, all;
  while (stream->next(block).value()) all.insert(all.end(), block.begin(), block.end());
  EXPECT_EQ(all.size(), 39u);
  EXPECT_EQ(stream->log().sha256, log->sha256);
  EXPECT_EQ(stream->log().warnings, log->warnings);
}

}  // namespace last_row_test
}  // namespace octant::io
