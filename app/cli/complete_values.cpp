// Values of a command line that come from the database and from tables of the program.

#include <fmt/format.h>

#include <array>

#include "app/cli/complete.hpp"
#include "app/device/open.hpp"
#include "app/job/stages.hpp"
#include "app/terminal/counted.hpp"
#include "core/model/effect.hpp"
#include "core/plan/named.hpp"
#include "store/campaign.hpp"
#include "store/job.hpp"
#include "store/model.hpp"
#include "store/open.hpp"
#include "store/query.hpp"
#include "store/session.hpp"

namespace trammel::cli {

namespace {

using store::Connection;

std::optional<store::Id> campaign_of(Connection& db, const Given& given) {
  const auto name = given.find("CAMPAIGN");
  if (name == given.end()) return std::nullopt;
  return store::require_campaign(db, name->second).id;
}

Candidates campaigns(Connection& db, const Given&) {
  Candidates found;
  for (const store::CampaignRow& row : store::list_campaigns(db)) {
    found.words.push_back({row.name, fmt::format("{}, {}", row.simulated ? "simulated" : "real",
                                                 terminal::counted(row.n_readings, "reading"))});
  }
  return found;
}

Candidates sessions(Connection& db, const Given& given) {
  Candidates found;
  const auto campaign = campaign_of(db, given);
  if (!campaign) return found;
  for (const store::SessionRow& row : store::list_sessions(db, *campaign)) {
    found.words.push_back({row.name, terminal::counted(row.n_readings, "reading")});
  }
  return found;
}

Candidates jobs(Connection& db, const Given& given) {
  Candidates found;
  for (const store::JobRow& row : store::list_jobs(db, campaign_of(db, given))) {
    found.words.push_back({std::to_string(row.id), row.stage + " of " + row.campaign});
  }
  return found;
}

Candidates versions(Connection& db, const Given& given) {
  Candidates found{.words = {{"last", "the newest"}}};
  const auto campaign = campaign_of(db, given);
  if (!campaign) return found;
  for (const store::Model& model : store::list_models(db, *campaign)) {
    found.words.push_back({std::to_string(model.version), model.data.name});
  }
  return found;
}

Candidates tables(Connection& db, const Given&) {
  Candidates found;
  store::Query query(db,
                     "SELECT name FROM sqlite_schema WHERE type IN ('table', 'view') AND name NOT "
                     "LIKE 'sqlite%' ORDER BY type DESC, name",
                     std::chrono::seconds(1));
  while (const auto row = query.next()) {
    found.words.push_back({std::get<std::string>(row->front()), "all of it"});
  }
  return found;
}

Candidates plans() {
  Candidates found{.words = {}, .paths = Paths::files};
  for (const std::string& name : grid_names()) found.words.push_back({name, "grid"});
  return found;
}

Candidates effects() {
  Candidates found;
  for (const Effect& effect : effect_catalogue()) {
    found.words.push_back({effect.name, effect.sentence});
  }
  return found;
}

Candidates devices() {
  Candidates found{.words = {}, .paths = Paths::files};
  for (const std::string& kind : device::stage_kinds()) found.words.push_back({kind, "FILE"});
  return found;
}

Candidates trackers() {
  return {.words = {{"sim", "sees a simulated stage"}, {"t2sa:", "FILE"}, {"file:", "FILE"}},
          .paths = Paths::files};
}

Candidates stages() {
  Candidates found;
  for (const job::Stage& stage : job::stages()) found.words.push_back({stage.name, stage.what});
  return found;
}

struct Stored {
  const char* name;
  Candidates (*values)(Connection& db, const Given& given);
};
constexpr std::array<Stored, 5> kStored = {{{"CAMPAIGN", campaigns},
                                            {"SESSION", sessions},
                                            {"JOB", jobs},
                                            {"VERSION", versions},
                                            {"SQL", tables}}};

struct Fixed {
  const char* name;
  Candidates (*values)();
};
constexpr std::array<Fixed, 7> kFixed = {
    {{"FILE", [] { return Candidates{.words = {}, .paths = Paths::files}; }},
     {"FOLDER", [] { return Candidates{.words = {}, .paths = Paths::folders}; }},
     {"PLAN", plans},
     {"EFFECT", effects},
     {"METHOD", stages},
     {"STAGE", devices},
     {"TRACKER", trackers}}};

}  // namespace

Candidates stored_values(const std::string& name, const Given& given, const Context& context) {
  for (const Fixed& fixed : kFixed) {
    if (name == fixed.name) return fixed.values();
  }
  for (const Stored& stored : kStored) {
    if (name != stored.name) continue;
    const auto file = given.find("--db");
    try {
      Connection db =
          store::open(file == given.end() ? context.db() : file->second, store::Access::read_only);
      return stored.values(db, given);
    } catch (const Error&) {
      return {};  // a line that is being typed is no place for errors
    }
  }
  return {};
}

}  // namespace trammel::cli
