// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "tests/apps/hall_folder.h"

namespace octant::test {
namespace sign_test {

using ::testing::HasSubstr;

TEST_F(HallFolder, SignedDeploymentsAreTrustedAndOthersAreNot) {
  ASSERT_EQ(calibrate().exit, 0);
  ASSERT_EQ(octant({"sign", "--new-key", out("site.key")}).exit, 0);
  const Outcome made =
      octant({"sign", out("d.json"), "--key", out("site.key"), "-o", out("signed.json"), "--json"});
  ASSERT_EQ(made.exit, 0) << made.err;
  EXPECT_EQ(made.json().at("status"), "ok");
  const auto verified =
      octant({"verify-signature", out("signed.json"), "--key", out("site.key.pub"), "--json"});
  EXPECT_EQ(verified.exit, 0) << verified.err;
  EXPECT_EQ(verified.json().at("genuine"), true);
  EXPECT_EQ(octant({"verify-signature", out("d.json"), "--key", out("site.key.pub")}).exit, 3);
  EXPECT_EQ(octant({"verify-signature", out("signed.json"), "--trusted-key", out("site.key.pub")}).exit, 0)
      << "the option's name in localize and verify";

  const auto localize = [&](const std::string& deployment, std::vector<std::string> more,
                            const RunOptions& options = {}) {
    std::vector<std::string> words = {"localize", deployment, hall("heldout"), "-o", out("f.tum")};
    words.insert(words.end(), more.begin(), more.end());
    return octant(words, options);
  };
  EXPECT_EQ(localize(out("signed.json"), {}).exit, 0) << "a signature bothers nobody who has no key";
  EXPECT_EQ(localize(out("signed.json"), {"--trusted-key", out("site.key.pub")}).exit, 0);
  const Outcome unsigned_one = localize(out("d.json"), {"--trusted-key", out("site.key.pub")});
  EXPECT_EQ(unsigned_one.exit, 3);
  EXPECT_THAT(unsigned_one.err, HasSubstr("no signature"));
  EXPECT_EQ(localize(out("d.json"), {}, {.environment = {"OCTANT_TRUSTED_KEY=" + out("site.key.pub")}}).exit,
            3);
  EXPECT_EQ(octant({"verify", out("d.json"), hall("heldout"), "--trusted-key", out("site.key.pub")}).exit, 3);

  std::string changed = slurp(out("signed.json"));
  changed.replace(changed.find("\"created\""), 9, "\"Created\"");
  spit(out("changed.json"), changed);
  EXPECT_EQ(localize(out("changed.json"), {"--trusted-key", out("site.key.pub")}).exit, 3);
}

TEST_F(HallFolder, SignRefusesWhatItMust) {
  spit(out("d.json"), "{}");
  EXPECT_EQ(octant({"sign"}).exit, 2);
  EXPECT_EQ(octant({"sign", out("d.json"), "--key", out("k")}).exit, 2) << "where to?";
  ASSERT_EQ(octant({"sign", "--new-key", out("k")}).exit, 0);
  EXPECT_EQ(octant({"sign", "--new-key", out("k")}).exit, 3) << "a key is never replaced";
  EXPECT_EQ(octant({"sign", "--new-key", out("k2"), "--key", out("k")}).exit, 2);
  EXPECT_EQ(octant({"sign", out("d.json"), "--key", out("k"), "-o", out("s.json")}).exit, 3);
  EXPECT_EQ(octant({"sign", out("d.json"), "--key", out("k"), "-o", out("d.json")}).exit, 2)
      << "over its input";
  EXPECT_EQ(octant({"sign", out("d.json"), "--key", out("k"), "-o", out("k")}).exit, 2) << "over the key";
}

}  // namespace sign_test
}  // namespace octant::test
