// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/deployment/signature.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <unistd.h>

#include "io/deployment/deployment_digest.h"
#include "io/deployment/deployment_json.h"
#include "io/text/atomic_file.h"
#include "io/text/json_reader.h"

namespace octant::io {
namespace {

using OrderedJson = nlohmann::ordered_json;
using SignatureBytes = std::array<unsigned char, 64>;
using PublicKeyBytes = std::array<unsigned char, 32>;

struct FreeKey {
  void operator()(EVP_PKEY* key) const { EVP_PKEY_free(key); }
};
using Key = std::unique_ptr<EVP_PKEY, FreeKey>;
struct FreeBio {
  void operator()(BIO* bio) const { BIO_free(bio); }
};
using Bio = std::unique_ptr<BIO, FreeBio>;
struct FreeContext {
  void operator()(EVP_MD_CTX* context) const { EVP_MD_CTX_free(context); }
};
using SigningContext = std::unique_ptr<EVP_MD_CTX, FreeContext>;

/// The preamble prevents a signature of another document from being valid for a deployment.
std::string message_of(const nlohmann::json& deployment) {
  return "octant deployment, ed25519, 1\n" + digest_of(deployment);
}

template <class Bytes>
std::string hex(const Bytes& bytes) {
  return fmt::format("{:02x}", fmt::join(bytes, ""));
}

template <class Bytes>
bool from_hex(const std::string& text, Bytes& bytes) {
  if (text.size() != 2 * bytes.size()) return false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const int digit = c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
    if (digit < 0) return false;
    bytes[i / 2] = static_cast<unsigned char>(i % 2 == 0 ? digit << 4 : bytes[i / 2] | digit);
  }
  return true;
}

Result<Key> read_key(const std::string& path, bool secret) {
  constexpr std::size_t kLongestPem = 1 << 16;
  const auto text = read_file(path, kLongestPem);
  if (!text) return fail(text.error());
  const Bio bio(BIO_new_mem_buf(text->data(), static_cast<int>(text->size())));
  Key key(secret ? PEM_read_bio_PrivateKey(bio.get(), nullptr, nullptr, nullptr)
                 : PEM_read_bio_PUBKEY(bio.get(), nullptr, nullptr, nullptr));
  if (!key || EVP_PKEY_id(key.get()) != EVP_PKEY_ED25519)
    return fail({.file = path,
                 .found = fmt::format("no {} Ed25519 key", secret ? "secret" : "public"),
                 .expected = "a PEM file",
                 .advice = secret ? "octant sign --new-key FILE makes one"
                                  : "octant sign --new-key FILE makes one, FILE.pub"});
  return key;
}

PublicKeyBytes public_bytes(const Key& key) {
  PublicKeyBytes bytes{};
  std::size_t size = bytes.size();
  EVP_PKEY_get_raw_public_key(key.get(), bytes.data(), &size);
  return bytes;
}

std::string pem_of(const Key& key, bool secret) {
  const Bio bio(BIO_new(BIO_s_mem()));
  if (secret) PEM_write_bio_PrivateKey(bio.get(), key.get(), nullptr, nullptr, 0, nullptr, nullptr);
  if (!secret) PEM_write_bio_PUBKEY(bio.get(), key.get());
  char* bytes = nullptr;
  const long size = BIO_get_mem_data(bio.get(), &bytes);
  return {bytes, static_cast<std::size_t>(size)};
}

/// An existing file may be a key that is still needed, so it is never replaced. No temporary file is used, so
/// that the secret key is never readable for others.
Result<void> write_new_file(const std::string& path, const std::string& text, mode_t mode) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
  if (file < 0)
    return fail({.code = Errc::kOutput,
                 .file = path,
                 .found = fmt::format("not written: {}", std::strerror(errno)),
                 .expected = "a name that is free",
                 .advice = "keys are never replaced"});
  const bool whole =
      ::write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size()) && ::fsync(file) == 0;
  if (::close(file) == 0 && whole) return {};
  return fail({.code = Errc::kOutput, .file = path, .found = "not written: is the disk full?"});
}

}  // namespace

Result<void> make_key(const std::string& path) {
  std::error_code ignored;
  for (const std::string& file : {path, path + ".pub"})
    if (std::filesystem::exists(std::filesystem::symlink_status(file, ignored)))
      return fail({.code = Errc::kOutput,
                   .file = file,
                   .found = "is there already",
                   .expected = "a name that is free",
                   .advice = "keys are never replaced"});
  const Key key(EVP_PKEY_Q_keygen(nullptr, nullptr, "ED25519"));
  if (!key)
    return fail(
        {.code = Errc::kOutput, .file = path, .found = "the system gave no random numbers for a key"});
  if (auto written = write_new_file(path, pem_of(key, true), 0600); !written) return written;
  return write_new_file(path + ".pub", pem_of(key, false), 0644);
}

Result<std::string> signed_deployment(const std::string& text, const std::string& file,
                                      const std::string& secret_key_path) {
  if (const auto deployment = deployment_from_json(text, file); !deployment) return fail(deployment.error());
  const auto key = read_key(secret_key_path, true);
  if (!key) return fail(key.error());
  OrderedJson json = OrderedJson::parse(text);
  const std::string message = message_of(nlohmann::json(json));
  SignatureBytes signature{};
  std::size_t size = signature.size();
  const SigningContext context(EVP_MD_CTX_new());
  if (EVP_DigestSignInit(context.get(), nullptr, nullptr, nullptr, key->get()) != 1 ||
      EVP_DigestSign(context.get(), signature.data(), &size,
                     reinterpret_cast<const unsigned char*>(message.data()), message.size()) != 1)
    return fail({.file = secret_key_path, .found = "a key that does not sign", .expected = "an Ed25519 key"});
  json["digest"] = digest_of(nlohmann::json(json));
  json["signature"] = {
      {"algorithm", "ed25519"}, {"public_key", hex(public_bytes(*key))}, {"value", hex(signature)}};
  return pretty(json);
}

Result<void> check_signature(const std::string& text, const std::string& file,
                             const std::string& public_key_path) {
  const auto key = read_key(public_key_path, false);
  if (!key) return fail(key.error());
  const auto json = parse_json(text, file);
  if (!json) return fail(json.error());
  if (!json->is_object() || !json->contains("signature") || !(*json)["signature"].is_object())
    return fail({.file = file,
                 .found = "no signature",
                 .expected = fmt::format("one by the key {}", public_key_path),
                 .advice = "octant sign makes it, by who has the secret key"});
  JsonLog log{file, text, std::nullopt};
  const JsonValue signature = JsonValue(&*json, "", log).at("signature");
  const std::string algorithm = signature.at("algorithm").text(), by = signature.at("public_key").text(),
                    value = signature.at("value").text();
  if (log.error) return fail(*log.error);
  if (algorithm != "ed25519")
    return fail({.file = file, .found = "a signature by " + in_quotes(algorithm), .expected = "ed25519"});
  if (by != hex(public_bytes(*key)))
    return fail(
        {.file = file,
         .found = fmt::format("signed by another key, {}...", by.substr(0, 12)),
         .expected = fmt::format("{}, {}...", public_key_path, hex(public_bytes(*key)).substr(0, 12))});
  SignatureBytes bytes{};
  const std::string message = message_of(*json);
  const SigningContext context(EVP_MD_CTX_new());
  const bool genuine =
      from_hex(value, bytes) &&
      EVP_DigestVerifyInit(context.get(), nullptr, nullptr, nullptr, key->get()) == 1 &&
      EVP_DigestVerify(context.get(), bytes.data(), bytes.size(),
                       reinterpret_cast<const unsigned char*>(message.data()), message.size()) == 1;
  if (!genuine)
    return fail({.file = file,
                 .found = "a signature that does not fit the content",
                 .expected = "the deployment as it was signed",
                 .advice = "the file was changed after it was signed: take the original"});
  return {};
}

}  // namespace octant::io
