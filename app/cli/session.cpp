#include "app/cli/session.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/cli/margins.hpp"
#include "app/cli/next_step.hpp"
#include "app/files/plan_json.hpp"
#include "app/job/fitted_range.hpp"
#include "app/job/run.hpp"
#include "app/job/stored_model.hpp"
#include "app/session/lock.hpp"
#include "app/session/session.hpp"
#include "app/session/stop_signal.hpp"
#include "app/session/wishes.hpp"
#include "app/terminal/counted.hpp"
#include "app/terminal/progress.hpp"
#include "store/campaign.hpp"
#include "store/machine.hpp"
#include "store/open.hpp"

namespace trammel::cli {

namespace {

struct RunOptions {
  session::Request request;
  std::string plan;
  std::string set;
  std::string compensate;
  std::vector<double> band_degc;  // low, high
  bool dry_run = false;
};

struct NamedOptions {
  std::string campaign;
  std::string session;
  bool dry_run = false;
};

session::Surroundings surroundings(const Context& context) {
  session::count_stop_signals();
  session::Surroundings around;
  around.correction_of = [](store::Connection& db, store::Id job) {
    return job::correction_of(db, job);
  };
  around.stop_signals = &session::stop_signals;
  around.stopped_by = session::stop_signal_words;
  around.quiet = context.quiet;
  around.terminal = ::isatty(STDERR_FILENO) == 1;
  return around;
}

ExitCode report(const session::Outcome& outcome, const std::string& verb, const std::string& name,
                Context& context) {
  const ExitCode code = outcome.exit_code();
  if (context.json) {
    Json fields = {{"session", name},
                   {"state", session::name_of(outcome.state)},
                   {"n_points", outcome.n_points},
                   {"n_before", outcome.n_before},
                   {"n_stored", outcome.n_stored}};
    if (!outcome.detail.empty()) fields["detail"] = outcome.detail;
    if (!outcome.violations.empty()) {
      fields["violations"] = violations_json(outcome.violations);
    }
    if (!outcome.missing.empty()) fields["missing"] = outcome.missing;
    if (!outcome.plan_sha256.empty()) {
      fields["estimated_s"] = outcome.estimated_s;
      fields["plan_sha256"] = outcome.plan_sha256;
    }
    context.print("session-" + verb, fields);
    return code;
  }
  std::string text;
  for (const Violation& v : outcome.violations) text += describe(v) + "\n";
  for (const std::string& what : outcome.missing) text += "missing: " + printable(what) + "\n";
  text += fmt::format("{}: {}, {} of {} stored", printable(name), session::name_of(outcome.state),
                      outcome.n_before + outcome.n_stored,
                      terminal::counted(outcome.n_points, "point"));
  if (!outcome.detail.empty()) text += "; " + printable(outcome.detail);
  context.print(text);
  return code;
}

void say_dry(const session::Outcome& outcome, const Context& context) {
  context.say("dry run: nothing is stored and nothing moves");
  if (outcome.watch_host_s) context.say(device::watch_text(*outcome.watch_host_s));
}

void say_duration(const session::Outcome& outcome, const Context& context) {
  if (outcome.refused()) return;
  context.say(fmt::format("{}, estimated {}",
                          terminal::counted(outcome.n_points - outcome.n_before, "point"),
                          terminal::clock_text(outcome.estimated_s)));
}

/// Before anything moves: where the compensation knows nothing of the plan's targets.
void say_extrapolation(store::Connection& db, store::Id job, const Plan& plan,
                       const Context& context) {
  std::vector<Pose> targets;
  for (const PlannedPoint& p : plan.points) targets.push_back(p.target);
  const FittedRange range = job::fitted_range(db, store::get_job(db, job));
  for (const std::string& words :
       job::extrapolation_words(range, targets, "target", " of the plan")) {
    context.say("warning: " + words);
  }
}

Correction dry_correction(const RunOptions& options, const Plan& plan, const Context& context) {
  if (options.compensate.empty()) return NominalCorrection{};
  store::Connection db = store::open(context.db(), store::Access::read_only);
  const store::Id job = job::find_compensation(db, options.request.campaign, options.compensate);
  say_extrapolation(db, job, plan, context);
  return job::correction_of(db, job);
}

/// After a refusal before anything moved: the look at the plan on this machine, with the record
/// that a real stage needs where it is missing.
void say_check(const RunOptions& options, const session::Request& request,
               const session::Outcome& outcome, const Context& context) {
  if (!outcome.refused()) return;
  const std::string& stage = request.stage;
  std::string line = fmt::format("trammel plan check {} --mechanism {}", shell_word(options.plan),
                                 shell_word(stage.substr(stage.find(':') + 1)));
  if (outcome.violations.empty()) {
    const std::string record =
        request.plan_check.empty()
            ? std::filesystem::path(options.plan).stem().string() + ".check.json"
            : request.plan_check + " --overwrite";
    line += " --record " + (request.plan_check.empty() ? shell_word(record) : record);
  }
  context.next(line);
}

ExitCode run_run(const RunOptions& options, Context& context) {
  session::Request request = options.request;
  request.plan = plan_of(options.plan);
  if (!options.band_degc.empty()) {
    request.policy.low_degc = options.band_degc[0];
    request.policy.high_degc = options.band_degc[1];
  }
  if (request.session.empty()) request.session = request.plan.name;
  if (!options.set.empty()) {
    for (PlannedPoint& point : request.plan.points) {
      point.set = options.set == "validate" ? ReadingSet::validate : ReadingSet::identify;
    }
  }
  if (options.dry_run) {
    std::optional<store::Connection> there;
    if (std::filesystem::exists(context.db())) {
      there.emplace(store::open(context.db(), store::Access::read_only));
    }
    const session::Outcome outcome = session::dry_run(
        request, dry_correction(options, request.plan, context), {}, there ? &*there : nullptr);
    say_dry(outcome, context);
    say_duration(outcome, context);
    say_check(options, request, outcome, context);
    return report(outcome, "run", request.session, context);
  }
  if (options.compensate.empty()) {  // a bad plan or robot leaves no database behind
    const session::Outcome looked = session::dry_run(request, NominalCorrection{});
    if (looked.refused()) {
      say_check(options, request, looked, context);
      return report(looked, "run", request.session, context);
    }
    say_duration(looked, context);
  }
  store::Connection db = store::open(
      context.db(), options.compensate.empty() ? store::Access::create : store::Access::write);
  if (!options.compensate.empty()) {
    request.compensation_job = job::find_compensation(db, request.campaign, options.compensate);
    say_extrapolation(db, *request.compensation_job, request.plan, context);
  }
  const session::Surroundings around = surroundings(context);
  const session::Outcome outcome = session::run(db, request, around);
  const ExitCode code = report(outcome, "run", request.session, context);
  say_check(options, request, outcome, context);
  if (outcome.state == session::State::done) {
    const store::Id campaign = store::require_campaign_id(db, request.campaign);
    context.next((request.compensation_job ? "trammel report "
                                           : first_calibration(store::load_machine(db, campaign))) +
                 shell_word(request.campaign));
  } else if (!outcome.refused() && outcome.session_id != 0) {
    context.next(fmt::format("trammel session resume {} --session {}", shell_word(request.campaign),
                             shell_word(request.session)));
  }
  return code;
}

/// The session that is named, or the one that is not done yet.
std::string session_to_resume(store::Connection& db, const NamedOptions& options) {
  if (!options.session.empty()) return options.session;
  const store::CampaignRow campaign = store::require_campaign(db, options.campaign);
  std::string last;
  for (const store::SessionRow& row : store::list_sessions(db, campaign.id)) {
    if (row.n_points > 0 && row.plan_name != store::kReferencePlan && row.last_event != "done") {
      last = row.name;
    }
  }
  if (last.empty()) {
    throw NotFoundError({.what = "the campaign has no session that is not done",
                         .where = {.field = "campaign"},
                         .got = options.campaign,
                         .hint = "`trammel report " + shell_word(options.campaign) +
                                 "`: all that was planned is measured"});
  }
  return last;
}

/// A runner that is paused is to resume; it sets up anew itself.
std::optional<session::Outcome> goes_on(store::Connection& db, const std::string& campaign,
                                        const std::string& name) {
  const store::CampaignRow owner = store::require_campaign(db, campaign);
  const auto process = session::CampaignLock::holder(db.file(), owner.uuid);
  const auto row = store::find_session(db, owner.id, name);
  if (!process || !row || row->last_event != "paused") return std::nullopt;
  session::ask(db, row->id, session::Wish::go_on);
  return session::Outcome{.state = session::State::paused,
                          .session_id = row->id,
                          .n_points = row->n_points,
                          .n_before = row->n_ok,
                          .detail = fmt::format("process {} is to resume", *process)};
}

ExitCode run_resume(const NamedOptions& options, Context& context) {
  store::Connection db =
      store::open(context.db(), options.dry_run ? store::Access::read_only : store::Access::write);
  const std::string name = session_to_resume(db, options);
  if (options.dry_run) {
    const session::Outcome outcome = session::dry_resume(db, options.campaign, name);
    say_dry(outcome, context);
    say_duration(outcome, context);
    return report(outcome, "resume", name, context);
  }
  if (const auto told = goes_on(db, options.campaign, name)) {
    return report(*told, "resume", name, context);
  }
  return report(session::resume(db, options.campaign, name, surroundings(context)), "resume", name,
                context);
}

void policy_options(Command c, RunOptions& o) {
  session::Policy& policy = o.request.policy;
  c.option("--plan-check", o.request.plan_check,
           "record of `plan check --record`: needed by a real stage")
      .type("FILE");
  c.option("--gate-mm", policy.gate_mm,
           "stop where measured and commanded are farther apart, mm (0.4 of the plan's smallest "
           "step)");
  c.option("--gate-deg", policy.gate_deg,
           "the same of the attitude, deg (0.4 of the smallest turn, 2 at most)");
  c.option("--temperature", o.band_degc, "LOW HIGH in degC: outside, measuring is suspended")
      .expected(2);
  c.option("--hysteresis-k", policy.hysteresis_k, "K inside the band before it goes on")
      .shown_default();
  c.option("--reference-every", policy.reference_every,
           "points between two visits of the reference points (0: at a resume only)")
      .shown_default();
  c.option("--base-every", policy.base_every,
           "points between two measurements of the tracker's base nests (0: never)")
      .shown_default();
  c.option("--drift-mm", policy.drift_mm,
           "of a reference point or base nest: beyond, it is suspended, mm")
      .shown_default();
  c.option("--patience-s", policy.patience_s, "how long bad conditions are waited out, s")
      .shown_default();
}

void setup_run(Command session, Context& context) {
  Command c = session.command("run", "Check a plan, then measure it point by point");
  auto o = std::make_shared<RunOptions>();
  c.option("campaign", o->request.campaign, "made when it is not there").required();
  c.option("--plan", o->plan, "plan file, or the name of a grid").required().type("PLAN");
  c.option("--stage", o->request.stage, "sim:FILE (robot/1) or galil:FILE (stage/1)")
      .required()
      .type("STAGE");
  c.option("--tracker", o->request.tracker,
           "sim (of a simulated stage), t2sa:FILE or file:FILE (tracker/1: behind T2SA, or "
           "known by the file its program writes)")
      .shown_default();
  c.option("--session", o->request.session, "its name (the plan's)").type("SESSION");
  c.option("--compensate", o->compensate,
           "job whose correction is commanded, a diagnose job too: its number or key, or "
           "model:VERSION (none)")
      .type("JOB");
  c.option("--set", o->set, "identify or validate, for all points (the plan's)")
      .one_of({"identify", "validate"});
  c.flag("--new-set-up", o->request.new_set_up, "homed and framed anew: an epoch of its own");
  c.flag("--dry-run", o->dry_run, "check everything; nothing is stored or moved");
  margin_options(c, o->request.check);
  policy_options(c, *o);
  on_run(c, context, o, run_run);
}

}  // namespace

void setup_session(Command app, Context& context) {
  Command session = noun(app, "session", "Measure a plan, and go on after any interruption");
  setup_run(session, context);
  Command resume =
      session.command("resume", "Measure what is left of a session, or go on where it is paused");
  auto o = std::make_shared<NamedOptions>();
  resume.option("campaign", o->campaign, "name or uuid").required().type("CAMPAIGN");
  resume.option("--session", o->session, "(the last that is not done)").type("SESSION");
  resume.flag("--dry-run", o->dry_run,
              "print what is left and check it; nothing is stored or moved");
  on_run(resume, context, o, run_resume);
}

}  // namespace trammel::cli
