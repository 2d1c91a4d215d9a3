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
/// Step 7: 180 degrees minus that angle, [0, 2 pi). It is the angle from +y to the vector from tail to head,
/// counter-clockwise: the vehicle's heading minus 90 degrees.
[[nodiscard]] double tail_orientation_from_y_rad(double head_orientation_rad);

struct HeadTailOptions {
  /// Side of the base line for a vehicle that receives only two stations, or stations in one line. Further
  /// stations would determine the side.
  BaseLineSide side = BaseLineSide::kAny;
  PairRangesOptions ranges{};
  double min_sine = 0.05;  ///< smallest sine of the angle at the vertex: at 0.05 a vertex is twenty times as
                           ///< uncertain as a range
  double gate_sigmas = 4.0;  ///< for stations among each other, and for the distance between head and tail
  double ambiguity_margin = 9.0;  ///< in squared sigmas: a second pose within this margin is as good
  double max_sigma_m = 1.0;       ///< position sigmas above this are poor geometry
  double max_heading_sigma_rad = 0.5;
};

/// Position and heading of a vehicle with one receiver at its head and one at its tail, from ranges to base
/// stations at known positions (R. Thamma, "Estimating Position and Orientation of an Unmanned Guided Vehicle
/// with Ultrasound and Radio Frequency Sensing"). Each receiver uses the stations that it receives, the
/// nearest ones first, so stations may work at different frequencies.
///
/// For each end: means of the repeated times (eq. 1, 2); distances (eq. 3 to 5), reduced to the receivers'
/// plane; one triangle for each pair of stations (ten steps), combined by weight. Then the pose: orientation
/// from head and tail (seven steps), position as the weighted mean of both. Two stations leave two mirrored
/// positions. The distance between head and tail excludes mixed pairs, HeadTailOptions::side the mirror
/// image; otherwise the fix is kAmbiguous.
///
/// Fix: kTooFewArrivals (an end receives fewer than two stations), kPoorGeometry (flat triangles, ends that
/// coincide), kNoConsensus (sides that form no triangle, stations that disagree, wrong distance between the
/// ends), kAmbiguous.
class HeadTail : public Localizer {
 public:
  explicit HeadTail(const Deployment& deployment, HeadTailOptions options = {});
  /// More stations would cost time (the square of their number) and hardly add accuracy.
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
    std::vector<PairRange> pairs;  ///< index of each station's range
    std::vector<double> by_slant;  ///< ratio of horizontal to slant distance
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
  std::vector<Ends> ends_;  ///< ends of each vehicle; not valid if it has none
  PairRanges ranges_;
  RangePropagation propagation_;
  std::array<End, 2> end_;
};

/// Checks that a deployment suits HeadTail: planar motion, synchronised clock, two usable base stations, and
/// a vehicle with two separate receivers (the first is the head, unless they are named head and tail).
[[nodiscard]] Result<void> head_tail_fits(const Deployment& deployment);

}  // namespace octant
