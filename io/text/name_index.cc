// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/text/name_index.h"

#include <algorithm>

namespace octant::io {

NameIndex::NameIndex(const std::vector<std::string_view>& names) {
  if (names.empty()) return;
  entries_.resize(std::bit_ceil(std::max<std::size_t>(16, 4 * names.size())));
  mask_ = entries_.size() - 1;
  for (std::size_t n = 0; n < names.size(); ++n) {
    if (find(names[n]) >= 0) continue;
    const Key key = key_of(names[n]);
    std::size_t i = slot_of(key, names[n].size());
    while (entries_[i].number >= 0) i = (i + 1) & mask_;
    entries_[i] = {key, names[n], static_cast<std::int32_t>(n)};
  }
}

}  // namespace octant::io
