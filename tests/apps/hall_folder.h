// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/apps/process.h"

namespace octant::test {

/// A simulated hall in its own folder, smaller than the demo's, and a second folder for results.
class HallFolder : public ::testing::Test {
 protected:
  void SetUp() override { make(40); }
  void make(int epochs) { make(hall_scenario_text("epochs: 150", "epochs: " + std::to_string(epochs))); }
  void make(const std::string& scenario) {
    spit(box / "scenario.yaml", scenario);
    const Outcome made = octant({"simulate", box / "scenario.yaml", "-o", box / "hall"});
    ASSERT_EQ(made.exit, 0) << made.err;
    std::filesystem::create_directory(box / "out");
  }
  [[nodiscard]] std::string hall(const std::string& name) const { return box / ("hall/" + name); }
  [[nodiscard]] std::string out(const std::string& name) const { return box / ("out/" + name); }
  [[nodiscard]] Outcome calibrate(std::vector<std::string> more = {}) const {
    std::vector<std::string> words = {"calibrate",   hall("site.yaml"), hall("run"), "-o",
                                      out("d.json"), "--progress",      "none"};
    words.insert(words.end(), more.begin(), more.end());
    return octant(words);
  }
  [[nodiscard]] std::vector<std::string> outputs() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(box / "out"))
      names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }
  TemporaryFolder box;
};

}  // namespace octant::test
