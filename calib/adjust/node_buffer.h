// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/sums/log_buffer.h"
#include "models/trajectory/trajectory.h"

namespace octant::calib {

template <class Buffer>
void exchange(Buffer& buffer, BufferRecord<Pose> auto&& T) {
  buffer.exchange(T.translation_m, T.rotation.coeffs());
}

template <class Buffer>
void exchange(Buffer& buffer, BufferRecord<Node> auto&& node) {
  buffer.exchange(node.T_map_vehicle, node.cycle_offset_s, node.velocity, node.placed, node.time_s,
                  node.epoch);
}

}  // namespace octant::calib
