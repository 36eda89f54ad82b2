#include "app/protocol/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "app/device/open.hpp"
#include "app/files/published_json.hpp"
#include "app/job/model_chain.hpp"
#include "app/job/next_points_plan.hpp"
#include "app/job/run.hpp"
#include "app/job/stages.hpp"
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

Plan named_plan_of(const MeasureStep& step) {
  PlanRequest request{.name = step.plan, .groups = named_groups(step.plan)};
  request.set = step.set;
  request.approaches = {step.approach};
  return build_plan(request);
}

std::string stage_of(const Protocol& protocol) {
  return "sim:" + std::filesystem::absolute(protocol.robot).lexically_normal().string();
}

std::optional<store::SessionRow> stored_session(store::Connection* connection,
                                                const Protocol& protocol, const std::string& name) {
  if (connection == nullptr) return std::nullopt;
  const auto campaign = store::find_campaign(*connection, protocol.name);
  return campaign ? store::find_session(*connection, campaign->id, name) : std::nullopt;
}

/// Whether a step asks for both: only readings left out, or another version, tell them apart.
bool same_step(const store::Job& a, const store::Job& b) {
  if (a.data.stage != b.data.stage || a.data.sessions != b.data.sessions) return false;
  const job::Stage& stage = job::find_stage(a.data.stage);
  return job::completed(stage, job::Json::parse(a.data.parameters_json)) ==
         job::completed(stage, job::Json::parse(b.data.parameters_json));
}

/// The job a session is measured with: one that has begun goes on with the job it began with, as
/// long as its step asks for the same.
store::Id correction_of_step(Run& run, const std::optional<store::SessionRow>& stored,
                             const std::string& step) {
  const store::Id now = run.jobs.at(step);
  if (!stored || !stored->compensation_job) return now;
  const bool same = same_step(store::get_job(run.connection, *stored->compensation_job),
                              store::get_job(run.connection, now));
  return same ? *stored->compensation_job : now;
}

/// Suggested points that were begun stay, whatever their diagnosis would suggest by now.
session::Outcome measured(Run& run, const session::Request& request, bool begun_suggestion) {
  return begun_suggestion
             ? session::resume(run.connection, request.campaign, request.session, run.surroundings)
             : session::run_or_resume(run.connection, request, run.surroundings);
}

StepOutcome run_step(Run& run, const std::string& name, const MeasureStep& step) {
  const auto stored = stored_session(&run.connection, run.protocol, name);
  const bool suggested = !step.next_points_of.empty();
  session::Request request;
  request.campaign = run.protocol.name;
  request.session = name;
  request.plan = suggested ? run.next_points.at(step.next_points_of) : named_plan_of(step);
  if (!stored && request.plan.points.empty()) {
    run.skipped.insert(name);
    return {.name = name,
            .kind = "measure",
            .skipped = true,
            .detail = fmt::format("skipped: {} suggests no points", step.next_points_of)};
  }
  request.stage = stage_of(run.protocol);
  if (!run.protocol.published.empty()) request.facts[kPublishedFact] = run.protocol.published;
  if (step.compensate) {
    request.compensation_job = correction_of_step(run, stored, *step.compensate);
  }
  const session::Outcome outcome = measured(run, request, stored && suggested);
  return {.name = name,
          .kind = "measure",
          .done_before = outcome.n_stored == 0 && outcome.n_before == outcome.n_points,
          .detail = outcome.exit_code() == ExitCode::ok
                        ? fmt::format("{} points", outcome.n_points)
                        : fmt::format("{} of {} points: {}", outcome.n_before + outcome.n_stored,
                                      outcome.n_points, outcome.detail),
          .violations = outcome.violations,
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

bool is_done(const std::optional<store::SessionRow>& session) {
  return session && session->n_ok == session->n_points && session->last_event == "done";
}

StepOutcome look_at(store::Connection* connection, const Protocol& protocol,
                    const std::string& name, const MeasureStep& step) {
  const auto session = stored_session(connection, protocol, name);
  StepOutcome outcome{.name = name, .kind = "measure", .done_before = is_done(session)};
  if (session) {
    outcome.detail = fmt::format("{} of {} points to measure", session->n_points - session->n_ok,
                                 session->n_points);
  } else if (step.next_points_of.empty()) {
    const std::size_t n = named_plan(step.plan, step.set).points.size();
    outcome.detail = fmt::format("{} of {} points to measure", n, n);
  } else {
    outcome.detail = fmt::format("the points that {} suggests", step.next_points_of);
  }
  return outcome;
}

/// A step that computes: its job is known once all its sessions are measured.
StepOutcome look_at_job(store::Connection* connection, const Protocol& protocol,
                        StepOutcome outcome, const job::Request& request) {
  const bool measured = std::all_of(request.sessions.begin(), request.sessions.end(),
                                    [&](const std::string& session) {
                                      return is_done(stored_session(connection, protocol, session));
                                    });
  outcome.detail = request.stage + " to compute";
  if (!measured) return outcome;
  const store::NewJob inputs = job::inputs_of(*connection, request);
  if (const auto job = store::find_job(*connection, inputs.campaign_id, inputs.key.key)) {
    outcome.done_before = true;
    outcome.detail = fmt::format("{}, job {}", request.stage, job->id);
  }
  return outcome;
}

StepOutcome look_at(store::Connection* connection, const Protocol& protocol,
                    const std::string& name, const CalibrateStep& step) {
  return look_at_job(connection, protocol, {.name = name, .kind = "calibrate"},
                     {.campaign = protocol.name,
                      .stage = step.method,
                      .parameters = step.parameters,
                      .sessions = step.sessions});
}

StepOutcome look_at(store::Connection* connection, const Protocol& protocol,
                    const std::string& name, const DiagnoseStep& step) {
  // sessions of suggested points that were skipped do not exist
  std::vector<std::string> sessions;
  for (const std::string& session : step.sessions) {
    const auto planned = std::find_if(protocol.steps.begin(), protocol.steps.end(),
                                      [&](const Step& s) { return s.name == session; });
    const auto* measure = std::get_if<MeasureStep>(&planned->what);
    const bool suggested = measure != nullptr && !measure->next_points_of.empty();
    if (!suggested || stored_session(connection, protocol, session)) sessions.push_back(session);
  }
  return look_at_job(connection, protocol, {.name = name, .kind = "diagnose"},
                     {.campaign = protocol.name,
                      .stage = "diagnose",
                      .parameters = step.parameters,
                      .sessions = sessions});
}

}  // namespace

std::vector<StepOutcome> preflight(const Protocol& protocol) {
  std::vector<StepOutcome> unsafe;
  std::set<std::pair<std::string, Approach>> seen;
  static_cast<void>(device::open_devices(stage_of(protocol), "sim"));
  for (const Step& step : protocol.steps) {
    const auto* measure = std::get_if<MeasureStep>(&step.what);
    if (measure == nullptr || !measure->next_points_of.empty()) continue;
    if (!seen.insert({measure->plan, measure->approach}).second) continue;
    const session::Request request{.campaign = protocol.name,
                                   .session = step.name,
                                   .plan = named_plan_of(*measure),
                                   .stage = stage_of(protocol)};
    const session::Outcome outcome = session::dry_run(request, NominalCorrection{});
    if (outcome.violations.empty()) continue;
    unsafe.push_back({.name = step.name,
                      .kind = "measure",
                      .detail = fmt::format("0 of {} points: {}", outcome.n_points, outcome.detail),
                      .violations = outcome.violations,
                      .code = outcome.exit_code()});
  }
  return unsafe;
}

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
