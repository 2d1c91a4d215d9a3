// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

namespace octant::calib {

/// Epochs are settled eight at a time, one in each lane; narrower machines take the eight in turns.
inline constexpr std::size_t kLanes = 8;

/// The evaluation point as flat tables. All beacon and receiver entries are x, y, z [m] and delay [s]; a site's one delay is on
/// the beacons. All arrivals have one sigma.
struct StopTables {
  const double* beacon = nullptr;    ///< beacons x 4
  const double* receiver = nullptr;  ///< receivers x 4
  double speed_mps = 343.0;          ///< of the medium where arrivals carry none, offset included
  double speed_offset_mps = 0.0;     ///< added to an arrival's own
  double sigma_s = 1.0;
  double late_scale = 0.0, early_scale = 0.0;  ///< of RobustLoss
  bool has_offset = false;                     ///< Clock::kCycleOffset
  double nominal_speed_mps = 343.0;            ///< turns cycle offsets into metres
};

/// Eight epochs turned sideways: slot k of all lanes, then slot k + 1. Lanes that have run out carry beacon -1.
struct StopLanes {
  std::size_t slots = 0;
  const double* tof_s = nullptr;            ///< slots x 8
  const std::int32_t* beacon = nullptr;     ///< slots x 8
  const std::int32_t* receiver = nullptr;   ///< slots x 8
  const double* model_speed_mps = nullptr;  ///< slots x 8, or null
};

/// State of eight epochs: x, y [m], heading [rad], cycle offset [m], a row of eight each.
struct StopStates {
  alignas(64) double value[4][kLanes];
};

struct StopOutcome {
  alignas(64) double cost[kLanes];       ///< 1/2 sum of rho
  alignas(64) double converged[kLanes];  ///< 1: at rest; 0: not, or singular: to be settled with care
};

/// Gauss-Newton steps (damped where the cost would rise) on the states of eight epochs, as `settle` does for one.
void settle_stops(const StopTables& tables, const StopLanes& lanes, StopStates& states, StopOutcome& outcome);

/// One epoch for the reduction: its lane of a StopLanes and the places of its parameters in the local system.
struct StopEpoch {
  const StopLanes* lanes = nullptr;
  std::size_t lane = 0;
  const std::uint8_t* local_beacon = nullptr;    ///< slots x 8: index among the beacons of the group
  const std::uint8_t* local_receiver = nullptr;  ///< slots x 8
  double x_m = 0.0, y_m = 0.0, heading_rad = 0.0, offset_m = 0.0;
};

/// Columns of the local system: four for each beacon, four for each receiver (x, y, z, delay each), the speed; padded to eights.
/// Derivatives are by metres and seconds and metres a second.
struct StopLayout {
  std::size_t beacons = 0, receivers = 0;
  [[nodiscard]] std::size_t speed() const { return 4 * (beacons + receivers); }
  [[nodiscard]] std::size_t stride() const { return (speed() + 1 + 7) / 8 * 8; }
};

/// Adds an epoch to the reduced system of its group but for what its state takes away: H (stride x stride, rows of upper right
/// parts from the diagonal's eight on) and the gradient (stride), which is complete. Of H the rows Y are left to be taken away
/// as Y'Y, some epochs together: `rows` gets three of them (four with a cycle offset), stride doubles each; returns how many.
int reduce_stop(const StopTables& tables, const StopEpoch& epoch, const StopLayout& layout, double unobserved, double* H,
                double* gradient, double* rows);

/// H -= Y'Y, the upper right part from the diagonal's eight on; Y has `count` rows of `stride` doubles.
void take_away(const double* Y, std::size_t count, std::size_t stride, double* H);

/// Name of the vector instructions in use, chosen when the program runs.
const char* stop_kernel_target();

}  // namespace octant::calib
