// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

// How Eigen's types are laid out and allocated depends on compiler flags: with -mavx a pose is aligned to 32
// bytes instead of 16, under AddressSanitizer matrices are allocated otherwise. A program that was built with
// other settings than the library would free what malloc never gave. So the libraries fix the settings, their
// CMake targets and pkg-config files pass them on, and every object file that includes this header asks the
// linker for a symbol that names its own: a program that goes another way does not link, and the linker's
// message says what to compile with.
namespace octant::abi {

template <int max_align_bytes, int max_static_align_bytes, bool malloc_already_aligned, int index_bytes,
          bool row_major>
// NOLINTNEXTLINE(readability-identifier-naming): what the linker says to whoever has other settings
struct CompileWith_EIGEN_MAX_ALIGN_BYTES_16_and_EIGEN_MALLOC_ALREADY_ALIGNED_1 {
  static const char as_octants_libraries;
};

using EigenSettings = CompileWith_EIGEN_MAX_ALIGN_BYTES_16_and_EIGEN_MALLOC_ALREADY_ALIGNED_1<
    EIGEN_MAX_ALIGN_BYTES, EIGEN_MAX_STATIC_ALIGN_BYTES, EIGEN_MALLOC_ALREADY_ALIGNED != 0,
    static_cast<int>(sizeof(EIGEN_DEFAULT_DENSE_INDEX_TYPE)),
    static_cast<int>(EIGEN_DEFAULT_MATRIX_STORAGE_ORDER_OPTION) == static_cast<int>(Eigen::RowMajor)>;

namespace {
[[gnu::used]] const char* const eigen_settings = &EigenSettings::as_octants_libraries;
}  // namespace

}  // namespace octant::abi
