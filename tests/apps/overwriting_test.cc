// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
// Compares every output of every command with every input: by its name, through a symbolic link and as a hard
// link.
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/apps/hall_folder.h"

namespace octant::test {
namespace overwriting_test {

namespace fs = std::filesystem;

/// A command with OUT where an output is named, and the inputs that it must not be.
struct WritingCommand {
  std::vector<std::string> words;
  std::vector<std::string> inputs;
};

class Overwriting : public HallFolder {
 protected:
  void SetUp() override {
    make(20);
    ASSERT_EQ(calibrate().exit, 0);
    ASSERT_EQ(octant({"sign", "--new-key", out("key")}).exit, 0);
    ASSERT_EQ(octant({"history", "add", out("d.json"), "--db", out("site.octant.db")}).exit, 0);
    spit(box / "list.yaml",
         "octant_batch: 1\nsites:\n  - {site: hall/site.yaml, runs: [hall/run], output: OUT}\n");
    spit(box / "map.yaml", "image: map.pgm\nresolution: 4\norigin: [0, 0, 0]\n");
    spit(box / "map.pgm", "P2 5 3 1\n1 1 1 1 1\n1 1 1 1 1\n1 1 1 1 1\n");
    spit(box / "scene.yaml", "octant_scene: 1\nimport: [{ros_map: map.yaml}]\n");
    spit(box / "kit.csv", "t,b,d\n1,B0,3\n");
    spit(box / "columns.yaml", "octant_columns: 1\ncolumns: {time_s: t, beacon: b, distance_m: d}\n");
  }

  [[nodiscard]] std::vector<WritingCommand> commands() const {
    const std::string site = hall("site.yaml"), run = hall("run"), tof = run + "/tof.csv",
                      yaml = run + "/run.yaml", heldout = hall("heldout"), truth = heldout + "/truth.tum",
                      d = out("d.json"), other = out("other"), scene = box / "scene.yaml",
                      map = box / "map.yaml", image = box / "map.pgm", key = out("key"),
                      db = out("site.octant.db"), table = box / "kit.csv", mapping = box / "columns.yaml";
    return {
        {{"calibrate", site, run, "-o", "OUT", "--since", d}, {site, tof, yaml, d}},
        {{"calibrate", site, run, "-o", other, "--report", "OUT"}, {site, tof}},
        {{"recalibrate", d, run, "-o", "OUT"}, {d, tof, yaml}},
        {{"recalibrate", d, run, "-o", other, "--report", "OUT"}, {d, tof}},
        {{"localize", d, heldout, "-o", "OUT"}, {d, heldout + "/tof.csv", truth}},
        {{"localize", d, heldout, "-o", other, "--csv", "OUT"}, {d, truth}},
        {{"localize", d, heldout, "-o", "OUT", "--trusted-key", key + ".pub"}, {key + ".pub"}},
        {{"verify", d, heldout, "--report", "OUT"}, {d, truth}},
        {{"report", d, heldout, "-o", "OUT"}, {d, truth}},
        {{"report", d, "--site-sheet", "OUT"}, {d}},
        {{"report", d, "-o", other, "--since", d, "--site-sheet", "OUT"}, {d}},
        {{"survey", site, "-o", "OUT", "--scene", scene}, {site, scene, map, image}},
        {{"survey", d, "--csv", "OUT"}, {d}},
        {{"plan", site, run, "--stations", "1", "--csv", "OUT"}, {site, tof}},
        {{"plan", site, "--beacons", "9", "--keep", "-o", "OUT", "--scene", scene},
         {site, scene, map, image}},
        {{"plan", site, "--beacons", "9", "--keep", "-o", other, "--report", "OUT"}, {site}},
        {{"export", d, heldout, "-o", "OUT"}, {d, heldout + "/tof.csv", truth}},
        {{"history", "export", "--db", db, "-o", "OUT"}, {db}},
        {{"history", "add", d, "--db", "OUT"}, {d}},
        {{"sign", d, "--key", key, "-o", "OUT"}, {d, key}},
        {{"sign", "--new-key", "OUT"}, {d, key}},
        {{"init", run, "-o", "OUT"}, {tof, yaml}},
        {{"convert", table, "--columns", mapping, "-o", other, "--save-columns", "OUT"}, {table, mapping}},
        {{"report", d, "--certificate", "OUT"}, {d}},
        {{"report", d, heldout, "-o", other, "--certificate", "OUT"}, {d, truth}},
        {{"report", d, "-o", other, "--since", d, "--certificate", "OUT"}, {d}}};
  }

  /// Both names as an output: exit 2 (by the arguments alone if the name has no fitting extension), with all
  /// files unchanged.
  void expect_refused(std::vector<std::string> words, const std::string& as, const std::string& input) {
    for (std::string& word : words)
      if (word == "OUT") word = as;
    const std::string before = slurp(input);
    const Outcome outcome = octant(words);
    std::string line;
    for (const std::string& word : words) line += word + " ";
    // Keys are never replaced, under any name.
    EXPECT_EQ(outcome.exit, words[1] == "--new-key" ? 3 : 2) << line << outcome.err;
    EXPECT_EQ(slurp(input), before) << line;
  }
};

TEST_F(Overwriting, NoCommandWritesOverItsInputs) {
  for (const WritingCommand& command : commands())
    for (const std::string& input : command.inputs) {
      ASSERT_TRUE(fs::exists(input)) << input;
      const std::string ending = fs::path(input).extension().string();
      fs::create_symlink(input, out("soft" + ending));
      fs::create_hard_link(input, out("hard" + ending));
      expect_refused(command.words, input, input);
      expect_refused(command.words, out("soft" + ending), input);
      expect_refused(command.words, out("hard" + ending), input);
      fs::remove(out("soft" + ending));
      fs::remove(out("hard" + ending));
    }
}

TEST_F(Overwriting, NorThroughFoldersAndLists) {
  const std::string list = slurp(box / "list.yaml"), site = hall("site.yaml"), tof = hall("run/tof.csv");
  for (const std::string input : {"hall/site.yaml", "hall/run/tof.csv", "list.yaml"}) {
    std::string by = list;
    by.replace(by.find("OUT"), 3, input);
    spit(box / "list.yaml", by);
    expect_refused({"batch", box / "list.yaml"}, "", box / input);
  }
  // Existing output folders that contain links to the inputs.
  fs::create_directory(box / "kit");
  fs::create_hard_link(box / "kit.csv", box / "kit/tof.csv");
  expect_refused({"convert", box / "kit.csv", "--columns", "time=t,beacon=b,distance=d", "-o", "OUT"},
                 box / "kit", box / "kit.csv");
  fs::create_directory(box / "world");
  fs::create_symlink(box / "scenario.yaml", box / "world/site.yaml");
  expect_refused({"simulate", box / "scenario.yaml", "-o", "OUT"}, box / "world", box / "scenario.yaml");
  expect_refused({"convert", tof, "--site", site, "--format", "counters", "-o", "OUT"}, hall("run"), tof);
  fs::create_directory(box / "maps");
  fs::rename(box / "map.pgm", box / "maps/hdop.pgm");
  spit(box / "map.yaml", "image: maps/hdop.pgm\nresolution: 4\norigin: [0, 0, 0]\n");
  expect_refused({"survey", site, "--scene", box / "scene.yaml", "--maps", "OUT"}, box / "maps",
                 box / "maps/hdop.pgm");
}

TEST_F(Overwriting, DiffAndMonitorWriteNothing) {
  const auto before = box.names(), before_out = outputs();
  const std::string d = out("d.json");
  EXPECT_EQ(octant({"diff", d, d}, {.folder = box.path()}).exit, 0);
  EXPECT_EQ(octant({"monitor", d, hall("heldout")}, {.folder = box.path()}).exit, 0);
  EXPECT_EQ(box.names(), before);
  EXPECT_EQ(outputs(), before_out);
}

/// The number of a process that has ended.
pid_t ended_process() {
  const pid_t pid = ::fork();
  if (pid == 0) ::_exit(0);
  ::waitpid(pid, nullptr, 0);
  return pid;
}

TEST_F(Overwriting, WhatKilledProcessesLeftGoesWithTheNextRun) {
  const std::string gone = std::to_string(ended_process()), here = std::to_string(::getpid());
  const std::string stale = out("d.json." + gone + ".0.tmp"), alive = out("d.json." + here + ".0.tmp"),
                    strange = out("d.json." + gone + ".tmp"), other = out("e.json." + gone + ".0.tmp");
  for (const std::string& file : {stale, alive, strange, other}) spit(file, "half");
  ASSERT_EQ(calibrate().exit, 0);
  EXPECT_FALSE(fs::exists(stale));
  EXPECT_TRUE(fs::exists(alive)) << "a process that runs may be writing it";
  EXPECT_TRUE(fs::exists(strange)) << "none of ours";
  EXPECT_TRUE(fs::exists(other)) << "of another output, which its next run removes";
}

}  // namespace overwriting_test
}  // namespace octant::test
