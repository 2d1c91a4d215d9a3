// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "tests/apps/process.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <thread>

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace octant::test {
namespace {

struct Channel {
  int ours = -1, theirs = -1;
  std::string* text = nullptr;
};

Channel pipe_channel(std::string* text) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("pipe");
  return {ends[0], ends[1], text};
}

Channel terminal_channel(std::string* text) {
  Channel channel;
  channel.text = text;
  if (openpty(&channel.ours, &channel.theirs, nullptr, nullptr, nullptr) != 0)
    throw std::runtime_error("openpty");
  fcntl(channel.ours, F_SETFD, FD_CLOEXEC);
  return channel;
}

}  // namespace

bool has_terminals() {
  int ours = -1, theirs = -1;
  if (openpty(&ours, &theirs, nullptr, nullptr, nullptr) != 0) return false;
  close(ours);
  close(theirs);
  return true;
}

namespace {

[[noreturn]] void become_octant(const std::vector<std::string>& words, const RunOptions& options, int out,
                                int err) {
  dup2(open("/dev/null", O_RDONLY), STDIN_FILENO);
  dup2(out, STDOUT_FILENO);
  dup2(err, STDERR_FILENO);
  for (const int number : {SIGINT, SIGTERM}) std::signal(number, SIG_DFL);
  unsetenv("NO_COLOR");
  setenv("TERM", "xterm", 1);
  for (const auto& pair : options.environment) putenv(strdup(pair.c_str()));
  if (!options.folder.empty() && chdir(options.folder.c_str()) != 0) _exit(125);
  for (const auto& [resource, most] : options.limits) {
    const rlimit limit{most, most};
    if (setrlimit(static_cast<__rlimit_resource_t>(resource), &limit) != 0) _exit(125);
  }
  std::vector<char*> argv = {const_cast<char*>("octant")};
  for (const auto& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  execv(OCTANT_BINARY, argv.data());
  _exit(126);
}

/// Reads both until their writers are gone.
void collect(std::vector<Channel> channels, pid_t child, int interrupt_signal) {
  while (!channels.empty()) {
    std::vector<pollfd> wait;
    for (const auto& channel : channels) wait.push_back({channel.ours, POLLIN, 0});
    if (poll(wait.data(), wait.size(), -1) < 0) continue;
    for (std::size_t i = channels.size(); i-- > 0;) {
      if (wait[i].revents == 0) continue;
      char buffer[65536];
      const ssize_t n = read(channels[i].ours, buffer, sizeof buffer);
      if (n > 0) {
        channels[i].text->append(buffer, static_cast<std::size_t>(n));
        if (interrupt_signal != 0) kill(child, interrupt_signal);
        interrupt_signal = 0;
      } else {  // a terminal whose other side is gone gives an error, not the end of the file
        close(channels[i].ours);
        channels.erase(channels.begin() + static_cast<std::ptrdiff_t>(i));
      }
    }
  }
}

}  // namespace

bool octant_killed(const std::vector<std::string>& words, double after_s) {
  const pid_t child = fork();
  if (child == 0) {
    const int nowhere = open("/dev/null", O_WRONLY);
    become_octant(words, {}, nowhere, nowhere);
  }
  std::this_thread::sleep_for(std::chrono::duration<double>(after_s));
  kill(child, SIGKILL);
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

nlohmann::json Outcome::json() const {
  if (out.empty() || out.back() != '\n' || std::count(out.begin(), out.end(), '\n') != 1) return nullptr;
  // The library accepts neither NaN nor Infinity, like JSON.
  auto object = nlohmann::json::parse(out, nullptr, false);
  return object.is_object() ? object : nlohmann::json(nullptr);
}

Outcome octant(const std::vector<std::string>& words, const RunOptions& options) {
  Outcome outcome;
  Channel out = pipe_channel(&outcome.out);
  const Channel err = options.on_terminal ? terminal_channel(&outcome.err) : pipe_channel(&outcome.err);
  if (!options.out_file.empty()) {
    close(out.theirs);
    out.theirs = open(options.out_file.c_str(), O_WRONLY | O_CLOEXEC);
  }
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("fork");
  if (child == 0) become_octant(words, options, out.theirs, err.theirs);
  close(out.theirs);
  close(err.theirs);
  collect({out, err}, child, options.interrupt_signal);
  int status = 0;
  rusage used{};
  wait4(child, &status, 0, &used);
  outcome.largest_mb = static_cast<double>(used.ru_maxrss) / 1024;
  outcome.exit = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return outcome;
}

TemporaryFolder::TemporaryFolder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "octant-test.XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("mkdtemp");
  path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::vector<std::string> TemporaryFolder::names() const {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(path_))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

std::string slurp(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void spit(const std::string& path, const std::string& content) {
  std::ofstream file(path, std::ios::binary);
  file << content;
  if (!file.flush()) throw std::runtime_error("cannot write " + path);
}

std::string hall_scenario_text(const std::string& what, const std::string& by) {
  std::string text = slurp(OCTANT_SOURCE_DIR "/datasets/hall/scenario.yaml");
  if (what.empty()) return text;
  const std::size_t at = text.find(what);
  if (at == std::string::npos) throw std::runtime_error("the hall's scenario does not say: " + what);
  return text.replace(at, what.size(), by);
}

}  // namespace octant::test
