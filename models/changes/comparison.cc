// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/changes/comparison.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "models/changes/change_sigmas.h"
#include "models/changes/chi_square.h"
#include "models/support/utc_time.h"

namespace octant {
namespace {

constexpr double kUnobservablePerMetre = 1e-3;

double sigma_along(const Eigen::Vector3d& v, const Eigen::Matrix3d& C) {
  const double length = v.norm();
  return length > 0 ? std::sqrt(std::max(0.0, v.dot(C * v))) / length
                    : std::sqrt(std::max(0.0, C.trace() / 3));
}

Change change_of(const TestedChange& tested, const ChangeHypothesis& hypothesis, const Deployment& d) {
  Change c;
  c.kind = hypothesis.kind;
  c.p = tested.p;
  const bool datum = hypothesis.kind == ChangeKind::kDatum;
  if (datum || hypothesis.kind == ChangeKind::kBeaconMoved || hypothesis.kind == ChangeKind::kReceiver) {
    const Eigen::Index axes = datum ? first_turn(d.motion) : 3;
    c.shift_m.head(axes) = tested.estimate.head(axes);
    c.shift_covariance_m2.topLeftCorner(axes, axes) = tested.covariance.topLeftCorner(axes, axes);
    c.size = c.shift_m.norm();
    c.sigma = sigma_along(c.shift_m, c.shift_covariance_m2);
  } else {
    c.size = tested.estimate[0];
    c.sigma = std::sqrt(std::max(0.0, tested.covariance(0, 0)));
  }
  if (hypothesis.kind == ChangeKind::kAmplitude) {
    c.size = std::exp(c.size);
    c.sigma *= c.size;
  }
  if (hypothesis.kind == ChangeKind::kDelay && hypothesis.owner == kAllBeacons) {
    c.subject = kAllBeaconsSubject;
  } else if (hypothesis.kind == ChangeKind::kReceiver) {
    c.subject = d.vehicles[d.receivers[hypothesis.owner].vehicle.index()].name + "/" +
                d.receivers[hypothesis.owner].name;
  } else {
    c.subject = datum                                   ? "datum"
                : hypothesis.kind == ChangeKind::kSpeed ? "speed"
                                                        : d.beacons[hypothesis.owner].name;
  }
  return c;
}

const DeploymentBeacon& beacon_named(const Deployment& d, const std::string& name) {
  return *std::ranges::find(d.beacons, name, &DeploymentBeacon::name);
}

/// Returns true if a change of delay is explained by a beacon that got the name of another one.
bool is_delay_of(const Change& c, const DeploymentBeacon& named, const DeploymentBeacon& device) {
  constexpr double kSigmas = 4.0;
  return c.kind == ChangeKind::kDelay && c.subject == named.name &&
         std::abs(c.size - (device.delay_s - named.delay_s)) <=
             kSigmas * std::hypot(c.sigma, named.delay_sigma_s, device.delay_sigma_s);
}

/// Combines two beacons that moved to each other's positions, to within a quarter of their distance, into one
/// change. Their delays moved with them.
void name_exchanges(const Deployment& d, std::vector<Change>& changes) {
  constexpr double kNear = 0.25;
  std::vector<std::pair<const DeploymentBeacon*, const DeploymentBeacon*>> exchanged;
  for (std::size_t i = 0; i < changes.size(); ++i)
    for (std::size_t j = i + 1; j < changes.size(); ++j) {
      Change &a = changes[i], &b = changes[j];
      if (a.kind != ChangeKind::kBeaconMoved || b.kind != ChangeKind::kBeaconMoved) continue;
      const DeploymentBeacon &one = beacon_named(d, a.subject), &other = beacon_named(d, b.subject);
      const Eigen::Vector3d way = other.position_m - one.position_m;
      if (std::max((a.shift_m - way).norm(), (b.shift_m + way).norm()) > kNear * way.norm()) continue;
      a.kind = ChangeKind::kExchanged;
      a.subject += ", " + b.subject;
      a.size = way.norm();
      a.sigma = std::max(a.sigma, b.sigma);
      a.p = std::max(a.p, b.p);
      changes.erase(changes.begin() + static_cast<std::ptrdiff_t>(j));
      exchanged.emplace_back(&one, &other);
      break;
    }
  for (const auto& [one, other] : exchanged)
    std::erase_if(changes, [&one = *one, &other = *other](const Change& c) {
      return is_delay_of(c, one, other) || is_delay_of(c, other, one);
    });
}

/// Returns true if the map is constrained. In a free network the covariance contains no information about its
/// position.
bool frame_is_held(const Deployment& d) {
  const auto is_free = [](const std::string& by) {
    return by.find("inner constraints") != std::string::npos;
  };
  return !is_free(d.datum.position) && !is_free(d.datum.orientation);
}

/// Appends directions in the parameters, such as motions of the map, as columns.
Innovation with_directions(const Innovation& innovation, const Eigen::MatrixXd& T) {
  Innovation out{Eigen::MatrixXd(innovation.B.rows(), innovation.B.cols() + T.cols()), innovation.y,
                 innovation.degrees_of_freedom};
  Eigen::MatrixXd moved = innovation.B.leftCols(T.rows()) * T;
  // Directions whose effect at 1 km is below rounding error are unobservable.
  for (Eigen::Index k = 0; k < T.cols(); ++k)
    if (moved.col(k).norm() < kUnobservablePerMetre) moved.col(k).setZero();
  out.B << innovation.B, moved;
  return out;
}

/// Common change of all delays: other electronics, or another synchronisation of the vehicle.
Eigen::VectorXd common_delay(const KnownParameters& known) {
  constexpr std::size_t kFewest = 3;  // two changes are reported as two beacons
  Eigen::VectorXd direction = Eigen::VectorXd::Zero(known.size());
  std::size_t count = 0;
  for (Eigen::Index i = 0; i < known.size(); ++i)
    if (known.parameters[static_cast<std::size_t>(i)].kind == ParameterKind::kBeaconDelay) {
      direction[i] = 1.0;
      ++count;
    }
  return count >= kFewest ? direction : Eigen::VectorXd();
}

/// Positions of beacons that are not control points; the search also starts with all of them moved.
std::vector<std::size_t> moves_of_free_beacons(const Deployment& d,
                                               const std::vector<ChangeHypothesis>& hypotheses) {
  std::vector<std::size_t> moves;
  for (std::size_t k = 0; k < hypotheses.size(); ++k)
    if (hypotheses[k].kind == ChangeKind::kBeaconMoved &&
        d.beacons[hypotheses[k].owner].status != BeaconStatus::kControlPoint)
      moves.push_back(k);
  return moves;
}

/// Parameters that both deployments have, in the order of the first.
struct CommonParameters {
  KnownParameters before, now;
};

KnownParameters part_of_known(const KnownParameters& known, const std::vector<int>& which) {
  KnownParameters part;
  part.speed_mps = known.speed_mps;
  for (const int i : which) part.parameters.push_back(known.parameters[static_cast<std::size_t>(i)]);
  part.value = known.value(which);
  part.covariance = known.covariance(which, which);
  return part;
}

CommonParameters common_parameters(const Deployment& before, const Deployment& now) {
  const KnownParameters a = known_parameters(before);
  KnownParameters b = known_parameters(now);
  const NameTable names = names_of(before), present = names_of(now);
  const ParameterLookup lookup(present);
  const ParameterIndex column(b.parameters);
  // Speed offsets are comparable only for the same model and temperature.
  if (const int speed = column[parameters::speed()]; speed >= 0)
    b.value[speed] =
        now.speed_mps(now.medium.temperature_degC) - speed_mps(before.medium, now.medium.temperature_degC);
  std::vector<int> of_a, of_b;
  for (std::size_t i = 0; i < a.parameters.size(); ++i)
    if (const auto same = lookup.find(parameter_name(a.parameters[i], names)))
      if (const int at = column[*same]; at >= 0) {
        of_a.push_back(static_cast<int>(i));
        of_b.push_back(at);
      }
  return {part_of_known(a, of_a), part_of_known(b, of_b)};
}

/// Converts released parameters to the indices of another deployment.
Released by_indices_of(const Deployment& d, const Released& released, const Deployment& of) {
  const NameTable names = names_of(d), other = names_of(of);
  const ParameterLookup lookup(names);
  Released same{{}, released.datum};
  for (const ParameterId& id : released.parameters)
    if (const auto found = lookup.find(parameter_name(id, other))) same.parameters.push_back(*found);
  return same;
}

/// Information of the second visit alone. Parameters that are fixed in the second deployment count as
/// unchanged.
Innovation second_visit(const CommonParameters& common, const Deployment& before, const Deployment& now) {
  std::vector<int> free;
  for (Eigen::Index i = 0; i < common.now.size(); ++i)
    if (common.now.covariance(i, i) > 0) free.push_back(static_cast<int>(i));
  const KnownParameters a = part_of_known(common.before, free), b = part_of_known(common.now, free);
  Eigen::MatrixXd P = a.covariance;
  P.diagonal() += drift_variances(a, now.previous->drift);
  const Eigen::MatrixXd released =
      P + released_covariance(a, by_indices_of(before, now.previous->released, now), before.motion);
  const Innovation prior = innovation_of_difference(Eigen::VectorXd::Zero(a.size()), released);
  const Innovation posterior = innovation_of_difference(b.value - a.value, b.covariance);
  const Eigen::MatrixXd N = posterior.B.transpose() * posterior.B - prior.B.transpose() * prior.B;
  const Innovation innovation_seen =
      innovation_of_information(P, 0.5 * (N + N.transpose()), posterior.B.transpose() * posterior.y);
  Innovation all{Eigen::MatrixXd::Zero(innovation_seen.B.rows(), common.before.size()), innovation_seen.y,
                 innovation_seen.degrees_of_freedom};
  all.B(Eigen::all, free) = innovation_seen.B;
  return all;
}

}  // namespace

Comparison compare(const Deployment& before, const KnownParameters& known, const Innovation& innovation,
                   const std::function<bool(const ChangeHypothesis&)>& is_possible) {
  Comparison out;
  out.hypotheses = change_hypotheses(known);
  if (is_possible) std::erase_if(out.hypotheses, [&](const ChangeHypothesis& h) { return !is_possible(h); });
  const Eigen::MatrixXd T = map_motions(known, before.motion);
  Innovation innovation_seen = innovation;
  if (frame_is_held(before)) {
    ChangeHypothesis datum{ChangeKind::kDatum, 0, {}, {}};
    for (Eigen::Index k = 0; k < T.cols(); ++k) {
      datum.columns.push_back(static_cast<int>(known.size() + k));
      datum.sigma.push_back(released_sigmas(known.speed_mps).beacon_m);
    }
    out.hypotheses.push_back(std::move(datum));
    innovation_seen = with_directions(innovation, T);
  } else {
    innovation_seen = free_of(innovation, T);
  }
  if (const Eigen::VectorXd delay = common_delay(known); delay.size() > 0) {
    out.hypotheses.push_back({ChangeKind::kDelay,
                              kAllBeacons,
                              {static_cast<int>(innovation_seen.B.cols())},
                              {released_sigmas(known.speed_mps).delay_s}});
    innovation_seen = with_directions(innovation_seen, delay);
  }
  out.search = search_changes(innovation_seen, out.hypotheses, moves_of_free_beacons(before, out.hypotheses));
  for (const TestedChange& t : out.search.tested)
    if (t.held) out.changes.push_back(change_of(t, out.hypotheses[t.hypothesis], before));
  name_exchanges(before, out.changes);
  std::ranges::stable_sort(out.changes, {}, &Change::p);
  int freedoms = innovation_seen.degrees_of_freedom;
  if (freedoms > 0) out.p = chi_square_tail(out.search.chi2, freedoms);
  for (const TestedChange& t : out.search.tested) freedoms -= t.held ? t.degrees_of_freedom : 0;
  if (freedoms > 0) out.p_left = chi_square_tail(out.search.chi2_left, freedoms);
  return out;
}

Comparison compare(const Deployment& before, const Deployment& now, const Drift& drift) {
  const CommonParameters common = common_parameters(before, now);
  if (common.before.size() == 0) return {};
  if (is_derived(now, before)) return compare(before, common.before, second_visit(common, before, now));
  Eigen::MatrixXd C = common.before.covariance + common.now.covariance;
  C.diagonal() += drift_variances(common.before, drift);
  return compare(before, common.before, innovation_of_difference(common.now.value - common.before.value, C));
}

bool is_derived(const Deployment& now, const Deployment& before) {
  return now.previous && !before.digest.empty() && now.previous->sha256 == before.digest;
}

Released changed_parameters(const Comparison& comparison, const KnownParameters& known) {
  Released released;
  for (const std::size_t k : comparison.search.held()) {
    const ChangeHypothesis& hypothesis = comparison.hypotheses[k];
    if (hypothesis.kind == ChangeKind::kDatum) {
      released.datum = true;
      continue;
    }
    if (hypothesis.owner == kAllBeacons) {
      for (const ParameterId& id : known.parameters)
        if (id.kind == ParameterKind::kBeaconDelay) released.parameters.push_back(id);
      continue;
    }
    for (const int i : hypothesis.columns)
      released.parameters.push_back(known.parameters[static_cast<std::size_t>(i)]);
  }
  return released;
}

Eigen::MatrixXd released_covariance(const KnownParameters& known, const Released& released, Motion motion) {
  const ChangeSigmas sigmas = released_sigmas(known.speed_mps);
  Eigen::MatrixXd W = Eigen::MatrixXd::Zero(known.size(), known.size());
  for (const ParameterId& id : released.parameters)
    if (const int i = known.index_of(id); i >= 0) W(i, i) = std::pow(sigmas.of(id), 2);
  if (released.datum) {
    const Eigen::MatrixXd T = map_motions(known, motion);
    W += std::pow(sigmas.beacon_m, 2) * T * T.transpose();
  }
  return W;
}

Drift drift_between(const Deployment& before, const std::string& now) {
  return drift_after(months_between(before.created, now), before.drift,
                     before.speed_mps(before.medium.temperature_degC));
}

double months_between(const std::string& before, const std::string& now) {
  const auto a = utc_seconds(before), b = utc_seconds(now);
  return a && b ? std::max(0.0, static_cast<double>(*b - *a) / kSecondsAMonth) : 0.0;
}

}  // namespace octant
