// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Files of earlier versions remain readable: golden/deployments has a file of each that changed the format.
#include <algorithm>
#include <filesystem>
#include <vector>

#include "io/deployment/deployment_json.h"
#include "tests/io/io_support.h"

namespace octant::io {
namespace older_deployments_test {

std::vector<std::filesystem::path> older_deployments() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(OCTANT_SOURCE_DIR "/tests/golden/deployments"))
    if (entry.path().extension() == ".json") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

TEST(OlderDeployments, AreReadWithAllTheyHold) {
  const auto files = older_deployments();
  ASSERT_GE(files.size(), 1U);
  for (const auto& file : files) {
    const Result<Deployment> d = read_deployment(file);
    ASSERT_TRUE(d) << d.error().message();
    EXPECT_TRUE(d->warnings.empty()) << file << ": " << d->warnings[0];
    EXPECT_EQ(d->beacons.size(), 8U) << file;
    EXPECT_EQ(d->receivers.size(), 8U) << file;
    EXPECT_EQ(d->covariance.parameters.size(), 48U) << file << ": no parameter is unknown by now";
    EXPECT_EQ(d->covariance.matrix.rows(), 48) << file;
    EXPECT_GE(d->covariance.index_of(parameters::receiver_position(7, 2)), 0) << file;
    EXPECT_GE(d->covariance.index_of(parameters::speed()), 0) << file;
    for (const DeploymentBeacon& b : d->beacons) EXPECT_EQ(b.gain, 1.0) << "as none was stated then";
    EXPECT_FALSE(d->previous.has_value()) << file;
  }
}

/// A recalibration writes the old values in the present format.
TEST(OlderDeployments, AreWrittenAgainWithTheSameNumbers) {
  for (const auto& file : older_deployments()) {
    const Result<Deployment> d = read_deployment(file);
    ASSERT_TRUE(d) << d.error().message();
    const Result<Deployment> again = deployment_from_json(deployment_to_json(*d), "again.json");
    ASSERT_TRUE(again) << again.error().message();
    EXPECT_EQ(again->covariance.parameters, d->covariance.parameters);
    EXPECT_EQ(again->covariance.matrix, d->covariance.matrix);
    for (std::size_t b = 0; b < d->beacons.size(); ++b) {
      EXPECT_EQ(again->beacons[b].position_m, d->beacons[b].position_m);
      EXPECT_EQ(again->beacons[b].delay_s, d->beacons[b].delay_s);
      EXPECT_EQ(again->beacons[b].status, d->beacons[b].status);
    }
  }
}

}  // namespace older_deployments_test
}  // namespace octant::io
