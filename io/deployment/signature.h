// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "models/support/result.h"

namespace octant::io {

/// Ed25519 signatures (RFC 8032) of deployment files. Keys are PEM files as `openssl genpkey -algorithm
/// ed25519` makes them. What is signed is a fixed preamble and the SHA-256 of the deployment's content, the
/// one that `digest` states; the signature stands beside it under `signature`, and is no part of the content.

/// Writes a new secret key, for its owner alone to read, and its public key beside it (path + ".pub").
/// Errors: one of them is there already.
[[nodiscard]] Result<void> make_key(const std::string& path);

/// The deployment with a signature. @param text  of the deployment; a signature that it has is replaced
/// Errors: no whole deployment, no secret Ed25519 key.
[[nodiscard]] Result<std::string> signed_deployment(const std::string& text, const std::string& file,
                                                    const std::string& secret_key_path);

/// Nothing where the deployment is as the owner of this key signed it. Errors: it is not signed, by another
/// key, or was changed; no public key.
[[nodiscard]] Result<void> check_signature(const std::string& text, const std::string& file,
                                           const std::string& public_key_path);

}  // namespace octant::io
