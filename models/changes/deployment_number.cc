// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/changes/deployment_number.h"

#include <cmath>
#include <cstddef>

#include "models/parameter.h"
#include "models/physics/attenuation.h"

namespace octant {
namespace {

/// Address of a value in a deployment; null if it is not stored.
struct NumberPlace {
  double* value = nullptr;
  double* sigma = nullptr;
  bool is_logarithm = false;  ///< true if the deployment stores the exponential
};

/// Visitor for visit_parameter. An array acts through its receivers and a common delay through the beacons;
/// localizers do not use biases of pairs.
struct InDeployment : HasNothing<NumberPlace> {
  Deployment& d;
  explicit InDeployment(Deployment& of) : d(of) {}
  [[nodiscard]] NumberPlace beacon_position(std::size_t b, std::size_t axis) const {
    return {&d.beacons[b].position_m[static_cast<Eigen::Index>(axis)], nullptr};
  }
  [[nodiscard]] NumberPlace beacon_delay(std::size_t b) const {
    return {&d.beacons[b].delay_s, &d.beacons[b].delay_sigma_s};
  }
  [[nodiscard]] NumberPlace beacon_gain(std::size_t b) const { return {&d.beacons[b].gain, nullptr, true}; }
  [[nodiscard]] NumberPlace receiver_position(std::size_t r, std::size_t axis) const {
    const auto i = static_cast<Eigen::Index>(axis);
    return {&d.receivers[r].position_m[i], &d.receivers[r].sigma_m[i]};
  }
  [[nodiscard]] NumberPlace receiver_delay(std::size_t r) const {
    return {&d.receivers[r].delay_s, &d.receivers[r].delay_sigma_s};
  }
  [[nodiscard]] NumberPlace speed(std::size_t) const { return {&d.speed_offset_mps, &d.speed_sigma_mps}; }
  [[nodiscard]] NumberPlace attenuation(std::size_t unknown) const {
    return {&attenuation_unknown(*d.attenuation, unknown), nullptr};
  }
  [[nodiscard]] NumberPlace clock_drift(std::size_t v) const {
    return {&d.vehicles[v].clock_drift, &d.vehicles[v].clock_drift_sigma};
  }
};

}  // namespace

DeploymentNumber number_in(const Deployment& deployment, const ParameterId& id) {
  // The addresses are only read.
  const NumberPlace place = visit_parameter(id, InDeployment(const_cast<Deployment&>(deployment)));
  if (place.value == nullptr) return {};
  return {place.is_logarithm ? std::log(*place.value) : *place.value,
          place.sigma != nullptr ? *place.sigma : 0.0};
}

void set_number(const ParameterId& id, const DeploymentNumber& number, Deployment& deployment) {
  const NumberPlace place = visit_parameter(id, InDeployment(deployment));
  if (place.value != nullptr) *place.value = place.is_logarithm ? std::exp(number.value) : number.value;
  if (place.sigma != nullptr) *place.sigma = number.sigma;
}

}  // namespace octant
