#pragma once

#include <functional>
#include <string>
#include <vector>

#include "app/cli/context.hpp"
#include "core/measure/screen.hpp"
#include "store/campaign.hpp"

namespace trammel::cli {

struct CampaignImportOptions {
  std::string folder;
  std::string name;  // empty: as the file says
  bool dry_run = false;
  std::string points;  // a tracker's file instead of a folder
  std::string layout;
  std::string mechanism, plan;  // empty: as the layout says
  std::string date;
  std::string frame;  // "fit": register the readings' frame on the targets
};
struct CampaignExportOptions {
  std::string campaign;
  std::string folder;
  bool dry_run = false;
};

/// `campaign import` and `campaign export`: the format campaign/2; import also takes points.
void setup_campaign_exchange(Command app, Context& context);

/// A campaign that the screen let in.
struct Admitted {
  std::vector<Suspicion> findings = {};  // none of them gross
  std::string frame = {};                // what was registered; empty: nothing

  [[nodiscard]] std::string text() const;
};
/// The door of every import: registers the frame where asked for, wraps phi near its target, and
/// refuses what the screen finds gross (InputError).
Admitted admitted_at_door(Campaign& campaign, const CampaignImportOptions& options);

using StoreIt = std::function<store::ImportResult(store::Connection&)>;
/// Runs `store_it` on the database; a dry run makes every check of it, and rolls all of it back.
store::ImportResult store_or_try(const StoreIt& store_it, bool dry_run, const Context& context);
/// "imported campaign bench: 24 readings"
std::string imported_text(const store::ImportResult& result, bool dry_run,
                          const Campaign& campaign);

ExitCode run_campaign_import(const CampaignImportOptions& options, Context& context);
ExitCode run_campaign_export(const CampaignExportOptions& options, Context& context);

}  // namespace trammel::cli
