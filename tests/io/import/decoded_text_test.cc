// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/import/decoded_text.h"

#include <gtest/gtest.h>
#include <zlib.h>
#include <zstd.h>

#include "io/import/vendor_logs.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace decoded_text_test {

std::string text_of(const std::string& path) {
  const auto text = DecodedText::open(path);
  return text ? std::string(text->text()) : "error: " + text.error().message();
}

std::string gzipped(const std::string& text) {
  z_stream stream{};
  deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&stream, text.size()) + 64, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  deflate(&stream, Z_FINISH);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

std::string zstd_of(const std::string& text) {
  std::string out(ZSTD_compressBound(text.size()), '\0');
  out.resize(ZSTD_compress(out.data(), out.size(), text.data(), text.size(), 3));
  return out;
}

/// Both orders of bytes; characters beyond the Basic Multilingual Plane are two units.
std::string utf16(const std::u16string& text, bool little) {
  std::string out;
  for (const char16_t unit : text)
    for (const int shift : {little ? 0 : 8, little ? 8 : 0}) out += static_cast<char>(unit >> shift & 0xFF);
  return out;
}

TEST(DecodedText, ReadsTheEncodingsAndCompressionsOfTables) {
  const test::TemporaryFolder box;
  const std::string text = "t,b\n1,\xC3\xA4\xF0\x9F\x98\x80\n";
  EXPECT_EQ(text_of(box.write("a", text)), text);
  EXPECT_EQ(text_of(box.write("a", "\xEF\xBB\xBF" + text)), text);
  const std::u16string wide = u"t,b\n1,\u00E4\U0001F600\n";
  for (const bool little : {true, false}) {
    EXPECT_EQ(text_of(box.write("a", utf16(u"\uFEFF" + wide, little))), text);
    EXPECT_EQ(text_of(box.write("a", utf16(wide, little))), text);
  }
  EXPECT_EQ(text_of(box.write("a", gzipped(text))), text);
  EXPECT_EQ(text_of(box.write("a", gzipped(text) + gzipped(text))), text + text) << "two members";
  EXPECT_EQ(text_of(box.write("a", zstd_of(text))), text);
  EXPECT_EQ(text_of(box.write("a", gzipped(utf16(u"\uFEFF" + wide, true)))), text);
  EXPECT_EQ(text_of(box.write("a", "1,\xE4\xB5\n")), "1,\xC3\xA4\xC2\xB5\n");
  EXPECT_EQ(DecodedText::open(box.path("a"))->notes().size(), 1u);
  EXPECT_EQ(text_of(box.write("a", "t,b\r1,2\r")), "t,b\n1,2\n");
  std::string long_text;
  for (int i = 0; i < 100'000; ++i) long_text += "1,2,3\n";
  EXPECT_EQ(text_of(box.write("a", gzipped(long_text))), long_text);
  EXPECT_EQ(text_of(box.write("a", zstd_of(long_text))), long_text);
}

TEST(DecodedText, LogsOfKitsAreDecompressed) {
  const test::TemporaryFolder box;
  const std::string text = "Timestamp,ranging.state,ranging.distance0\n1000,1,1.5\n";
  const auto log = read_crazyflie_log(box.write("cf.csv.gz", gzipped(text)));
  ASSERT_TRUE(log) << log.error().message();
  EXPECT_EQ(log->arrivals.size(), 1u);
}

TEST(DecodedText, DamagedFilesAreErrors) {
  const test::TemporaryFolder box;
  for (const std::string& whole : {gzipped("t,b\n1,2\n"), zstd_of("t,b\n1,2\n")})
    for (std::size_t size = 4; size < whole.size(); ++size)
      EXPECT_TRUE(text_of(box.write("a", whole.substr(0, size))).starts_with("error:")) << size;
  EXPECT_NE(text_of(box.write("a", "PK\x03\x04 more")).find("export the sheet as CSV"), std::string::npos);
  EXPECT_TRUE(text_of(box.write("a", "1,\xFF\n")).starts_with("error:"));
  EXPECT_TRUE(text_of(box.path("none")).starts_with("error:"));
}

}  // namespace decoded_text_test
}  // namespace octant::io
