#include "app/cli/campaign.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/next_step.hpp"
#include "app/files/machine_json.hpp"
#include "app/files/mechanism_json.hpp"
#include "app/files/published_json.hpp"
#include "app/terminal/table.hpp"
#include "store/campaign.hpp"
#include "store/job.hpp"
#include "store/model.hpp"
#include "store/open.hpp"
#include "store/session.hpp"

namespace trammel::cli {

namespace {

std::string kind_of(const store::CampaignRow& row) { return row.simulated ? "simulated" : "real"; }
std::string origin_of(const store::CampaignRow& row) {
  return row.imported ? "imported" : "measured";
}

Json row_json(const store::CampaignRow& row) {
  return {{"name", row.name},
          {"uuid", row.uuid},
          {"kind", kind_of(row)},
          {"origin", origin_of(row)},
          {"created_utc", row.created_utc},
          {"n_sessions", row.n_sessions},
          {"n_readings", row.n_readings},
          {"n_exclusions", row.n_exclusions}};
}

// Everything `show` knows of a campaign.
struct Shown {
  store::CampaignRow row;
  store::LoadedCampaign loaded;
  std::vector<store::SessionRow> sessions;
  std::vector<store::JobRow> jobs;
  std::vector<store::Model> models;
  std::string chain_head;

  [[nodiscard]] std::string method(const store::SessionRow& session) const {
    for (const store::JobRow& job : jobs) {
      if (session.compensation_job == job.id) return fmt::format("{} (job {})", job.stage, job.id);
    }
    return session.compensated() ? session.compensation_name + " (imported)" : "baseline";
  }
};

Shown look_up(const std::string& name, const Context& context) {
  store::Connection db = store::open(context.db(), store::Access::read_only);
  Shown shown;
  shown.row = store::require_campaign(db, name);
  const store::Id id = shown.row.id;
  shown.loaded = store::load_campaign(db, id);
  shown.sessions = store::list_sessions(db, id);
  shown.jobs = store::list_jobs(db, id);
  shown.models = store::list_models(db, id);
  shown.chain_head = store::hex(store::chain_head(db, id));
  return shown;
}

Json parts_json(const Shown& s) {
  Json parts = {{"sessions", Json::array()},
                {"exclusions", Json::array()},
                {"jobs", Json::array()},
                {"models", Json::array()}};
  for (const store::SessionRow& session : s.sessions) {
    Json row = {{"name", session.name},        {"compensation_job", nullptr},
                {"plan", session.plan_name},   {"stage", session.stage},
                {"tracker", session.tracker},  {"n_points", session.n_points},
                {"n_ok", session.n_ok},        {"n_readings", session.n_readings},
                {"state", session.last_event}, {"created_utc", session.created_utc}};
    if (session.compensation_job) row["compensation_job"] = *session.compensation_job;
    if (session.compensated()) row["compensation"] = session.compensation_name;
    parts["sessions"].push_back(std::move(row));
  }
  for (const store::Exclusion& e : s.loaded.exclusions) {
    parts["exclusions"].push_back(
        {{"seq", e.seq}, {"reason", e.reason}, {"created_utc", e.created_utc}});
  }
  for (const store::JobRow& job : s.jobs) {
    parts["jobs"].push_back({{"job", job.id},
                             {"stage", job.stage},
                             {"algorithm_version", job.algorithm_version},
                             {"run", job.run},
                             {"key", job.key}});
  }
  for (const store::Model& model : s.models) {
    parts["models"].push_back({{"version", model.version}, {"name", model.data.name}});
  }
  return parts;
}

void print_json(const Shown& s, const Context& context) {
  Json out = row_json(s.row);
  out["chain_head"] = s.chain_head;
  const Machine& machine = s.loaded.campaign.machine;
  out["mechanism"] = machine.kind->chain == &kPrrChain ? Json(mechanism_json(mechanism_of(machine)))
                                                       : Json(machine_json(machine));
  out["facts"] = s.loaded.campaign.facts;
  out.update(parts_json(s));
  context.print("campaign-show", out);
}

void print_text(const Shown& s, const Context& context) {
  std::string head = fmt::format(
      "{}: {}, {}\nuuid        {}\ncreated     {}\nreadings    {} ({} excluded)\nchain head  {}\n",
      bold(printable(s.row.name)), kind_of(s.row), origin_of(s.row), s.row.uuid, s.row.created_utc,
      s.row.n_readings, s.row.n_exclusions, s.chain_head);
  for (const auto& [key, value] : s.loaded.campaign.facts) {
    if (key == kPublishedFact) continue;  // a page of figures: the report shows them
    head += fmt::format("{:<11} {}\n", printable(key), printable(value));
  }
  context.print(head);
  Table sessions({"session", "method", "plan", "points", "stored", "readings", "state"});
  for (const store::SessionRow& row : s.sessions) {
    sessions.add({row.name, s.method(row), row.plan_name, std::to_string(row.n_points),
                  std::to_string(row.n_ok), std::to_string(row.n_readings), row.last_event});
  }
  if (!s.sessions.empty()) context.print("\n" + sessions.text());
  Table exclusions({"excluded seq", "reason"});
  for (const store::Exclusion& e : s.loaded.exclusions) {
    exclusions.add({std::to_string(e.seq), e.reason});
  }
  if (!s.loaded.exclusions.empty()) context.print("\n" + exclusions.text());
  Table jobs({"job", "stage", "version", "run", "key"});
  for (const store::JobRow& job : s.jobs) {
    jobs.add({std::to_string(job.id), job.stage, std::to_string(job.algorithm_version),
              std::to_string(job.run), job.key.substr(0, 12)});
  }
  if (!s.jobs.empty()) context.print("\n" + jobs.text());
}

}  // namespace

ExitCode run_campaign_list(const CampaignListOptions&, Context& context) {
  store::Connection db = store::open(context.db(), store::Access::read_only);
  Table table({"name", "kind", "origin", "sessions", "readings", "excluded", "created"});
  Json all = Json::array();
  for (const store::CampaignRow& row : store::list_campaigns(db)) {
    all.push_back(row_json(row));
    table.add({row.name, kind_of(row), origin_of(row), std::to_string(row.n_sessions),
               std::to_string(row.n_readings), std::to_string(row.n_exclusions),
               row.created_utc.substr(0, 10)});
  }
  const std::string next =
      all.empty() ? "trammel campaign import FOLDER"
                  : "trammel campaign show " + shell_word(all.back()["name"].get<std::string>());
  if (context.json) {
    context.print("campaign-list", {{"campaigns", std::move(all)}});
  } else if (all.empty()) {
    context.say("no campaigns yet");
  } else {
    context.print(table.text());
  }
  context.next(next);
  return ExitCode::ok;
}

ExitCode run_campaign_show(const CampaignShowOptions& options, Context& context) {
  const Shown shown = look_up(options.campaign, context);
  context.json ? print_json(shown, context) : print_text(shown, context);
  context.next(
      (shown.jobs.empty() ? first_calibration(shown.loaded.campaign.machine) : "trammel report ") +
      shell_word(shown.row.name));
  return ExitCode::ok;
}

void setup_campaign(Command app, Context& context) {
  Command campaigns = noun(app, "campaign", "Campaigns: list, show, check, points, import, export");
  on_run(campaigns.command("list", "All campaigns of the database"), context,
         std::make_shared<CampaignListOptions>(), run_campaign_list);
  const auto options = std::make_shared<CampaignShowOptions>();
  Command show = campaigns.command("show", "Sessions, exclusions, jobs, models of one");
  show.option("CAMPAIGN", options->campaign, "Name or uuid").required();
  on_run(show, context, options, run_campaign_show);
}

}  // namespace trammel::cli
