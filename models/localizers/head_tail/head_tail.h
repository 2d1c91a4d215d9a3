// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "models/localizers/common/localizer.h"
#include "models/localizers/common/pair_ranges.h"
#include "models/localizers/common/range_propagation.h"
#include "models/localizers/head_tail/triangles.h"

namespace octant {

/// Thamma, section VI, steps 1 to 6: angle from the +y axis to the vector from head to tail, clockwise, [0, 2
/// pi).
[[nodiscard]] double head_orientation_from_y_rad(const Eigen::Vector2d& head_m,
                                                 const Eigen::Vector2d& tail_m);
/// Step 7: 180 degrees less that, [0, 2 pi). It is the angle from +y to the vector from tail to head,
/// counter-clockwise: the vehicle's heading less 90 degrees.
[[nodiscard]] double tail_orientation_from_y_rad(double head_orientation_rad);

struct HeadTailOptions {
  /// Side of the base line for a vehicle that hears two stations only, or stations in one line: what the
  /// others would tell.
  BaseLineSide side = BaseLineSide::kAny;
  PairRangesOptions ranges{};
  double min_sine =
      0.05;  ///< of the angle at the vertex: 0.05 makes a vertex twenty times as uncertain as a range
  double gate_sigmas = 4.0;  ///< of stations against each other, and of the distance between head and tail
  double ambiguity_margin = 9.0;  ///< of squared sigmas: a second pose closer than this is as good
  double max_sigma_m = 1.0;       ///< a larger position sigma is poor geometry
  double max_heading_sigma_rad = 0.5;
};

/// Position and heading of a vehicle with a receiver at its head and one at its tail, from ranges to base
/// stations at known places (R. Thamma, "Estimating Position and Orientation of an Unmanned Guided Vehicle
/// with Ultrasound and Radio Frequency Sensing"). A receiver uses the stations it hears, the nearest of them,
/// so stations may work at different frequencies.
///
/// For each end: means of the repeated times (eq. 1, 2), distances (eq. 3 to 5), reduced to the receivers'
/// plane; a triangle with each pair of stations (ten steps), combined by weight. Then the pose: orientation
/// from head and tail (seven steps), position from both by weight. Two stations leave two mirrored places:
/// the distance between head and tail rejects mixed pairs, HeadTailOptions::side the mirror image; otherwise
/// kAmbiguous.
///
/// Fix: kTooFewArrivals (an end hears fewer than two stations), kPoorGeometry (flat triangles, ends that
/// coincide), kNoConsensus (sides that make no triangle, stations that disagree, wrong distance between the
/// ends), kAmbiguous.
class HeadTail : public Localizer {
 public:
  explicit HeadTail(const Deployment& deployment, HeadTailOptions options = {});
  /// Pairs of more stations would add time (their number squared), and hardly accuracy.
  static constexpr std::size_t kMaxStations = 12;

 private:
  void locate_known(const Observations& observations, Fix& fix) noexcept override;
  using Ends = std::array<ReceiverId, 2>;  ///< head, tail
  struct Choice {
    const TrianglePoint* head = nullptr;
    const TrianglePoint* tail = nullptr;
    double cost = 0.0;
  };
  struct End {
    ReceiverId receiver;
    std::vector<StationRange> stations;
    std::vector<PairRange> pairs;  ///< behind the stations
    std::vector<double> by_slant;  ///< horizontal by slant distance
    TriangleSolver solver;
  };
  [[nodiscard]] FixStatus fix_pose(std::span<const Arrival> arrivals, Fix& fix);
  void gather(std::size_t end, std::span<const Arrival> arrivals, std::span<const PairRange> pairs, Fix& fix);
  [[nodiscard]] bool make_room(End& end, double horizontal_m, std::span<const Arrival> arrivals,
                               Fix& fix) const;
  [[nodiscard]] Choice rate(const TrianglePoint& head, const TrianglePoint& tail) const;
  [[nodiscard]] bool on_side(const Choice& choice) const;
  [[nodiscard]] FixStatus choose(Choice& choice) const;
  [[nodiscard]] FixStatus set_pose(const Choice& choice, Fix& fix);

  Deployment deployment_;
  HeadTailOptions options_;
  std::vector<Ends> ends_;  ///< of each vehicle; not valid: it has none
  PairRanges ranges_;
  RangePropagation propagation_;
  std::array<End, 2> end_;
};

/// Whether a deployment suits HeadTail: planar, synchronised clock, two usable base stations, a vehicle with
/// two receivers apart (the first is the head, or they are named head and tail).
[[nodiscard]] Result<void> head_tail_fits(const Deployment& deployment);

}  // namespace octant
