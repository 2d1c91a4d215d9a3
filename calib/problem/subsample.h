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

/// How much of a recording a forecast looks at.
struct SubsampleOptions {
  std::size_t instants = 300;         ///< epochs or distinct times, evenly spread
  std::size_t per_beacon = 40;        ///< arrivals that each beacon keeps, if it has as many
  std::size_t per_pair = 16;          ///< arrivals of one beacon at one receiver within one epoch or stretch
  std::size_t drive_arrivals = 6000;  ///< of all stretches of a drive together, about
  std::size_t fewest_stretches = SIZE_MAX;  ///< of a drive, if that is less than drive_stretches() has it
};

/// How a drive is cut: a stretch is kept or left as a whole.
struct DriveStretches {
  double length_s = 3.0;    ///< long against the time over which odometry ties states together
  std::size_t fewest = 30;  ///< that are kept
};
/// Number of stretches that hold about SubsampleOptions::drive_arrivals arrivals together. @param arrivals,
/// stretches  of the run
[[nodiscard]] std::size_t stretches_kept(const Site& site, const SubsampleOptions& options,
                                         std::size_t arrivals, std::size_t stretches);
/// Time from the request of a two-way range to its reply; 0 for one way.
[[nodiscard]] double asked_before_s(const Site& site, const Arrival& arrival);
/// In space a stretch is placed by its own shape among beacons that are known roughly, and of poses that are
/// as likely by what is heard around it (rough_path.h): what is kept has to be as long as that takes, as
/// odometry over a long gap tells neither. So there are few of them.
[[nodiscard]] DriveStretches drive_stretches(const Site& site);

/// A smaller recording that tells the same: evenly spread epochs (or stretches of a drive, with their
/// odometry row for row and the odometry between them summed up), and more of them where a beacon would have
/// too little. Measured poses stay where arrivals do. A recording that is small already comes back as it is.
[[nodiscard]] MeasurementLog subsample(const MeasurementLog& run, const Site& site,
                                       const SubsampleOptions& options = {});

/// Odometry of all vehicles, by time: rows of the spans of time as they are, what lies between summed up to
/// longer steps, of which a gap has some tens at most, however long it is.
/// @param spans  begin and end, ascending
[[nodiscard]] std::vector<OdometryStep> subsampled_odometry(
    const std::vector<OdometryStep>& odometry, const std::vector<std::pair<double, double>>& spans);

/// Measured poses within such spans, and the next ones on either side.
[[nodiscard]] std::vector<TimedPose> poses_near(const std::vector<TimedPose>& poses,
                                                const std::vector<std::pair<double, double>>& spans);

/// The choice of groups (epochs, instants, stretches) that subsample() makes, by their numbers in the order
/// of time. Evenly spread ones first:
[[nodiscard]] std::vector<bool> evenly_chosen(std::size_t groups, std::size_t budget);
/// and then more for each beacon that the chosen ones hear too seldom, evenly again.
struct GroupsHearing {
  std::vector<std::size_t> kept;  ///< of each beacon, its arrivals in the groups chosen
  std::vector<std::vector<std::size_t>>
      more;  ///< of each beacon, the groups left out that hear it, ascending
  /// Calls visit(beacon) for each arrival of a group of `more`.
  std::function<void(std::size_t group, const std::function<void(std::size_t beacon)>& visit)> for_each_heard;
};
void choose_more(GroupsHearing& hearing, std::size_t per_beacon, std::vector<bool>& chosen);

/// Makes both choices. @param for_each_heard  calls visit(beacon) for each observation of a group
[[nodiscard]] std::vector<bool> chosen_groups(std::size_t groups, std::size_t beacons, std::size_t budget,
                                              std::size_t per_beacon,
                                              decltype(GroupsHearing::for_each_heard) for_each_heard);

/// In the order of time, and of the rows of a file within an instant.
void sort_by_time(std::vector<Arrival>& arrivals);

/// At most so many arrivals of each beacon at one receiver, evenly: their places in the list, ascending.
[[nodiscard]] std::vector<std::size_t> some_of_pairs(const std::vector<const Arrival*>& arrivals,
                                                     std::size_t per_pair);

/// A run without the lists that are long (arrivals, bearings, odometry, poses, truth, scans).
[[nodiscard]] MeasurementLog without_lists(const MeasurementLog& run);

}  // namespace octant::calib
