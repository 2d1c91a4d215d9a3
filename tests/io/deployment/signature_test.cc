// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "io/deployment/signature.h"

#include <nlohmann/json.hpp>

#include <sys/stat.h>

#include "io/deployment/deployment_json.h"
#include "io/text/atomic_file.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace signature_test {

using test::expect_error;
using test::TemporaryFolder;

std::string plain_deployment() {
  Deployment d;
  d.site = "hall";
  d.created = "2026-01-02T03:04:05Z";
  d.medium = {MediumModel::kConstant, 343.21, 20.0, 0.5, 101325.0};
  d.beacons.push_back({.name = "B0", .position_m = {1, 2, 3.000000001}});
  d.vehicles.push_back({"robot", 0, 1});
  d.receivers.push_back(
      {.name = "r0", .vehicle = VehicleId(0), .position_m = {0.1, 0, 0.3}, .axis = std::nullopt});
  d.covariance.matrix.resize(0, 0);
  return deployment_to_json(d);
}

class Signatures : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(make_key(folder.path("site.key")));
    ASSERT_TRUE(make_key(folder.path("other.key")));
    auto made = signed_deployment(plain_deployment(), "d.json", folder.path("site.key"));
    ASSERT_TRUE(made) << made.error().message();
    text = *made;
  }
  [[nodiscard]] Result<void> check(const std::string& signed_text,
                                   const std::string& key = "site.key.pub") const {
    return check_signature(signed_text, "d.json", folder.path(key));
  }
  TemporaryFolder folder;
  std::string text;
};

TEST_F(Signatures, HoldInAnyLayoutAndTheDeploymentStaysReadable) {
  EXPECT_TRUE(check(text));
  EXPECT_TRUE(check(nlohmann::json::parse(text).dump()));
  const auto deployment = deployment_from_json(text, "d.json");
  ASSERT_TRUE(deployment) << deployment.error().message();
  EXPECT_TRUE(deployment->warnings.empty()) << "the digest fits, as the signature is no part of the content";
  EXPECT_EQ(deployment_to_json(*deployment), plain_deployment());
  const auto again = signed_deployment(text, "d.json", folder.path("other.key"));
  EXPECT_TRUE(check(*again, "other.key.pub")) << "signing anew replaces";
}

TEST_F(Signatures, DoNotHoldForWhatWasChanged) {
  std::string moved = text;
  moved.replace(moved.find("3.000000001"), 11, "3.000000002");
  expect_error(check(moved), 0, "does not fit the content", "d.json");
  auto json = nlohmann::json::parse(text);
  std::string value = json["signature"]["value"];
  value[7] = value[7] == '0' ? '1' : '0';
  json["signature"]["value"] = value;
  EXPECT_FALSE(check(json.dump()));
  json["signature"]["value"] = "zz";
  EXPECT_FALSE(check(json.dump()));
  json["signature"] = {{"algorithm", "rot13"}, {"public_key", ""}, {"value", ""}};
  expect_error(check(json.dump()), 0, "'rot13'", "d.json");
  json.erase("signature");
  expect_error(check(json.dump()), 0, "no signature", "d.json");
  EXPECT_FALSE(check("[]"));
  EXPECT_FALSE(check("{"));
}

TEST_F(Signatures, AreOfTheirKeyAlone) {
  expect_error(check(text, "other.key.pub"), 0, "another key", "d.json");
  // Who claims the right key with a signature of his own is found out by it.
  auto forged =
      nlohmann::json::parse(*signed_deployment(plain_deployment(), "d.json", folder.path("other.key")));
  forged["signature"]["public_key"] = nlohmann::json::parse(text)["signature"]["public_key"];
  expect_error(check(forged.dump()), 0, "does not fit", "d.json");
}

TEST_F(Signatures, KeysAreSecretAndNeverReplaced) {
  struct stat status {};
  ASSERT_EQ(::stat(folder.path("site.key").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
  EXPECT_THAT(folder.read("site.key.pub"), testing::Not(testing::HasSubstr("PRIVATE")));
  expect_error(make_key(folder.path("site.key")), 0, "there already", "site.key");
  expect_error(make_key(folder.path("no/such/site.key")), 0, "", "site.key");
  expect_error(signed_deployment(plain_deployment(), "d.json", folder.path("site.key.pub")), 0,
               "no secret Ed25519 key", "site.key.pub");
  expect_error(check(text, "site.key"), 0, "no public Ed25519 key", "site.key");
  expect_error(check(text, "none.pub"), 0, "", "none.pub");
  EXPECT_FALSE(signed_deployment("{}", "d.json", folder.path("site.key")));
}

// RFC 8032, section 7.1, test 1: keys are those of the standard, so that other programs can check.
TEST(SignatureKeys, AreTheStandards) {
  const TemporaryFolder folder;
  const std::string secret = folder.write("rfc.key",
                                          "-----BEGIN PRIVATE "
                                          "KEY-----\nMC4CAQAwBQYDK2VwBCIEIJ1hsZ3v/"
                                          "VpguoRK9JLsLMREScVpezJpGXA7rAMcrn9g\n-----END PRIVATE KEY-----\n");
  const auto made = signed_deployment(plain_deployment(), "d.json", secret);
  ASSERT_TRUE(made) << made.error().message();
  EXPECT_EQ(nlohmann::json::parse(*made)["signature"]["public_key"],
            "d75a980182b10ab7d54bfed3c964073a0ee172f3daa62325af021a68f707511a");
}

}  // namespace signature_test
}  // namespace octant::io
