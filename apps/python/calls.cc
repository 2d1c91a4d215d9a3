// SPDX-FileCopyrightText: 2026 Octant developers
// SPDX-License-Identifier: Apache-2.0
#include "apps/python/calls.h"

#include <string>
#include <utility>
#include <vector>

#include <pybind11/stl.h>

#include "apps/octant/interrupt.h"
#include "apps/octant/session.h"
#include "apps/octant/steps/revisiting.h"
#include "apps/octant/steps/steps.h"
#include "apps/octant/survey_input.h"
#include "apps/octant/text/survey_text.h"
#include "io/deployment/deployment_json.h"
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

py::object check(const std::string& site, const std::vector<std::string>& runs, bool strict, int threads) {
  return Call(words_of("check", site, runs), threads).run([&](app::Session& session) {
    return app::check_recordings({site, runs, strict}, session);
  });
}

py::tuple calibrate(const std::string& site, const std::vector<std::string>& runs, bool strict, bool accept,
                    int threads) {
  Call call(words_of("calibrate", site, runs), threads);
  std::optional<Deployment> deployment;
  const py::object object = call.run([&](app::Session& session) {
    auto calibration = app::calibrate_files(site, runs, {.strict = strict, .accept = accept}, session);
    Json result = app::calibration_json(calibration, session);
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
