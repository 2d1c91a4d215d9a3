// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/text/sha256.h"

#include <array>

#include <fmt/format.h>
#include <openssl/sha.h>

// OpenSSL 3 marks SHA256_* as deprecated in favour of EVP_*; sha256.h says why they are used.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wdeprecated-declarations"

namespace octant::io {

Sha256::Sha256() : context_(new SHA256_CTX, [](SHA256_CTX* context) { delete context; }) {
  SHA256_Init(context_.get());
}

void Sha256::add(std::string_view bytes) { SHA256_Update(context_.get(), bytes.data(), bytes.size()); }

std::string Sha256::hex() {
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest{};
  SHA256_Final(digest.data(), context_.get());
  std::string hex;
  for (const unsigned char byte : digest) hex += fmt::format("{:02x}", byte);
  return hex;
}

}  // namespace octant::io

#pragma GCC diagnostic pop
