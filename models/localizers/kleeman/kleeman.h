// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "models/deployment.h"
#include "models/fix.h"
#include "models/localizers/common/localizer.h"
#include "models/localizers/kleeman/kleeman_heading.h"
#include "models/localizers/kleeman/kleeman_longsolve.h"
#include "models/run.h"
#include "models/support/result.h"

namespace octant {

// L. Kleeman, "Ultrasonic autonomous robot localisation system". Parts in the order of the paper:
//   kleeman_schedule.h    firing in turn, eq. 1
//   hyperbolic_fix.h      three beacons, eq. 2-4, and its error analysis (in least_squares/)
//   kleeman_sync.h        pulses to labelled arrivals
//   kleeman_validation.h  triangle inequality, eq. 5-6
//   kleeman_longsolve.h   the best triples of all beacons
//   kleeman_heading.h     orientation
// This file applies them to the arrivals of one cycle. The speed of sound from redundant arrivals is
// estimated in models/localizers/speed/run_speed.h.

struct KleemanVehicle;  // kleeman_work.h
struct KleemanWork;

struct KleemanOptions {
  KleemanHeading heading = KleemanHeading::kInterpolation;
  double triangle_sigmas = 4.0;  ///< tolerance of eq. 5-6
  double gate_sigmas = 4.0;      ///< an arrival that is later than the first of its beacon by more is an echo
  int max_passes = 10;           ///< alternating passes for position and heading, until neither changes
  LongsolveOptions longsolve{};
};

/// Checks the requirements of Kleeman's method: planar motion, one-way ranging, 3 to 16 beacons with at least
/// three usable ones, and a vehicle with a receiver.
[[nodiscard]] Result<void> kleeman_fits(const Deployment& deployment);

/// Kleeman's localizer: one fix for each epoch from arrivals with an unknown clock offset, which is estimated
/// even for a synchronised clock. Bearings are ignored.
///
/// Receivers are displaced from the vehicle's centre, in a direction that depends on the heading, which
/// depends on the position. The first pass therefore uses the first arrival of each beacon and treats the
/// array as a point, as published (a ring shortens all distances equally). Each further pass reduces every
/// arrival to the centre with the position and heading of the previous pass, averages the arrivals of a
/// beacon that agree, and ends when neither changes. Heights and elevations: hyperbolic_fix.h.
///
/// The covariance includes the noise of the arrivals, propagated through the averaged triples and the
/// heading. It also includes the calibration: covariances of the beacons (without correlations between
/// beacons), sigmas of the receivers, delays and the speed. For each vehicle the last position and the errors
/// of the triples there are kept; they determine which triples are averaged.
class Kleeman : public Localizer {
 public:
  /// @throws std::invalid_argument if the deployment is unsuitable, see kleeman_fits()
  explicit Kleeman(const Deployment& deployment, const KleemanOptions& options = {});
  ~Kleeman() override;

  /// Forgets the last positions of the vehicles.
  void reset() noexcept;

 private:
  /// Locates one vehicle from the arrivals of one epoch. Arrivals rejected by longsolve are kOutvoted, late
  /// ones of a beacon whose other arrivals agree kLate, and agreeing beacons outside the averaged triples
  /// kNotNeeded.
  void locate_known(const Observations& observations, Fix& fix) noexcept override;
  using Vehicle = KleemanVehicle;
  using Work = KleemanWork;

  [[nodiscard]] FixStatus place(std::span<const Arrival> arrivals) noexcept;
  void gather(std::span<const Arrival> arrivals) noexcept;
  [[nodiscard]] FixStatus solve_pass(bool first) noexcept;
  void subtract_walk(HeardDistance& heard, double distance_m, double log_directivity) const noexcept;
  void earliest() noexcept;
  void centre() noexcept;
  void keep_agreeing(std::size_t beacon) noexcept;
  void combine(std::size_t beacon) noexcept;
  void set_rough_aside() noexcept;
  [[nodiscard]] double calibration_variance_m2(std::size_t beacon) const noexcept;
  void find_heading(bool first) noexcept;
  void fill(std::span<const Arrival> arrivals, Fix& fix) const noexcept;
  void propagate(Fix& fix) const noexcept;

  Deployment deployment_;
  KleemanOptions options_;
  std::vector<Eigen::Vector3d> beacon_p_map_m_;
  std::vector<Vehicle> vehicles_;
  std::unique_ptr<Work> work_;
};

}  // namespace octant
