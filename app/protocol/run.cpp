#include "app/protocol/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <utility>

#include "app/device/open.hpp"
#include "app/files/files.hpp"
#include "app/files/plan_json.hpp"
#include "app/files/published_json.hpp"
#include "app/job/model_chain.hpp"
#include "app/job/next_points_plan.hpp"
#include "app/job/run.hpp"
#include "app/job/stages.hpp"
#include "app/report/dcc.hpp"
#include "app/report/gather.hpp"
#include "app/report/page/page.hpp"
#include "app/report/print.hpp"
#include "app/report/tolerance.hpp"
#include "app/terminal/counted.hpp"
#include "app/terminal/text.hpp"

namespace trammel::protocol {

namespace {

/// What the steps of one run share.
struct Run {
  store::Connection& connection;
  const Protocol& protocol;
  const Requests& requests;
  session::Surroundings surroundings;
  const Person& person;
  std::map<std::string, store::Id> jobs = {};    // by step
  std::map<std::string, Plan> next_points = {};  // by diagnose step
  std::set<std::string> skipped = {};            // measure steps
  std::vector<std::string> confirmed = {};       // since the last measure step
};

Plan plan_of_step(const MeasureStep& step, const Machine& machine) {
  if (step.suggested()) return {};  // not known yet
  const auto* file = std::get_if<std::filesystem::path>(&step.plan);
  Plan plan = file != nullptr ? read_plan(*file)
                              : job::grid_plan(std::get<job::GridRequest>(step.plan), machine).plan;
  for (PlannedPoint& point : plan.points) point.set = step.set.value_or(point.set);
  return plan;
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

/// A real stage walks suggested points when somebody has looked at them.
std::string record_of_suggested(const session::Request& request, const std::string& record) {
  return fmt::format(
      "the points are suggested by now: `trammel plan create next-points --campaign {} --out "
      "next.json`, `trammel plan check next.json --mechanism {} --record {}`, then again",
      terminal::shell_word(request.campaign),
      terminal::shell_word(request.stage.substr(request.stage.find(':') + 1)),
      terminal::shell_word(record));
}

StepOutcome outcome_of(const std::string& name, const session::Outcome& outcome) {
  return {.name = name,
          .kind = "measure",
          .done_before = outcome.n_stored == 0 && outcome.n_before == outcome.n_points,
          .detail = outcome.exit_code() == ExitCode::ok
                        ? terminal::counted(outcome.n_points, "point")
                        : fmt::format("{} of {}: {}", outcome.n_before + outcome.n_stored,
                                      terminal::counted(outcome.n_points, "point"), outcome.detail),
          .violations = outcome.violations,
          .missing = outcome.missing,
          .estimated_s = outcome.estimated_s,
          .code = outcome.exit_code()};
}

StepOutcome run_step(Run& run, const std::string& name, const MeasureStep& step) {
  const auto stored = stored_session(&run.connection, run.protocol, name);
  session::Request request = run.requests.at(name);
  if (const auto* next = std::get_if<NextPointsOf>(&step.plan)) {
    request.plan = run.next_points.at(next->step);
    if (!stored && request.plan.points.empty()) {
      run.skipped.insert(name);
      run.confirmed.clear();
      return {.name = name,
              .kind = "measure",
              .skipped = true,
              .detail = fmt::format("skipped: {} suggests no points", next->step)};
    }
    if (!std::filesystem::exists(request.plan_check)) request.plan_check.clear();
  }
  if (step.compensate) {
    request.compensation_job = correction_of_step(run, stored, *step.compensate);
  }
  request.confirmed = std::exchange(run.confirmed, {});
  const session::Outcome outcome = measured(run, request, stored && step.suggested());
  StepOutcome told = outcome_of(name, outcome);
  if (step.suggested() && !outcome.missing.empty()) {
    told.missing = {record_of_suggested(request, step.plan_check.empty()
                                                     ? "FILE (and name it in \"plan_check\")"
                                                     : step.plan_check.string())};
  }
  return told;
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

/// The measure step that begins when what the pause asks for is done.
const Step& measured_after(const Protocol& protocol, const std::string& pause) {
  auto at = std::ranges::find(protocol.steps, pause, &Step::name);
  return *std::find_if(at, protocol.steps.end(), [](const Step& step) {
    return std::holds_alternative<MeasureStep>(step.what);
  });
}

StepOutcome run_step(Run& run, const std::string& name, const PauseStep& step) {
  StepOutcome outcome{.name = name, .kind = "pause", .detail = step.ask};
  const Step& next = measured_after(run.protocol, name);
  if (stored_session(&run.connection, run.protocol, next.name)) {
    outcome.done_before = true;
    return outcome;
  }
  const auto* suggested = std::get_if<NextPointsOf>(&std::get<MeasureStep>(next.what).plan);
  if (suggested != nullptr && run.next_points.contains(suggested->step) &&
      run.next_points.at(suggested->step).points.empty()) {
    outcome.skipped = true;
    outcome.detail = fmt::format("skipped: {} suggests no points", suggested->step);
    return outcome;
  }
  if (run.person.confirms(name, step.ask)) {
    run.confirmed.push_back(fmt::format("{}: {}", name, step.ask));
    outcome.detail += ": done";
  } else {
    outcome.code = ExitCode::interrupted;
    outcome.detail = "waits for a person: " + step.ask;
  }
  return outcome;
}

StepOutcome run_step(Run& run, const std::string& name, const ReportStep& step) {
  const store::CampaignRow campaign = store::require_campaign(run.connection, run.protocol.name);
  report::Gathered gathered = report::gather(run.connection, campaign);
  report::Report& found = gathered.report;
  StepOutcome outcome{.name = name, .kind = "report"};
  const auto points = [&] { return report::judged_points(run.connection, campaign, gathered); };
  if (!step.dcc.empty()) {
    write_output(step.dcc, report::dcc_xml(run.connection, campaign, found, points()),
                 Existing::replace);
  }
  if (step.tolerance_mm) {
    found.tolerance = report::tolerance_test(points(), *step.tolerance_mm);
    outcome.detail = report::tolerance_words(*found.tolerance);
    if (found.tolerance->machine != Conformity::passes) outcome.code = ExitCode::not_acceptable;
  }
  if (!step.text.empty()) {
    write_output(step.text, report::to_text(found, {.glyphs = report::Glyphs::ascii}),
                 Existing::replace);
  }
  if (!step.json.empty()) {
    job::Json file = {{"schema", "trammel/report/1"}};
    file.update(report::to_json(found));
    write_output(step.json, file.dump(2) + "\n", Existing::replace);
  }
  if (!step.html.empty()) {
    write_output(step.html,
                 report::page_html(report::page_json(run.connection, campaign, gathered)),
                 Existing::replace);
  }
  for (const auto& file : {step.text, step.json, step.html, step.dcc}) {
    if (file.empty()) continue;
    outcome.detail += (outcome.detail.empty() ? "" : "; ") + file.filename().string();
  }
  return outcome;
}

bool is_done(const std::optional<store::SessionRow>& session) {
  return session && session->n_ok == session->n_points && session->last_event == "done";
}

/// What is asked of a look at one step.
struct Look {
  store::Connection* connection;
  const Protocol& protocol;
  const std::map<std::string, StepOutcome>& checked;  // by measure step, as preflight found it
};

StepOutcome look_at(const Look& look, const std::string& name, const MeasureStep& step) {
  if (const auto* next = std::get_if<NextPointsOf>(&step.plan)) {
    StepOutcome outcome{.name = name,
                        .kind = "measure",
                        .detail = fmt::format("the points that {} suggests", next->step)};
    const auto session = stored_session(look.connection, look.protocol, name);
    if (!session) return outcome;
    outcome.done_before = is_done(session);
    outcome.detail = fmt::format("{} of {} to measure", session->n_points - session->n_ok,
                                 terminal::counted(session->n_points, "point"));
    return outcome;
  }
  StepOutcome outcome = look.checked.at(name);
  const auto session = stored_session(look.connection, look.protocol, name);
  if (!session) return outcome;
  const int left = session->n_points - session->n_ok;
  outcome.done_before = is_done(session);
  outcome.detail =
      fmt::format("{} of {} to measure", left, terminal::counted(session->n_points, "point"));
  outcome.estimated_s *= static_cast<double>(left) / std::max(1, session->n_points);
  return outcome;
}

StepOutcome look_at(const Look& look, const std::string& name, const PauseStep& step) {
  const Step& next = measured_after(look.protocol, name);
  return {.name = name,
          .kind = "pause",
          .done_before = stored_session(look.connection, look.protocol, next.name).has_value(),
          .detail = "a person: " + step.ask};
}

StepOutcome look_at(const Look&, const std::string& name, const ReportStep& step) {
  std::string files;
  for (const auto& file : {step.text, step.json, step.html, step.dcc}) {
    if (!file.empty()) files += (files.empty() ? "" : ", ") + file.filename().string();
  }
  if (step.tolerance_mm) {
    files += fmt::format("{}tolerance {:g} mm", files.empty() ? "" : ", ", *step.tolerance_mm);
  }
  return {.name = name, .kind = "report", .detail = "to write: " + files};
}

/// A step that computes: its job is known once all its sessions are measured.
StepOutcome look_at_job(const Look& look, StepOutcome outcome, const job::Request& request) {
  const bool measured = std::all_of(
      request.sessions.begin(), request.sessions.end(), [&](const std::string& session) {
        return is_done(stored_session(look.connection, look.protocol, session));
      });
  outcome.detail = request.stage + " to compute";
  if (!measured) return outcome;
  const store::NewJob inputs = job::inputs_of(*look.connection, request);
  if (const auto job = store::find_job(*look.connection, inputs.campaign_id, inputs.key.key)) {
    outcome.done_before = true;
    outcome.detail = fmt::format("{}, job {}", request.stage, job->id);
  }
  return outcome;
}

StepOutcome look_at(const Look& look, const std::string& name, const CalibrateStep& step) {
  return look_at_job(look, {.name = name, .kind = "calibrate"},
                     {.campaign = look.protocol.name,
                      .stage = step.method,
                      .parameters = step.parameters,
                      .sessions = step.sessions});
}

StepOutcome look_at(const Look& look, const std::string& name, const DiagnoseStep& step) {
  // sessions of suggested points that were skipped do not exist
  std::vector<std::string> sessions;
  for (const std::string& session : step.sessions) {
    const auto planned = std::ranges::find(look.protocol.steps, session, &Step::name);
    if (!std::get<MeasureStep>(planned->what).suggested() ||
        stored_session(look.connection, look.protocol, session)) {
      sessions.push_back(session);
    }
  }
  return look_at_job(look, {.name = name, .kind = "diagnose"},
                     {.campaign = look.protocol.name,
                      .stage = "diagnose",
                      .parameters = step.parameters,
                      .sessions = sessions});
}

}  // namespace

Requests requests_of(const Protocol& protocol) {
  std::map<std::pair<std::string, std::string>, Machine> machines;  // by stage and tracker
  Requests requests;
  for (const Step& step : protocol.steps) {
    const auto* measure = std::get_if<MeasureStep>(&step.what);
    if (measure == nullptr) continue;
    const Setting& with = measure->setting;
    const auto devices = std::pair(with.stage, with.tracker);
    if (!machines.contains(devices)) {
      machines[devices] = device::open_devices(with.stage, with.tracker).machine;
    }
    session::Request request{.campaign = protocol.name,
                             .session = step.name,
                             .plan = plan_of_step(*measure, machines.at(devices)),
                             .stage = with.stage,
                             .tracker = with.tracker,
                             .check = with.check,
                             .policy = with.policy,
                             .plan_check = measure->plan_check.string(),
                             .new_set_up = measure->new_set_up};
    if (!protocol.published.empty()) request.facts[kPublishedFact] = protocol.published;
    requests[step.name] = request;
  }
  for (const Step& step : protocol.steps) {
    const auto* calibrate = std::get_if<CalibrateStep>(&step.what);
    if (calibrate == nullptr) continue;
    const job::Stage& stage = job::find_stage(calibrate->method);
    for (const auto& [devices, machine] : machines) {
      if (stage.serves != nullptr) stage.serves(machine);
    }
  }
  return requests;
}

std::vector<StepOutcome> preflight(const Protocol& protocol, const Requests& requests,
                                   store::Connection* connection) {
  std::vector<StepOutcome> steps;
  for (const Step& step : protocol.steps) {
    const auto* measure = std::get_if<MeasureStep>(&step.what);
    if (measure == nullptr || measure->suggested()) continue;
    session::Request request = requests.at(step.name);
    const bool recorded = std::filesystem::exists(request.plan_check);
    if (!recorded) request.plan_check.clear();
    const session::Outcome outcome = session::dry_run(request, NominalCorrection{}, {}, connection);
    steps.push_back(outcome_of(step.name, outcome));
    StepOutcome& last = steps.back();
    last.detail = outcome.violations.empty()
                      ? fmt::format("{} of {} to measure", outcome.n_points,
                                    terminal::counted(outcome.n_points, "point"))
                      : fmt::format("0 of {}: {}", terminal::counted(outcome.n_points, "point"),
                                    outcome.detail);
    last.done_before = false;
    if (!outcome.missing.empty() && !recorded) {
      last.missing = {measure->plan_check.empty()
                          ? "a real stage needs the record of a plan check: name a file in "
                            "\"plan_check\", and write it by `trammel protocol check --record`"
                          : measure->plan_check.string() +
                                " is not there: `trammel protocol check --record` writes it"};
    }
  }
  return steps;
}

std::vector<StepOutcome> dry_run(store::Connection* connection, const Protocol& protocol,
                                 const Requests& requests) {
  std::map<std::string, StepOutcome> checked;
  for (const StepOutcome& step : preflight(protocol, requests, connection))
    checked[step.name] = step;
  const Look look{connection, protocol, checked};
  std::vector<StepOutcome> steps;
  for (const Step& step : protocol.steps) {
    steps.push_back(
        std::visit([&](const auto& what) { return look_at(look, step.name, what); }, step.what));
  }
  return steps;
}

Outcome run(store::Connection& connection, const Protocol& protocol, const Requests& requests,
            const session::Surroundings& surroundings, const Person& person) {
  Run state{connection, protocol, requests, surroundings, person};
  Outcome outcome;
  for (const Step& step : protocol.steps) {
    const auto execute = [&](const auto& what) { return run_step(state, step.name, what); };
    outcome.steps.push_back(std::visit(execute, step.what));
    person.tell(outcome.steps.back());
    outcome.code = outcome.steps.back().code;
    if (outcome.code != ExitCode::ok) break;
  }
  return outcome;
}

}  // namespace trammel::protocol
