// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/statements/statement_words.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "calib/problem/ranges.h"
#include "calib/problem/trilaterate.h"

namespace octant::calib {
namespace {

std::string point(const Eigen::Vector3d& p) {
  return fmt::format("({:.3f}, {:.3f}, {:.3f}) m", p.x(), p.y(), p.z());
}

class StatementWords {
 public:
  StatementWords(const StatedSite& stated, const Fit& fit) : stated_(stated), fit_(fit) {}

  [[nodiscard]] Contradiction contradiction(const Statement& s, double sigmas) const {
    const SharedState state = fit_.state();
    Contradiction c;
    switch (s.what) {
      case What::kControlPoint:
      case What::kPlace: describe_place(s, state, c); break;
      case What::kBeaconDelay:
        describe_delay(stated_.site().beacons[s.index].name, beacon_delay_prior(stated_.site(), s.index),
                       state.beacon_delay_s[s.index], c);
        break;
      case What::kReceiverDelay:
        describe_delay(receiver_name(s.index), timing_prior(), state.receiver_delay_s[s.index], c);
        break;
      case What::kSiteDelay: describe_delay("the site", timing_prior(), state.site_delay_s, c); break;
      case What::kNoDelays:
      case What::kOneDelay:
      case What::kDelays: describe_delays(state, c); break;
      case What::kHeldSpeed:
      case What::kSpeed: describe_speed(s, c); break;
      case What::kReceiver: describe_receiver(s, state, c); break;
      case What::kAttenuation: describe_attenuation(s, c); break;
      case What::kDistance: describe_distance(s, state, c); break;
      case What::kLabels:
        c = exchange_in_words(stated_.site().beacons[s.index], stated_.site().beacons[s.other]);
        break;
      case What::kHeights: c = heights_in_words(); break;
    }
    c.sigmas = sigmas;
    return c;
  }

  /// Joins the control points of a planar site if all are too high, or too low, by the same amount.
  void join_heights(const std::vector<Statement>& culprits, std::vector<Contradiction>& found) const {
    constexpr std::size_t kFewest = 3;
    constexpr double kAlike = 0.15, kDistances = 0.25;  ///< share of that height
    const Site& site = stated_.site();
    const auto points =
        std::ranges::count_if(site.beacons, [](const SiteBeacon& b) { return b.is_control_point(); });
    if (site.motion != Motion::kPlanar || culprits.size() < kFewest ||
        culprits.size() != static_cast<std::size_t>(points) ||
        std::ranges::any_of(culprits, [](const Statement& s) { return s.what != What::kControlPoint; }))
      return;
    const SharedState state = fit_.state();
    std::vector<Eigen::Vector3d> here, there;
    double higher_m = 0.0;
    std::string names;
    for (const Statement& s : culprits) {
      const SiteBeacon& b = site.beacons[s.index];
      here.push_back(*b.place_m());
      there.push_back(on_stated_side(here.back(), state.beacon_p_map_m[s.index]));
      higher_m += (there.back() - here.back()).z() / static_cast<double>(culprits.size());
      names += (names.empty() ? "" : ", ") + b.name;
    }
    for (std::size_t i = 0; i < here.size(); ++i) {
      const double off_m = (there[i] - here[i]).z() - higher_m,
                   distance_m = (there[i] - there[0]).head<2>().norm() - (here[i] - here[0]).head<2>().norm();
      if (std::abs(off_m) > kAlike * std::abs(higher_m) ||
          std::abs(distance_m) > kDistances * std::abs(higher_m))
        return;
    }
    Contradiction& c = found.front();
    c.subject = names;
    c.stated = "at their heights, held fixed";
    c.found = fmt::format("all {} {} than stated, as far from each other as stated",
                          length(std::abs(higher_m)), higher_m > 0 ? "higher" : "lower");
    c.remedy =
        "check from where heights count: z = 0 is the floor on which the vehicle stands, for beacons and for "
        "receivers";
    found.resize(1);
  }

 private:
  static std::string length(double m) {
    return std::abs(m) < 1.0 ? fmt::format("{:.1f} mm", 1e3 * m) : fmt::format("{:.3f} m", m);
  }
  static std::string time(double s) {
    return std::abs(s) < 1e-6 ? fmt::format("{:.2f} ns", 1e9 * s) : fmt::format("{:.1f} us", 1e6 * s);
  }
  [[nodiscard]] std::string receiver_name(std::size_t r) const {
    return receiver_path(r, names_of(stated_.site()));
  }

  [[nodiscard]] Eigen::Vector3d on_stated_side(const Eigen::Vector3d& stated, Eigen::Vector3d found) const {
    const Site& site = stated_.site();
    if (site.motion == Motion::kPlanar && !site.receivers.empty())
      found.z() = height_on_known_side_m(site.receivers, stated.z(), found.z());
    return found;
  }

  void describe_place(const Statement& s, const SharedState& state, Contradiction& c) const {
    const SiteBeacon& b = stated_.site().beacons[s.index];
    Eigen::Vector3d stated = state.beacon_p_map_m[s.index];  // coordinates without a stated value agree
    double sigma_m = 0.0;
    for (int i = 0; i < 3; ++i)
      if (const auto k = static_cast<std::size_t>(i); b.position_m[k] && b.sigma_m[k]) {
        stated[i] = *b.position_m[k];
        sigma_m = std::max(sigma_m, *b.sigma_m[k]);
      }
    const Eigen::Vector3d found = on_stated_side(stated, state.beacon_p_map_m[s.index]);
    const bool is_held = s.what == What::kControlPoint;
    c.kind = is_held ? ContradictionKind::kControlPoint : ContradictionKind::kBeacon;
    c.subject = b.name;
    c.stated = fmt::format("at {}, {}", point(stated), is_held ? "held fixed" : "sigma " + length(sigma_m));
    c.found = fmt::format("at {}, {} away", point(found), length((found - stated).norm()));
    c.remedy =
        fmt::format("survey {} {} again, check its label and its entry in the site file; or give it a {}",
                    is_held ? "control point" : "beacon", b.name,
                    is_held ? "sigma_m, so that the others determine its position" : "larger sigma_m");
  }

  [[nodiscard]] Prior timing_prior() const {
    return {stated_.site().timing.delay_s, stated_.site().timing.delay_sigma_s};
  }

  void describe_delay(const std::string& whose, const Prior& stated, double found_s, Contradiction& c) const {
    c.kind = ContradictionKind::kDelay;
    c.subject = whose;
    c.stated = fmt::format("{}, sigma {}", time(stated.value), time(stated.sigma));
    c.found = time(found_s);
    c.remedy = fmt::format(
        "check the electronics of {} and for obstacles in front of it, or state a larger delay_sigma_s "
        "(timing, or the beacon)",
        whose);
  }

  void describe_delays(const SharedState& state, Contradiction& c) const {
    // The full delay: the site, or all receivers alike, may have a part of it.
    const double held_s =
        state.site_delay_s + (state.receiver_delay_s.empty() ? 0.0 : state.receiver_delay_s.front());
    std::vector<std::pair<double, std::size_t>> delays;
    for (std::size_t b = 0; b < state.beacon_delay_s.size(); ++b)
      if (fit_.beacon_usable[b]) delays.emplace_back(held_s + state.beacon_delay_s[b], b);
    std::ranges::sort(delays);
    const Timing& timing = stated_.site().timing;
    const double stated_s = timing.delay_s, sigma_s = largest_delay_sigma_s(stated_.site());
    const bool each = timing.delay_per.beacon && sigma_s > 0,
               one = !each && timing.delay_per.site && sigma_s > 0;
    c.kind = ContradictionKind::kDelay;
    c.subject = "all beacons";
    const bool own = std::ranges::any_of(stated_.site().beacons,
                                         [](const SiteBeacon& b) { return b.delay_s.has_value(); });
    c.stated = each              ? fmt::format("delays of the beacons, sigma {}", time(sigma_s))
               : one             ? std::string("one delay for all (timing.delay_per: site)")
               : own             ? std::string("delays of the beacons, held fixed (delay_sigma_s: 0)")
               : stated_s == 0.0 ? std::string("no delay (timing.delay_per: none)")
                                 : "a delay of exactly " + time(stated_s);
    c.found = fmt::format("delays from {} to {}", time(delays.front().first), time(delays.back().first));
    c.remedy = "state the delay in the site file: timing.delay_per: beacon, with delay_s and delay_sigma_s";
    if (each)
      c.remedy = "state the delays as they are known: timing.delay_s, or a larger timing.delay_sigma_s";
    const auto lone = lone_delay(delays);
    if (!lone) return;
    c.subject = stated_.site().beacons[lone->second].name;
    c.found = fmt::format("a delay of {}, and about {} of all others", time(lone->first),
                          time(delays[delays.size() / 2].first));
    c.remedy = fmt::format("look at the settings and the electronics of {}; {}", c.subject, c.remedy);
  }

  /// The one delay that differs from all others, if there is one.
  /// @param delays  sorted, with their beacons
  static std::optional<std::pair<double, std::size_t>> lone_delay(
      const std::vector<std::pair<double, std::size_t>>& delays) {
    constexpr std::size_t kFewest = 4;
    constexpr double kPlainly = 5.0;  // times the range of the others
    if (delays.size() < kFewest) return {};
    const std::size_t last = delays.size() - 1;
    const double above = delays[last].first - delays[last - 1].first,
                 below = delays[1].first - delays[0].first;
    if (above > kPlainly * (delays[last - 1].first - delays[0].first)) return delays[last];
    if (below > kPlainly * (delays[last].first - delays[1].first)) return delays[0];
    return {};
  }

  void describe_speed(const Statement& s, Contradiction& c) const {
    const Medium& medium = stated_.site().medium;
    double offset = fit_.state().speed_offset(s.index), model = 0.0, degC = 0.0;
    std::size_t count = 0;
    for (const Trajectory& t : fit_.trajectories) {
      if (stated_.layout().speed.size() > 1 && t.run != s.index) continue;
      for (const ArrivalObservation& a : t.arrivals) {
        model += a.model_speed_mps;
        ++count;
        const MeasurementLog& run = stated_.problem().runs[t.run];
        degC += a.arrival < run.arrivals.size()
                    ? temperature_degC(run.arrivals[a.arrival], run, stated_.site())
                    : medium.temperature_degC;
      }
    }
    const double n = static_cast<double>(std::max<std::size_t>(count, 1));
    model /= n;
    degC /= n;
    const bool has_temperature = medium.model != MediumModel::kConstant;
    c.kind = ContradictionKind::kSpeed;
    c.subject = stated_.layout().speed.size() > 1 ? fmt::format("in run {}", s.index + 1) : "";
    const double sigma_mps = stated_.site().speed_sigma_mps;
    c.stated = fmt::format("{:.2f} m/s, {}", model,
                           sigma_mps > 0 ? fmt::format("sigma {:.2g} m/s", sigma_mps) : "held fixed") +
               (has_temperature ? fmt::format(", at {:.1f} degC", degC) : "");
    c.found = fmt::format("{:.2f} m/s", model + offset);
    c.remedy = "check medium.speed_mps, or state a larger medium.sigma_mps";
    if (!has_temperature) return;
    c.remedy =
        "check the thermometer: the temperature in the site file, in run.yaml and in the recording (degrees "
        "Celsius); or state a larger medium.sigma_mps";
    if (const auto would_be = temperature_at(medium, model + offset))
      c.found += fmt::format(", as at {:.1f} degC", *would_be);
    const double celsius = (degC - 32) / 1.8;
    if (celsius < -50 || celsius > 60) return;
    const double slack = 3 * std::max(stated_.site().speed_sigma_mps, 0.5);
    if (std::abs(speed_mps(medium, celsius) - model - offset) > slack) return;
    c.found += fmt::format(": the temperature is in degrees Fahrenheit ({:.1f} degF are {:.1f} degC)", degC,
                           celsius);
    c.remedy = "write the temperature in degrees Celsius: the thermometer's is in Fahrenheit";
  }

  void describe_receiver(const Statement& s, const SharedState& state, Contradiction& c) const {
    const SiteReceiver& r = stated_.site().receivers[s.index];
    c.kind = ContradictionKind::kReceiver;
    c.subject = receiver_name(s.index);
    c.stated =
        fmt::format("at {} on the vehicle, sigma {}", point(r.position_m), length(r.sigma_m.maxCoeff()));
    c.found = fmt::format("at {}, {} away", point(state.receiver_p_vehicle_m[s.index]),
                          length((state.receiver_p_vehicle_m[s.index] - r.position_m).norm()));
    c.remedy = fmt::format(
        "measure the position of receiver {} on the vehicle again and write it into the site file", r.name);
  }

  void describe_attenuation(const Statement& s, Contradiction& c) const {
    const ParameterId id = parameters::attenuation(s.index);
    const int column = fit_.layout.column_of(id);
    const Parameter& p = stated_.layout().parameter(stated_.layout().column_of(id));
    c.kind = ContradictionKind::kAttenuation;
    c.subject = parameter_name(p.id, names_of(stated_.site()));
    c.stated =
        fmt::format("{:.4g}, sigma {:.2g}", p.prior_mean * p.si_per_unit, p.prior_sigma * p.si_per_unit);
    c.found = fmt::format("{:.4g}", fit_.x[column] * p.si_per_unit);
    c.remedy = fmt::format("check {} in the site file, or state a larger sigma", c.subject);
  }

  void describe_distance(const Statement& s, const SharedState& state, Contradiction& c) const {
    const ControlDistance& d = stated_.site().distances[s.index];
    c.kind = ContradictionKind::kDistance;
    c.subject =
        stated_.site().beacons[d.from.index()].name + ", " + stated_.site().beacons[d.to.index()].name;
    c.stated = fmt::format("{:.4f} m, sigma {}", d.distance_m, length(d.sigma_m));
    c.found = fmt::format("{:.4f} m",
                          (state.beacon_p_map_m[d.from.index()] - state.beacon_p_map_m[d.to.index()]).norm());
    c.remedy =
        fmt::format("tape the distance from {} to {} again", stated_.site().beacons[d.from.index()].name,
                    stated_.site().beacons[d.to.index()].name);
  }

  const StatedSite& stated_;
  const Fit& fit_;
};

}  // namespace

Contradiction exchange_in_words(const SiteBeacon& a, const SiteBeacon& b) {
  const bool are_points = a.is_control_point() && b.is_control_point();
  return {ContradictionKind::kExchanged,
          a.name + ", " + b.name,
          fmt::format("at {} and {}", point(*a.place_m()), point(*b.place_m())),
          "at each other's places",
          0.0,
          fmt::format("exchange the positions of {} {} and {} in the site file, or their labels on the wall",
                      are_points ? "control points" : "beacons", a.name, b.name)};
}

Contradiction heights_in_words() {
  return {ContradictionKind::kExchanged,
          "of the site file",
          "in a frame with z up",
          "that heights count downwards: z of all beacons has the wrong sign",
          0.0,
          "write the heights of the beacons with z up: above the floor, or the surface of the water, is "
          "positive"};
}

std::vector<Contradiction> in_words(const StatedSite& stated, const Fit& fit,
                                    const std::vector<Statement>& culprits,
                                    const std::vector<double>& sigmas) {
  const StatementWords words(stated, fit);
  std::vector<Contradiction> found;
  for (std::size_t i = 0; i < culprits.size(); ++i)
    found.push_back(words.contradiction(culprits[i], sigmas[i]));
  words.join_heights(culprits, found);
  return found;
}

}  // namespace octant::calib
