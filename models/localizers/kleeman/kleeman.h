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

// L. Kleeman, "Ultrasonic autonomous robot localisation system". Where its parts are, in the paper's order:
//   kleeman_schedule.h    firing in turn, eq. 1
//   hyperbolic_fix.h      three beacons, eq. 2-4, and its error analysis (in least_squares/)
//   kleeman_sync.h        pulses to labelled arrivals
//   kleeman_validation.h  triangle inequality, eq. 5-6
//   kleeman_longsolve.h   the best triples of all beacons
//   kleeman_heading.h     orientation
// and here: the arrivals of one cycle through all of it. The speed of sound from their redundancy:
// models/localizers/speed/run_speed.h.

struct KleemanVehicle;  // kleeman_work.h
struct KleemanWork;

struct KleemanOptions {
  KleemanHeading heading = KleemanHeading::kInterpolation;
  double triangle_sigmas = 4.0;  ///< tolerance of eq. 5-6
  double gate_sigmas = 4.0;      ///< an arrival later than the first of its beacon by more is an echo
  int max_passes = 10;           ///< position and heading in turn, until neither moves
  LongsolveOptions longsolve{};
};

/// What a deployment lacks for Kleeman's method: planar motion, one-way ranging, 3 to 16 beacons of which
/// three are usable, a vehicle with a receiver.
[[nodiscard]] Result<void> kleeman_fits(const Deployment& deployment);

/// Kleeman's localizer: one fix an epoch, from arrivals whose clock may be off by any amount (a synchronised
/// clock is solved for all the same). Bearings are ignored.
///
/// An arrival belongs to a receiver beside the vehicle's centre, on a side that depends on the heading, which
/// depends on the position. So the first pass takes the first arrival of each beacon and the array for a
/// point, as published (a ring makes all distances shorter by the same); the next ones carry every arrival to
/// the centre with the position and heading of the pass before, average those of one beacon that agree, and
/// end when neither moves. Heights and elevations: hyperbolic_fix.h.
///
/// The covariance holds the arrivals' noise carried through the averaged triples and the heading, and of the
/// calibration the beacons' covariance (without correlations between them), the receivers' sigmas, delays,
/// and the speed. Keeps, vehicle by vehicle, where it was and the errors of the triples there, which decides
/// which triples are averaged.
class Kleeman : public Localizer {
 public:
  /// @throws std::invalid_argument if the deployment does not fit, see kleeman_fits()
  explicit Kleeman(const Deployment& deployment, const KleemanOptions& options = {});
  ~Kleeman() override;

  /// Forgets where the vehicles were.
  void reset() noexcept;

 private:
  /// The arrivals of one epoch of one vehicle. Those that longsolve outvotes are kOutvoted, late ones of a
  /// beacon whose other arrivals agree are kLate, agreeing beacons in none of the averaged triples are
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
