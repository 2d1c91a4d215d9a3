// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The fast way through tof.csv against the general one, on files of every kind of oddness.
#include "io/tof/tof_reader.h"

#include <bit>
#include <random>

#include "io/text/atomic_file.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace tof_reader_test {

using test::TemporaryFolder;

const NameTable kNames{.beacons = {"B0", "B1", "B10", "north-east corner", "Süd 北", "a\"b", "1.5"},
                       .vehicles = {"robot", "cart"},
                       .receivers = {{"r0", VehicleId(0)}, {"r1", VehicleId(0)}, {"r0", VehicleId(1)}}};

/// Complete result of the reader as a text for comparison: numbers by their bits.
std::string outcome_of(const std::string& path, Clock clock, const TofReaderOptions& options) {
  const NameLookup names(kNames);
  TofReader reader(std::make_shared<const MappedFile>(MappedFile::open(path).value()), "tof.csv", names,
                   clock, options);
  if (auto ok = reader.read_header(); !ok) return ok.error().message();
  std::string out = reader.has_epochs() ? "epochs\n" : "";
  std::vector<Arrival> all;
  std::vector<RejectedRow> rejected;
  for (;;) {
    const auto more = reader.append(all);
    if (!more) return more.error().message();
    for (auto& row : reader.refusals().take()) rejected.push_back(row);
    if (!*more) break;
  }
  for (const Arrival& a : all) {
    for (const double value :
         {a.time_s, a.tof_s, a.amplitude_v, a.temperature_degC, double{a.received_after_s}})
      out += std::isnan(value) ? "nan " : std::to_string(std::bit_cast<std::uint64_t>(value)) + " ";
    for (const std::int64_t value : {std::int64_t{a.beacon.value}, std::int64_t{a.receiver.value},
                                     std::int64_t{a.vehicle.value}, a.epoch, std::int64_t{a.line}})
      out += std::to_string(value) + " ";
    out += "\n";
  }
  for (const RejectedRow& row : rejected) out += std::to_string(row.line) + " " + row.reason + "\n";
  for (const std::string& warning : reader.warnings()) out += warning + "\n";
  return out + std::to_string(reader.rows()) + " " + reader.sha256();
}

std::string outcome_of_text(const std::string& text, const TofReaderOptions& options,
                            Clock clock = Clock::kSynchronised) {
  const TemporaryFolder folder;
  return outcome_of(folder.write("tof.csv", text), clock, options);
}

/// Returns true with a probability of 1 / one_in.
bool rarely(std::mt19937& random, unsigned one_in) { return random() % one_in == 0; }
template <class... Text>
std::string one_of(std::mt19937& random, const Text&... texts) {
  const std::vector<std::string> all = {texts...};
  return all[random() % all.size()];
}

struct Oddness {
  unsigned cell, row, file;  // one in so many is odd
};

std::string some_number(std::mt19937& random) {
  const auto digits = [&](unsigned most) {
    std::string text;
    for (unsigned n = 1 + random() % most; n > 0; --n) text += static_cast<char>('0' + random() % 10);
    return text;
  };
  return digits(random() % 4 == 0 ? 17 : 4) +
         (random() % 4 == 0 ? "" : "." + digits(random() % 4 == 0 ? 17 : 8));
}

std::string some_cell(const std::string& column, int row, std::mt19937& random, const Oddness& odd) {
  if (rarely(random, odd.cell)) {
    return one_of(random, "", " ", "nan", "NaN", "inf", "-inf", "1e308", "1e400", "1e-400", "-1e-9", "1.5e1",
                  "+2", "-3", "--3", "0x10", ".5", "5.", ".", "1.2.3", "1,5", "\"1.5\"", "\"a\"\"b\"", "1.5 ",
                  "\t7", "00000000000000000001", "123456789012345678901", "9007199254740993",
                  "0.30000000000000004", "B99", "\xFF", std::string(1, '\0'), "x\ry", "\"two\nlines\"", "-0",
                  "-0.0", "1_0", "7.0", "1e2");
  }
  if (column == "time_s") return std::to_string(1000 + row / 3) + (row % 3 == 2 ? ".50" : "");
  if (column == "beacon")
    return one_of(random, "B0", "B1", "B10", "north-east corner", "Süd 北", " B0 ", "1.5");
  if (column == "tof_s")
    return rarely(random, 4) ? some_number(random)
                             : one_of(random, "0.01234567", "0.5", "nan", "", "-0.25", "1e-3", "12");
  if (column == "epoch") return std::to_string(row / 4 - 3);
  if (column == "vehicle") return row % 3 == 0 ? "cart" : one_of(random, "robot", "");
  if (column == "receiver") return "r0";
  if (column == "amplitude_v" || column == "level_dbm") return one_of(random, "0.5", "-80", "", "nan", "0");
  if (column == "received_s") return one_of(random, std::to_string(1000 + row / 3) + ".75", "", "nan");
  if (column == "temperature_degC") return one_of(random, "21.5", "-3", "");
  return one_of(random, "red", "", "a b", "3.4.5", "ü");
}

std::string some_file(std::mt19937& random, const Oddness& odd) {
  std::vector<std::string> columns = {"time_s", "beacon", "tof_s", "receiver"};
  for (const char* more :
       {"epoch", "vehicle", "amplitude_v", "level_dbm", "temperature_degC", "received_s", "colour", "note"})
    if (random() % 2 == 0) columns.emplace_back(more);
  std::shuffle(columns.begin(), columns.end(), random);
  const std::string newline = random() % 2 == 0 ? "\n" : "\r\n";
  const bool comma_behind = rarely(random, 8);
  std::string text = rarely(random, 4) ? "\xEF\xBB\xBF" : "";
  if (rarely(random, 4)) text += "# made by \"x\", 1.0" + newline + newline;
  for (const auto& column : columns) text += (&column == &columns.front() ? "" : ",") + column;
  text += newline;
  const int rows = static_cast<int>(random() % 60);
  for (int row = 0; row < rows; ++row) {
    for (const auto& column : columns)
      text += (&column == &columns.front() ? "" : ",") + some_cell(column, row, random, odd);
    if (comma_behind) text += one_of(random, ",", ", ");
    if (rarely(random, odd.row)) text += one_of(random, ",", ",5", " ", "\r");
    text += rarely(random, odd.row) ? newline + one_of(random, " ", "", "\t") + newline : newline;
  }
  if (rarely(random, odd.file)) text.resize(random() % (text.size() + 1));
  if (rarely(random, 3) && text.ends_with(newline)) text.resize(text.size() - newline.size());
  return text;
}

void expect_both_ways_agree(const Oddness& odd) {
  int read = 0, refused = 0;
  EXPECT_TRUE(rc::check("pieces, threads and the general way agree", [&] {
    std::mt19937 random(*rc::gen::arbitrary<unsigned>());
    const std::string text = some_file(random, odd);
    const Clock clock = random() % 2 == 0 ? Clock::kSynchronised : Clock::kCycleOffset;
    const std::string expected = outcome_of_text(text, {.general_way = true}, clock);
    (expected.starts_with("tof.csv") ? refused : read) += 1;
    for (const std::size_t chunk_bytes :
         {std::size_t{1}, std::size_t{1 + random() % 200}, std::size_t{1} << 17}) {
      for (const int threads : {1, 3}) {
        const std::string found =
            outcome_of_text(text, {.threads = threads, .chunk_bytes = chunk_bytes}, clock);
        if (found != expected)
          RC_FAIL("pieces of " + std::to_string(chunk_bytes) + " bytes:\n" + found + "\ninstead of\n" +
                  expected + "\nof\n" + text);
      }
    }
  }));
  EXPECT_GE(read + refused, 100);
  if (odd.cell > 10'000) EXPECT_GT(read, refused) << "most of these files are to be readable";
  if (odd.cell < 1'000) EXPECT_GT(refused, 10) << "some of these files are to be wrong";
}

/// A repeated row is found after the others of its piece; the list of refused rows is by line all the same.
TEST(TofReader, RefusedRowsComeByLine) {
  const std::string text =
      "time_s,beacon,tof_s,receiver,vehicle\n1,B0,0.01,r0,robot\n1,B0,0.01,r0,robot\n2,B1,nan,r0,robot\n"
      "3,B0,,r0,robot\n3,B1,0.02,r0,robot\n3,B1,0.02,r0,robot\n4,B1,-1,r0,robot\n";
  const std::string whole = outcome_of_text(text, {.chunk_bytes = 1 << 17});
  EXPECT_EQ(whole, outcome_of_text(text, {.general_way = true}));
  EXPECT_EQ(whole, outcome_of_text(text, {.threads = 1, .chunk_bytes = 1}));
  std::size_t at = 0;
  for (const char* refused : {"\n3 the row", "\n4 tof_s", "\n5 tof_s", "\n7 the row", "\n8 tof_s"}) {
    const std::size_t next = whole.find(refused);
    ASSERT_NE(next, std::string::npos) << refused << " in\n" << whole;
    EXPECT_GT(next, at);
    at = next;
  }
}

TEST(TofReader, ReadsGoodFilesTheSameWhateverThePieces) {
  expect_both_ways_agree({.cell = 1'000'000, .row = 20, .file = 1'000'000});
}
TEST(TofReader, ReadsOddFilesTheSameWhateverThePieces) {
  expect_both_ways_agree({.cell = 200, .row = 1000, .file = 20});
}

/// A file long enough for many pieces of the usual size.
std::string long_file(int rows) {
  std::string text = "time_s,epoch,beacon,receiver,tof_s\n";
  for (int i = 0; i < rows; ++i)
    text += std::to_string(i / 20) + ".25," + std::to_string(i / 20) + ",B" + std::to_string(i % 2) +
            ",r1,0.0" + std::to_string(10000 + i % 997) + "\n";
  return text;
}

TEST(TofReader, DoesNotDependOnThreads) {
  const std::string text = long_file(60'000);
  const std::string expected = outcome_of_text(text, {.general_way = true});
  ASSERT_FALSE(expected.starts_with("tof.csv"));
  for (const int threads : {1, 2, 5})
    EXPECT_TRUE(outcome_of_text(text, {.threads = threads}) == expected) << threads;
}

TEST(TofReader, FindsWhatIsWrongFarBehind) {
  const std::string good = long_file(60'000);
  const std::string end = good.substr(good.rfind('\n', good.size() - 2) + 1);
  struct Bad {
    std::string row, words;
  };
  for (const auto& [row, words] :
       {Bad{"3000.25,3000,B7,r1,0.01\n", "tof.csv:60002:14: beacon 'B7'"},
        Bad{"3.5,3000,B1,r1,0.01\n", "tof.csv:60002:1: time_s goes back"},
        Bad{"3000.25,7,B1,r1,0.01\n", "tof.csv:60002:9: epoch 7 comes back after epoch 2999"},
        Bad{"3000.25,3000,B1,r1,0.01,\"x\"\n", "tof.csv:60002"},
        Bad{"3000.25,3000,B1,r1,\xC0\n", "tof.csv:60002:20: byte 0xC0"}}) {
    for (const int threads : {1, 2})
      EXPECT_THAT(outcome_of_text(good + row, {.threads = threads}), testing::StartsWith(words));
    // And where more pieces follow.
    EXPECT_THAT(outcome_of_text(good + row + end + end, {.chunk_bytes = 64}), testing::StartsWith(words));
  }
}

TEST(TofReader, GoesOnBehindQuotes) {
  const std::string text = long_file(30'000) + "1500,1500,\"B0\",\"r0\",0.01\n1500,1500,B1,r0,\"nan\"\n";
  const std::string found = outcome_of_text(text, {.threads = 2});
  EXPECT_TRUE(found == outcome_of_text(text, {.general_way = true}));
  EXPECT_THAT(found, testing::HasSubstr("tof.csv:30003: tof_s is not a number (nan); 1 arrival"));
}

TEST(TofReader, DigestIsTheFiles) {
  const std::string text = long_file(10'000);
  for (const int threads : {1, 2})
    EXPECT_THAT(outcome_of_text(text, {.threads = threads}), testing::EndsWith(" " + sha256_hex(text)));
}

TEST(TofReader, GuessesTheNumberOfRows) {
  const TemporaryFolder folder;
  const NameLookup names(kNames);
  TofReader reader(std::make_shared<const MappedFile>(
                       MappedFile::open(folder.write("tof.csv", long_file(60'000))).value()),
                   "tof.csv", names, Clock::kSynchronised);
  ASSERT_TRUE(reader.read_header().has_value());
  EXPECT_GE(reader.rows_estimate(), 60'000u);
  EXPECT_LE(reader.rows_estimate(), 66'000u) << "a tenth of the memory in vain at most";
}

}  // namespace tof_reader_test
}  // namespace octant::io
