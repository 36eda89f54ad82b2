#include "app/cli/session.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "app/cli/table.hpp"
#include "app/job/run.hpp"
#include "app/job/stored_model.hpp"
#include "app/session/lock.hpp"
#include "app/session/plan_json.hpp"
#include "app/session/session.hpp"
#include "app/session/stop_signal.hpp"
#include "store/campaign.hpp"
#include "store/open.hpp"

namespace trammel::cli {

namespace {

struct RunOptions {
  session::Request request;
  std::string plan;
  std::string set;
  std::string compensate;
  bool dry_run = false;
};

struct NamedOptions {
  std::string campaign;
  std::string session;
  bool now = false;
  bool dry_run = false;
};

session::Surroundings surroundings(const Context& context) {
  session::count_stop_signals();
  session::Surroundings around;
  around.correction_of = [](store::Connection& db, store::Id job) {
    return job::correction_of(db, job);
  };
  around.stop_signals = &session::stop_signals;
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
      fields["violations"] = session::violations_json(outcome.violations);
    }
    context.print("session-" + verb, fields);
    return code;
  }
  std::string text;
  for (const Violation& v : outcome.violations) text += describe(v) + "\n";
  text += fmt::format("{}: {}, {} of {} points stored", printable(name),
                      session::name_of(outcome.state), outcome.n_before + outcome.n_stored,
                      outcome.n_points);
  if (!outcome.detail.empty()) text += "; " + printable(outcome.detail);
  context.print(text);
  return code;
}

Correction dry_correction(const RunOptions& options, const Context& context) {
  if (options.compensate.empty()) return NominalCorrection{};
  store::Connection db = store::open(context.db(), store::Access::read_only);
  return job::correction_of(
      db, job::find_compensation(db, options.request.campaign, options.compensate));
}

ExitCode run_run(const RunOptions& options, Context& context) {
  session::Request request = options.request;
  request.plan = session::plan_of(options.plan);
  if (request.session.empty()) request.session = request.plan.name;
  if (!options.set.empty()) {
    for (PlannedPoint& point : request.plan.points) {
      point.set = options.set == "validate" ? ReadingSet::validate : ReadingSet::identify;
    }
  }
  if (options.dry_run) {
    const session::Outcome outcome = session::dry_run(request, dry_correction(options, context));
    context.say("dry run: nothing is stored and nothing moves");
    return report(outcome, "run", request.session, context);
  }
  if (options.compensate.empty()) {  // a bad plan or robot leaves no database behind
    const session::Outcome looked = session::dry_run(request, NominalCorrection{});
    if (!looked.violations.empty()) return report(looked, "run", request.session, context);
  }
  store::Connection db = store::open(
      context.db(), options.compensate.empty() ? store::Access::create : store::Access::write);
  if (!options.compensate.empty()) {
    request.compensation_job = job::find_compensation(db, request.campaign, options.compensate);
  }
  const session::Surroundings around = surroundings(context);
  const session::Outcome outcome = session::run(db, request, around);
  const ExitCode code = report(outcome, "run", request.session, context);
  if (outcome.state == session::State::done) {
    context.next((request.compensation_job ? "trammel report " : "trammel calibrate lsq ") +
                 shell_word(request.campaign));
  } else if (outcome.session_id != 0) {
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
    if (row.n_points > 0 && row.plan_name != "reference points" && row.last_event != "done") {
      last = row.name;
    }
  }
  if (last.empty()) {
    throw NotFoundError({.what = "the campaign has no session that is not done",
                         .where = {.field = "campaign"},
                         .got = options.campaign});
  }
  return last;
}

ExitCode run_resume(const NamedOptions& options, Context& context) {
  store::Connection db =
      store::open(context.db(), options.dry_run ? store::Access::read_only : store::Access::write);
  const std::string name = session_to_resume(db, options);
  if (options.dry_run) {
    context.say("dry run: nothing is stored and nothing moves");
    return report(session::dry_resume(db, options.campaign, name), "resume", name, context);
  }
  return report(session::resume(db, options.campaign, name, surroundings(context)), "resume", name,
                context);
}

const char* state_of(const store::SessionRow& row, bool running) {
  if (row.last_event == "done") return "done";
  if (row.n_points == 0) return "imported";
  if (row.plan_name == "reference points") return "reference";
  if (running) return "running";
  return row.last_event == "stopped" || row.last_event == "faulted" ? row.last_event.c_str()
                                                                    : "interrupted";
}

ExitCode run_status(const NamedOptions& options, Context& context) {
  store::Connection db = store::open(context.db(), store::Access::read_only);
  const store::CampaignRow campaign = store::require_campaign(db, options.campaign);
  const auto holder = session::CampaignLock::holder(db.file(), campaign.uuid);
  const auto sessions = store::list_sessions(db, campaign.id);
  Json rows = Json::array();
  Table table({"session", "state", "points", "readings"});
  bool unfinished = false;
  for (const store::SessionRow& row : sessions) {
    const std::string state = state_of(row, holder && row.id == sessions.back().id);
    rows.push_back({{"name", row.name},
                    {"state", state},
                    {"plan", row.plan_name},
                    {"n_points", row.n_points},
                    {"n_ok", row.n_ok},
                    {"n_readings", row.n_readings},
                    {"compensated", row.compensation_job.has_value()}});
    unfinished = unfinished || state == "stopped" || state == "faulted" || state == "interrupted";
    table.add({row.name, state, fmt::format("{}/{}", row.n_ok, row.n_points),
               std::to_string(row.n_readings)});
  }
  Json fields = {{"campaign", campaign.name}, {"running", holder.has_value()}, {"sessions", rows}};
  if (holder) fields["process"] = *holder;
  const std::string now =
      holder ? fmt::format("measured now by process {}\n", *holder) : std::string();
  context.json ? context.print("session-status", fields) : context.print(table.text() + now);
  context.next((holder       ? "trammel session stop "
                : unfinished ? "trammel session resume "
                             : "trammel report ") +
               shell_word(campaign.name));
  return ExitCode::ok;
}

ExitCode run_stop(const NamedOptions& options, Context& context) {
  store::Connection db = store::open(context.db(), store::Access::read_only);
  const store::CampaignRow campaign = store::require_campaign(db, options.campaign);
  const auto holder = session::CampaignLock::holder(db.file(), campaign.uuid);
  if (!holder || *holder <= 0) {
    throw NotFoundError({.what = "no process measures this campaign",
                         .where = {.field = "campaign"},
                         .got = options.campaign});
  }
  const int signals = options.dry_run ? 0 : options.now ? 2 : 1;
  for (int k = 0; k < signals; ++k) {
    if (::kill(*holder, k == 0 ? SIGINT : SIGTERM) != 0) {
      throw Error(ExitCode::error,
                  {.what = "the runner cannot be told to stop", .got = std::strerror(errno)});
    }
  }
  if (context.json) {
    context.print("session-stop",
                  {{"process", *holder}, {"now", options.now}, {"dry_run", options.dry_run}});
  } else {
    context.print(fmt::format("process {} {} told to {}", *holder,
                              options.dry_run ? "would be" : "was",
                              options.now ? "stop now" : "finish the point and stop"));
  }
  return ExitCode::ok;
}

void setup_run(CLI::App& session, Context& context) {
  CLI::App& c = *session.add_subcommand("run", "Check a plan, then measure it point by point");
  auto o = std::make_shared<RunOptions>();
  c.add_option("campaign", o->request.campaign, "made when it is not there")->required();
  c.add_option("--plan", o->plan, "plan file, or the name of a grid")
      ->required()
      ->type_name("PLAN");
  c.add_option("--stage", o->request.stage, "sim:FILE")->required()->type_name("STAGE");
  c.add_option("--tracker", o->request.tracker, "sim")->capture_default_str();
  c.add_option("--session", o->request.session, "its name (the plan's)")->type_name("SESSION");
  c.add_option("--compensate", o->compensate,
               "job whose correction is commanded, a diagnose job too: its number or key, or "
               "model:VERSION (none)")
      ->type_name("JOB");
  c.add_option("--set", o->set, "identify or validate, for all points (the plan's)")
      ->check(CLI::IsMember(std::vector<std::string>{"identify", "validate"}));
  c.add_flag("--new-set-up", o->request.new_set_up, "homed and framed anew: an epoch of its own");
  c.add_flag("--dry-run", o->dry_run, "check everything, store and move nothing");
  c.add_option("--limit-margin", o->request.check.limit_margin_mm, "free stroke, mm")
      ->capture_default_str();
  c.add_option("--singularity-margin", o->request.check.singularity_margin, "0 to 1")
      ->capture_default_str();
  on_run(c, context, o, run_run);
}

}  // namespace

void setup_session(CLI::App& app, Context& context) {
  CLI::App& session = noun(app, "session", "Measure a plan, and go on after any interruption");
  setup_run(session, context);
  const auto verb = [&](const char* name, const char* what,
                        ExitCode (*run)(const NamedOptions&, Context&)) {
    CLI::App& command = *session.add_subcommand(name, what);
    auto options = std::make_shared<NamedOptions>();
    command.add_option("campaign", options->campaign, "name or uuid")->required();
    on_run(command, context, options, run);
    return std::pair<CLI::App*, NamedOptions*>(&command, options.get());
  };
  const auto resume = verb("resume", "Measure what is left of a session", run_resume);
  resume.first->add_option("--session", resume.second->session, "(the last that is not done)")
      ->type_name("SESSION");
  resume.first->add_flag("--dry-run", resume.second->dry_run,
                         "say what is left and check it, store and move nothing");
  verb("status", "Sessions of a campaign, and who measures now", run_status);
  const auto stop = verb("stop", "Tell the runner to stop after the point", run_stop);
  stop.first->add_flag("--now", stop.second->now, "at once");
  stop.first->add_flag("--dry-run", stop.second->dry_run, "say which process, tell it nothing");
}

}  // namespace trammel::cli
