// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "models/parameter.h"

namespace octant {

/// The one switch over the kinds of parameters for whoever holds them (a state, a site, a deployment): calls
/// the visitor's function of that name. A visitor that lacks one does not compile, so that a new kind is
/// thought of wherever parameters are held.
template <class Visitor>
auto visit_parameter(const ParameterId& id, Visitor&& holder) {
  const std::size_t owner = id.owner, component = id.component;
  switch (id.kind) {
    case ParameterKind::kBeaconPosition: return holder.beacon_position(owner, component);
    case ParameterKind::kBeaconDelay: return holder.beacon_delay(owner);
    case ParameterKind::kBeaconGain: return holder.beacon_gain(owner);
    case ParameterKind::kReceiverPosition: return holder.receiver_position(owner, component);
    case ParameterKind::kReceiverDelay: return holder.receiver_delay(owner);
    case ParameterKind::kArray: return holder.array(owner, component);
    case ParameterKind::kSiteDelay: return holder.site_delay();
    case ParameterKind::kSpeed: return holder.speed(owner);
    case ParameterKind::kAttenuation: return holder.attenuation(component);
    case ParameterKind::kClockDrift: return holder.clock_drift(owner);
    case ParameterKind::kPairBias: break;
  }
  return holder.pair_bias(owner, component);
}

}  // namespace octant
