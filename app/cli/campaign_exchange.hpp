#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/cli/context.hpp"
#include "core/measure/screen.hpp"
#include "store/campaign.hpp"

namespace trammel::cli {

/// How a table of positions is to be read, beside what it says itself.
struct PositionsGiven {
  std::string unit, only, runs;
  bool in_order = false;
  int fit_every = 1;
  std::optional<double> sigma_xy_mm, sigma_phi_deg;
  std::string instrument = "unknown";  // that made the table; whose standard uncertainty may be
  std::optional<double> instrument_u_mm;
};

struct CampaignImportOptions {
  std::string folder;
  std::string name;  // empty: as the file says
  bool dry_run = false;
  std::string points;  // a tracker's file instead of a folder
  std::string layout;
  std::string mechanism, plan;  // empty: as the layout says
  std::string date;
  std::string grid, axis;  // a table of positions instead
  PositionsGiven positions;
  std::string frame;  // "fit": register the readings' frame on the targets
};
struct CampaignExportOptions {
  std::string campaign;
  std::string folder;
  bool dry_run = false;
};

/// `campaign import` and `campaign export`: the format campaign/2; import also takes points, and
/// tables of positions.
void setup_campaign_exchange(Command app, Context& context);

/// What kinds of imports differ in, from the door on.
struct Import {
  Campaign& campaign;
  std::function<store::ImportResult(store::Connection&)> store_it;
  std::function<std::string()> text = {};  // what was read, before "imported campaign bench: …"
  std::function<void(Json&)> add_fields = {};  // to the answer in JSON
  std::string next = {};  // command that goes on with the campaign; empty: a first calibration
  std::function<std::vector<Suspicion>()> screen = {};  // empty: of the campaign, all baseline
};
/// Through the door, into the database, and the answer. A dry run makes every check of it, and
/// rolls all of it back.
ExitCode import_campaign(const Import& import, const CampaignImportOptions& options,
                         Context& context);

ExitCode run_campaign_import(const CampaignImportOptions& options, Context& context);
ExitCode run_campaign_export(const CampaignExportOptions& options, Context& context);

}  // namespace trammel::cli
