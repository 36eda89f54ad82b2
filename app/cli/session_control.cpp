#include "app/cli/session_control.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <thread>

#include "app/session/lock.hpp"
#include "app/session/settings.hpp"
#include "app/session/side_file.hpp"
#include "app/session/status.hpp"
#include "app/session/wishes.hpp"
#include "app/terminal/counted.hpp"
#include "app/terminal/table.hpp"
#include "store/campaign.hpp"
#include "store/open.hpp"

namespace trammel::cli {

namespace {

using session::CampaignLock;
using session::Wish;

struct WatchOptions {
  std::string campaign;
  std::string session;
  bool watch = false;
  double interval_s = 1;
};

struct AskOptions {
  std::string campaign;
  bool now = false;
  bool dry_run = false;
};

std::string state_in_list(const store::SessionRow& row, bool running) {
  if (row.last_event == "done") return "done";
  if (row.n_points == 0) return "imported";
  if (row.plan_name == store::kReferencePlan) return "reference";
  if (running) return row.last_event == "paused" ? "paused" : "running";
  return row.last_event == "stopped" || row.last_event == "faulted" ? row.last_event
                                                                    : "interrupted";
}

int terminal_width() {
  winsize size{};
  return ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

/// Until the session has come to an end. Nothing is locked and nothing written.
ExitCode watch(store::Connection& db, const store::CampaignRow& campaign, const std::string& name,
               const WatchOptions& options, Context& context) {
  const bool terminal = ::isatty(STDOUT_FILENO) == 1;
  std::string before;
  for (;;) {
    const auto status =
        session::status_of(db, campaign, name, CampaignLock::holder(db.file(), campaign.uuid));
    const std::string mark = fmt::format("{} {} {}", status.state, status.n_ok, status.stalled);
    if (terminal) std::fputs("\x1b[H\x1b[J", stdout);
    if (terminal || mark != before) context.print(session::status_text(status, terminal_width()));
    std::fflush(stdout);
    before = mark;
    if (status.state != "running" && status.state != "paused") return ExitCode::ok;
    std::this_thread::sleep_for(std::chrono::duration<double>(options.interval_s));
  }
}

ExitCode run_status(const WatchOptions& options, Context& context) {
  store::Connection db = store::open(context.db(), store::Access::read_only);
  const store::CampaignRow campaign = store::require_campaign(db, options.campaign);
  const auto current = session::current_session(db, campaign);
  const std::string name = options.session.empty() ? current.value_or("") : options.session;
  if (options.watch) {
    if (context.json) {
      throw UsageError({.what = "--watch draws for a person",
                        .where = {.field = "--watch"},
                        .hint = "a program calls --json again and again"});
    }
    if (name.empty()) {
      throw NotFoundError({.what = "the campaign has no session to watch",
                           .where = {.field = "campaign"},
                           .got = campaign.name});
    }
    return watch(db, campaign, name, options, context);
  }
  const auto holder = CampaignLock::holder(db.file(), campaign.uuid);
  Json rows = Json::array();
  Table table({"session", "state", "points", "readings"});
  bool unfinished = false, paused = false;
  for (const store::SessionRow& row : store::list_sessions(db, campaign.id)) {
    const std::string state = state_in_list(row, holder && row.name == current);
    rows.push_back({{"name", row.name},
                    {"state", state},
                    {"plan", row.plan_name},
                    {"n_points", row.n_points},
                    {"n_ok", row.n_ok},
                    {"n_readings", row.n_readings},
                    {"compensated", row.compensated()}});
    paused = paused || state == "paused";
    unfinished = unfinished || state == "stopped" || state == "faulted" || state == "interrupted";
    table.add({row.name, state, fmt::format("{}/{}", row.n_ok, row.n_points),
               std::to_string(row.n_readings)});
  }
  Json fields = {{"campaign", campaign.name}, {"running", holder.has_value()}, {"sessions", rows}};
  if (holder) fields["process"] = *holder;
  std::string text = table.text();
  if (!name.empty()) {
    const auto status = session::status_of(db, campaign, name, holder);
    fields["status"] = session::status_json(status);
    text += "\n" + session::status_text(status, terminal_width());
  }
  context.json ? context.print("session-status", fields) : context.print(text);
  context.next((paused       ? "trammel session resume "
                : holder     ? "trammel session stop "
                : unfinished ? "trammel session resume "
                             : "trammel report ") +
               shell_word(campaign.name));
  return ExitCode::ok;
}

const char* words_of(Wish wish) {
  switch (wish) {
    case Wish::pause:
      return "finish the point and pause";
    case Wish::stop:
      return "finish the point and stop";
    case Wish::stop_now:
      return "stop now";
    default:
      return "go on";
  }
}

ExitCode ask(const AskOptions& options, Context& context, const char* command, Wish wish) {
  store::Connection db =
      store::open(context.db(), options.dry_run ? store::Access::read_only : store::Access::write);
  const store::CampaignRow campaign = store::require_campaign(db, options.campaign);
  const auto holder = CampaignLock::holder(db.file(), campaign.uuid);
  const auto name = session::current_session(db, campaign);
  if (!holder || (!name && !options.dry_run)) {
    throw NotFoundError({.what = "no process measures this campaign",
                         .where = {.field = "campaign"},
                         .got = options.campaign,
                         .hint = "see `trammel session status " + shell_word(campaign.name) + "`"});
  }
  if (!options.dry_run) session::ask(db, store::find_session(db, campaign.id, *name)->id, wish);
  if (context.json) {
    Json fields = {{"process", *holder}, {"session", name.value_or("")}};
    if (wish != Wish::pause) fields["now"] = options.now;
    fields["dry_run"] = options.dry_run;
    context.print(command, fields);
  } else {
    context.print(fmt::format("process {} {} asked to {}", *holder,
                              options.dry_run ? "would be" : "is", words_of(wish)));
  }
  context.next((wish == Wish::pause ? "trammel session resume " : "trammel session status ") +
               shell_word(campaign.name));
  return ExitCode::ok;
}

ExitCode run_pause(const AskOptions& options, Context& context) {
  return ask(options, context, "session-pause", Wish::pause);
}

ExitCode run_stop(const AskOptions& options, Context& context) {
  return ask(options, context, "session-stop", options.now ? Wish::stop_now : Wish::stop);
}

ExitCode run_recover(const AskOptions& options, Context& context) {
  store::Connection db =
      store::open(context.db(), options.dry_run ? store::Access::read_only : store::Access::write);
  const store::CampaignRow campaign = store::require_campaign(db, options.campaign);
  session::Recovery recovery;
  if (options.dry_run) {
    recovery = session::recover(db, campaign, true);
  } else {
    const CampaignLock lock(db.file(), campaign.uuid);
    recovery = session::recover(db, campaign);
  }
  const auto file = session::side_file(db.file(), campaign.uuid).string();
  if (context.json) {
    context.print("session-recover", {{"file", file},
                                      {"n_lines", recovery.n_lines},
                                      {"n_taken", recovery.n_taken},
                                      {"n_there", recovery.n_there},
                                      {"problems", recovery.problems},
                                      {"dry_run", options.dry_run}});
  } else if (recovery.n_lines == 0) {
    context.print("nothing was kept aside");
  } else {
    std::string text = fmt::format("{} of {} {} taken in; there already: {}\n", recovery.n_taken,
                                   terminal::counted(recovery.n_lines, "reading"),
                                   options.dry_run ? "would be" : "are", recovery.n_there);
    for (const std::string& problem : recovery.problems) text += printable(problem) + "\n";
    context.print(text);
  }
  context.next((recovery.n_lines == 0 ? "trammel session status " : "trammel session resume ") +
               shell_word(campaign.name));
  return recovery.problems.empty() ? ExitCode::ok : ExitCode::invalid_data;
}

template <class Options>
Command verb(Command session, Context& context, const char* name, const char* what,
             std::shared_ptr<Options> options, ExitCode (*run)(const Options&, Context&)) {
  Command command = session.command(name, what);
  command.option("campaign", options->campaign, "name or uuid").required().type("CAMPAIGN");
  on_run(command, context, std::move(options), run);
  return command;
}

}  // namespace

void setup_session_control(Command app, Context& context) {
  Command session = noun(app, "session", "Measure a plan, and go on after any interruption");
  auto watched = std::make_shared<WatchOptions>();
  Command status = verb(session, context, "status",
                        "Sessions of a campaign; how the one that is measured now is doing",
                        watched, run_status);
  status.option("--session", watched->session, "(the one with the latest event)").type("SESSION");
  status.flag("--watch", watched->watch, "draw it again and again until the session ends");
  status.option("--interval", watched->interval_s, "s between two looks")
      .range(0.01, 3600.0)
      .shown_default();
  auto paused = std::make_shared<AskOptions>();
  verb(session, context, "pause", "Ask the runner to pause after the point; resume goes on", paused,
       run_pause)
      .flag("--dry-run", paused->dry_run, "print which process measures, and leave it alone");
  auto stopped = std::make_shared<AskOptions>();
  Command stop =
      verb(session, context, "stop", "Ask the runner to stop after the point", stopped, run_stop);
  stop.flag("--now", stopped->now, "at once: the point is given up");
  stop.flag("--dry-run", stopped->dry_run, "print which process measures, and leave it alone");
  auto recovered = std::make_shared<AskOptions>();
  verb(session, context, "recover",
       "Take in readings that were kept aside when the database could not be written", recovered,
       run_recover)
      .flag("--dry-run", recovered->dry_run, "print what would be taken in");
}

}  // namespace trammel::cli
