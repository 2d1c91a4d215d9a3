// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

// The layout and allocation of Eigen's types depend on compiler flags. With -mavx a pose is aligned to 32
// bytes instead of 16, and AddressSanitizer changes the allocation of matrices. A program built with other
// settings than the library would free memory that malloc never returned. Therefore the libraries fix the
// settings, and their CMake targets and pkg-config files pass them on. Each object file that includes this
// header references a symbol named after its own settings. A program with other settings does not link, and
// the message of the linker states the required flags.
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
