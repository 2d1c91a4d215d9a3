// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "models/localizers/chain/chain_calibration.h"
#include "models/localizers/common/calibration_part.h"
#include "models/localizers/drive/beacon_bank.h"
#include "models/localizers/drive/drive_filter.h"
#include "models/localizers/drive/start_window.h"
#include "models/localizers/start/tracker_options.h"
#include "models/support/scratch.h"

namespace octant {

struct DriveSearchOptions {
  TrackerOptions tracker;
  double air_sigma_mps = 0.0;  ///< prior sigma of the speed's offset where no temperature is stated
  double most_place_m = 1.0, most_turn_rad = 0.6;  ///< sigmas beyond which a filter is not linear
};

[[nodiscard]] DriveSearchOptions drive_search_options(const Deployment& deployment,
                                                      const TrackerOptions& tracker);
/// The states of a moving vehicle.
[[nodiscard]] StateSpace drive_states(const TrajectoryModel& model, Motion motion);

/// Finds a vehicle by the last seconds of its drive, and starts the filters there. The pose is searched as
/// for an unknown start (drive_start.h), first at the stated speed and then with room for another one. It has
/// to be determined without any one of its beacons, and is as uncertain as these solutions are apart. All
/// memory is taken at construction.
template <int kDof>
class DriveSearchOf {
 public:
  using Filter = DriveFilterOf<kDof>;
  using Vector = typename Filter::Vector;

  /// @param model, calibration  outlive it; while it searches the model's speed is changed
  DriveSearchOf(EpochFixModel& model, const CalibrationPart& calibration, const StateSpace& vehicle,
                const DriveSearchOptions& options);

  void begin(double time_s);
  [[nodiscard]] StartWindow& window() { return window_; }
  /// Searches if the window has grown by a third since the last time, and starts the filters at its end.
  /// @param work  a filter to work with
  [[nodiscard]] bool search(bool is_temperature_known, Filter& filter, BeaconBankOf<kDof>& bank,
                            Filter& work);

 private:
  /// In the plane and in space: of so many beacons each can be held against the others.
  static constexpr std::size_t kVerifiable = kDof == 3 ? 3 : 4;
  [[nodiscard]] bool has_searched_long();
  [[nodiscard]] bool place(double sigma_mps);
  [[nodiscard]] bool start_filters(Filter& filter, BeaconBankOf<kDof>& bank, Filter& work);
  [[nodiscard]] bool is_verified(const Filter& filter, Filter& work, Vector& farthest);
  /// Starts a filter where the window's states, as they are solved, have its end.
  void start_at_end(Filter& filter);
  /// The same of the states as they are solved without a beacon. A filter that began with little known of
  /// its attitude instead would not be linear enough to judge another one.
  void start_without(BeaconId beacon, Filter& filter);

  EpochFixModel& model_;
  const CalibrationPart& calibration_;
  DriveSearchOptions options_;
  StartWindow window_;
  StartSpeed start_speed_;
  NodeCalibration start_calibration_;  ///< how the place found follows the calibration
  std::vector<Node> with_all_;         ///< the window's nodes, while they are solved without a beacon
  double next_search_s_ = 0.0;         ///< span of the window at which to search
  double begun_s_ = 0.0;
  Scratch scratch_;
};

extern template class DriveSearchOf<3>;
extern template class DriveSearchOf<6>;

}  // namespace octant
