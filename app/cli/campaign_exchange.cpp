#include "app/cli/campaign_exchange.hpp"

#include "app/cli/next_step.hpp"

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>

#include "app/cli/campaign_check.hpp"
#include "app/cli/campaign_points.hpp"
#include "app/cli/points_import.hpp"
#include "app/cli/positions_import.hpp"
#include "app/files/stored_campaign.hpp"
#include "app/files/tracker_clock.hpp"
#include "app/job/screening.hpp"
#include "app/terminal/counted.hpp"
#include "core/measure/gross.hpp"
#include "core/mechanism/nominal_machine.hpp"
#include "core/units.hpp"
#include "store/open.hpp"
#include "store/transaction.hpp"

namespace trammel::cli {

namespace {

/// What is said of a table of positions does nothing for any other source.
void require_used(const CampaignImportOptions& o) {
  const PositionsGiven& p = o.positions;
  const bool grid = !o.grid.empty(), axis = !o.axis.empty(), either = grid || axis;
  struct Use {
    const char* option;
    bool given, used;
    const char* with;
  };
  const std::array<Use, 9> uses = {
      {{"--unit", !p.unit.empty(), either, "--grid or --axis"},
       {"--only", !p.only.empty(), axis, "--axis"},
       {"--runs", !p.runs.empty(), axis, "--axis"},
       {"--in-order", p.in_order, grid, "--grid"},
       {"--fit-every", p.fit_every != 1, either, "--grid or --axis"},
       {"--sigma-xy", p.sigma_xy_mm.has_value(), either, "--grid or --axis"},
       {"--instrument", p.instrument != PositionsGiven{}.instrument, either, "--grid or --axis"},
       {"--instrument-u", p.instrument_u_mm.has_value(), either, "--grid or --axis"},
       {"--sigma-phi", p.sigma_phi_deg.has_value(), grid && p.sigma_xy_mm,
        "--grid and --sigma-xy"}}};
  for (const Use& use : uses) {
    if (!use.given || use.used) continue;
    throw UsageError(
        {.what = std::string("this option goes with ") + use.with, .where = {.field = use.option}});
  }
}

/// A folder of campaign/2 or /1, a tracker's points with their layout, or a table of positions.
void require_one_source(const CampaignImportOptions& o) {
  const bool points = !o.points.empty(), positions = !o.grid.empty() || !o.axis.empty();
  const int sources = (o.folder.empty() ? 0 : 1) + (points ? 1 : 0) + (o.grid.empty() ? 0 : 1) +
                      (o.axis.empty() ? 0 : 1);
  if (sources != 1) {
    throw UsageError(
        {.what = sources > 1 ? "several things to import: which of them?" : "nothing to import",
         .expected = "FOLDER, --points FILE --layout FILE, --grid FILE or "
                     "--axis FILE"});
  }
  if (points && o.layout.empty()) {
    throw UsageError({.what = "no layout explains the points",
                      .where = {.field = "--layout"},
                      .hint = "copy one from examples/tracker-files"});
  }
  for (const auto& [option, value] : {std::pair{"--layout", o.layout},
                                      {"--mechanism", o.mechanism},
                                      {"--plan", o.plan},
                                      {"--date", o.date}}) {
    const bool of_positions = positions && std::string_view(option) == "--mechanism";
    if (points || of_positions || value.empty()) continue;
    throw UsageError({.what = "this option goes with --points", .where = {.field = option}});
  }
  require_used(o);
}

using StoreIt = std::function<store::ImportResult(store::Connection&)>;

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
  return fmt::format("{} campaign {}: {}",
                     result.already_stored ? "already stored:"
                     : dry_run             ? "dry run, would import"
                                           : "imported",
                     printable(campaign.name),
                     terminal::counted(campaign.readings.size(), "reading"));
}

/// A campaign that the screen let in.
struct Admitted {
  std::vector<Suspicion> findings = {};  // none of them gross
  std::string frame = {};                // what was registered; empty: nothing

  [[nodiscard]] std::string text() const {
    return (frame.empty() ? "" : "\nframe   " + frame) + "\n" + job::findings_text(findings);
  }
};

/// The door of every import: registers the frame where asked for, wraps phi near its target, and
/// refuses what the screen finds gross (InputError).
Admitted admitted_at_door(const Import& import, const CampaignImportOptions& options) {
  Campaign& campaign = import.campaign;
  Admitted admitted;
  if (options.frame == "fit") {
    const auto frame = fitted_frame(campaign);
    if (!frame) {
      throw InputError({.what = "no turned and shifted frame takes the readings to their targets",
                        .where = {.field = "--frame"},
                        .hint = "trammel campaign check names what is wrong"});
    }
    const NominalMachine machine(campaign.machine);
    for (Reading& r : campaign.readings) {
      if (r.measured)
        r.measured = machine.measured_else(in_robot_frame(*frame, *r.measured), *r.measured);
    }
    admitted.frame = fmt::format(
        "registered on the targets: readings were turned by {:.6g} deg and shifted by ({:.6g}, "
        "{:.6g}) mm, taken back",
        deg_from_rad(frame->turn_rad), frame->shift_x_mm, frame->shift_y_mm);
    campaign.facts["frame"] = admitted.frame;
  }
  for (Reading& r : campaign.readings) {
    r.target.phi_rad = near_target_rad(r.target.phi_rad, campaign.machine.home.phi_rad);
    if (r.measured) r.measured->phi_rad = near_target_rad(r.measured->phi_rad, r.target.phi_rad);
  }
  admitted.findings = import.screen ? import.screen() : screened(campaign);
  require_sound(campaign, admitted.findings,
                "`trammel campaign check` and `trammel diagnose --from` show it too");
  return admitted;
}

}  // namespace

ExitCode import_campaign(const Import& import, const CampaignImportOptions& options,
                         Context& context) {
  Campaign& campaign = import.campaign;
  const Admitted admitted = admitted_at_door(import, options);
  const store::ImportResult result = store_or_try(import.store_it, options.dry_run, context);
  if (context.json) {
    Json fields = {{"campaign", campaign.name},
                   {"n_readings", campaign.readings.size()},
                   {"already_stored", result.already_stored},
                   {"dry_run", options.dry_run},
                   {"findings", job::findings_json(admitted.findings)}};
    if (import.add_fields) import.add_fields(fields);
    context.print("campaign-import", fields);
  } else {
    context.print((import.text ? import.text() : "") +
                  imported_text(result, options.dry_run, campaign) + admitted.text());
  }
  if (!options.dry_run)
    context.next((import.next.empty() ? first_calibration(campaign.machine)
                                      : "trammel " + import.next + " ") +
                 shell_word(campaign.name));
  return ExitCode::ok;
}

ExitCode run_campaign_import(const CampaignImportOptions& options, Context& context) {
  require_one_source(options);
  if (!options.points.empty()) return import_points(options, context);
  if (!options.grid.empty() || !options.axis.empty()) return import_positions(options, context);
  CampaignFile file = read_campaign(options.folder);
  if (!options.name.empty()) file.campaign.name = options.name;
  return import_campaign(
      {.campaign = file.campaign,
       .store_it = [&file](store::Connection& db) { return store_campaign(db, file); },
       .screen = [&file] { return screened(file); }},
      options, context);
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
        "{} campaign {}: {} to {}", options.dry_run ? "would export" : "exported",
        printable(campaign.name), terminal::counted(file.campaign.readings.size(), "reading"),
        printable(options.folder)));
  }
  return ExitCode::ok;
}

void setup_campaign_exchange(Command app, Context& context) {
  Command campaigns = noun(app, "campaign", "Campaigns: list, show, check, points, import, export");
  auto in = std::make_shared<CampaignImportOptions>();
  Command import = campaigns.command(
      "import", "Store a campaign/2 (or /1) of another tool, a tracker's points, an error map");
  import.option("FOLDER", in->folder, "Folder with campaign.json, or that file");
  import.option("--points", in->points, "Instead: a tracker's file of points").type("FILE");
  import.option("--layout", in->layout, "points: what its rows mean (layout/1)").type("FILE");
  import
      .option("--mechanism", in->mechanism,
              "points: mechanism file (as in the layout); grid, axis: machine file (assumed)")
      .type("FILE");
  import.option("--plan", in->plan, "points: plan that was measured (as in the layout)")
      .type("PLAN");
  import.option("--date", in->date, "points: how dates are written (as in the layout)")
      .one_of(date_order_names());
  import
      .option("--grid", in->grid,
              "Instead: commanded and measured positions of an XY stage (table, Aerotech)")
      .type("FILE");
  import
      .option("--axis", in->axis,
              "Instead: runs of one axis: target, run, direction, position (table, Renishaw RTL)")
      .type("FILE");
  import.option("--unit", in->positions.unit, "grid, axis: of lengths whose column names none")
      .one_of({"mm", "um", "m", "in"});
  import.option("--only", in->positions.only, "axis: of several in one table, this one")
      .type("AXIS");
  import
      .option("--runs", in->positions.runs,
              "axis, RTL: one-way, or both-ways where every second run came back")
      .one_of({"one-way", "both-ways"});
  import.flag("--in-order", in->positions.in_order,
              "grid: rows stand as they were measured, each move from the row before");
  import
      .option("--fit-every", in->positions.fit_every,
              "grid, axis: fit every Nth line of targets, validate on the others")
      .range(1, 1000)
      .shown_default();
  import.option("--sigma-xy", in->positions.sigma_xy_mm,
                "grid, axis: one sigma of a measured position, mm (from repeats)");
  import.option("--sigma-phi", in->positions.sigma_phi_deg, "grid: of a measured angle, deg");
  import
      .option("--instrument", in->positions.instrument,
              "grid, axis: what measured, for the budget of uncertainties: interferometer, "
              "grid-encoder, tracker")
      .one_of({"interferometer", "grid-encoder", "tracker", "unknown"})
      .shown_default();
  import.option("--instrument-u", in->positions.instrument_u_mm,
                "grid, axis: its standard uncertainty by calibration, mm");
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
