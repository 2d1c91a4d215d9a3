// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// One reader under libFuzzer: OCTANT_FUZZ_TARGET names it.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const octant::fuzz::Target* const target = [] {
    for (const auto& t : octant::fuzz::targets())
      if (t.name == OCTANT_FUZZ_TARGET) return &t;
    __builtin_trap();
  }();
  target->take({reinterpret_cast<const char*>(data), size});
  return 0;
}
