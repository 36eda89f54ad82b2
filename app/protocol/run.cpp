#include "app/protocol/run.hpp"

#include <fmt/format.h>

#include <map>
#include <set>

#include "app/job/model_chain.hpp"
#include "app/job/next_points_plan.hpp"
#include "app/job/run.hpp"
#include "core/plan/named.hpp"

namespace trammel::protocol {

namespace {

/// What the steps of one run share.
struct Run {
  store::Connection& connection;
  const Protocol& protocol;
  session::Surroundings surroundings;
  std::map<std::string, store::Id> jobs = {};    // by step
  std::map<std::string, Plan> next_points = {};  // by diagnose step
  std::set<std::string> skipped = {};            // measure steps
};

Plan plan_of(const Run& run, const MeasureStep& step) {
  if (!step.next_points_of.empty()) return run.next_points.at(step.next_points_of);
  PlanRequest request{.name = step.plan, .groups = named_groups(step.plan)};
  request.set = step.set;
  request.approaches = {step.approach};
  return build_plan(request);
}

StepOutcome run_step(Run& run, const std::string& name, const MeasureStep& step) {
  session::Request request;
  request.campaign = run.protocol.name;
  request.session = name;
  request.plan = plan_of(run, step);
  if (request.plan.points.empty()) {
    run.skipped.insert(name);
    return {.name = name,
            .kind = "measure",
            .skipped = true,
            .detail = fmt::format("skipped: {} suggests no points", step.next_points_of)};
  }
  request.stage =
      "sim:" + std::filesystem::absolute(run.protocol.robot).lexically_normal().string();
  if (step.compensate) request.compensation_job = run.jobs.at(*step.compensate);
  const session::Outcome outcome =
      session::run_or_resume(run.connection, request, run.surroundings);
  return {.name = name,
          .kind = "measure",
          .done_before = outcome.n_stored == 0 && outcome.n_before == outcome.n_points,
          .detail = outcome.exit_code() == ExitCode::ok
                        ? fmt::format("{} points", outcome.n_points)
                        : fmt::format("{} of {} points: {}", outcome.n_before + outcome.n_stored,
                                      outcome.n_points, outcome.detail),
          .code = outcome.exit_code()};
}

/// The job of a step on those of its sessions that were measured.
job::Outcome run_job(Run& run, const std::string& name, const std::string& stage,
                     const std::vector<std::string>& sessions, const job::Json& parameters) {
  job::Request request{
      .campaign = run.protocol.name, .stage = stage, .parameters = parameters, .sessions = {}};
  for (const std::string& session : sessions) {
    if (!run.skipped.contains(session)) request.sessions.push_back(session);
  }
  job::Outcome outcome = job::run(run.connection, request);
  run.jobs[name] = outcome.job.id;
  return outcome;
}

StepOutcome run_step(Run& run, const std::string& name, const CalibrateStep& step) {
  const job::Outcome outcome = run_job(run, name, step.method, step.sessions, step.parameters);
  return {.name = name,
          .kind = "calibrate",
          .done_before = outcome.reused,
          .detail = fmt::format("{}, job {}", step.method, outcome.job.id)};
}

StepOutcome run_step(Run& run, const std::string& name, const DiagnoseStep& step) {
  const job::Outcome outcome = run_job(run, name, "diagnose", step.sessions, step.parameters);
  job::store_model_chain(run.connection, outcome.job);
  const job::Json details = job::Json::parse(outcome.job.data.result_json)["details"];
  run.next_points[name] = job::next_points_plan(details);
  std::string named;
  for (const job::Json& effect : details["effects"]) {
    named += (named.empty() ? ": " : " + ") + effect["name"].get<std::string>();
  }
  return {.name = name,
          .kind = "diagnose",
          .done_before = outcome.reused,
          .detail = fmt::format("{}{}, job {}", details["verdict"].get<std::string>(), named,
                                outcome.job.id)};
}

}  // namespace

Outcome run(store::Connection& connection, const Protocol& protocol,
            const session::Surroundings& surroundings,
            const std::function<void(const StepOutcome&)>& tell) {
  Run state{connection, protocol, surroundings};
  Outcome outcome;
  for (const Step& step : protocol.steps) {
    const auto execute = [&](const auto& what) { return run_step(state, step.name, what); };
    outcome.steps.push_back(std::visit(execute, step.what));
    tell(outcome.steps.back());
    outcome.code = outcome.steps.back().code;
    if (outcome.code != ExitCode::ok) break;
  }
  return outcome;
}

}  // namespace trammel::protocol
