#include "app/cli/campaign_points.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/points_import.hpp"
#include "app/files/numbers.hpp"
#include "app/files/points_look.hpp"
#include "app/terminal/counted.hpp"
#include "app/terminal/table.hpp"
#include "core/judge/iso9283.hpp"

namespace trammel::cli {

namespace {

std::string rp_name(int n) {
  return n < kVisitsOfTheStandard ? fmt::format("RP_l (n = {})", n) : "RP_l";
}

Json place_json(const PlaceLook& p) {
  Json json = {{"place", p.place},
               {"n", p.n},
               {"misses", Json::array()},
               {"outliers", Json::array()},
               {"outlier_limit_mm", p.limit_mm ? Json(*p.limit_mm) : Json()},
               {"median_mm", {p.median_mm.x(), p.median_mm.y(), p.median_mm.z()}},
               {"rms_mm", p.rms_mm},
               {"RP_l_mm", p.RP_l_mm ? Json(*p.RP_l_mm) : Json()},
               {"RP_l_n_of_standard", kVisitsOfTheStandard}};
  for (const auto& miss : p.misses) {
    json["misses"].push_back({{"line", miss.line}, {"why", name_of(miss.why)}});
  }
  for (const auto& outlier : p.outliers) {
    json["outliers"].push_back({{"line", outlier.line}, {"distance_mm", outlier.distance_mm}});
  }
  return json;
}

Json look_json(const PointsFile& file, const PointsLook& look) {
  Json json = {{"file", file.name},
               {"format", file.format},
               {"unit", file.unit},
               {"unit_stated", file.unit_stated},
               {"frame", file.frame},
               {"program", file.program},
               {"code_page_1252", file.code_page_1252},
               {"n_rows", file.rows.size()},
               {"dates", file.dates.why},
               {"n_without_u95", look.n_without_u95},
               {"places", Json::array()}};
  for (const PlaceLook& place : look.places) json["places"].push_back(place_json(place));
  return json;
}

std::string head_text(const PointsFile& file, const PointsLook& look) {
  std::string text = fmt::format(
      "{}: {}, {}, {}{}\n", bold(printable(file.name)), terminal::counted(file.rows.size(), "row"),
      file.format, printable(file.unit), file.unit_stated ? "" : " (not stated in the file)");
  if (!file.program.empty()) text += "program   " + printable(file.program) + "\n";
  if (!file.frame.empty()) text += "frame     " + printable(file.frame) + "\n";
  text += "dates     " + file.dates.why + "\n";
  if (file.code_page_1252) text += "encoding  code page 1252\n";
  if (look.n_without_u95 > 0) {
    text += fmt::format("U(95)     0 in {}: no estimate, not a perfect one\n",
                        terminal::counted(look.n_without_u95, "row"));
  }
  return text;
}

std::string rows_out_text(const PlaceLook& place) {
  std::string text;
  for (const auto& miss : place.misses) {
    text += fmt::format("line {}: {}: miss ({})\n", miss.line, printable(place.place),
                        name_of(miss.why));
  }
  for (const auto& outlier : place.outliers) {
    text += fmt::format("line {}: {}: gross outlier, {:.3f} mm from the median (limit {:.3f})\n",
                        outlier.line, printable(place.place), outlier.distance_mm, *place.limit_mm);
  }
  return text;
}

std::string look_text(const PointsFile& file, const PointsLook& look) {
  Table table({"place", "n", "misses", "outliers", "rms um", "RP_l um", "x mm", "y mm", "z mm"});
  std::string rows_out;
  int least_n = kVisitsOfTheStandard;
  for (const PlaceLook& p : look.places) {
    const auto coordinate = [&p](Eigen::Index k) {
      return fmt::format("{:.4f}", rounded(p.median_mm[k], 4));
    };
    table.add({p.place, std::to_string(p.n), std::to_string(p.misses.size()),
               std::to_string(p.outliers.size()), um_text(p.rms_mm),
               p.RP_l_mm ? um_text(*p.RP_l_mm) : "-", coordinate(0), coordinate(1), coordinate(2)});
    rows_out += rows_out_text(p);
    if (p.RP_l_mm) least_n = std::min(least_n, p.n);
  }
  std::string text = head_text(file, look) + "\n" + table.text();
  text += "\nrms: of the distances from the median, outliers left out; x, y, z: the median\n";
  if (least_n < kVisitsOfTheStandard) {
    text += fmt::format("RP_l as in ISO 9283, which asks for n >= {}: call it {}\n",
                        kVisitsOfTheStandard, rp_name(least_n));
  }
  return text + (rows_out.empty() ? "" : "\n" + rows_out);
}

}  // namespace

ExitCode run_campaign_points(const CampaignPointsOptions& o, Context& context) {
  PointsOptions options;
  options.format = o.format;
  options.unit = o.unit;
  options.date = date_order(o.date);
  options.decimal = o.decimal.front();
  const PointsFile file = read_points(o.file, options);
  const std::map<std::string, PlaceBy> kBy = {
      {"name", PlaceBy::name}, {"group", PlaceBy::group}, {"file", PlaceBy::file}};
  const PointsLook look =
      look_at(file, o.by.empty() ? std::nullopt : std::optional(kBy.at(o.by)), o.nests);
  if (context.json) {
    context.print("campaign-points", look_json(file, look));
  } else {
    context.print(look_text(file, look));
  }
  return ExitCode::ok;
}

void setup_campaign_points(Command campaigns, Context& context) {
  auto o = std::make_shared<CampaignPointsOptions>();
  Command look = campaigns.command(
      "points", "Look into a tracker's file of points: misses, outliers, repeatability");
  look.option("FILE", o->file, "Points as SpatialAnalyzer, Leica or a script wrote them")
      .required();
  std::vector<std::string> formats;
  for (const PointsFormat& format : points_formats()) formats.emplace_back(format.name);
  look.option("--format", o->format, "default: recognised").one_of(formats);
  look.option("--unit", o->unit, "of the file (default: as it states, else mm)")
      .one_of({"mm", "m", "um", "in"});
  look.option("--date", o->date, "how dates are written, where no line decides")
      .one_of(date_order_names());
  look.option("--decimal", o->decimal, "decimal sign").one_of({".", ","}).shown_default();
  look.option("--by", o->by, "rows of one place share this (default: recognised)")
      .one_of({"name", "group", "file"});
  look.option("--nests", o->nests, "rows go round so many nests, whatever their names")
      .range(0, 1000);
  on_run(look, context, o, run_campaign_points);
}

}  // namespace trammel::cli
