// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "calib/calibrate.h"

#include <fmt/format.h>

#include "apps/octant/commands.h"
#include "apps/octant/interrupt.h"
#include "apps/octant/outputs.h"
#include "apps/octant/ranks.h"
#include "apps/octant/steps/reporting.h"
#include "apps/octant/text/changes_text.h"
#include "apps/octant/text/layout.h"
#include "calib/solution/variances.h"
#include "io/deployment/deployment_json.h"
#include "io/text/atomic_file.h"

namespace octant::app {
namespace {

struct CalibrateArgs {
  std::string site, output;
  ReportArgs report;
  std::vector<std::string> runs;
  CalibrateOptions options;
};

/// Results of the adjustment, which exist even if there is no deployment to export.
Json solution_json(const Calibration& c, const Session& session) {
  const calib::Solution& s = c.solution;
  return {{"converged", s.status == calib::SolveStatus::kConverged},
          {"iterations", s.iterations},
          {"seconds", session.seconds()},
          {"arrivals", s.statistics.arrivals},
          {"rejected", s.statistics.rejected},
          {"unknowns", s.statistics.unknowns},
          {"redundancy", s.statistics.redundancy},
          {"variance_factor", s.statistics.variance_factor},
          {"chi2_p", s.statistics.chi2_p},
          {"rms_s", s.statistics.rms_s},
          {"speed_mps", nullptr},
          {"speed_sigma_mps", nullptr},
          {"beacons", Json::array()},
          {"receivers", Json::array()},
          {"attenuation", nullptr},
          {"undetermined", s.undetermined},
          {"weak", weak_json(s.weak)},
          {"datum",
           {{"description", s.datum.description},
            {"position", s.datum.position},
            {"orientation", s.datum.orientation},
            {"scale", s.datum.scale},
            {"control_points", s.datum.control_points}}},
          {"left_out", left_out_json(c)},
          {"streamed",
           s.totals ? Json{{"epochs", s.totals->epochs}, {"every", s.totals->stride}} : Json(nullptr)},
          {"reliability", reliability_json(c)}};
}

}  // namespace

void add_deployment_json(const Deployment& d, Json& object) {
  for (const char* list : {"beacons", "receivers"}) object[list] = Json::array();
  object["speed_mps"] = d.speed_mps(d.medium.temperature_degC);
  object["speed_sigma_mps"] = d.speed_sigma_mps;
  for (const auto& b : d.beacons) {
    const Eigen::Vector3d sigma_m = b.covariance_m2.diagonal().cwiseMax(0.0).cwiseSqrt();
    object["beacons"].push_back({{"id", b.name},
                                 {"position_m", b.position_m},
                                 {"sigma_m", sigma_m},
                                 {"delay_s", b.delay_s},
                                 {"delay_sigma_s", b.delay_sigma_s},
                                 {"status", to_string(b.status)}});
  }
  for (const auto& r : d.receivers) {
    object["receivers"].push_back(
        {{"vehicle", d.vehicles[r.vehicle.index()].name}, {"id", r.name}, {"position_m", r.position_m}});
  }
  if (d.attenuation) {
    object["attenuation"] = {{"amplitude_1m_v", d.attenuation->amplitude_1m_v},
                             {"absorption_np_per_m", d.attenuation->absorption_np_per_m},
                             {"threshold_v", d.attenuation->threshold_v},
                             {"rise_time_s", d.attenuation->rise_time_s}};
    if (d.attenuation->directional())
      object["attenuation"]["half_power_angle_rad"] = d.attenuation->half_power_angle_rad;
  }
}

std::optional<Failure> failure_of(const Calibration& calibration) {
  const calib::Solution& s = calibration.solution;
  if (s.status == calib::SolveStatus::kUndetermined) {
    std::string message = s.message.empty() ? "the data do not determine what is asked for" : s.message,
                advice;
    if (s.message.empty())
      for (const auto& name : s.undetermined)
        message += (&name == &s.undetermined.front() ? ": " : ", ") + name;
    for (const Contradiction& c : s.contradictions) {
      message += "; " + in_words(c);
      advice += (advice.empty() ? "" : "; ") + c.remedy;
    }
    for (const auto& weak : s.weak) {
      // The message of the solver may already include the remedy.
      if (!weak.blocking || weak.remedy.empty() || message.find(weak.remedy) != std::string::npos) continue;
      advice += (advice.empty() ? "remedy: " : "; ") + weak.remedy;
    }
    return Failure{"undetermined", "undetermined", kUndetermined, message, advice};
  }
  if (!s.contradictions.empty()) {
    std::string message = "the data contradict what was stated", advice;
    for (const Contradiction& c : s.contradictions) {
      message += (&c == &s.contradictions.front() ? ": " : "; ") + in_words(c);
      if (advice.find(c.remedy) == std::string::npos) advice += (advice.empty() ? "" : "; ") + c.remedy;
    }
    if (calibration.deployment && !calibration.accepted)
      advice += "; --accept exports it all the same, marked";
    return Failure{"contradicted", "contradicted", kGateFailed, message, advice};
  }
  if (calibration.deployment) return std::nullopt;
  return Failure{"not_converged", "not_converged", kNotConverged,
                 s.message.empty() ? "the adjustment did not converge" : s.message,
                 "are the units, the beacon ids and the approximate positions right?"};
}

Json calibration_json(const Calibration& calibration, const Session& session) {
  Json object = solution_json(calibration, session);
  for (const calib::ClockResult& c : calibration.clocks)
    object["clocks"].push_back({{"id", c.name},
                                {"run", c.run + 1},
                                {"time_s", c.time_s},
                                {"offset_s", c.offset_s},
                                {"offset_sigma_s", c.offset_sigma_s},
                                {"rate", c.rate},
                                {"rate_sigma", c.rate_sigma}});
  if (!calibration.deployment) return object;
  add_deployment_json(*calibration.deployment, object);
  for (std::size_t b = 0; b < object["beacons"].size(); ++b) {
    Json& beacon = object["beacons"][b];
    const auto white = calib::white_sigma_m(calibration.solution, b);
    beacon["white_sigma_m"] = white ? Json(*white) : beacon["sigma_m"];
  }
  return object;
}

namespace {

/// Changes since an earlier deployment. If the result is contradicted, they may be due to the contradiction.
std::string comparison_text(const Calibration& calibration, const survey::ReportInput& input) {
  std::string text = changes_text(input);
  if (!text.empty() && !calibration.solution.contradictions.empty())
    text += named_line("",
                       "this comparison hangs on what is contradicted; octant recalibrate OLD.json RUN "
                       "tells what moved");
  return text;
}

int run(const CalibrateArgs& args, Session& session) {
  check_outputs(with_files(args.runs, {args.site, args.report.since}),
                report_outputs(args.report, {{"-o", args.output}}), session);
  check_report(args.report);

  const Calibration calibration = calibrate_files(args.site, args.runs, args.options, session);
  Json object = calibration_json(calibration, session);
  const auto failure = failure_of(calibration);
  if (session.job != nullptr && !session.job->is_first())  // only the first rank writes
    return failure ? session.fail(*failure, object) : kDone;

  const survey::ReportInput input = calibration_report(calibration, args.report, session);
  object["verdict"] = verdict_json(input);
  add_changes_json(input, object);
  write_calibration(args.output, args.report, calibration, input);
  if (!calibration.deployment) {
    session.result(report_lines(args.report));
    return session.fail(*failure, object);
  }
  session.result(calibration_summary(calibration, input) + comparison_text(calibration, input));
  if (calibration.exported() && args.output != "-")
    session.result(fmt::format("{:<17}{}\n", "deployment", args.output));
  session.result(report_lines(args.report));
  if (session.options.verbose > 0) session.result("\n" + calibration_text(calibration));
  return failure ? session.fail(*failure, object) : session.finish(object);
}

}  // namespace

void add_calibrate(CLI::App& app, CommonOptions& common, Action& action) {
  const auto [command, args] = add_command<CalibrateArgs>(
      app, common, action, "calibrate", "Find beacons, delays, speed and receivers from recordings",
      "octant calibrate hall/site.yaml hall/run -o hall/deployment.json --report hall/report.html", run);
  add_required_option(*command, "site", args->site, "SITE.yaml", "Site file: what is known beforehand");
  add_required_option(*command, "run", args->runs, "RUN", "Run folders: the recordings");
  add_required_option(*command, "-o,--output", args->output, "DEPLOYMENT.json",
                      "Deployment file to write; - is standard output");
  add_report_options(*command, args->report, true);
  command->add_flag("--strict", args->options.strict, "A single undetermined beacon is exit 5");
  command->add_flag("--accept", args->options.accept,
                    "Write the deployment, marked, although the data contradict what the site file states "
                    "(exit 6 all the same)");
  add_option(*command, "--memory-mb", args->options.memory_mb, "N",
             "Bound of the memory: recordings of stops or drives that would take more are read in chunks, "
             "several times")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1} << 30));
}

}  // namespace octant::app
