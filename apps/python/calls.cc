// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/python/calls.h"

#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <pybind11/stl.h>

#include "apps/octant/interrupt.h"
#include "apps/octant/session.h"
#include "apps/octant/steps/reporting.h"
#include "apps/octant/steps/revisiting.h"
#include "apps/octant/steps/steps.h"
#include "apps/octant/survey_input.h"
#include "apps/octant/text/survey_text.h"
#include "apps/python/run.h"
#include "io/deployment/deployment_json.h"
#include "io/site/site_yaml.h"
#include "io/text/atomic_file.h"
#include "survey/map/survey.h"
#include "survey/schedule/floor_schedule.h"

namespace octant::python {
namespace {

namespace py = pybind11;
using namespace py::literals;
using app::Json;

py::object to_python(const Json& json) { return py::module_::import("json").attr("loads")(app::dump(json)); }

[[noreturn]] void raise_object(const Json& object) {
  py::module_::import("octant.errors").attr("raise_failure")(to_python(object));
  throw py::error_already_set();
}

/// A session without a terminal, whose result is stored here.
struct Call {
  explicit Call(const std::string& words, int threads) {
    app::Session any;
    any.options.progress = "none";
    any.command_line = words;
    session = any.part(threads);
    session.object = &object;
  }
  Json object;
  app::Session session;

  /// Runs work(session), which must end with one of the session's final calls, without Python's lock. Ctrl-C
  /// interrupts it.
  template <class Work>
  py::object run(Work&& work) {
    int exit = 0;
    {
      const app::PoliteInterrupts until_done;
      const py::gil_scoped_release others_may_run;
      try {
        exit = work(session);
      } catch (const app::CommandFailed& ended) {
        exit = session.fail(ended.failure);
      }
      if (exit != app::kDone && app::interrupted()) exit = session.fail(app::interruption());
    }
    // Ctrl-C while Python was not running: raises KeyboardInterrupt on the main thread.
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (exit != app::kDone) raise_object(object);
    return to_python(object);
  }
};

std::string words_of(const char* command, const std::string& first, const std::vector<std::string>& runs) {
  std::string words = std::string("octant.") + command + " " + first;
  for (const std::string& run : runs) words += " " + run;
  return words;
}

/// Sites and recordings come as values or as paths of their files.
using SiteOrPath = std::variant<Site, std::string>;
using RunOrPath = std::variant<Run, std::string>;

std::string name_of(const SiteOrPath& site) {
  if (const auto* path = std::get_if<std::string>(&site)) return *path;
  const std::string& path = std::get<Site>(site).path;
  return path.empty() ? "(Site)" : path;
}
std::string name_of(const RunOrPath& run) {
  if (const auto* path = std::get_if<std::string>(&run)) return *path;
  const std::string& path = std::get<Run>(run).log.path;
  return path.empty() ? "(Run)" : path;
}

template <class Runs>
std::string words_of(const char* command, const SiteOrPath& site, const Runs& runs) {
  std::vector<std::string> names;
  for (const auto& run : runs) names.push_back(name_of(run));
  return words_of(command, name_of(site), names);
}

Site site_of(const SiteOrPath& given, app::Session& session) {
  const auto* path = std::get_if<std::string>(&given);
  Site site = path != nullptr ? app::need(io::read_site(*path)) : std::get<Site>(given);
  if (site.path.empty()) site.path = name_of(given);
  session.warn(site.warnings);
  return site;
}

std::vector<MeasurementLog> runs_of(const std::vector<RunOrPath>& given, const Site& site,
                                    app::Session& session) {
  std::vector<MeasurementLog> runs;
  for (const RunOrPath& one : given) {
    if (const auto* path = std::get_if<std::string>(&one)) {
      for (MeasurementLog& run : app::read_runs({*path}, site, {}, session)) runs.push_back(std::move(run));
      continue;
    }
    const Run& run = std::get<Run>(one);
    if (!same_names(run.names, names_of(site)))
      app::fail_with({.code = Errc::kUsage,
                      .file = name_of(one),
                      .found = "a run whose numbers stand for other names than the site's",
                      .expected = "a run of this site",
                      .advice = "read it with octant.read_run(folder, site), or make it with "
                                "octant.make_run(site, ...)"});
    runs.push_back(run.log);
    runs.back().path = name_of(one);
    session.warn(run.log.warnings);
  }
  return runs;
}

/// Paths, where all are given as paths: recordings that are too long for memory can be streamed then.
std::optional<std::vector<std::string>> all_paths(const SiteOrPath& site,
                                                  const std::vector<RunOrPath>& runs) {
  if (!std::holds_alternative<std::string>(site)) return std::nullopt;
  std::vector<std::string> paths;
  for (const RunOrPath& run : runs) {
    if (!std::holds_alternative<std::string>(run)) return std::nullopt;
    paths.push_back(std::get<std::string>(run));
  }
  return paths;
}

py::object check(const SiteOrPath& site, const std::vector<RunOrPath>& runs, bool strict, int threads) {
  return Call(words_of("check", site, runs), threads).run([&](app::Session& session) {
    Site known = site_of(site, session);
    std::vector<MeasurementLog> logs = runs_of(runs, known, session);
    return app::check_recordings(std::move(known), std::move(logs), strict, session);
  });
}

py::tuple calibrate(const SiteOrPath& site, const std::vector<RunOrPath>& runs, bool strict, bool accept,
                    int threads) {
  Call call(words_of("calibrate", site, runs), threads);
  std::optional<Deployment> deployment;
  const py::object object = call.run([&](app::Session& session) {
    const app::CalibrateOptions how{.strict = strict, .accept = accept};
    const auto calibrated = [&] {
      if (const auto paths = all_paths(site, runs))
        return app::calibrate_files(std::get<std::string>(site), *paths, how, session);
      Site known = site_of(site, session);
      std::vector<MeasurementLog> logs = runs_of(runs, known, session);
      const std::string sha256 = io::sha256_hex(io::site_to_yaml(known));
      return app::calibrate_runs(std::move(known), std::move(logs), sha256, how, session);
    };
    app::Calibration calibration = calibrated();
    Json result = app::calibration_json(calibration, session);
    result["verdict"] = app::verdict_json(app::calibration_report(calibration, {}, session));
    if (calibration.exported()) deployment = std::move(calibration.deployment);
    if (const auto failure = app::failure_of(calibration); failure && !deployment)
      return session.fail(*failure, result);
    return session.finish(result);
  });
  return py::make_tuple(std::move(deployment), object);
}

py::object verify(const std::string& path, const std::vector<std::string>& runs, const std::string& method,
                  int threads) {
  return Call(words_of("verify", path, runs), threads).run([&](app::Session& session) {
    const Deployment deployment = app::need(io::read_deployment(path));
    Method how = Method::kAuto;
    for (const auto& [name, value] : method_names())
      if (name == method) how = value;
    const auto read = app::read_runs(runs, deployment,
                                     {.read_truth = true, .read_poses = how == Method::kLineMap}, session);
    const auto located = app::need(app::localize_runs(deployment, read, how));
    const auto evaluation = app::verify_fixes(deployment, read, located);
    if (const std::string doubt = app::doubt_of_sigmas(evaluation, deployment.motion); !doubt.empty())
      session.warn(doubt);
    return session.finish(app::evaluation_json(evaluation));
  });
}

py::object survey(const std::string& input, const std::string& scene, std::size_t bins, int failures,
                  int threads) {
  return Call(words_of("survey", input, {}), threads).run([&](app::Session& session) {
    const auto read = app::read_survey_input(input, scene, "", std::nullopt, session);
    const survey::Survey found =
        app::need(survey::run_survey(read.model, read.scene, read.deployment ? &*read.deployment : nullptr,
                                     {.threads = session.threads(), .failures = failures}));
    const auto schedule = survey::schedule_of_survey(found.model, found.scene, session.threads());
    return session.finish(app::survey_json(found, schedule, bins));
  });
}

py::object monitor(const std::string& deployment, const std::vector<std::string>& runs, int threads) {
  return Call(words_of("monitor", deployment, runs), threads).run([&](app::Session& session) {
    const app::SecondVisitFiles visit = app::revisit_files(deployment, runs, {}, session);
    Json object = visit.head;
    object.update(app::revisit_json(visit, session));
    if (const auto failure = app::failure_of(visit.revisit)) return session.fail(*failure, object);
    object["action"] = false;
    for (const Change& c : visit.revisit.comparison.changes)
      if (app::needs_action(c, visit.revisit.medium)) object["action"] = true;
    return session.finish(object);
  });
}

}  // namespace

void raise(const Error& error) { raise_object(app::failure_of(error).object()); }

void bind_calls(py::module_& m) {
  m.def("check", &check, "site"_a, "runs"_a, "strict"_a = false, "threads"_a = 0);
  m.def("calibrate", &calibrate, "site"_a, "runs"_a, "strict"_a = false, "accept"_a = false, "threads"_a = 0);
  m.def("verify", &verify, "deployment"_a, "runs"_a, "method"_a = "auto", "threads"_a = 0);
  m.def("survey", &survey, "input"_a, "scene"_a = "", "bins"_a = 0, "failures"_a = 2, "threads"_a = 0);
  m.def("monitor", &monitor, "deployment"_a, "runs"_a, "threads"_a = 0);
}

}  // namespace octant::python
