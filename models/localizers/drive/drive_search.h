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
  double air_sigma_mps = 0.0;  ///< prior sigma of the speed's offset without a recorded temperature
  double most_place_m = 1.0;   ///< sigma of the position beyond which a filter is not linear
};

[[nodiscard]] DriveSearchOptions drive_search_options(const Deployment& deployment,
                                                      const TrackerOptions& tracker);
/// State space of a moving vehicle.
[[nodiscard]] StateSpace drive_states(const TrajectoryModel& model, Motion motion);

/// Finds a vehicle from the last seconds of its drive, and starts the filters there. The pose is searched as
/// for an unknown start (drive_start.h), first at the deployment's speed and then with an unknown offset. It
/// must be determined without any one of its beacons; its uncertainty includes the differences of these
/// solutions. All memory is allocated at construction.
template <int kDof>
class DriveSearchOf {
 public:
  using Filter = DriveFilterOf<kDof>;
  using State = typename Filter::State;

  /// @param model, calibration  must outlive it; a search changes the model's speed
  DriveSearchOf(EpochFixModel& model, const CalibrationPart& calibration, const StateSpace& vehicle,
                const DriveSearchOptions& options);

  void begin(double time_s);
  [[nodiscard]] StartWindow& window() { return window_; }
  /// Searches if the window has grown by a third since the last search, and starts the filters at its end.
  /// @param work  auxiliary filter
  [[nodiscard]] bool search(bool is_temperature_known, Filter& filter, BeaconBankOf<kDof>& bank,
                            Filter& work);

 private:
  /// Number of beacons from which each can be checked against the others, in the plane and in space.
  static constexpr std::size_t kVerifiable = kDof == 3 ? 3 : 4;
  [[nodiscard]] bool has_searched_long();
  [[nodiscard]] bool place();
  [[nodiscard]] bool start_filters(Filter& filter, BeaconBankOf<kDof>& bank, Filter& work);
  [[nodiscard]] bool is_verified(const Filter& filter, Filter& work, State& farthest);
  /// Starts a filter at the end of the window, from its solved states.
  void start_at_end(Filter& filter);
  /// Starts a filter at the end of the window, from the states solved without a beacon. With a poorly known
  /// attitude instead, a filter would not be linear enough to judge another one.
  void start_without(const DriveMember& member, Filter& filter);

  EpochFixModel& model_;
  const CalibrationPart& calibration_;
  DriveSearchOptions options_;
  StartWindow window_;
  double base_mps_ = 0.0, speed_sigma_mps_ = 0.0;  ///< offset in the model, and prior sigma of a further one
  StartSpeed start_speed_;
  NodeCalibration start_calibration_;  ///< sensitivity of the pose to the calibration
  std::vector<Node> with_all_;         ///< nodes of the window during a solution without a beacon
  double next_search_s_ = 0.0;         ///< span of the window at the next search
  double begun_s_ = 0.0;
  Scratch scratch_, solving_;
};

extern template class DriveSearchOf<3>;
extern template class DriveSearchOf<6>;

}  // namespace octant
