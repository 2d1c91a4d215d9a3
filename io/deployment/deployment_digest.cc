// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/deployment/deployment_digest.h"

#include "io/deployment/deployment_json.h"
#include "io/text/bounds.h"
#include "io/text/json_reader.h"
#include "io/text/sha256.h"

namespace octant::io {

std::string digest_of(nlohmann::json json) {
  json.erase("digest");
  json.erase("signature");
  Sha256 digest;
  digest.add(json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  return digest.hex();
}

Result<std::string> deployment_digest(const std::string& path) {
  return read_document(path)
      .and_then([&path](const std::string& text) { return parse_json(text, path); })
      .map(digest_of);
}

}  // namespace octant::io
