// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/steps/next_stops.h"

#include "survey/geometry/hearing.h"

namespace octant::app {

Result<KnownBefore> known_from(const calib::Calibration& c, int threads) {
  auto knowledge = calib::knowledge_of(c.problem, c.solution, threads);
  if (!knowledge) return fail(knowledge.error());
  KnownBefore before{std::move(*knowledge), calib::hearing_of(c.solution, c.problem.site), {}};
  for (const MeasurementLog& run : c.problem.runs)
    if (!run.poses.empty()) before.measured_poses = run.pose_accuracy;
  return before;
}

void restrict_by_scene(const SurveyInput& input, const survey::SurveyModel& model,
                       calib::HearingModel& hearing) {
  const NameTable names = input.names();
  std::vector<std::size_t> of_model(names.beacons.size(), model.beacons.size());
  for (std::size_t b = 0; b < names.beacons.size(); ++b)
    for (std::size_t m = 0; m < model.beacons.size(); ++m)
      if (model.beacons[m].name == names.beacons[b]) of_model[b] = m;
  const std::size_t first_receiver = input.vehicles()[model.vehicle].first_receiver;
  hearing.also = [&model, of_model, first_receiver](BeaconId beacon, ReceiverId receiver,
                                                    const Pose& T_map_vehicle) {
    const std::size_t m = of_model[beacon.index()];
    return m >= model.beacons.size() ||
           survey::hears(model, m, receiver.index() - first_receiver, T_map_vehicle);
  };
}

}  // namespace octant::app
