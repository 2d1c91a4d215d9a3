// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Read back by the specification (W3C PNG, third edition): chunks, checksums, deflate, filters.
#include "io/import/png.h"

#include <zlib.h>

#include <cstdlib>

#include "tests/io/io_support.h"

namespace octant::io {
namespace png_test {

std::uint32_t number_at(const std::string& text, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(text.at(at + i));
  return value;
}

struct Chunk {
  std::string type, content;
};

std::vector<Chunk> chunks_of(const std::string& file) {
  EXPECT_EQ(file.substr(0, 8), std::string("\x89PNG\r\n\x1a\n", 8));
  std::vector<Chunk> chunks;
  for (std::size_t at = 8; at < file.size();) {
    const std::size_t length = number_at(file, at);
    chunks.push_back({file.substr(at + 4, 4), file.substr(at + 8, length)});
    const std::string checked = file.substr(at + 4, 4 + length);
    const auto crc = crc32_z(0, reinterpret_cast<const Bytef*>(checked.data()), checked.size());
    EXPECT_EQ(number_at(file, at + 8 + length), crc) << chunks.back().type;
    at += 12 + length;
  }
  return chunks;
}

/// The neighbour to the left, above or to the upper left that is nearest to their plane (clause 9.4).
int paeth(int left, int up, int corner) {
  const int p = left + up - corner, a = std::abs(p - left), b = std::abs(p - up), c = std::abs(p - corner);
  return a <= b && a <= c ? left : b <= c ? up : corner;
}

/// Pixels of red, green, blue and opacity, eight bits each.
std::vector<std::uint8_t> pixels_of(const std::string& file, std::size_t columns, std::size_t rows) {
  std::string packed;
  for (const Chunk& chunk : chunks_of(file))
    if (chunk.type == "IDAT") packed += chunk.content;
  std::vector<Bytef> lines(rows * (4 * columns + 1));
  uLongf size = lines.size();
  EXPECT_EQ(uncompress(lines.data(), &size, reinterpret_cast<const Bytef*>(packed.data()), packed.size()),
            Z_OK);
  EXPECT_EQ(size, lines.size());
  std::vector<std::uint8_t> pixels(4 * columns * rows);
  const auto at = [&](std::size_t row, std::size_t i, bool there) {
    return there ? static_cast<int>(pixels[row * 4 * columns + i]) : 0;
  };
  for (std::size_t row = 0; row < rows; ++row) {
    const Bytef* line = lines.data() + row * (4 * columns + 1);
    for (std::size_t i = 0; i < 4 * columns; ++i) {
      const int left = at(row, i - 4, i >= 4), up = at(row - 1, i, row > 0),
                corner = at(row - 1, i - 4, row > 0 && i >= 4);
      const int predicted[] = {0, left, up, (left + up) / 2, paeth(left, up, corner)};
      pixels[row * 4 * columns + i] = static_cast<std::uint8_t>(line[1 + i] + predicted[line[0]]);
    }
  }
  return pixels;
}

TEST(Png, ReadsBackPixelByPixel) {
  EXPECT_TRUE(rc::check("any picture", [] {
    const auto columns = *rc::gen::inRange<std::size_t>(1, 40), rows = *rc::gen::inRange<std::size_t>(1, 30);
    const auto pixels = *rc::gen::container<std::vector<std::uint8_t>>(
        4 * columns * rows,
        rc::gen::oneOf(rc::gen::arbitrary<std::uint8_t>(), rc::gen::just<std::uint8_t>(200)));
    const auto file = png_of(pixels, columns, rows);
    RC_ASSERT(file.has_value());
    RC_ASSERT(pixels_of(*file, columns, rows) == pixels);
  }));
}

TEST(Png, HasTheHeadOfItsPicture) {
  const auto chunks = chunks_of(png_of(std::vector<std::uint8_t>(4 * 7 * 3, 9), 7, 3).value());
  ASSERT_GE(chunks.size(), 3U);
  EXPECT_EQ(chunks.front().type, "IHDR");
  EXPECT_EQ(number_at(chunks.front().content, 0), 7U);
  EXPECT_EQ(number_at(chunks.front().content, 4), 3U);
  // Eight bits; red, green, blue and opacity; deflate; the filters above; not interlaced.
  EXPECT_EQ(chunks.front().content.substr(8), std::string("\x08\x06\x00\x00\x00", 5));
  EXPECT_EQ(chunks.back().type, "IEND");
}

TEST(Png, PixelsThatAreNoneAreRefused) {
  for (const std::size_t count : {0U, 4U, 47U, 49U}) {
    const auto file = png_of(std::vector<std::uint8_t>(count), 4, 3);
    test::expect_error(file, 0, "a picture of 4 x 3 pixels");
    EXPECT_EQ(file.error().code, Errc::kOutput);
  }
  EXPECT_FALSE(png_of({}, 0, 0));
}

}  // namespace png_test
}  // namespace octant::io
