// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "models/support/result.h"

namespace octant::io {

/// Ed25519 signatures (RFC 8032) of deployment files. Keys are PEM files as `openssl genpkey -algorithm
/// ed25519` writes them. The signed message is a fixed preamble and the SHA-256 of the deployment's content,
/// which `digest` states. The signature is stored under `signature` and is not part of the content.

/// Writes a new secret key, readable for its owner only, and its public key (path + ".pub"). Errors: one of
/// the files exists.
[[nodiscard]] Result<void> make_key(const std::string& path);

/// The deployment with a signature. @param text  of the deployment; a signature that it has is replaced
/// Errors: no whole deployment, no secret Ed25519 key.
[[nodiscard]] Result<std::string> signed_deployment(const std::string& text, const std::string& file,
                                                    const std::string& secret_key_path);

/// Succeeds if the deployment is unchanged since the owner of this key signed it. Errors: not signed, signed
/// with another key, changed; not a public key.
[[nodiscard]] Result<void> check_signature(const std::string& text, const std::string& file,
                                           const std::string& public_key_path);

}  // namespace octant::io
