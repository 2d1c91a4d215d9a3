// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/steps/trusted.h"

#include "apps/octant/options.h"
#include "io/deployment/deployment_json.h"
#include "io/deployment/signature.h"
#include "io/text/bounds.h"

namespace octant::app {

void add_trust_option(CLI::App& command, std::string& trusted_key) {
  add_option(command, "--trusted-key", trusted_key, "PUB",
             "Refuse a deployment that the owner of this public key did not sign")
      ->envname("OCTANT_TRUSTED_KEY");
}

Result<Deployment> read_trusted_deployment(const std::string& path, const std::string& trusted_key) {
  if (trusted_key.empty()) return io::read_deployment(path);
  // Read once: what was checked is what is used.
  const auto text = io::read_document(path);
  if (!text) return fail(text.error());
  if (auto genuine = io::check_signature(*text, path, trusted_key); !genuine) return fail(genuine.error());
  return io::deployment_from_json(*text, path);
}

}  // namespace octant::app
