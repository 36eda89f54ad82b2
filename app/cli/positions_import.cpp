#include "app/cli/positions_import.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/files/budget_json.hpp"
#include "app/files/files.hpp"
#include "app/files/json_file.hpp"
#include "app/files/machine_json.hpp"
#include "app/files/positions_campaign.hpp"
#include "app/terminal/counted.hpp"
#include "core/units.hpp"

namespace trammel::cli {

namespace {

PositionsUse use_of(const CampaignImportOptions& o) {
  PositionsUse use{.kind = o.axis.empty() ? "XY" : "X",
                   .name = o.name,
                   .in_order = o.positions.in_order,
                   .fit_every = o.positions.fit_every};
  if (!o.mechanism.empty()) use.machine = read_machine_file(o.mechanism);
  if (o.positions.sigma_xy_mm) {
    use.sigma =
        TrackerSigma{*o.positions.sigma_xy_mm, rad_from_deg(o.positions.sigma_phi_deg.value_or(0))};
  }
  return use;
}

/// What the session keeps of where its readings came from.
std::string provenance_json(const PositionsFile& file) {
  const std::string bytes = read_file(file.name, kMaxPositionsBytes);
  return Json{{"positions",
               {{"file", std::filesystem::path(file.name).filename().string()},
                {"sha256", store::hex(store::sha256_of(bytes))},
                {"format", file.format},
                {"unused_columns", file.unused}}}}
      .dump();
}

std::string positions_text(const PositionsFile& file, const Campaign& campaign) {
  std::vector<std::string_view> measured;
  for (std::size_t c = 0; c < 3; ++c) {
    if (campaign.machine.measured[c]) measured.push_back(kCoordinateNames[c]);
  }
  const auto fitted = std::ranges::count(campaign.readings, ReadingSet::identify, &Reading::set);
  std::string text = fmt::format("positions   {}: {}, {}; measured {}\n", printable(file.name),
                                 terminal::counted(file.rows.size(), "row"), file.format,
                                 fmt::join(measured, ", "));
  if (file.missed > 0) {
    text += fmt::format("missed      {} without a measured position\n",
                        terminal::counted(file.missed, "node"));
  }
  if (!file.unused.empty()) {
    text +=
        fmt::format("not used    {}\n", printable(fmt::format("{}", fmt::join(file.unused, ", "))));
  }
  if (static_cast<std::size_t>(fitted) < campaign.readings.size()) {
    text += fmt::format("sets        {} to fit, {} to validate\n", fitted,
                        campaign.readings.size() - static_cast<std::size_t>(fitted));
  }
  text += fmt::format("instrument  {}\n", budget_facts(campaign).instrument);
  for (const char* fact : {"machine", "approach"}) {
    const auto at = campaign.facts.find(fact);
    if (at != campaign.facts.end()) text += fmt::format("{:<11} {}\n", fact, at->second);
  }
  return text;
}

}  // namespace

ExitCode import_positions(const CampaignImportOptions& o, Context& context) {
  const bool one_axis = !o.axis.empty();
  const PositionsFile file = read_positions(one_axis ? o.axis : o.grid, {.unit = o.positions.unit,
                                                                         .axis = o.positions.only,
                                                                         .one_axis = one_axis,
                                                                         .runs = o.positions.runs});
  Campaign campaign = campaign_of_positions(file, use_of(o));
  Json budget = {{"instrument", o.positions.instrument}};
  if (o.positions.instrument_u_mm) budget["instrument_u_mm"] = *o.positions.instrument_u_mm;
  const JsonFile stated = parse_json(budget.dump(), "--instrument");
  campaign.facts[kBudgetFact] = read_budget(Fields(stated));
  return import_campaign({.campaign = campaign,
                          .store_it =
                              [&](store::Connection& db) {
                                return store::import_campaign(
                                    db, campaign, {.settings_json = provenance_json(file)});
                              },
                          .text = [&] { return positions_text(file, campaign); },
                          .add_fields =
                              [&](Json& fields) {
                                fields["positions"] = {{"file", file.name},
                                                       {"format", file.format},
                                                       {"machine", machine_json(campaign.machine)},
                                                       {"machine_assumed", o.mechanism.empty()},
                                                       {"unused_columns", file.unused}};
                              },
                          .next = "diagnose"},
                         o, context);
}

}  // namespace trammel::cli
