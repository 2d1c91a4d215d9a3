// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "models/run.h"
#include "models/site.h"

namespace octant::calib {

/// Size of the sample of a recording for a forecast.
struct SubsampleOptions {
  std::size_t instants = 300;   ///< epochs or distinct times, evenly spread
  std::size_t per_beacon = 40;  ///< number of arrivals kept for each beacon, if it has as many
  std::size_t per_pair =
      16;  ///< largest number of arrivals of one beacon at one receiver in an epoch or segment
  std::size_t drive_arrivals = 6000;  ///< approximate number of arrivals of all segments of a drive
  std::size_t fewest_stretches =
      SIZE_MAX;  ///< segments of a drive, if less than drive_stretches() determines
};

/// Segmentation of a drive: a segment is kept or omitted as a whole.
struct DriveStretches {
  double length_s = 3.0;    ///< long against the time over which odometry ties states together
  std::size_t fewest = 30;  ///< smallest number of kept segments
};
/// Number of segments with about SubsampleOptions::drive_arrivals arrivals.
/// @param arrivals, stretches  numbers of arrivals and segments of the run
[[nodiscard]] std::size_t stretches_kept(const Site& site, const SubsampleOptions& options,
                                         std::size_t arrivals, std::size_t stretches);
/// Time from the request of a two-way range to its reply; 0 for one way.
[[nodiscard]] double asked_before_s(const Site& site, const Arrival& arrival);
/// Segmentation for a site. In space the pose of a segment follows from its own shape among roughly known
/// beacons, and from the beacons that it receives if several poses are equally likely (rough_path.h).
/// Odometry over a long gap determines neither, so segments are long and few.
[[nodiscard]] DriveStretches drive_stretches(const Site& site);

/// A smaller recording with the same information: evenly spaced epochs (or segments of a drive, with their
/// odometry row by row and summed odometry between them), and further ones for beacons with too few arrivals.
/// Measured poses stay with the arrivals. A small recording is returned unchanged.
[[nodiscard]] MeasurementLog subsample(const MeasurementLog& run, const Site& site,
                                       const SubsampleOptions& options = {});

/// Odometry of all vehicles, by time: the rows within the spans, and the gaps between them summed to longer
/// steps, some tens at most for each gap.
/// @param spans  begin and end, ascending
[[nodiscard]] std::vector<OdometryStep> subsampled_odometry(
    const std::vector<OdometryStep>& odometry, const std::vector<std::pair<double, double>>& spans);

/// Measured poses within such spans, and the next ones on either side.
[[nodiscard]] std::vector<TimedPose> poses_near(const std::vector<TimedPose>& poses,
                                                const std::vector<std::pair<double, double>>& spans);

/// Choice of groups (epochs, moments, segments) by subsample(), as numbers in the order of time. First evenly
/// spaced ones:
[[nodiscard]] std::vector<bool> evenly_chosen(std::size_t groups, std::size_t budget);
/// then further ones for each beacon that the chosen ones receive too rarely, again evenly.
struct GroupsHearing {
  std::vector<std::size_t> kept;               ///< arrivals of each beacon in the chosen groups
  std::vector<std::vector<std::size_t>> more;  ///< omitted groups with arrivals of each beacon, ascending
  /// Calls visit(beacon) for each arrival of a group of `more`.
  std::function<void(std::size_t group, const std::function<void(std::size_t beacon)>& visit)> for_each_heard;
};
void choose_more(GroupsHearing& hearing, std::size_t per_beacon, std::vector<bool>& chosen);

/// Makes both choices. @param for_each_heard  calls visit(beacon) for each observation of a group
[[nodiscard]] std::vector<bool> chosen_groups(std::size_t groups, std::size_t beacons, std::size_t budget,
                                              std::size_t per_beacon,
                                              decltype(GroupsHearing::for_each_heard) for_each_heard);

/// Sorts by time, and within equal times by the rows of the file.
void sort_by_time(std::vector<Arrival>& arrivals);

/// At most the given number of arrivals of each beacon at one receiver, evenly spaced: their indices,
/// ascending.
[[nodiscard]] std::vector<std::size_t> some_of_pairs(const std::vector<const Arrival*>& arrivals,
                                                     std::size_t per_pair);

/// A run without the lists that are long (arrivals, bearings, odometry, poses, truth, scans).
[[nodiscard]] MeasurementLog without_lists(const MeasurementLog& run);

}  // namespace octant::calib
