// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <random>

#include <Eigen/Core>

namespace octant {

/// Random numbers that are identical with every standard library. The standard specifies the output of the
/// engine, but not that of std::normal_distribution and the other distributions.
class Random {
 public:
  /// Streams of one seed are independent, so a change in one part of a world leaves the others unchanged.
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0)
      : engine_(mix(seed + 0x9e3779b97f4a7c15ULL * (stream + 1))) {}

  [[nodiscard]] double uniform();                         ///< [0, 1)
  [[nodiscard]] double uniform(double low, double high);  ///< [low, high)
  [[nodiscard]] double log_uniform(double low, double high);
  [[nodiscard]] double normal();  ///< mean 0, sigma 1
  [[nodiscard]] double clipped_normal(double limit = 2.0);
  [[nodiscard]] Eigen::Vector3d normal3();

 private:
  [[nodiscard]] static std::uint64_t mix(std::uint64_t x);
  std::mt19937_64 engine_;
};

}  // namespace octant
