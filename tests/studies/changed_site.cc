// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "tests/studies/changed_site.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "models/simulator/random.h"
#include "tests/support/worlds.h"

namespace octant::study {
namespace {

constexpr double kControlPoints = 4, kApproximate_m = 0.2, kWarmerBy_degC = 8.0, kLaterBy_s = 40e-6;

std::size_t below(Random& draws, std::size_t count) {
  return std::min(count - 1, static_cast<std::size_t>(draws.uniform() * static_cast<double>(count)));
}

Eigen::Vector3d step(Random& draws, double shortest_m, double longest_m) {
  const double size_m = draws.log_uniform(shortest_m, longest_m);
  return size_m * draws.normal3().normalized();
}

/// Round the walls, at heights that differ by up to a metre.
void hang_beacons(Scenario& s, Random& draws) {
  const std::size_t count = 8 + below(draws, 5), first = below(draws, count);
  const auto [lx, ly] = s.hall_m;
  const double height_m = draws.uniform(2.5, 3.5);
  for (std::size_t b = 0; b < count; ++b) {
    const double along_m =
        2 * (lx + ly) * (static_cast<double>(b) + draws.uniform(-0.3, 0.3)) / static_cast<double>(count);
    const double at_m = std::fmod(along_m + 2 * (lx + ly), 2 * (lx + ly));
    const Eigen::Vector2d p = at_m < lx            ? Eigen::Vector2d(at_m, 0.05)
                              : at_m < lx + ly     ? Eigen::Vector2d(lx - 0.05, at_m - lx)
                              : at_m < 2 * lx + ly ? Eigen::Vector2d(2 * lx + ly - at_m, ly - 0.05)
                                                   : Eigen::Vector2d(0.05, 2 * (lx + ly) - at_m);
    std::string name = "B";
    name += std::to_string(b + 1);
    const auto control = [&](double k) {
      return (static_cast<std::size_t>(k * static_cast<double>(count) / kControlPoints) + first) % count == b;
    };
    const bool held = control(0) || control(1) || control(2) || control(3);
    s.site.beacons.push_back(
        test::beacon(name, {p.x(), p.y(), height_m + draws.uniform(-0.5, 0.5)}, held ? 0.0 : kApproximate_m));
  }
}

void add_cart(Scenario& s, Random& draws) {
  const std::size_t count = 4 + below(draws, 5);
  const double height_m = draws.uniform(0.2, 0.6);
  std::vector<Eigen::Vector3d> places;
  for (std::size_t r = 0; r < count; ++r) {
    const double angle = 2 * std::numbers::pi * (static_cast<double>(r) + draws.uniform(-0.25, 0.25)) /
                         static_cast<double>(count),
                 radius_m = draws.uniform(0.25, 0.45);
    places.emplace_back(radius_m * std::cos(angle), radius_m * std::sin(angle),
                        height_m + 0.15 * static_cast<double>(r % 2));
  }
  test::add_receivers(s.site, places, 0.001);
}

Scenario first_visit(Random& draws) {
  Scenario s;
  s.hall_m = {draws.uniform(16, 24), draws.uniform(10, 15)};
  s.site.name = "hall";
  s.site.medium = {.model = MediumModel::kCramer1993, .temperature_degC = std::round(draws.uniform(14, 27))};
  s.site.speed_sigma_mps = 1.5;
  s.site.timing.delay_per.beacon = true;
  s.site.timing.delay_s = 1e-4;
  s.site.timing.delay_sigma_s = 5e-5;
  s.site.noise.tof_sigma_s = 1e-5;
  hang_beacons(s, draws);
  add_cart(s, draws);
  if (draws.uniform() < 0.25) {
    s.site.attenuation = AttenuationPrior{.amplitude_1m_v = {12.5, 1.25},
                                          .absorption_np_per_m = {0.12, 0.02},
                                          .rise_time_s = {4.5e-4, 1e-4},
                                          .threshold_v = 0.05};
    s.log_amplitude = true;
  }
  s.range_m = 14.0;
  s.echo_fraction = draws.uniform() < 0.5 ? 0.0 : 0.03;
  s.warming_degC = draws.uniform() < 0.5 ? 0.5 : 3.0;
  s.path.epochs = 60 + static_cast<int>(below(draws, 21));
  s.heldout_path.epochs = 1;
  return s;
}

/// All values of the first visit's truth, without any random part.
void hold_truth(Scenario& s, const Deployment& truth) {
  for (std::size_t b = 0; b < truth.beacons.size(); ++b) {
    s.site.beacons[b].delay_s = truth.beacons[b].delay_s;
    s.site.beacons[b].delay_sigma_s = 0.0;
  }
  for (std::size_t r = 0; r < truth.receivers.size(); ++r) {
    s.site.receivers[r].position_m = truth.receivers[r].position_m;
    s.site.receivers[r].sigma_m.setZero();
  }
  s.true_speed_offset_mps = truth.speed_offset_mps;
  if (!s.site.attenuation) return;
  s.site.attenuation->amplitude_1m_v = {truth.attenuation->amplitude_1m_v, 0.0};
  s.site.attenuation->absorption_np_per_m = {truth.attenuation->absorption_np_per_m, 0.0};
  s.site.attenuation->rise_time_s = {truth.attenuation->rise_time_s, 0.0};
}

void move_beacon(Scenario& s, std::size_t b, const Eigen::Vector3d& by_m) {
  for (std::size_t i = 0; i < 3; ++i) *s.site.beacons[b].position_m[i] += by_m[static_cast<Eigen::Index>(i)];
}

void wander(Scenario& s, const Drift& drift, Random& draws) {
  for (std::size_t b = 0; b < s.site.beacons.size(); ++b) {
    const Eigen::Vector3d by_m = drift.beacon_m * draws.normal3();
    move_beacon(s, b, by_m);
    *s.site.beacons[b].delay_s += drift.delay_s * draws.normal();
  }
  for (SiteReceiver& r : s.site.receivers) r.position_m += drift.receiver_m * draws.normal3();
  *s.true_speed_offset_mps += drift.speed_mps * draws.normal();
  s.site.medium.temperature_degC += std::round(draws.uniform(-3, 3));
}

/// Selects this number of different beacons, with or without control points.
std::vector<std::size_t> some_beacons(const Scenario& s, std::size_t count, bool control, Random& draws) {
  std::vector<std::size_t> all, chosen;
  for (std::size_t b = 0; b < s.site.beacons.size(); ++b)
    if (s.site.beacons[b].is_control_point() == control) all.push_back(b);
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t at = below(draws, all.size());
    chosen.push_back(all[at]);
    all.erase(all.begin() + static_cast<std::ptrdiff_t>(at));
  }
  return chosen;
}

TrueChange moved(Scenario& s, std::size_t b, const Eigen::Vector3d& by_m, ChangeKind kind) {
  move_beacon(s, b, by_m);
  return {kind, b, s.site.beacons[b].name, by_m, 0.0};
}

std::vector<TrueChange> happen(Event event, Scenario& s, Random& draws) {
  std::vector<TrueChange> out;
  const auto move_some = [&](std::size_t count, bool control, double shortest_m, double longest_m) {
    for (const std::size_t b : some_beacons(s, count, control, draws))
      out.push_back(moved(s, b, step(draws, shortest_m, longest_m), ChangeKind::kBeaconMoved));
  };
  switch (event) {
    case Event::kNothing: break;
    case Event::kOneMoved: move_some(1, false, 0.01, 0.1); break;
    case Event::kTwoMoved: move_some(2, false, 0.01, 0.1); break;
    case Event::kThreeMoved: move_some(3, false, 0.01, 0.1); break;
    case Event::kControlPoint: move_some(1, true, 0.02, 0.2); break;
    case Event::kWarmer: s.site.medium.temperature_degC += kWarmerBy_degC; break;
    case Event::kDelay: {
      const std::size_t b = below(draws, s.site.beacons.size());
      *s.site.beacons[b].delay_s += kLaterBy_s;
      out.push_back({ChangeKind::kDelay, b, s.site.beacons[b].name, Eigen::Vector3d::Zero(), kLaterBy_s});
      break;
    }
    case Event::kReceiver: {
      const std::size_t r = below(draws, s.site.receivers.size());
      const Eigen::Vector3d by_m = step(draws, 0.02, 0.05);
      s.site.receivers[r].position_m += by_m;
      out.push_back({ChangeKind::kReceiver, r, "robot/" + s.site.receivers[r].name, by_m, 0.0});
      break;
    }
    case Event::kExchanged: {
      const auto pair = some_beacons(s, 2, false, draws);
      Eigen::Vector3d way;
      for (std::size_t i = 0; i < 3; ++i)
        way[static_cast<Eigen::Index>(i)] =
            *s.site.beacons[pair[1]].position_m[i] - *s.site.beacons[pair[0]].position_m[i];
      out.push_back(moved(s, pair[0], way, ChangeKind::kExchanged));
      out.push_back(moved(s, pair[1], -way, ChangeKind::kExchanged));
      break;
    }
  }
  return out;
}

void drive_for(Scenario::Path& path, Random& draws) {
  path.kind = PathKind::kDrive;
  path.duration_s = draws.uniform(180, 300);
  path.slot_s = 0.1;
}

}  // namespace

const char* to_string(Event event) {
  switch (event) {
    case Event::kNothing: return "nothing";
    case Event::kOneMoved: return "1 beacon moved";
    case Event::kTwoMoved: return "2 beacons moved";
    case Event::kThreeMoved: return "3 beacons moved";
    case Event::kControlPoint: return "control point";
    case Event::kWarmer: return "8 degC warmer";
    case Event::kDelay: return "delay +40 us";
    case Event::kReceiver: return "receiver bent";
    case Event::kExchanged: return "exchanged";
  }
  return "";
}

ChangedSite changed_site(Event event, std::uint64_t seed, const Drift& drift) {
  Random draws(seed, 1);
  ChangedSite out;
  Scenario s = first_visit(draws);
  out.first = test::must(simulate(s, 2 * seed));
  hold_truth(s, out.first.truth);
  wander(s, drift, draws);
  out.changes = happen(event, s, draws);
  out.drives = draws.uniform() < 0.4;
  s.path.epochs = 15 + static_cast<int>(below(draws, 11));
  if (out.drives) drive_for(s.path, draws);
  drive_for(s.heldout_path, draws);
  out.second = test::must(simulate(s, 2 * seed + 1));
  return out;
}

BothVisits both_visits(const ChangedSite& changed) {
  BothVisits out{changed.first.site, changed.second.run, {}};
  std::vector<std::size_t> receiver;
  for (std::size_t b = 0; b < out.site.beacons.size(); ++b) out.beacon.push_back(b);
  for (std::size_t r = 0; r < out.site.receivers.size(); ++r) receiver.push_back(r);
  for (const TrueChange& c : changed.changes) {
    if (c.kind == ChangeKind::kReceiver) {
      receiver[c.owner] = out.site.receivers.size();
      SiteReceiver anew = out.site.receivers[c.owner];
      anew.name += "new";
      anew.sigma_m.setConstant(0.1);
      out.site.receivers.push_back(anew);
      ++out.site.vehicles[0].receiver_count;
    } else {
      out.beacon[c.owner] = out.site.beacons.size();
      SiteBeacon anew;
      anew.name = out.site.beacons[c.owner].name + "new";
      out.site.beacons.push_back(anew);
    }
  }
  for (Arrival& a : out.second.arrivals) {
    a.beacon = BeaconId(out.beacon[a.beacon.index()]);
    a.receiver = ReceiverId(receiver[a.receiver.index()]);
  }
  return out;
}

}  // namespace octant::study
