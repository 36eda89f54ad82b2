#include "app/cli/campaign_exchange.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/campaign_check.hpp"
#include "app/cli/campaign_points.hpp"
#include "app/cli/points_import.hpp"
#include "app/files/stored_campaign.hpp"
#include "app/files/tracker_clock.hpp"
#include "app/job/screening.hpp"
#include "core/measure/gross.hpp"
#include "core/units.hpp"
#include "store/open.hpp"
#include "store/transaction.hpp"

namespace trammel::cli {

namespace {

/// A folder of campaign/2 or /1, or a tracker's points with their layout.
void require_one_source(const CampaignImportOptions& o) {
  const bool points = !o.points.empty();
  if (points != o.folder.empty()) {
    throw UsageError(
        {.what = points ? "a folder and --points: which of them?" : "nothing to import",
         .expected = "FOLDER, or --points FILE --layout FILE"});
  }
  if (points && o.layout.empty()) {
    throw UsageError({.what = "nothing says what the points mean",
                      .where = {.field = "--layout"},
                      .hint = "copy one from examples/tracker-files"});
  }
  for (const auto& [option, value] : {std::pair{"--layout", o.layout},
                                      {"--mechanism", o.mechanism},
                                      {"--plan", o.plan},
                                      {"--date", o.date}}) {
    if (points || value.empty()) continue;
    throw UsageError({.what = "this option goes with --points", .where = {.field = option}});
  }
}

}  // namespace

store::ImportResult store_or_try(const StoreIt& store_it, bool dry_run, const Context& context) {
  if (!dry_run) {
    store::Connection db = store::open(context.db(), store::Access::create);
    return store_it(db);
  }
  if (!std::filesystem::exists(context.db())) return {};
  store::Connection db = store::open(context.db(), store::Access::write);
  const store::Transaction rolled_back(db);
  return store_it(db);
}

std::string imported_text(const store::ImportResult& result, bool dry_run,
                          const Campaign& campaign) {
  return fmt::format("{} campaign {}: {} readings",
                     result.already_stored ? "already stored:"
                     : dry_run             ? "dry run, would import"
                                           : "imported",
                     printable(campaign.name), campaign.readings.size());
}

Admitted admitted_at_door(Campaign& campaign, const CampaignImportOptions& options) {
  Admitted admitted;
  if (options.frame == "fit") {
    const auto frame = fitted_frame(campaign);
    if (!frame) {
      throw InputError({.what = "no turned and shifted frame takes the readings to their targets",
                        .where = {.field = "--frame"},
                        .hint = "trammel campaign check names what is wrong"});
    }
    for (Reading& r : campaign.readings) {
      if (r.measured) r.measured = in_robot_frame(*frame, *r.measured);
    }
    admitted.frame = fmt::format(
        "registered on the targets: readings were turned by {:.6g} deg and shifted by ({:.6g}, "
        "{:.6g}) mm, taken back",
        deg_from_rad(frame->turn_rad), frame->shift_x_mm, frame->shift_y_mm);
    campaign.facts["frame"] = admitted.frame;
  }
  for (Reading& r : campaign.readings) {
    if (r.measured) r.measured->phi_rad = near_target_rad(r.measured->phi_rad, r.target.phi_rad);
  }
  admitted.findings = screened(campaign);
  require_sound(campaign, admitted.findings,
                "`trammel campaign check` and `trammel diagnose --from` show it too");
  return admitted;
}

std::string Admitted::text() const {
  return (frame.empty() ? "" : "\nframe   " + frame) + "\n" + job::findings_text(findings);
}

ExitCode run_campaign_import(const CampaignImportOptions& options, Context& context) {
  require_one_source(options);
  if (!options.points.empty()) return import_points(options, context);
  CampaignFile file = read_campaign(options.folder);
  if (!options.name.empty()) file.campaign.name = options.name;
  const Admitted admitted = admitted_at_door(file.campaign, options);
  const store::ImportResult result = store_or_try(
      [&](store::Connection& db) { return store_campaign(db, file); }, options.dry_run, context);
  const std::string& name = file.campaign.name;
  if (context.json) {
    context.print("campaign-import", {{"campaign", name},
                                      {"n_readings", file.campaign.readings.size()},
                                      {"already_stored", result.already_stored},
                                      {"dry_run", options.dry_run},
                                      {"findings", job::findings_json(admitted.findings)}});
  } else {
    context.print(imported_text(result, options.dry_run, file.campaign) + admitted.text());
  }
  if (!options.dry_run) context.next("trammel calibrate lsq " + shell_word(name));
  return ExitCode::ok;
}

ExitCode run_campaign_export(const CampaignExportOptions& options, Context& context) {
  store::Connection connection = store::open(context.db(), store::Access::read_only);
  const store::CampaignRow campaign = store::require_campaign(connection, options.campaign);
  const CampaignFile file = stored_campaign(connection, campaign);
  if (!options.dry_run) write_campaign(file, options.folder, context.existing());
  if (context.json) {
    context.print("campaign-export", {{"campaign", campaign.name},
                                      {"folder", options.folder},
                                      {"n_readings", file.campaign.readings.size()},
                                      {"dry_run", options.dry_run}});
  } else {
    context.print(fmt::format(
        "{} campaign {}: {} readings to {}", options.dry_run ? "would export" : "exported",
        printable(campaign.name), file.campaign.readings.size(), printable(options.folder)));
  }
  return ExitCode::ok;
}

void setup_campaign_exchange(Command app, Context& context) {
  Command campaigns = noun(app, "campaign", "Campaigns: list, show, check, points, import, export");
  auto in = std::make_shared<CampaignImportOptions>();
  Command import = campaigns.command(
      "import", "Store a campaign/2 (or /1) of another tool, or a tracker's file of points");
  import.option("FOLDER", in->folder, "Folder with campaign.json, or that file");
  import.option("--points", in->points, "Instead: a tracker's file of points").type("FILE");
  import.option("--layout", in->layout, "points: what its rows mean (layout/1)").type("FILE");
  import.option("--mechanism", in->mechanism, "points: mechanism file (as the layout says)")
      .type("FILE");
  import.option("--plan", in->plan, "points: plan that was measured (as the layout says)")
      .type("PLAN");
  import.option("--date", in->date, "points: how dates are written (as the layout says)")
      .one_of(date_order_names());
  import.option("--name", in->name, "Name it is stored under (default: as the file says)")
      .type("NAME");
  import
      .option("--frame", in->frame,
              "fit: take a tracker's own frame, turned and shifted, onto the targets (as-is)")
      .one_of({"as-is", "fit"});
  import.flag("--dry-run", in->dry_run, "Read and check all of it, store nothing");
  on_run(import, context, in, run_campaign_import);

  setup_campaign_points(campaigns, context);
  setup_campaign_check(campaigns, context);

  auto out = std::make_shared<CampaignExportOptions>();
  Command exporting = campaigns.command("export", "Write a campaign as campaign/2");
  exporting.option("CAMPAIGN", out->campaign, "Name or uuid").required();
  exporting.option("--out,FOLDER", out->folder, "Where campaign.json and readings.csv go")
      .required()
      .type("FOLDER");
  exporting.flag("--dry-run", out->dry_run, "Say what would be written, write nothing");
  on_run(exporting, context, out, run_campaign_export);
}

}  // namespace trammel::cli
