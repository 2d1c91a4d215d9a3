// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/localizers/drive/start_window.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "models/localizers/start/stretch_states.h"
#include "models/physics/plane.h"
#include "models/support/scratch.h"
#include "models/trajectory/observed_range.h"
#include "models/trajectory/solve_states.h"

namespace octant {
namespace {

constexpr std::size_t kMaxNodes = 768, kMaxArrivals = 8192;
/// Additional uncertainty for a wrong speed, as a share of its prior sigma.
constexpr std::array kSpeedRooms = {1.0, 0.3, 0.1, 0.0};
constexpr int kStepsPerRoom = 4;
constexpr double kProfileSpan = 0.3;        ///< share of that uncertainty, to both sides
constexpr double kLeastProfileSpan = 2e-4;  ///< share of the speed
/// The robust solution marks no outliers, so its variance is inflated like that of the start's pose.
constexpr double kInflation = 4.0;

/// Sum of squared residuals at an offset of the speed, including its prior.
class MisfitBySpeed {
 public:
  MisfitBySpeed(Trajectory& t, const Segment& window, EpochFixModel& model, double sigma_mps,
                Scratch& scratch)
      : scratch_(scratch),
        t_(t),
        window_(window),
        model_(model),
        base_mps_(model.state.speed_offset_mps.front()),
        prior_(1.0 / square(sigma_mps)) {}
  double cost(double offset_mps) {
    const ScratchScope scope(scratch_);
    model_.state.speed_offset_mps.front() = base_mps_ + offset_mps;
    return solve_states(t_, window_, model_.state, {.late_scale = 2.5, .early_scale = 4.0}, 15).cost +
           0.5 * prior_ * square(offset_mps);
  }
  [[nodiscard]] double prior() const { return prior_; }

 private:
  Scratch& scratch_;
  Trajectory& t_;
  const Segment& window_;
  EpochFixModel& model_;
  double base_mps_, prior_;
};

}  // namespace

StartWindow::StartWindow(const StateSpace& vehicle) {
  static_cast<StateSpace&>(t_) = vehicle;
  t_.nodes.reserve(kMaxNodes + 1);
  t_.odometry.reserve(kMaxNodes);
  t_.arrivals.reserve(kMaxArrivals);
  t_.T_hear_send.reserve(kMaxArrivals);
  begin(0.0);
}

void StartWindow::begin(double time_s) {
  t_.nodes.assign(1, {.time_s = time_s, .T_map_vehicle = {}});
  t_.odometry.clear();
  t_.arrivals.clear();
  t_.T_hear_send.clear();
}

void StartWindow::step(const OdometryObservation& motion, double span_s) {
  if (t_.nodes.size() >= kMaxNodes) keep_recent_half();
  t_.odometry.push_back(motion);
  t_.odometry.back().node = last_node();
  t_.nodes.push_back({.time_s = t_.nodes.back().time_s + span_s, .T_map_vehicle = {}});
}

/// Late arrivals are inserted at the state of their time.
void StartWindow::add(const Trajectory& instant) {
  const double time_s = instant.nodes.front().time_s;
  std::size_t node = last_node();
  while (node > 0 && t_.nodes[node].time_s > time_s) --node;
  if (time_s < t_.nodes[node].time_s) return;
  double alpha = 0.0;
  if (node < last_node())
    alpha = (time_s - t_.nodes[node].time_s) / (t_.nodes[node + 1].time_s - t_.nodes[node].time_s);
  for (const ArrivalObservation& a : instant.arrivals) {
    if (t_.arrivals.size() == kMaxArrivals) return keep_recent_half();
    if (a.two_way && node < last_node()) continue;  // the return path is known for the newest node only
    const auto after = std::ranges::upper_bound(
        t_.arrivals, std::pair<std::size_t, double>(node, alpha), {},
        [](const ArrivalObservation& o) { return std::pair<std::size_t, double>(o.node, o.alpha); });
    ArrivalObservation& added = *t_.arrivals.insert(after, a);
    added.node = static_cast<std::uint32_t>(node);
    added.alpha = alpha;
    if (!a.two_way) continue;
    added.hear_send = static_cast<std::int32_t>(t_.T_hear_send.size());
    t_.T_hear_send.push_back(instant.T_hear_send[static_cast<std::size_t>(a.hear_send)]);
  }
}

void StartWindow::keep_recent_half() {
  const std::size_t drop = t_.nodes.size() / 2;
  const auto head = [](auto& list, auto until) { list.erase(list.begin(), until); };
  head(t_.nodes, t_.nodes.begin() + static_cast<std::ptrdiff_t>(drop));
  head(t_.odometry, t_.odometry.begin() + static_cast<std::ptrdiff_t>(drop));
  head(t_.arrivals, t_.arrivals.begin() +
                        static_cast<std::ptrdiff_t>(first_of_node(t_.arrivals, drop, 0, t_.arrivals.size())));
  const std::int32_t first =
      t_.arrivals.empty() || t_.arrivals.front().hear_send < 0 ? 0 : t_.arrivals.front().hear_send;
  if (!t_.T_hear_send.empty()) head(t_.T_hear_send, t_.T_hear_send.begin() + first);
  for (OdometryObservation& o : t_.odometry) o.node -= drop;
  for (ArrivalObservation& a : t_.arrivals) {
    a.node -= static_cast<std::uint32_t>(drop);
    if (a.two_way) a.hear_send -= first;
  }
}

bool StartWindow::hears(BeaconId beacon) const {
  return std::ranges::any_of(t_.arrivals, [beacon](const ArrivalObservation& a) {
    return a.beacon == beacon && a.rejection == Rejection::kUsed;
  });
}

std::size_t StartWindow::beacons() const {
  std::pmr::vector<BeaconId> ids(scratch());
  for (const ArrivalObservation& a : t_.arrivals)
    if (a.rejection == Rejection::kUsed && std::ranges::find(ids, a.beacon) == ids.end())
      ids.push_back(a.beacon);
  return ids.size();
}

Segment StartWindow::all() const {
  Segment all;
  all.last_node = t_.nodes.size();
  all.last_arrival = t_.arrivals.size();
  all.last_odometry = t_.odometry.size();
  return all;
}

double range_sigma_of_speed_m(const Trajectory& t, const Segment& window, const EpochFixModel& model,
                              double sigma_mps) {
  double range_m = 0.0;
  for (std::size_t i = window.first_arrival; i < window.last_arrival; ++i)
    range_m += observed_range_m(t, t.arrivals[i], model.state);
  const auto arrivals = static_cast<double>(window.last_arrival - window.first_arrival);
  return arrivals > 0 ? range_m / arrivals * sigma_mps / model.nominal_speed_mps : 0.0;
}

StartSpeed fit_start_speed(Trajectory& t, const Segment& window, EpochFixModel& model, double sigma_mps,
                           Scratch& scratch, std::optional<double> known_mps) {
  MisfitBySpeed profile(t, window, model, sigma_mps, scratch);
  const double range_m = range_sigma_of_speed_m(t, window, model, sigma_mps);
  double offset_mps = known_mps.value_or(0.0), information = profile.prior(), span_mps = 0.0;
  for (const double room : std::span(kSpeedRooms).subspan(known_mps ? 1 : 0)) {
    const WidenedArrivals widened(t, window, model, room * range_m);
    span_mps = std::max(kLeastProfileSpan * model.nominal_speed_mps, kProfileSpan * room * sigma_mps);
    for (int step = 0; step < kStepsPerRoom; ++step) {
      const double less = profile.cost(offset_mps - span_mps), more = profile.cost(offset_mps + span_mps),
                   here = profile.cost(offset_mps);
      information = std::max((more - 2.0 * here + less) / square(span_mps), profile.prior());
      const double by_mps = -(more - less) / (2.0 * span_mps) / information;
      if (!std::isfinite(by_mps)) break;
      offset_mps += std::clamp(by_mps, -3.0 * span_mps, 3.0 * span_mps);
      if (std::abs(by_mps) < 0.1 * span_mps) break;
    }
  }
  static_cast<void>(profile.cost(offset_mps - span_mps));
  const Pose less = t.nodes[window.last_node - 1].T_map_vehicle;
  static_cast<void>(profile.cost(offset_mps + span_mps));
  const Pose more = t.nodes[window.last_node - 1].T_map_vehicle;
  static_cast<void>(profile.cost(offset_mps));
  return {{offset_mps, std::min(kInflation / information, square(sigma_mps))},
          tangent_between(less, more, t.motion) / (2.0 * span_mps)};
}

}  // namespace octant
