// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "io/import/plan_import.h"
#include "io/text/bounds.h"
#include "io/text/open_file.h"
#include "io/yaml/yaml_reader.h"

namespace octant::io {
namespace {

constexpr double kMostPixels = 1e8;
constexpr std::size_t kLargestPicture = std::size_t{1} << 30;

struct Picture {
  std::size_t columns = 0, rows = 0;
  unsigned largest = 255;
  std::vector<std::uint16_t> grey;  ///< row by row from the top
};

/// Numbers of a PGM's head: white space between them, '#' comments to the end of a line.
class PgmHead {
 public:
  explicit PgmHead(std::string_view text) : text_(text) {}
  bool next(unsigned long& number) {
    while (at < text_.size() &&
           (std::isspace(static_cast<unsigned char>(text_[at])) != 0 || text_[at] == '#')) {
      if (text_[at] == '#')
        at =
            std::min(text_.substr(0, std::min(text_.size(), at + kLongestLine)).find('\n', at), text_.size());
      else
        ++at;
    }
    const std::size_t begin = at;
    for (number = 0;
         at < text_.size() && std::isdigit(static_cast<unsigned char>(text_[at])) != 0 && at - begin < 10;
         ++at)
      number = 10 * number + static_cast<unsigned long>(text_[at] - '0');
    return at > begin;
  }
  std::size_t at = 2;

 private:
  std::string_view text_;
};

Result<Picture> picture_from_pgm(std::string_view text, const std::string& file) {
  const auto bad = [&](std::string found, std::string expected) {
    return fail({.file = file, .found = std::move(found), .expected = std::move(expected)});
  };
  if (!text.starts_with("P5") && !text.starts_with("P2"))
    return bad("no PGM image", "a file that begins with P5 or P2");
  PgmHead head(text);
  unsigned long columns = 0, rows = 0, largest = 0;
  if (!head.next(columns) || !head.next(rows) || !head.next(largest) || columns == 0 || rows == 0 ||
      largest == 0 || largest > 65535)
    return bad("a PGM without width, height and largest grey value",
               "three whole numbers, the last up to 65535");
  if (static_cast<double>(columns) * static_cast<double>(rows) > kMostPixels)
    return bad(fmt::format("an image of {} x {} pixels", columns, rows),
               fmt::format("{:.0e} pixels at most", kMostPixels));
  Picture picture{columns, rows, static_cast<unsigned>(largest), {}};
  const std::size_t pixels = columns * rows;
  if (text[1] == '5') {
    const std::size_t begin = head.at + 1, bytes = largest > 255 ? 2 : 1;
    if (text.size() < begin + pixels * bytes)
      return bad("an image that ends early", fmt::format("{} bytes of pixels", pixels * bytes));
    picture.grey.reserve(pixels);
    for (std::size_t i = 0; i < pixels; ++i) {
      const auto byte = [&](std::size_t k) {
        return static_cast<unsigned>(static_cast<unsigned char>(text[begin + bytes * i + k]));
      };
      picture.grey.push_back(static_cast<std::uint16_t>(bytes == 1 ? byte(0) : 256 * byte(0) + byte(1)));
    }
    return picture;
  }
  if (text.size() < head.at + pixels)
    return bad("an image that ends early", fmt::format("{} pixels", pixels));
  picture.grey.reserve(pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    unsigned long value = 0;
    if (!head.next(value) || value > largest)
      return bad(fmt::format("pixel {} that is no grey value", i),
                 fmt::format("whole numbers up to {}", largest));
    picture.grey.push_back(static_cast<std::uint16_t>(value));
  }
  return picture;
}

struct Head {
  std::string image;
  double resolution_m = 0.05, occupied = 0.65, free = 0.196;
  std::vector<double> origin;
  bool negate = false;
};

Result<Head> head_from_yaml(const std::string& path) {
  const auto root = read_yaml(path);
  if (!root) return fail(root.error());
  YamlLog log(path);
  Head head;
  YamlMap map(*root, "", log);
  head.image = map.required_text("image");
  head.resolution_m = map.required_number("resolution", kPositive);
  head.origin = map.numbers("origin", 3);
  if (head.origin.size() != 3) map.fail_missing("origin", "[x, y, yaw]");
  head.negate = map.integer("negate", 0, 0, 1) == 1;
  head.occupied = map.number("occupied_thresh", head.occupied, kFraction);
  head.free = map.number("free_thresh", head.free, kFraction);
  if (log.error) return fail(*log.error);
  return head;
}

}  // namespace

Eigen::Vector2d RosMap::place_m(double column, double row) const {
  const double x = resolution_m * column, y = resolution_m * row;
  return origin_m + Eigen::Vector2d(std::cos(yaw_rad) * x - std::sin(yaw_rad) * y,
                                    std::sin(yaw_rad) * x + std::cos(yaw_rad) * y);
}

Result<RosMap> read_ros_map(const std::string& yaml_path) {
  const auto head = head_from_yaml(yaml_path);
  if (!head) return fail(head.error());
  const std::filesystem::path image(head->image);
  const std::string path =
      image.is_absolute() ? head->image : (std::filesystem::path(yaml_path).parent_path() / image).string();
  const auto pixels = MappedFile::open(path);
  if (!pixels) return fail(pixels.error());
  if (pixels->text().size() > kLargestPicture)
    return fail({.file = path,
                 .found = fmt::format("{} bytes", pixels->text().size()),
                 .expected = fmt::format("a picture of at most {} MB", kLargestPicture >> 20U)});
  const auto picture = picture_from_pgm(pixels->text(), path);
  if (!picture) return fail(picture.error());
  RosMap map{.columns = picture->columns,
             .rows = picture->rows,
             .resolution_m = head->resolution_m,
             .origin_m = {head->origin[0], head->origin[1]},
             .yaw_rad = head->origin[2],
             .cells = {},
             .image = path};
  map.cells.resize(map.columns * map.rows);
  for (std::size_t row = 0; row < map.rows; ++row)
    for (std::size_t column = 0; column < map.columns; ++column) {
      // map_server: dark is occupied, unless negated; the image's first row is the map's last.
      const double shade =
          static_cast<double>(picture->grey[(map.rows - 1 - row) * map.columns + column]) / picture->largest;
      const double occupied = head->negate ? shade : 1.0 - shade;
      map.cells[row * map.columns + column] = occupied > head->occupied ? RosMap::kOccupied
                                              : occupied < head->free   ? RosMap::kFree
                                                                        : RosMap::kUnknown;
    }
  return map;
}

std::vector<std::vector<Eigen::Vector2d>> rectangles_of(const RosMap& map, RosMap::Cell kind) {
  std::vector<std::vector<Eigen::Vector2d>> rectangles;
  std::vector<bool> taken(map.cells.size(), false);
  const auto open = [&](std::size_t column, std::size_t row) {
    const std::size_t at = row * map.columns + column;
    return map.cells[at] == kind && !taken[at];
  };
  for (std::size_t row = 0; row < map.rows; ++row)
    for (std::size_t column = 0; column < map.columns; ++column) {
      if (!open(column, row)) continue;
      std::size_t right = column, top = row;
      while (right < map.columns && open(right, row)) ++right;
      for (bool whole = true; whole; top += whole ? 1 : 0) {
        whole = top < map.rows;
        for (std::size_t c = column; whole && c < right; ++c) whole = open(c, top);
      }
      for (std::size_t r = row; r < top; ++r)
        for (std::size_t c = column; c < right; ++c) taken[r * map.columns + c] = true;
      const auto left_m = static_cast<double>(column), right_m = static_cast<double>(right),
                 low_m = static_cast<double>(row), high_m = static_cast<double>(top);
      rectangles.push_back({map.place_m(left_m, low_m), map.place_m(right_m, low_m),
                            map.place_m(right_m, high_m), map.place_m(left_m, high_m)});
    }
  return rectangles;
}

CostmapText costmap_text(const std::vector<std::uint8_t>& grey, std::size_t columns, std::size_t rows,
                         double resolution_m, const Eigen::Vector2d& origin_m,
                         const std::string& image_name) {
  CostmapText text;
  text.pgm = fmt::format("P5\n{} {}\n255\n", columns, rows);
  for (std::size_t row = rows; row-- > 0;)
    text.pgm.append(reinterpret_cast<const char*>(grey.data()) + row * columns, columns);
  text.yaml = fmt::format(
      "image: {}\nmode: scale\nresolution: {}\norigin: [{}, {}, 0.0]\nnegate: 0\noccupied_thresh: "
      "0.65\nfree_thresh: 0.196\n",
      image_name, exact(resolution_m), exact(origin_m.x()), exact(origin_m.y()));
  return text;
}

}  // namespace octant::io
