#include <fstream>

#include "app/device/stage_json.hpp"
#include "app/device/tracker_json.hpp"
#include "app/files/campaign_file.hpp"
#include "app/files/commands_csv.hpp"
#include "app/files/mechanism_json.hpp"
#include "app/files/plan_json.hpp"
#include "app/files/points_campaign.hpp"
#include "app/files/robot_json.hpp"
#include "app/job/run.hpp"
#include "app/job/stored_model.hpp"
#include "app/job/text.hpp"
#include "app/protocol/protocol.hpp"
#include "app/report/gather.hpp"
#include "core/plan/build.hpp"
#include "core/plan/grids.hpp"
#include "store/open.hpp"
#include "store/query.hpp"
#include "store/session.hpp"
#include "store/verify.hpp"
#include "tests/stress/mutate.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary.hpp"

namespace trammel::test {

namespace {

namespace fs = std::filesystem;
using tests::read_text;

const fs::path kSource = tests::source_folder();
const fs::path kCampaign = kSource / "tests/support/campaigns/drive-error";

void copy_into(const fs::path& folder, const char* name) {
  fs::copy_file(kCampaign / name, folder / name, fs::copy_options::overwrite_existing);
}

std::string commands_of(const std::string& readings) {
  // The same columns: a readings.csv is a file of commands, too.
  return readings.substr(0, readings.size() / 4);
}

const fs::path kTrackerFiles = kSource / "examples/tracker-files";

/// As `campaign import --points` does it, with the layout in `layout`.
void take_points(const fs::path& points, const fs::path& layout) {
  const Layout known = read_layout(layout);
  static_cast<void>(campaign_of_points(read_points(points, known.points), known, paper_mechanism(),
                                       read_plan(kTrackerFiles / "plan.json")));
}

std::string plan_text() {
  const Plan plan = build_plan({.name = "p",
                                .groups = {{"grid", paper_80(25, 2)}},
                                .approaches = {Approach{0, 0, 0}, Approach{1, 0, -1}},
                                .repeats = 2});
  return plan_json(plan).dump(1);
}

/// A laboratory with an import, two jobs, a model and an exclusion, in one file without a log.
std::string database_bytes(const fs::path& folder) {
  const fs::path file = folder / "seed.db", copy = folder / "seed-copy.db";
  for (const fs::path& old : {file, copy}) fs::remove(old);
  {
    store::Connection db = store::open(file, store::Access::create);
    Campaign campaign = read_campaign(kCampaign).campaign;
    campaign.name = "seed";
    const store::Id id = store::import_campaign(db, campaign).campaign_id;
    store::exclude_reading(db, id, 5, "bumped");
    const auto job = job::run(db, {.campaign = "seed", .stage = "idw"}).job;
    job::run(db, {.campaign = "seed", .stage = "lsq"});
    store::add_model(db, {.campaign_id = id, .name = "nominal", .job_id = job.id});
  }
  store::Connection(file, store::Access::write).execute("VACUUM INTO '" + copy.string() + "'");
  return read_text(copy);
}

void ask(store::Connection& db, const std::string& question) {
  using namespace std::chrono_literals;
  store::Query query(db, question, 2s);
  while (query.next()) {
  }
}

/// All that a person would do with a file that came by mail.
void look_through(const fs::path& file) {
  store::Connection db = store::open(file, store::Access::read_only);
  static_cast<void>(store::verify(db));
  for (const char* view :
       {"v_accuracy", "v_point_error", "v_job", "v_job_point", "v_drift", "v_point_status"}) {
    ask(db, view);
  }
  for (const store::CampaignRow& campaign : store::list_campaigns(db)) {
    static_cast<void>(store::list_sessions(db, campaign.id));
    static_cast<void>(store::load_campaign(db, campaign.id));
    static_cast<void>(store::chain_head(db, campaign.id));
    static_cast<void>(store::list_models(db, campaign.id));
    for (const store::JobRow& row : store::list_jobs(db, campaign.id)) {
      const store::Job job = store::get_job(db, row.id);
      static_cast<void>(job::job_text(job, campaign));
      static_cast<void>(
          job::job_json(job, campaign)
              .dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
      static_cast<void>(job::inputs_of(db, job::request_of(db, job)));
    }
    static_cast<void>(report::gather(db, campaign));
  }
}

void take_database(const fs::path& file) {
  try {
    look_through(file);
    store::Connection db = store::open(file, store::Access::write);
    for (const store::CampaignRow& campaign : store::list_campaigns(db)) {
      store::exclude_reading(db, campaign.id, 7, "a mutation");
    }
  } catch (const nlohmann::json::exception& error) {
    // As the command line answers it.
    throw StoreError({.what = "stored JSON is not what this program writes", .got = error.what()});
  }
}

}  // namespace

std::vector<Importer> importers(const fs::path& folder) {
  const std::string readings = read_text(kCampaign / "readings.csv");
  const std::string head = read_text(kCampaign / "campaign.json");
  const std::string robot = read_text(kSource / "examples/paper/robot.json");
  const std::string protocol = read_text(kSource / "examples/paper/protocol.json");
  const auto beside = [](const char* name) {
    return [name](const fs::path& here) { copy_into(here, name); };
  };
  const auto campaign_there = [](const fs::path& file) {
    static_cast<void>(read_campaign(file.parent_path()));
  };
  std::vector<Importer> all;
  all.push_back({"campaign", "campaign.json", {head}, beside("readings.csv"), campaign_there});
  all.push_back({"readings", "readings.csv", {readings}, beside("campaign.json"), campaign_there});
  all.push_back({"commands", "commands.csv", {commands_of(readings)}, {}, [](const fs::path& file) {
                   static_cast<void>(read_commands_csv(file, machine_of(paper_mechanism())));
                 }});
  all.push_back({"plan", "plan.json", {plan_text()}, {}, [](const fs::path& file) {
                   static_cast<void>(read_plan(file));
                 }});
  all.push_back({"robot", "robot.json", {robot}, {}, [](const fs::path& file) {
                   static_cast<void>(read_robot(file));
                 }});
  all.push_back({"protocol", "protocol.json", {protocol}, {}, [](const fs::path& file) {
                   static_cast<void>(protocol::read_protocol(file));
                 }});
  all.push_back({"mechanism", "mechanism.json", {robot, head}, {}, [](const fs::path& file) {
                   static_cast<void>(read_mechanism_file(file));
                 }});
  for (const std::string program : {"leica", "spatialanalyzer"}) {
    const std::string points = program == "leica" ? "leica.csv" : "spatialanalyzer.txt";
    const fs::path layout = kTrackerFiles / (program + ".layout.json");
    all.push_back({program + " points",
                   points,
                   {read_text(kTrackerFiles / points)},
                   {},
                   [layout](const fs::path& file) { take_points(file, layout); }});
    all.push_back({program + " layout",
                   "layout.json",
                   {read_text(layout)},
                   {},
                   [points](const fs::path& file) { take_points(kTrackerFiles / points, file); }});
  }
  all.push_back({"stage",
                 "stage.json",
                 {read_text(kSource / "examples/emulated/stage.json")},
                 {},
                 [](const fs::path& file) { static_cast<void>(device::read_stage(file)); }});
  all.push_back({"tracker",
                 "tracker.json",
                 {read_text(kSource / "examples/emulated/tracker.json")},
                 {},
                 [](const fs::path& file) { static_cast<void>(device::read_tracker(file)); }});
  all.push_back({"database", "lab.db", {database_bytes(folder)}, {}, take_database});
  return all;
}

}  // namespace trammel::test
