// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fstream>
#include <stdexcept>
#include <string>

#include <nlohmann/json.hpp>

namespace octant::test {

/// tests/golden/<name>.json: {"source": ..., "cases": [...]}.
inline nlohmann::json golden(const std::string& name) {
  const std::string path = std::string(OCTANT_SOURCE_DIR) + "/tests/golden/" + name + ".json";
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot open " + path);
  return nlohmann::json::parse(file);
}

/// Its cases, by value: a range-for over golden(name)["cases"] would run over a dead temporary.
inline nlohmann::json golden_cases(const std::string& name) {
  nlohmann::json cases = golden(name).at("cases");
  if (cases.empty()) throw std::runtime_error(name + ": no cases");
  return cases;
}

}  // namespace octant::test
