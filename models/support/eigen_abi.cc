// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "models/support/eigen_abi.h"

namespace octant::abi {

template <int max_align_bytes, int max_static_align_bytes, bool malloc_already_aligned, int index_bytes,
          bool row_major>
const char CompileWith_EIGEN_MAX_ALIGN_BYTES_16_and_EIGEN_MALLOC_ALREADY_ALIGNED_1<
    max_align_bytes, max_static_align_bytes, malloc_already_aligned, index_bytes,
    row_major>::as_octants_libraries = 0;

// Only the settings of the libraries are defined here and can be linked. Instantiated, not specialised,
// because the header uses it before.
template struct CompileWith_EIGEN_MAX_ALIGN_BYTES_16_and_EIGEN_MALLOC_ALREADY_ALIGNED_1<
    EIGEN_MAX_ALIGN_BYTES, EIGEN_MAX_STATIC_ALIGN_BYTES, EIGEN_MALLOC_ALREADY_ALIGNED != 0,
    static_cast<int>(sizeof(EIGEN_DEFAULT_DENSE_INDEX_TYPE)),
    static_cast<int>(EIGEN_DEFAULT_MATRIX_STORAGE_ORDER_OPTION) == static_cast<int>(Eigen::RowMajor)>;

}  // namespace octant::abi
