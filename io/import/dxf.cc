// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <fmt/format.h>

#include "io/import/plan_import.h"
#include "io/text/bounds.h"
#include "io/text/open_file.h"
#include "io/text/text.h"

namespace octant::io {
namespace {

constexpr std::size_t kMostPoints = 2'000'000;
constexpr std::size_t kLargestDxf = std::size_t{1} << 28;

/// A group: a code, which defines the kind of the value, and the value, each on its own line.
struct Group {
  int code = 0;
  std::string_view value;
  int line = 0;  ///< line of the value
};

class Groups {
 public:
  Groups(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  /// Next group; false at the end and on error.
  bool next(Group& group) {
    std::string_view code;
    do {
      if (error || !read_line(code)) return false;
    } while (code.empty() && text_.empty());
    double number = 0.0;
    if (parse_number(code, number) != NumberText::kNumber || number != std::floor(number) ||
        std::abs(number) > 100000) {
      fail(fmt::format("{} where a DXF group code should be", in_quotes(code)),
           "a whole number on a line of its own, as in an ASCII DXF");
      return false;
    }
    group.code = static_cast<int>(number);
    if (!read_line(group.value)) {
      fail("the file ends within a group", "a value behind each group code", "write the DXF again");
      return false;
    }
    group.line = line_;
    return true;
  }

  double number(const Group& group) {
    double value = 0.0;
    if (parse_number(group.value, value) != NumberText::kNumber || !std::isfinite(value))
      fail(fmt::format("{} for group {}", in_quotes(group.value), group.code), "a number");
    return value;
  }

  /// Flags and units as an integer; 0 if the text is no integer.
  int integer(const Group& group) {
    constexpr double kMost = 1e9;
    const double value = number(group);
    if (std::abs(value) <= kMost && value == std::floor(value)) return static_cast<int>(value);
    fail(fmt::format("{} for group {}", in_quotes(group.value), group.code), "a whole number");
    return 0;
  }

  void fail(std::string found, std::string expected, std::string advice = "") {
    if (!error)
      error = Error{.file = file_,
                    .line = line_,
                    .found = std::move(found),
                    .expected = std::move(expected),
                    .advice = std::move(advice)};
  }

  std::optional<Error> error;

 private:
  bool read_line(std::string_view& line) {
    if (text_.empty()) return false;
    line = without_blanks(take_line(text_));
    ++line_;
    return true;
  }

  std::string_view text_;
  const std::string& file_;
  int line_ = 0;
};

/// Metres per unit of $INSUNITS; 0: not stated, -1: a unit that plans do not use.
double metres_of(int unit) {
  switch (unit) {
    case 0: return 0.0;
    case 1: return 0.0254;
    case 2: return 0.3048;
    case 4: return 1e-3;
    case 5: return 1e-2;
    case 6: return 1.0;
    case 7: return 1e3;
    case 10: return 0.9144;
    case 14: return 0.1;
    default: return -1.0;
  }
}

/// An entity while its groups are read.
struct Entity {
  std::string type;
  DrawnLine drawn;
  std::vector<double> bulges;
  Eigen::Vector2d end = Eigen::Vector2d::Zero();
  bool mirrored = false;  ///< extrusion direction (0, 0, -1)
  int flags = 0;
};

/// Chords of a side with a bulge (the tangent of a quarter of its angle).
void add_side(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double bulge,
              std::vector<Eigen::Vector2d>& points) {
  const double angle = 4 * std::atan(bulge);
  const int chords =
      std::clamp(static_cast<int>(std::ceil(std::abs(angle) / (std::numbers::pi / 18))), 1, 36);
  if (bulge != 0 && chords > 1) {
    const Eigen::Vector2d half = (to - from) / 2;
    const Eigen::Vector2d centre = from + half + Eigen::Vector2d(-half.y(), half.x()) / std::tan(angle / 2);
    const Eigen::Vector2d arm = from - centre;
    for (int k = 1; k < chords; ++k) {
      const double turn = angle * k / chords;
      points.emplace_back(centre + Eigen::Vector2d(std::cos(turn) * arm.x() - std::sin(turn) * arm.y(),
                                                   std::sin(turn) * arm.x() + std::cos(turn) * arm.y()));
    }
  }
  points.push_back(to);
}

class Reader {
 public:
  Reader(std::string_view text, const std::string& file, std::optional<double> unit_m)
      : groups_(text, file), file_(file), unit_m_(unit_m) {}

  Result<Drawing> read() {
    Group group;
    std::string section, variable;
    while (groups_.next(group)) {
      if (group.code == 0) {
        finish_entity();
        if (group.value == "EOF") break;
        if (group.value == "ENDSEC") section.clear();
        begin(group, section);
      } else if (group.code == 2 && entity_.type == "SECTION") {
        section = group.value;
      } else if (section == "HEADER") {
        if (group.code == 9) variable = group.value;
        if (group.code == 70 && variable == "$INSUNITS") header_unit_ = groups_.integer(group);
      } else if (section == "ENTITIES") {
        take(group);
      }
    }
    if (groups_.error) return octant::fail(*groups_.error);
    return scaled();
  }

 private:
  void begin(const Group& group, const std::string& section) {
    const bool vertex = group.value == "VERTEX" || group.value == "SEQEND";
    entity_ = {};
    entity_.type = group.value;
    entity_.drawn.line = group.line;
    if (section != "ENTITIES" || vertex) return;
    if (group.value == "LINE") entity_.drawn.points_m.emplace_back(0, 0);
    if (group.value == "POLYLINE") polyline_ = entity_;
    if (group.value != "LINE" && group.value != "LWPOLYLINE" && group.value != "POLYLINE" &&
        group.value != "ENDSEC")
      ++others_[entity_.type];
  }

  void take(const Group& g) {
    const double value = g.code >= 10 && g.code < 60 ? groups_.number(g) : 0.0;
    Entity& e = entity_.type == "POLYLINE" ? polyline_ : entity_;
    auto& points = e.drawn.points_m;
    if (g.code == 8) e.drawn.layer = g.value;
    if (g.code == 70 || (g.code == 230 && without_blanks(g.value).starts_with("-1")))
      (g.code == 70 ? e.flags = groups_.integer(g) : e.mirrored = true);
    if (entity_.type == "LINE") {
      if (g.code == 10) points[0].x() = value;
      if (g.code == 20) points[0].y() = value;
      if (g.code == 11) e.end.x() = value;
      if (g.code == 21) e.end.y() = value;
    } else if (entity_.type == "LWPOLYLINE" || entity_.type == "VERTEX") {
      if (g.code == 10) points.emplace_back(value, 0), e.bulges.push_back(0.0);
      if (g.code == 20 && !points.empty()) points.back().y() = value;
      if (g.code == 42 && !e.bulges.empty()) e.bulges.back() = value;
      if (++count_ > kMostPoints * 4)
        groups_.fail("a drawing of millions of points", "a floor plan", "export the walls' layers alone");
    }
  }

  void finish_entity() {
    if (entity_.type == "LINE" && !entity_.drawn.points_m.empty()) {
      entity_.drawn.points_m.push_back(entity_.end);
      entity_.bulges = {0.0, 0.0};
      keep(entity_);
    } else if (entity_.type == "LWPOLYLINE") {
      keep(entity_);
    } else if (entity_.type == "VERTEX" && !entity_.drawn.points_m.empty() &&
               (entity_.flags & 16) == 0) {  // 16: a spline's frame
      polyline_.drawn.points_m.push_back(entity_.drawn.points_m[0]);
      polyline_.bulges.push_back(entity_.bulges[0]);
    } else if (entity_.type == "SEQEND" && polyline_.type == "POLYLINE") {
      if ((polyline_.flags & (16 | 64)) != 0) {
        ++others_["POLYLINE of a mesh"];
      } else {
        keep(polyline_);
      }
      polyline_ = {};
    }
    entity_ = {};
  }

  void keep(const Entity& e) {
    DrawnLine drawn = e.drawn;
    drawn.closed = e.type != "LINE" && (e.flags & 1) != 0;
    drawn.points_m.clear();
    const auto& points = e.drawn.points_m;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (i == 0)
        drawn.points_m.push_back(points[0]);
      else
        add_side(points[i - 1], points[i], e.bulges[i - 1], drawn.points_m);
    }
    // Two corners enclose an area if a side bulges: a circle is drawn as two halves.
    if (drawn.closed && (points.size() > 2 || (points.size() == 2 && e.bulges.back() != 0.0))) {
      add_side(points.back(), points.front(), e.bulges.back(), drawn.points_m);
      drawn.points_m.pop_back();  // the first corner again
    }
    if (e.mirrored)
      for (auto& p : drawn.points_m) p.x() = -p.x();
    const auto twice = std::unique(drawn.points_m.begin(), drawn.points_m.end());
    drawn.points_m.erase(twice, drawn.points_m.end());
    if (drawn.closed && drawn.points_m.size() > 1 && drawn.points_m.front() == drawn.points_m.back())
      drawn.points_m.pop_back();
    if (drawn.points_m.size() > 1) drawing_.lines.push_back(std::move(drawn));
  }

  Result<Drawing> scaled() {
    double unit = unit_m_.value_or(metres_of(header_unit_));
    if (unit < 0)
      return octant::fail({.file = file_,
                           .found = fmt::format("$INSUNITS {}", header_unit_),
                           .expected = "inches, feet, mm, cm, dm, m or km",
                           .advice = "state unit_m: the metres in a unit of the drawing"});
    if (unit == 0) {
      drawing_.warnings.push_back(
          fmt::format("{}: the drawing states no unit ($INSUNITS); metres are assumed (unit_m: 1)", file_));
      unit = 1.0;
    }
    for (DrawnLine& line : drawing_.lines)
      for (auto& p : line.points_m) p *= unit;
    std::string names;
    for (const auto& [type, count] : others_)
      names += fmt::format("{}{} {}", names.empty() ? "" : ", ", count, type);
    if (!names.empty()) drawing_.warnings.push_back(fmt::format("{}: not read: {}", file_, names));
    return std::move(drawing_);
  }

  Groups groups_;
  std::string file_;
  std::optional<double> unit_m_;
  Drawing drawing_;
  Entity entity_, polyline_;
  std::map<std::string, int> others_;
  int header_unit_ = 0;
  std::size_t count_ = 0;
};

}  // namespace

Result<Drawing> drawing_from_dxf(std::string_view text, const std::string& file,
                                 std::optional<double> unit_m) {
  if (text.starts_with("AutoCAD Binary DXF"))
    return fail({.file = file,
                 .line = 1,
                 .found = "a binary DXF",
                 .expected = "an ASCII DXF",
                 .advice = "save it as ASCII"});
  if (auto ok = check_lines(text, file); !ok) return fail(ok.error());
  return Reader(without_bom(text), file, unit_m).read();
}

Result<Drawing> read_dxf(const std::string& path, std::optional<double> unit_m) {
  const auto map = MappedFile::open(path);
  if (!map) return fail(map.error());
  if (map->text().size() > kLargestDxf)
    return fail({.file = path,
                 .found = fmt::format("{} bytes", map->text().size()),
                 .expected = fmt::format("a DXF of at most {} MB", kLargestDxf >> 20U),
                 .advice = "export the walls' layers alone"});
  return drawing_from_dxf(map->text(), path, unit_m);
}

}  // namespace octant::io
