// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/import/png.h"

#include <png.h>

#include <fmt/format.h>

namespace octant::io {

Result<std::string> png_of(const std::vector<std::uint8_t>& rgba, std::size_t columns, std::size_t rows) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(columns);
  image.height = static_cast<png_uint_32>(rows);
  image.format = PNG_FORMAT_RGBA;
  std::string file;
  png_alloc_size_t bytes = 0;
  // The first call computes the size, the second one writes the bytes.
  bool written = rgba.size() == 4 * columns * rows &&
                 png_image_write_to_memory(&image, nullptr, &bytes, 0, rgba.data(), 0, nullptr) != 0;
  if (written) {
    file.resize(bytes);
    written = png_image_write_to_memory(&image, file.data(), &bytes, 0, rgba.data(), 0, nullptr) != 0;
    file.resize(bytes);
  }
  if (!written)
    return fail({.code = Errc::kOutput,
                 .found = fmt::format("a picture of {} x {} pixels that libpng does not write: {}", columns,
                                      rows, image.message),
                 .expected = "a picture"});
  return file;
}

}  // namespace octant::io
