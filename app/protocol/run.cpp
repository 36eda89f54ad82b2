#include "app/protocol/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "app/job/run.hpp"
#include "core/plan/build.hpp"

namespace trammel::protocol {

namespace {

/// What the steps of one run share.
struct Run {
  store::Connection& connection;
  const Protocol& protocol;
  session::Surroundings surroundings;
  std::map<std::string, store::Id> jobs;  // by step
};

StepOutcome run_step(Run& run, const std::string& name, const MeasureStep& step) {
  session::Request request;
  request.campaign = run.protocol.name;
  request.session = name;
  request.plan = named_plan(step.plan, step.set);
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

StepOutcome run_step(Run& run, const std::string& name, const CalibrateStep& step) {
  const job::Outcome outcome = job::run(run.connection, {.campaign = run.protocol.name,
                                                         .stage = step.method,
                                                         .parameters = step.parameters,
                                                         .sessions = step.sessions});
  run.jobs[name] = outcome.job.id;
  return {.name = name,
          .kind = "calibrate",
          .done_before = outcome.reused,
          .detail = fmt::format("{}, job {}", step.method, outcome.job.id)};
}

bool is_done(const std::optional<store::SessionRow>& session) {
  return session && session->n_ok == session->n_points && session->last_event == "done";
}

std::optional<store::SessionRow> stored_session(store::Connection* connection,
                                                const Protocol& protocol, const std::string& name) {
  if (connection == nullptr) return std::nullopt;
  const auto campaign = store::find_campaign(*connection, protocol.name);
  return campaign ? store::find_session(*connection, campaign->id, name) : std::nullopt;
}

StepOutcome look_at(store::Connection* connection, const Protocol& protocol,
                    const std::string& name, const MeasureStep& step) {
  const auto session = stored_session(connection, protocol, name);
  const std::size_t n = named_plan(step.plan, step.set).points.size();
  return {.name = name,
          .kind = "measure",
          .done_before = is_done(session),
          .detail = fmt::format("{} of {} points to measure",
                                n - static_cast<std::size_t>(session ? session->n_ok : 0), n)};
}

StepOutcome look_at(store::Connection* connection, const Protocol& protocol,
                    const std::string& name, const CalibrateStep& step) {
  const bool measured =
      std::all_of(step.sessions.begin(), step.sessions.end(), [&](const std::string& session) {
        return is_done(stored_session(connection, protocol, session));
      });
  StepOutcome outcome{.name = name, .kind = "calibrate", .detail = step.method + " to compute"};
  if (!measured) return outcome;
  const store::JobKey key = job::key_of(*connection, {.campaign = protocol.name,
                                                      .stage = step.method,
                                                      .parameters = step.parameters,
                                                      .sessions = step.sessions});
  if (const auto job = store::find_job(*connection, key.key)) {
    outcome.done_before = true;
    outcome.detail = fmt::format("{}, job {}", step.method, job->id);
  }
  return outcome;
}

}  // namespace

std::vector<StepOutcome> dry_run(store::Connection* connection, const Protocol& protocol) {
  std::vector<StepOutcome> steps;
  for (const Step& step : protocol.steps) {
    const auto look = [&](const auto& what) {
      return look_at(connection, protocol, step.name, what);
    };
    steps.push_back(std::visit(look, step.what));
  }
  return steps;
}

Plan named_plan(const std::string& name, ReadingSet set) {
  PlanRequest request;
  request.name = name;
  request.set = set;
  if (name == "paper-80") {
    request.groups = {{.name = {}, .poses = paper_80()}};
  } else if (name == "paper-48") {
    request.groups = {{.name = {}, .poses = paper_48()}};
  } else if (name == "circles") {
    for (const Circle& c : paper_circles()) {
      request.groups.push_back(
          {.name = fmt::format("circle {}", request.groups.size() + 1), .poses = circle(c)});
    }
  } else {
    throw InputError(
        {.what = "unknown plan", .got = name, .expected = "paper-80, paper-48 or circles"});
  }
  return build_plan(request);
}

Outcome run(store::Connection& connection, const Protocol& protocol,
            const session::Surroundings& surroundings,
            const std::function<void(const StepOutcome&)>& tell) {
  Run state{connection, protocol, surroundings, {}};
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
