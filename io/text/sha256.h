// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once
// Private to io/: SHA-256 of a text that comes in pieces.

#include <memory>
#include <string>
#include <string_view>

struct SHA256state_st;

namespace octant::io {

/// Uses OpenSSL's SHA256_* functions rather than EVP_*: linked statically into liboctant they are 40 KB, EVP
/// with its providers 4 MB.
class Sha256 {
 public:
  Sha256();
  void add(std::string_view bytes);
  /// Lower-case hexadecimal digest of all pieces; to be called once, at the end.
  [[nodiscard]] std::string hex();

 private:
  std::unique_ptr<SHA256state_st, void (*)(SHA256state_st*)> context_;
};

}  // namespace octant::io
