// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: SHA-256 of a text that comes in pieces.

#include <memory>
#include <string>
#include <string_view>

struct evp_md_ctx_st;

namespace octant::io {

class Sha256 {
 public:
  Sha256();
  void add(std::string_view bytes);
  /// Lower-case hexadecimal digest of all pieces; to be called once, at the end.
  [[nodiscard]] std::string hex();

 private:
  std::unique_ptr<evp_md_ctx_st, void (*)(evp_md_ctx_st*)> context_;
};

}  // namespace octant::io
