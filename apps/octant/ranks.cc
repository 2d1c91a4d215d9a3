// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/octant/ranks.h"

#ifndef OCTANT_MPI

namespace octant::app {

class Job::Mpi {};
Job::Job(int* /*argc*/, char*** /*argv*/) {}
Job::~Job() = default;
const calib::Ranks* Job::ranks() const { return nullptr; }
std::vector<std::string> Job::gather(const std::string& text) const { return {text}; }
int Job::finish(int code) { return code; }

}  // namespace octant::app

#else

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <thread>

#include <fcntl.h>
#include <mpi.h>
#include <unistd.h>

namespace octant::app {
namespace {

/// Initialising MPI without a launcher takes time and may fail, so it is done only if the environment shows a
/// launcher.
bool was_launched() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK", "PMI_SIZE"})
    if (std::getenv(name) != nullptr) return true;
  return false;
}

constexpr std::chrono::milliseconds kPatience{3000};

}  // namespace

class Job::Mpi : public calib::Ranks {
 public:
  Mpi(int* argc, char*** argv) {
    int provided = 0;
    MPI_Init_thread(argc, argv, MPI_THREAD_FUNNELED, &provided);
    MPI_Comm_size(MPI_COMM_WORLD, &count_);
    MPI_Comm_rank(MPI_COMM_WORLD, &index_);
    if (index_ == 0) return;
    // All ranks find the same errors, so only the first one reports them.
    stderr_ = dup(STDERR_FILENO);
    const int nowhere = open("/dev/null", O_WRONLY);
    if (nowhere < 0) return;
    dup2(nowhere, STDOUT_FILENO);
    dup2(nowhere, STDERR_FILENO);
    close(nowhere);
  }
  ~Mpi() override {
    int finalized = 0;
    MPI_Finalized(&finalized);
    if (finalized == 0) MPI_Finalize();
  }

  [[nodiscard]] int count() const override { return count_; }
  [[nodiscard]] int index() const override { return index_; }
  void sum(std::span<double> values) const override {
    // MPI counts in int. The last bit may differ between ranks, but all must make the same decisions, so the
    // first rank's result is used.
    constexpr std::size_t kMost = std::numeric_limits<int>::max() / 2;
    for (std::size_t first = 0; first < values.size(); first += kMost) {
      const int count = static_cast<int>(std::min(kMost, values.size() - first));
      MPI_Allreduce(MPI_IN_PLACE, values.data() + first, count, MPI_DOUBLE, MPI_SUM, MPI_COMM_WORLD);
      MPI_Bcast(values.data() + first, count, MPI_DOUBLE, 0, MPI_COMM_WORLD);
    }
  }

  [[nodiscard]] std::vector<std::string> gather(const std::string& text) const {
    const int mine = static_cast<int>(text.size());
    std::vector<int> sizes(static_cast<std::size_t>(count_)), first(sizes.size(), 0);
    MPI_Gather(&mine, 1, MPI_INT, sizes.data(), 1, MPI_INT, 0, MPI_COMM_WORLD);
    std::string all;
    if (index_ == 0) {
      for (std::size_t i = 1; i < sizes.size(); ++i) first[i] = first[i - 1] + sizes[i - 1];
      all.resize(static_cast<std::size_t>(first.back() + sizes.back()));
    }
    MPI_Gatherv(text.data(), mine, MPI_CHAR, all.data(), sizes.data(), first.data(), MPI_CHAR, 0,
                MPI_COMM_WORLD);
    std::vector<std::string> texts;
    for (std::size_t i = 0; index_ == 0 && i < sizes.size(); ++i)
      texts.push_back(all.substr(static_cast<std::size_t>(first[i]), static_cast<std::size_t>(sizes[i])));
    return texts;
  }

  int finish(int code) {
    std::fflush(nullptr);
    MPI_Request all_here = MPI_REQUEST_NULL;
    MPI_Ibarrier(MPI_COMM_WORLD, &all_here);
    const auto until = std::chrono::steady_clock::now() + kPatience;
    for (int here = 0; here == 0;) {
      MPI_Test(&all_here, &here, MPI_STATUS_IGNORE);
      if (here != 0) break;
      // A rank that succeeded waits for slower ones; a rank that failed would leave them waiting.
      if (code != 0 && std::chrono::steady_clock::now() > until) {
        if (stderr_ >= 0)
          dprintf(stderr_,
                  "octant: rank %d of %d failed with exit code %d; the job is ended, nothing was written\n",
                  index_, count_, code);
        MPI_Abort(MPI_COMM_WORLD, code);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    MPI_Finalize();
    return code;
  }

 private:
  int count_ = 1, index_ = 0, stderr_ = STDERR_FILENO;
};

Job::Job(int* argc, char*** argv) {
  if (was_launched()) mpi_ = std::make_unique<Mpi>(argc, argv);
}
Job::~Job() = default;
const calib::Ranks* Job::ranks() const { return mpi_ && mpi_->count() > 1 ? mpi_.get() : nullptr; }
std::vector<std::string> Job::gather(const std::string& text) const {
  return mpi_ ? mpi_->gather(text) : std::vector<std::string>{text};
}
int Job::finish(int code) { return mpi_ ? mpi_->finish(code) : code; }

}  // namespace octant::app

#endif
