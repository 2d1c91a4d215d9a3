// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/small_world.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "io/run/run_folder.h"
#include "io/site/site_yaml.h"
#include "models/simulator/synthetic.h"
#include "models/simulator/synthetic_truth.h"
#include "tests/fuzz/bytes.h"
#include "tests/fuzz/must.h"

namespace octant::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::array<double, 3>, 8> kPlaces_m = {
    {{0, 0, 2.5}, {8, 0, 2.3}, {8, 6, 2.6}, {0, 6, 2.4}, {4, 0, 2.5}, {4, 6, 2.2}, {0, 3, 2.5}, {8, 3, 2.4}}};

void choose_medium(Bytes& in, Site& site) {
  static const std::array<Medium, 6> kMedia = {
      {{.model = MediumModel::kCramer1993},
       {.model = MediumModel::kConstant, .speed_mps = 343.0},
       {.model = MediumModel::kConstant, .speed_mps = 1500.0},
       {.model = MediumModel::kConstant, .speed_mps = 299792458.0},
       {.model = MediumModel::kLinearTemperature},
       {.model = MediumModel::kCramer1993, .temperature_degC = -19.0, .pressure_pa = 80000.0}}};
  site.medium = in.one_of(kMedia);
  site.speed_sigma_mps = in.one_of(std::array{2.0, 0.0, 0.1, 50.0, 1e6, 1e-9});
  site.speed_offset_per_run = in.sometimes();
}

void choose_timing(Bytes& in, Site& site) {
  Timing& t = site.timing;
  t.clock = in.sometimes() ? Clock::kCycleOffset : Clock::kSynchronised;
  t.ranging = in.sometimes() ? Ranging::kTwoWay : Ranging::kOneWay;
  if (t.ranging == Ranging::kTwoWay) t.turnaround_s = in.one_of(std::array{0.0, 1e-3, 0.5});
  const unsigned per = in.byte();
  t.delay_per = {.beacon = per % 2 == 1, .receiver = per % 8 > 5, .site = per % 16 > 11};
  t.delay_s = in.one_of(std::array{0.0, 1e-4, -1e-3, 0.1});
  t.delay_sigma_s = in.one_of(std::array{5e-5, 0.0, 1e-2, 1e-12, 1.0});
  if (t.clock == Clock::kCycleOffset) t.drift_sigma = in.one_of(std::array{0.0, 1e-5, 1e-3});
  site.noise.tof_sigma_s = in.one_of(std::array{1e-5, 1e-6, 1e-9, 1e-3, 1e-12, 0.1});
  if (in.sometimes()) site.noise.pair_sigma_s = in.one_of(std::array{3e-5, 1e-9, 1e-2});
}

void choose_beacons(Bytes& in, double metres, Site& site) {
  const std::size_t count = in.one_of(std::array<std::size_t, 8>{6, 5, 4, 3, 2, 1, 7, 8});
  for (std::size_t b = 0; b < count; ++b) {
    SiteBeacon beacon;
    beacon.name = "B" + std::to_string(b);
    static constexpr std::array<double, 8> kSigmas = {-1, 0.0, 0.3, 1e-4, 10.0, 1e3, 1e-9, -2};
    const double chosen = in.one_of(kSigmas);  // -1: as usual, -2: nobody knows
    const double sigma = chosen == -1 ? (b % 3 == 0 ? 0.0 : 0.3) : chosen;
    for (std::size_t i = 0; i < 3; ++i) {
      beacon.position_m[i] = metres * (kPlaces_m[b][i] + 4 * in.part());
      if (sigma >= 0) beacon.sigma_m[i] = sigma;
    }
    if (in.sometimes()) beacon.sigma_m[2] = in.one_of(std::array{0.0, 0.01});
    if (in.sometimes() && site.timing.delay_per.beacon) beacon.delay_sigma_s = 1e-6;
    site.beacons.push_back(std::move(beacon));
  }
  if (count > 1 && in.sometimes())
    site.distances.push_back({BeaconId(std::size_t{0}), BeaconId(1 + in.below(count - 1)), metres,
                              in.one_of(std::array{0.01, 1e-6, 1.0})});
}

void choose_vehicle(Bytes& in, Site& site) {
  const std::size_t count = in.one_of(std::array<std::size_t, 4>{2, 1, 3, 2});
  SiteVehicle vehicle{.first_receiver = 0, .receiver_count = count};
  for (std::size_t r = 0; r < count; ++r) {
    SiteReceiver receiver;
    receiver.name = "r" + std::to_string(r);
    receiver.vehicle = VehicleId(std::size_t{0});
    receiver.position_m = {0.15 * (r == 0 ? 1.0 : -1.0) + in.part(), 0.1 * in.part(), 0.3};
    receiver.sigma_m.setConstant(in.one_of(std::array{0.0, 0.001, 0.1, 10.0}));
    if (in.sometimes()) receiver.axis = Eigen::Vector3d(r == 0 ? 1.0 : -1.0, 0.0, 0.0);
    site.receivers.push_back(std::move(receiver));
  }
  if (in.sometimes()) vehicle.motion = MotionPrior{};
  if (in.sometimes()) vehicle.rail = Rail{.from_m = {0.0, 1.0}, .to_m = {7.0, 1.0 + in.part()}};
  site.vehicles.push_back(vehicle);
}

void choose_attenuation(Bytes& in, Scenario& s) {
  if (!in.sometimes()) return;
  s.site.attenuation = AttenuationPrior{.amplitude_1m_v = {12.5, in.one_of(std::array{1.25, 0.0, 100.0})},
                                        .absorption_np_per_m = {0.12, in.one_of(std::array{0.02, 0.0, 3.0})},
                                        .rise_time_s = {4.5e-4, in.one_of(std::array{1e-4, 0.0, 1.0})},
                                        .threshold_v = in.one_of(std::array{0.05, 0.4})};
  s.log_amplitude = in.below(2) == 0;
}

void choose_path(Bytes& in, double metres, Scenario& s) {
  Scenario::Path& path = s.path;
  path.epochs = 6 + static_cast<int>(in.below(7));
  switch (in.below(4)) {
    case 0:
    case 1: path.kind = PathKind::kStops; break;
    case 2:  // some of the same place, and not many
      path.kind = PathKind::kStations;
      for (std::size_t i = 1 + in.below(4); i > 0; --i)
        path.stations.emplace_back(metres * (4 + 3 * in.part()), metres * (3 + 2 * in.part()), 3 * in.part());
      break;
    default:
      path.kind = PathKind::kDrive;
      path.duration_s = 3 + 2 * in.part();
      path.odometry_period_s = 0.1;
      path.slot_s = 0.1;
  }
  s.heldout_path.epochs = 1;
  s.hall_m = {8 * metres, 6 * metres};
  s.range_m = 60 * metres;
  s.log_poses = in.sometimes();
  if (s.log_poses)
    s.pose_accuracy = {.position_sigma_m = in.one_of(std::array{0.01, 1e-6, 10.0}),
                       .heading_known = in.below(2) == 0};
  if (in.sometimes()) s.echo_fraction = 0.5 * std::abs(in.part());
  s.unknown_beacons = in.sometimes();
  if (in.sometimes()) s.bearings = Scenario::Bearings{.unlabelled_fraction = std::abs(in.part()) * 0.9};
}

/// Recording after the distortions.
void distort(Bytes& in, MeasurementLog& run) {
  while (!in.empty() && !run.arrivals.empty()) {
    const std::size_t what = in.below(10), at = in.below(256) % run.arrivals.size(), other = in.byte();
    Arrival& a = run.arrivals[at];
    switch (what) {
      case 0: run.arrivals.erase(run.arrivals.begin() + static_cast<std::ptrdiff_t>(at)); break;
      case 1: run.arrivals.resize(std::max<std::size_t>(1, run.arrivals.size() * (other + 1) / 256)); break;
      case 2: a.tof_s *= 1 + static_cast<double>(other) / 64; break;
      case 3: a.tof_s += 1e-4 * static_cast<double>(other); break;
      case 4: a.beacon = run.arrivals[other % run.arrivals.size()].beacon; break;
      case 5: a.receiver = run.arrivals[other % run.arrivals.size()].receiver; break;
      case 6: a.epoch = run.arrivals[other % run.arrivals.size()].epoch; break;
      case 7: a.tof_s = std::pow(10.0, static_cast<double>(other) / 8 - 16); break;
      case 8:  // one beacon or all as another's time
        for (Arrival& b : run.arrivals)
          if (b.beacon == a.beacon) b.tof_s *= 1 + static_cast<double>(other) / 1024;
        break;
      default: a.amplitude_v = std::pow(10.0, static_cast<double>(other) / 16 - 8);
    }
  }
}

}  // namespace

std::optional<SmallWorld> small_world(std::string_view input) {
  Bytes in(input);
  Scenario scenario;
  scenario.site.name = "fuzzed";
  scenario.site.motion = in.sometimes() ? Motion::kSpatial : Motion::kPlanar;
  const double metres = in.one_of(std::array{1.0, 1.0, 0.01, 100.0, 1e4});
  choose_medium(in, scenario.site);
  choose_timing(in, scenario.site);
  choose_vehicle(in, scenario.site);
  choose_path(in, metres, scenario);
  choose_attenuation(in, scenario);
  if (in.sometimes()) scenario.site.tolerance = {.beacon_m = 0.03, .fix_m = 0.05};
  choose_beacons(in, metres, scenario.site);
  const std::size_t seed = in.byte();
  scenario.path.epoch_period_s = dwell_s(scenario, scenario.path) + 1;
  scenario.heldout_path = scenario.path;
  auto world = simulate(scenario, seed);
  if (!world) return std::nullopt;
  distort(in, world->run);

  const auto site = io::read_site(written("world/site.yaml", io::site_to_yaml(world->site)));
  must_explain(site);
  if (!site) return std::nullopt;
  const std::string folder = scratch("world/run");
  fs::remove_all(folder);
  must(io::write_run(folder, world->run, names_of(*site)).has_value(), "a recording is written");
  auto run = io::read_run(folder, names_of(*site), site->timing);
  must_explain(run);
  if (!run) return std::nullopt;
  return SmallWorld{*site, std::move(*run)};
}

}  // namespace octant::fuzz
