// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "models/ids.h"

namespace octant {

/// Test for beacons that fell silent. The drive is divided into places, and at each place a beacon was
/// received or missed. The probability of a miss is that of all beacons at the same distance or farther away,
/// corrected by the beacon's own history at this place. Misses in a row multiply, and a reception resets the
/// product. So a beacon that is out of reach, or behind a wall, is not silent.
class ReceptionWatch {
 public:
  /// @param threshold  on the sum of -ln(probability of a miss)
  ReceptionWatch(std::vector<Eigen::Vector3d> beacons_map_m, double threshold);

  void receive(BeaconId beacon) {
    if (beacon.index() < beacons_.size()) beacons_[beacon.index()].received = true;
  }
  /// The vehicle leaves the place where the arrivals since the last call were received. Returns a beacon that
  /// fell silent, once.
  [[nodiscard]] std::optional<BeaconId> leave_place(const Eigen::Vector3d& p_map_m, double time_s);
  /// Time of the last reception, or of the first place.
  [[nodiscard]] double since_s(BeaconId beacon) const { return beacons_[beacon.index()].since_s; }
  void restart();

 private:
  static constexpr std::size_t kDistances = 96, kCells = 2048;
  struct Count {
    double places = 0.0, missed = 0.0;
  };
  struct History {
    std::uint8_t places = 0, missed = 0;
    std::uint8_t open = 0;  ///< misses since the last reception, which are not counted yet
  };
  struct Beacon {
    Eigen::Vector3d p_map_m;
    bool received = false, silent = false;
    double evidence = 0.0, since_s = 0.0;
    std::array<float, kDistances> missed{};  ///< places missed since the last reception, by distance
  };
  void close_misses(std::size_t beacon);
  [[nodiscard]] double miss_probability(std::size_t distance, const History& here) const;
  [[nodiscard]] std::size_t cell_of(const Eigen::Vector3d& p_map_m);

  double threshold_;
  bool begun_ = false;
  std::vector<Beacon> beacons_;
  std::array<Count, kDistances> by_distance_{};
  std::vector<std::int64_t> cells_;  ///< keys of places, open addressing; 0: free
  std::vector<History> history_;     ///< for each cell and beacon
};

}  // namespace octant
