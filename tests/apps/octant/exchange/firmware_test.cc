// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/exchange/firmware.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/deployment/deployment_json.h"
#include "tests/support/worlds.h"

namespace octant::test {
namespace firmware_test {

using testing::HasSubstr;
using testing::Not;

// A comment of the sources must not end where a text of the deployment says so.
TEST(FirmwareFiles, TextsOfTheDeploymentStayInTheirComments) {
  Deployment d =
      must(io::read_deployment(std::string(OCTANT_SOURCE_DIR) + "/datasets/hall/deployment.true.json"));
  d.site = "hall */ int site; /*";
  d.created = d.digest = "2026 */ int date; /*\n#include <evil.h>";
  for (const app::FirmwareFile& file : must(app::firmware_files(d, {}))) {
    EXPECT_THAT(file.text, Not(HasSubstr("*/ int"))) << file.name;
    EXPECT_THAT(file.text, Not(HasSubstr("#include <evil"))) << file.name;
  }
}

}  // namespace firmware_test
}  // namespace octant::test
