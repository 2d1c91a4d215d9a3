// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Representation of values in JSON, for all documents: missing values as null, vectors as lists of numbers,
// changes and contradictions with the same keys.

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "models/change.h"
#include "models/contradiction.h"

namespace nlohmann {

template <class Value>
struct adl_serializer<std::optional<Value>> {
  template <class Json>
  static void to_json(Json& j, const std::optional<Value>& value) {
    j = value ? Json(*value) : Json(nullptr);
  }
  template <class Json>
  static void from_json(const Json& j, std::optional<Value>& value) {
    value = std::nullopt;
    if (!j.is_null()) value = j.template get<Value>();
  }
};

template <int N>
struct adl_serializer<Eigen::Matrix<double, N, 1>> {
  template <class Json>
  static void to_json(Json& j, const Eigen::Matrix<double, N, 1>& v) {
    j = std::vector<double>(v.data(), v.data() + N);
  }
  template <class Json>
  static void from_json(const Json& j, Eigen::Matrix<double, N, 1>& v) {
    v = Eigen::Map<const Eigen::Matrix<double, N, 1>>(j.template get<std::array<double, N>>().data());
  }
};

}  // namespace nlohmann

namespace octant::io {

[[nodiscard]] inline nlohmann::ordered_json json_of(const std::vector<Change>& changes) {
  auto list = nlohmann::ordered_json::array();
  for (const Change& c : changes)
    list.push_back({{"kind", to_string(c.kind)},
                    {"subject", c.subject},
                    {"size", c.size},
                    {"sigma", c.sigma},
                    {"unit", unit_of(c.kind)},
                    {"p", c.p}});
  return list;
}

[[nodiscard]] inline nlohmann::ordered_json json_of(const std::vector<Contradiction>& contradictions) {
  auto list = nlohmann::ordered_json::array();
  for (const Contradiction& c : contradictions)
    list.push_back({{"kind", to_string(c.kind)},
                    {"subject", c.subject},
                    {"stated", c.stated},
                    {"found", c.found},
                    {"sigmas", c.sigmas},
                    {"remedy", c.remedy}});
  return list;
}

}  // namespace octant::io
