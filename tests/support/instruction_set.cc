// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// OCTANT_SIMD=AVX2 octant_calib_test: the tests as a machine runs them whose best vector instructions are
// those. Names are Highway's: EMU128 (the baseline), SSE4, AVX2, AVX3 (AVX-512). Exit code 77 where this
// machine does not have them.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include <gtest/gtest.h>
#include <hwy/targets.h>

namespace {

class InstructionSet : public testing::Environment {
 public:
  void SetUp() override {
    const char* name = std::getenv("OCTANT_SIMD");
    if (name == nullptr) return;
    for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1) {
      const std::int64_t target = left & -left;
      if (std::string_view(name) != hwy::TargetName(target)) continue;
      hwy::DisableTargets(~target);
      return;
    }
    std::printf("this machine has no %s: skipped\n", name);
    std::fflush(stdout);
    std::_Exit(77);
  }
};

[[maybe_unused]] const testing::Environment* const instruction_set =
    testing::AddGlobalTestEnvironment(new InstructionSet);

}  // namespace
