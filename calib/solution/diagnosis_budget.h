// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <ctime>
#include <exception>
#include <string>

#include "calib/solution/solution.h"
#include "calib/solution/solve_options.h"

namespace octant::calib {

/// Processor time of the calling thread [s], so that a budget permits the same work on a loaded machine.
[[nodiscard]] inline double thread_time_s() {
  std::timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Bounds one step of a diagnosis by the time that is left of three times the time of the fit (45 s at
/// most) and SolveOptions::diagnosis_s, or of a share of that. The step's time counts when the object goes
/// out of scope.
class DiagnosisBudget {
 public:
  /// Options and diagnosis must outlive it.
  /// @param share  share of the whole time for all steps up to the end of this one
  DiagnosisBudget(const SolveOptions& options, Diagnosis& diagnosis, double share)
      : diagnosis_(diagnosis), options_(options), share_(share) {
    options_.ranks = nullptr;  // each rank diagnoses by itself
    options_.on_progress = [this, &options](const Progress&) {
      const bool goes_on =
          left_s() > 0 && (!options.on_progress ||
                           options.on_progress({"search for what contradicts the data", 0, 0.0, 0.97}));
      diagnosis_.is_cut_short = diagnosis_.is_cut_short || !goes_on;
      return goes_on;
    };
  }
  ~DiagnosisBudget() { diagnosis_.spent_s += passed_s(); }
  DiagnosisBudget(const DiagnosisBudget&) = delete;
  DiagnosisBudget& operator=(const DiagnosisBudget&) = delete;

  /// Options whose progress function ends adjustments when the time is over.
  [[nodiscard]] const SolveOptions& options() const { return options_; }

 private:
  static constexpr double kTimesOfFit = 3.0, kMostOfFit_s = 45.0;

  [[nodiscard]] double passed_s() const { return thread_time_s() - began_s_; }
  [[nodiscard]] double left_s() const {
    return share_ * (std::min(kTimesOfFit * diagnosis_.fit_s, kMostOfFit_s) + options_.diagnosis_s) -
           diagnosis_.spent_s - passed_s();
  }

  Diagnosis& diagnosis_;
  SolveOptions options_;
  double share_;
  double began_s_ = thread_time_s();
};

/// Runs one step of the diagnosis of a complete solution: work(options). A failure of the diagnosis leaves
/// the solution unchanged.
/// @param share  share of the whole time for all steps up to the end of this one
template <class Work>
void diagnose_within_budget(const SolveOptions& options, Solution& solution, double share, Work&& work) {
  const DiagnosisBudget budget(options, solution.diagnosis, share);
  try {
    work(budget.options());
  } catch (const std::exception& fault) {
    solution.diagnosis.is_cut_short = true;
    solution.warnings.push_back(std::string("The search for what contradicts the data failed (") +
                                fault.what() + "). The calibration itself is complete. Please report this.");
  }
}

}  // namespace octant::calib
