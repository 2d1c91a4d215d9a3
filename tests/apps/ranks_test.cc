// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// The program under mpirun: more processes, the same answer. Skipped where MPI is not installed.
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/apps/process.h"

namespace octant::test {
namespace ranks_test {

#ifdef OCTANT_MPI_BINARY

struct Shell {
  int exit;
  std::string out, err;
};

/// `mpirun -n ranks octant ...` as root and with more processes than cores, as in a container of continuous
/// integration.
Shell mpirun(int ranks, const std::string& words, const TemporaryFolder& folder,
             const std::string& before = "") {
  const std::string out = folder / "out", err = folder / "err";
  // OpenMPI does not release its memory, which the address sanitizer would report as leaks.
  const std::string command = before +
                              " ASAN_OPTIONS=detect_leaks=0 OMPI_ALLOW_RUN_AS_ROOT=1 "
                              "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 mpirun --oversubscribe -n " +
                              std::to_string(ranks) + " " OCTANT_MPI_BINARY " " + words + " > '" + out +
                              "' 2> '" + err + "'";
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, slurp(out), slurp(err)};
}

std::string simulated_hall(const TemporaryFolder& folder) {
  const std::string world = folder / "hall";
  EXPECT_EQ(octant({"simulate", OCTANT_SOURCE_DIR "/datasets/hall/scenario.yaml", "-o", world, "-q"}).exit,
            0);
  return world;
}

TEST(Ranks, FourGiveTheAnswerOfOne) {
  const TemporaryFolder folder;
  const std::string world = simulated_hall(folder);
  nlohmann::json answer[2];
  int i = 0;
  for (const int ranks : {1, 4}) {
    const std::string deployment = folder / ("deployment" + std::to_string(ranks) + ".json");
    const Shell done = mpirun(
        ranks,
        "calibrate '" + world + "/site.yaml' '" + world + "/run' -o '" + deployment + "' --json --threads 1",
        folder);
    ASSERT_EQ(done.exit, 0) << done.err;
    answer[i++] = nlohmann::json::parse(slurp(deployment));
    // One rank talks: one object, not four.
    EXPECT_EQ(nlohmann::json::parse(done.out)["status"], "ok");
  }
  ASSERT_EQ(answer[0]["beacons"].size(), answer[1]["beacons"].size());
  for (std::size_t b = 0; b < answer[0]["beacons"].size(); ++b)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double one = answer[0]["beacons"][b]["position_m"][axis],
                   four = answer[1]["beacons"][b]["position_m"][axis];
      EXPECT_NEAR(one, four, 1e-9 * std::max(1.0, std::abs(one)));
    }
  const auto &one = answer[0]["covariance"]["upper_triangle"],
             &four = answer[1]["covariance"]["upper_triangle"];
  ASSERT_EQ(one.size(), four.size());
  double largest = 0.0, off = 0.0;
  for (std::size_t k = 0; k < one.size(); ++k) {
    largest = std::max(largest, std::abs(one[k].get<double>()));
    off = std::max(off, std::abs(one[k].get<double>() - four[k].get<double>()));
  }
  EXPECT_LE(off, 1e-9 * largest);
  EXPECT_EQ(answer[0]["statistics"]["arrivals"], answer[1]["statistics"]["arrivals"]);
}

/// A log that is read in chunks: each rank reads its own.
TEST(Ranks, ShareALogThatIsStreamed) {
  const TemporaryFolder folder;
  spit(folder / "scenario.yaml", hall_scenario_text("epochs: 150", "epochs: 1500"));
  const std::string world = folder / "hall";
  ASSERT_EQ(octant({"simulate", folder / "scenario.yaml", "-o", world, "-q"}).exit, 0);
  std::vector<nlohmann::json> answers;
  for (const int ranks : {1, 2, 4}) {
    const std::string deployment = folder / ("deployment" + std::to_string(ranks) + ".json");
    const Shell done = mpirun(ranks,
                              "calibrate '" + world + "/site.yaml' '" + world + "/run' -o '" + deployment +
                                  "' --memory-mb 1 --json --threads 1",
                              folder);
    ASSERT_EQ(done.exit, 0) << done.err;
    EXPECT_EQ(nlohmann::json::parse(done.out)["streamed"]["epochs"], 1500);
    answers.push_back(nlohmann::json::parse(slurp(deployment)));
  }
  for (const nlohmann::json& answer : answers) {
    for (std::size_t b = 0; b < answer["beacons"].size(); ++b)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double one = answers[0]["beacons"][b]["position_m"][axis],
                     many = answer["beacons"][b]["position_m"][axis];
        EXPECT_NEAR(one, many, 1e-9 * std::max(1.0, std::abs(one)));
      }
    EXPECT_EQ(answer["statistics"]["arrivals"], answers[0]["statistics"]["arrivals"]);
    EXPECT_EQ(answer["validity"]["area"].size(), answers[0]["validity"]["area"].size());
    EXPECT_EQ(answer["inputs"], answers[0]["inputs"]);
  }
}

TEST(Ranks, BadInputIsSaidOnce) {
  const TemporaryFolder folder;
  spit(folder / "site.yaml", "octant_site: 1\nname: [\n");
  const Shell done = mpirun(3,
                            "calibrate '" + (folder / "site.yaml") + "' '" + (folder / "nowhere") + "' -o '" +
                                (folder / "d.json") + "'",
                            folder);
  EXPECT_EQ(done.exit, 3);
  const std::size_t first = done.err.find("site.yaml");
  ASSERT_NE(first, std::string::npos) << done.err;
  EXPECT_FALSE(std::filesystem::exists(folder / "d.json"));
}

/// One rank cannot read a file that the others can: the job ends without a deadlock and without output.
TEST(Ranks, OneThatFailsEndsTheJob) {
  const TemporaryFolder folder;
  const std::string world = simulated_hall(folder);
  const std::string words =
      "calibrate '" + world + "/site.yaml' '" + world + "/run' -o '" + (folder / "d.json") + "'";
  // The second rank is given a run that is not there.
  const std::string out = folder / "out", err = folder / "err";
  const std::string command =
      "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 timeout 60 mpirun --oversubscribe -n "
      "1 " OCTANT_MPI_BINARY " " +
      words + " : -n 1 " OCTANT_MPI_BINARY " calibrate '" + world + "/site.yaml' '" + (folder / "nowhere") +
      "' -o '" + (folder / "d.json") + "' > '" + out + "' 2> '" + err + "'";
  const int status = std::system(command.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 3) << slurp(err);
  EXPECT_NE(slurp(err).find("rank 1 of 2 failed"), std::string::npos) << slurp(err);
  EXPECT_FALSE(std::filesystem::exists(folder / "d.json"));
}

/// One rank is killed while it reads: the launcher ends the job, without output.
TEST(Ranks, OneThatIsKilledEndsTheJob) {
  if (std::string(OCTANT_FAULTY_SYSTEM).empty()) GTEST_SKIP() << "a sanitizer wants to be loaded first";
  const TemporaryFolder folder;
  const std::string world = simulated_hall(folder), d = folder / "d.json";
  const Shell done =
      mpirun(3, "calibrate '" + world + "/site.yaml' '" + world + "/run' -o '" + d + "'", folder,
             "LD_PRELOAD=" OCTANT_FAULTY_SYSTEM " OCTANT_FAULTS=die=tof.csv timeout 60 env");
  EXPECT_EQ(done.exit, 128 + SIGKILL) << done.err;
  EXPECT_FALSE(std::filesystem::exists(d));
  for (const std::string& name : folder.names()) EXPECT_EQ(name.find(".tmp"), std::string::npos) << name;
}

TEST(Ranks, ShareABatch) {
  const TemporaryFolder folder;
  const std::string world = simulated_hall(folder);
  spit(folder / "sites.yaml",
       "octant_batch: 1\nsites:\n"
       "  - {name: first, site: hall/site.yaml, runs: [hall/run], output: first.json}\n"
       "  - {name: broken, site: hall/none.yaml, runs: [hall/run], output: broken.json}\n"
       "  - {name: last, site: hall/site.yaml, runs: [hall/run], output: last.json}\n");
  const Shell done = mpirun(2, "batch '" + (folder / "sites.yaml") + "' --json --threads 1", folder);
  EXPECT_EQ(done.exit, 3) << done.err;
  const auto object = nlohmann::json::parse(done.out);
  ASSERT_EQ(object["sites"].size(), 3u);
  EXPECT_EQ(object["sites"][0]["name"], "first");
  EXPECT_EQ(object["sites"][1]["exit"], 3);
  EXPECT_EQ(object["sites"][2]["status"], "ok");
  EXPECT_TRUE(std::filesystem::exists(folder / "first.json"));
  EXPECT_TRUE(std::filesystem::exists(folder / "last.json"));
  EXPECT_FALSE(std::filesystem::exists(folder / "broken.json"));
}

#else

TEST(Ranks, NeedMpi) { GTEST_SKIP() << "MPI is not installed: the program under mpirun was not tested"; }

#endif

}  // namespace ranks_test
}  // namespace octant::test
