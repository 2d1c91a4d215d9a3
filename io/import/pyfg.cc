// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/import/pyfg.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include <fmt/format.h>

#include "io/import/decoded_text.h"
#include "io/import/kit_lines.h"
#include "io/text/text.h"

namespace octant::io {
namespace {

constexpr double kShortestQuaternion = 1e-6;

/// Words of one line.
struct GraphLine {
  int number = 0;
  std::vector<std::string_view> words;

  [[nodiscard]] std::string_view word(std::size_t i) const {
    return i < words.size() ? words[i] : std::string_view();
  }
};

/// Letters before the number of a pose: the robot.
std::string_view robot_of(std::string_view pose) {
  return pose.substr(0, std::min(pose.find_first_of("0123456789"), pose.size()));
}

class PyfgReader {
 public:
  PyfgReader(const std::string& path, std::string_view robot) : robot_(robot) { log_.path = path; }

  Result<ImportedLog> read(std::string_view text) {
    GraphLine line;
    while (!text.empty()) {
      ++line.number;
      const std::string_view content = without_blanks(take_line(text));
      if (content.empty() || content.front() == '#') continue;
      line.words = fields_at(content, ' ');
      std::erase_if(line.words, [](std::string_view word) { return word.empty(); });
      if (auto read = read_line(line); !read) return fail(read.error());
    }
    order_steps();
    join_odometry();
    for (const auto& [what, count] : left_out_)
      log_.warnings.push_back(fmt::format("{}: {} {} are left out", log_.path, count, what));
    return std::move(log_);
  }

 private:
  struct Step {
    std::string from, to;
    double time_s;
    Pose T_from_to;
  };

  [[nodiscard]] tl::unexpected<Error> error(const GraphLine& line, std::string found,
                                            std::string expected) const {
    return fail(
        {.file = log_.path, .line = line.number, .found = std::move(found), .expected = std::move(expected)});
  }

  Result<void> read_line(const GraphLine& line) {
    const std::string_view kind = line.word(0);
    if (kind == "VERTEX_SE2" || kind == "VERTEX_SE3:QUAT") return read_vertex(line);
    if (kind == "EDGE_SE2" || kind == "EDGE_SE3:QUAT") return read_step(line);
    if (kind == "EDGE_RANGE") return read_range(line);
    if (kind == "VERTEX_XY" || kind == "VERTEX_XYZ") {
      landmarks_.emplace(line.word(1));
      return {};
    }
    if (kind.ends_with(":PRIOR")) return leave_out("priors");
    if (kind == "EDGE_SE2_XY" || kind == "EDGE_SE3_XYZ") return leave_out("relative positions of landmarks");
    return error(line, in_quotes(kind), "a vertex or an edge of a graph of PyFactorGraph");
  }

  Result<void> leave_out(const char* what) { return ++left_out_[what], Result<void>(); }

  /// Numbers from a word on.
  template <std::size_t N>
  bool numbers(const GraphLine& line, std::size_t first, std::array<double, N>& values) const {
    for (std::size_t i = 0; i < N; ++i)
      if (!logged_number(line.word(first + i), values[i])) return false;
    return true;
  }

  /// A pose in the plane (x, y, angle) or in space (x, y, z, qx, qy, qz, qw).
  bool pose_at(const GraphLine& line, std::size_t first, Pose& pose) const {
    if (line.word(0).find("SE2") != std::string_view::npos) {
      std::array<double, 3> v{};
      if (!numbers(line, first, v)) return false;
      pose = Pose::planar(v[0], v[1], v[2]);
      return true;
    }
    std::array<double, 7> v{};
    if (!numbers(line, first, v)) return false;
    const Eigen::Quaterniond rotation(v[6], v[3], v[4], v[5]);
    if (!(rotation.norm() > kShortestQuaternion)) return false;
    pose.translation_m = {v[0], v[1], v[2]};
    pose.rotation = rotation.normalized();
    return true;
  }

  /// True for the robot that is read: the stated one, or that of the first vertex.
  bool is_robot(std::string_view pose) {
    if (robot_.empty()) robot_ = robot_of(pose);
    return robot_of(pose) == robot_;
  }

  Result<void> read_vertex(const GraphLine& line) {
    TimedPose pose;
    if (!logged_number(line.word(1), pose.time_s) || line.word(2).empty() ||
        !pose_at(line, 3, pose.T_map_vehicle))
      return error(line, "an incomplete vertex", "time, name, position and rotation");
    if (!is_robot(line.word(2))) return leave_out("poses of other robots");
    time_of_[std::string(line.word(2))] = pose.time_s;
    order_of_.emplace(line.word(2), log_.truth.size());
    log_.truth.push_back(pose);
    return {};
  }

  /// Sorts the steps by their vertices; a repeated step counts once. Warns of vertices without a step.
  void order_steps() {
    if (order_of_.empty()) return;
    const auto place = [this](const Step& step) {
      const auto known = order_of_.find(step.from);
      return known != order_of_.end() ? known->second : order_of_.size();
    };
    std::ranges::stable_sort(steps_, {}, place);
    const auto same = [](const Step& a, const Step& b) { return a.from == b.from && a.to == b.to; };
    const auto repeated = std::ranges::unique(steps_, same);
    if (!repeated.empty()) left_out_["repeated edges of the odometry"] = repeated.size();
    steps_.erase(repeated.begin(), repeated.end());
    const auto apart = [](const Step& a, const Step& b) { return a.to != b.from; };
    const auto gap = std::ranges::adjacent_find(steps_, apart);
    if (gap == steps_.end()) return;
    log_.warnings.push_back(
        fmt::format("{}: the odometry has no edge from {} to {}; the motion between them is unknown and is "
                    "left out, there and at other gaps",
                    log_.path, gap->to, std::next(gap)->from));
  }

  /// True for a step to the next vertex. Without vertices, steps follow each other and reach new poses.
  bool is_next(const Step& step) {
    const auto from = order_of_.find(step.from), to = order_of_.find(step.to);
    if (from != order_of_.end() && to != order_of_.end()) return to->second == from->second + 1;
    const bool follows = steps_.empty() || steps_.back().to == step.from;
    return follows && reached_.insert(step.to).second;
  }

  Result<void> read_step(const GraphLine& line) {
    Step step;
    if (!logged_number(line.word(1), step.time_s) || line.word(3).empty() ||
        !pose_at(line, 4, step.T_from_to))
      return error(line, "an incomplete edge", "time, two poses, translation and rotation");
    step.from = line.word(2);
    step.to = line.word(3);
    if (!is_robot(step.from) || !is_robot(step.to)) return leave_out("edges of other robots");
    if (!is_next(step)) return leave_out("loop closures");
    steps_.push_back(std::move(step));
    return {};
  }

  Result<void> read_range(const GraphLine& line) {
    ImportedArrival a;
    if (!logged_number(line.word(1), a.time_s) || line.word(3).empty() ||
        !logged_number(line.word(4), a.value))
      return error(line, "an incomplete range", "time, pose, landmark and distance");
    if (!is_robot(line.word(2))) return leave_out("ranges of other robots");
    if (!landmarks_.empty() && !landmarks_.contains(line.word(3))) return leave_out("ranges between robots");
    a.is_distance = true;
    a.beacon = log_.names.number_of(line.word(3));
    if (a.beacon < 0)
      return error(line, fmt::format("more than {} names", kMostImportedNames),
                   "as many as there may be at a site");
    log_.arrivals.push_back(a);
    return {};
  }

  /// Poses of the odometry from the steps between them. The time of a step is that of its first pose.
  void join_odometry() {
    if (steps_.empty()) return;
    const auto time_of = [this](const std::string& pose, double otherwise_s) {
      const auto known = time_of_.find(pose);
      return known != time_of_.end() ? known->second : otherwise_s;
    };
    TimedPose pose{time_of(steps_.front().from, steps_.front().time_s), {}};
    log_.odometry.push_back(pose);
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      const Step& step = steps_[i];
      if (i > 0 && steps_[i - 1].to != step.from) {
        pose.time_s = time_of(step.from, step.time_s);
        log_.odometry.push_back(pose);
      }
      pose.T_map_vehicle = pose.T_map_vehicle * step.T_from_to;
      pose.time_s = time_of(step.to, step.time_s);
      log_.odometry.push_back(pose);
    }
  }

  std::string robot_;
  ImportedLog log_;
  std::vector<Step> steps_;
  std::map<std::string, double, std::less<>> time_of_;
  std::map<std::string, std::size_t, std::less<>> order_of_;  // of the vertices
  std::set<std::string, std::less<>> landmarks_, reached_;
  std::map<std::string, std::size_t> left_out_;
};

}  // namespace

bool is_pyfg(const std::string& path) {
  const auto text = DecodedText::open(path);
  if (!text) return false;
  std::string_view rest = text->text();
  std::string_view line;
  while (!rest.empty() && (line.empty() || line.front() == '#')) line = without_blanks(take_line(rest));
  for (const char* kind : {"VERTEX_SE2 ", "VERTEX_SE3:QUAT ", "VERTEX_XY ", "VERTEX_XYZ ", "EDGE_RANGE "})
    if (line.starts_with(kind)) return true;
  return false;
}

Result<ImportedLog> read_pyfg(const std::string& path, std::string_view robot) {
  const auto text = DecodedText::open(path);
  if (!text) return fail(text.error());
  return PyfgReader(path, robot).read(text->text());
}

}  // namespace octant::io
