// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Parts of the reader of tof.csv.
#include <set>

#include "io/text/atomic_file.h"
#include "io/text/csv_marks.h"
#include "io/text/name_index.h"
#include "io/text/open_file.h"
#include "io/text/sha256.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace reading_parts_test {

using test::expect_error;
using test::TemporaryFolder;

TEST(MappedFile, IsTheFile) {
  const TemporaryFolder folder;
  const std::string text = std::string(100'000, 'a') + "b";
  const auto map = MappedFile::open(folder.write("file", text));
  ASSERT_TRUE(map.has_value());
  EXPECT_EQ(map->text(), text);
  map->release(0, 50'000);
  map->release(50'000, text.size());
  EXPECT_EQ(map->text(), text) << "what was given back comes again";
  EXPECT_EQ(MappedFile::open(folder.write("empty", ""))->text(), "");
}

TEST(MappedFile, CopiesWhatCannotBeMapped) {
  // The system generates this file's content when it is read, and gives no size, so it cannot be mapped.
  if (::access("/proc/self/status", R_OK) != 0) GTEST_SKIP() << "no /proc here";
  EXPECT_EQ(MappedFile::open("/proc/self/status")->text(), read_file("/proc/self/status").value());
}

TEST(MappedFile, SaysWhatCannotBeRead) {
  const TemporaryFolder folder;
  expect_error(MappedFile::open(folder.path("none")), 0, "No such file", "none");
  expect_error(MappedFile::open(folder.path()), 0, "this is a folder");
}

TEST(Sha256, DoesNotDependOnThePieces) {
  Sha256 digest;
  for (const char* piece : {"a", "", "bc"}) digest.add(piece);
  // FIPS 180-4, example of one block
  EXPECT_EQ(digest.hex(), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(CsvMarks, FindsAllAndNothingElse) {
  EXPECT_TRUE(rc::check("against a loop over the bytes", [] {
    const auto text = *rc::gen::container<std::string>(
        rc::gen::weightedOneOf<char>({{20, rc::gen::element('a', '1', ' ', '-', '+', '/', '\t', '\r')},
                                      {8, rc::gen::element(',', '.', '\n')},
                                      {1, rc::gen::arbitrary<char>()}}));
    std::vector<std::uint32_t> expected;
    for (std::size_t i = 0; i < text.size(); ++i)
      if (text[i] == ',' || text[i] == '.' || text[i] == '\n')
        expected.push_back(static_cast<std::uint32_t>(i));
    CsvMarks marks;
    marks.find(std::string(200, ','));  // what was found before is forgotten
    marks.find(text);
    marks.offsets.resize(marks.count);
    RC_ASSERT(marks.offsets == expected);
    RC_ASSERT(marks.has_quote == (text.find('"') != std::string::npos));
    RC_ASSERT(marks.has_nul == (text.find('\0') != std::string::npos));
    RC_ASSERT(marks.has_high == std::any_of(text.begin(), text.end(),
                                            [](char c) { return static_cast<unsigned char>(c) >= 0x80; }));
  }));
}

TEST(NameIndex, FindsEachNameAndNoOther) {
  EXPECT_EQ(NameIndex().find("a"), -1);
  EXPECT_TRUE(rc::check("against a search", [] {
    const auto some = rc::gen::container<std::string>(rc::gen::element('a', 'b', '\xFF'));
    const auto names = *rc::gen::container<std::vector<std::string>>(some);
    const NameIndex index({names.begin(), names.end()});
    auto asked = *rc::gen::container<std::vector<std::string>>(some);
    asked.insert(asked.end(), names.begin(), names.end());
    for (const auto& name : asked) {
      const auto found = std::find(names.begin(), names.end(), name);
      RC_ASSERT(index.find(name) ==
                (found == names.end() ? -1 : static_cast<std::int32_t>(found - names.begin())));
    }
  }));
  // Equal ends and equal length.
  const std::vector<std::string_view> alike = {"the first eight ... the last eight",
                                               "the first eight --- the last eight"};
  EXPECT_EQ(NameIndex(alike).find(alike[1]), 1);
  EXPECT_EQ(NameIndex(alike).find("the first eight *** the last eight"), -1);
}

}  // namespace reading_parts_test
}  // namespace octant::io
