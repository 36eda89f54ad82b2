#include "app/cli/points_import.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/files/files.hpp"
#include "app/files/json_file.hpp"
#include "app/files/mechanism_json.hpp"
#include "app/files/numbers.hpp"
#include "app/files/plan_json.hpp"
#include "app/files/points_campaign.hpp"
#include "app/job/screening.hpp"
#include "app/terminal/counted.hpp"
#include "core/units.hpp"

namespace trammel::cli {

namespace {

struct Loaded {
  Layout layout;
  PointsFile file;
  Plan plan;
  PointsCampaign made;
};

/// `given` from the line, else `stated` beside the layout.
std::string file_of(const std::string& given, const std::string& stated, const std::string& layout,
                    const char* what, const char* option) {
  if (!given.empty()) return given;
  if (!stated.empty()) return (std::filesystem::path(layout).parent_path() / stated).string();
  throw UsageError({.what = fmt::format("nothing says which {} was measured", what),
                    .where = {.field = option},
                    .hint = fmt::format("{} FILE, or \"{}\" in the layout", option, what)});
}

Plan plan_beside(const std::string& given, const Layout& layout) {
  if (given.empty() && !layout.plan.empty()) {
    const auto beside = std::filesystem::path(layout.file).parent_path() / layout.plan;
    return plan_of(std::filesystem::exists(beside) ? beside.string() : layout.plan);
  }
  return plan_of(file_of(given, layout.plan, layout.file, "plan", "--plan"));
}

Loaded load(const CampaignImportOptions& o) {
  Loaded loaded;
  loaded.layout = read_layout(o.layout);
  Layout& layout = loaded.layout;
  if (!o.name.empty()) layout.name = o.name;
  if (!o.date.empty()) layout.points.date = date_order(o.date);
  const Mechanism mechanism = read_mechanism_file(
      file_of(o.mechanism, layout.mechanism, layout.file, "mechanism", "--mechanism"));
  loaded.plan = plan_beside(o.plan, layout);
  loaded.file = read_points(o.points, layout.points);
  loaded.made = campaign_of_points(loaded.file, layout, mechanism, loaded.plan);
  return loaded;
}

Json dropped_json(const PointsCampaign& made) {
  Json all = Json::array();
  for (const DroppedRow& d : made.poses.dropped)
    all.push_back({{"lines", d.lines}, {"why", d.why}});
  return all;
}

Json drifts_json(const PointsCampaign& made) {
  Json all = Json::array();
  for (const DriftSeen& d : made.poses.drifts) {
    all.push_back({{"line", d.line},
                   {"nest", d.drift.nest},
                   {"moved_mm", d.drift.largest_mm},
                   {"limit_mm", d.drift.limit_mm},
                   {"moved", d.drift.moved},
                   {"shift_x_mm", d.drift.shift.x_mm},
                   {"shift_y_mm", d.drift.shift.y_mm},
                   {"shift_phi_deg", deg_from_rad(d.drift.shift.phi_rad)},
                   {"epoch", d.epoch}});
  }
  return all;
}

Json points_json(const Loaded& l) {
  const PointsCampaign& made = l.made;
  const TrackerSigma& sigma = *made.file.campaign.tracker;
  Json json = {{"file", l.file.name},
               {"format", l.file.format},
               {"unit", l.file.unit},
               {"plan", l.plan.name},
               {"n_rows", l.file.rows.size()},
               {"started_tracker_clock", made.started},
               {"sigma_xy_mm", sigma.xy_mm},
               {"sigma_phi_deg", deg_from_rad(sigma.phi_rad)},
               {"base_nests", made.poses.base.n_nests},
               {"base_rms_mm", made.poses.base.rms_mm},
               {"drifts", drifts_json(made)},
               {"sides", Json::array()},
               {"in_plane_rms_mm", made.rms_mm},
               {"out_of_plane_mm", made.out_of_plane_mm},
               {"height_spread_mm", made.height_spread_mm},
               {"dropped", dropped_json(made)}};
  for (const SideSeen& s : made.poses.sides) {
    json["sides"].push_back({{"side", s.side}, {"off_mm", s.off_mm}, {"scatter_mm", s.scatter_mm}});
  }
  return json;
}

/// What the session keeps of where its readings came from.
std::string provenance_json(const Loaded& l) {
  const auto bytes = read_file(l.file.name, kMaxPointsBytes);
  return Json{{"points",
               {{"file", std::filesystem::path(l.file.name).filename().string()},
                {"sha256", store::hex(store::sha256_of(bytes))},
                {"format", l.file.format},
                {"unit", l.file.unit},
                {"layout", read_json(l.layout.file).value},
                {"plan", l.plan.name},
                {"dropped", dropped_json(l.made)}}}}
      .dump();
}

std::string frame_text(const Loaded& l) {
  const PointsCampaign& made = l.made;
  if (l.layout.frame.from == FrameFrom::robot)
    return "frame       the robot's, as the layout says\n";
  if (l.layout.frame.from == FrameFrom::zeroing) {
    return "frame       plane of motion, zeroed at the first pose at home\n";
  }
  std::string text =
      fmt::format("frame       {} base nests, residual rms {} um, largest {} um ({})\n",
                  made.poses.base.n_nests, um_text(made.poses.base.rms_mm),
                  um_text(made.poses.base.max_mm), printable(made.poses.base.worst));
  for (const DriftSeen& d : made.poses.drifts) {
    text += fmt::format(
        "base        line {}: {} moved by {} um, limit {} um (one false alarm in "
        "{:.0f} checks){}\n",
        d.line, printable(d.drift.nest), um_text(d.drift.largest_mm), um_text(d.drift.limit_mm),
        1 / l.layout.frame.false_alarm,
        d.drift.moved ? fmt::format(": MOVED; epoch {} from here, and what was read "
                                    "since the check before is in doubt",
                                    d.epoch)
                      : "");
  }
  return text;
}

std::string made_text(const Loaded& l) {
  const PointsCampaign& made = l.made;
  const TrackerSigma& sigma = *made.file.campaign.tracker;
  std::string text =
      fmt::format("points      {}: {}, {}, {}\nplan        {}: {}\n", printable(l.file.name),
                  terminal::counted(l.file.rows.size(), "row"), l.file.format, l.file.unit,
                  printable(l.plan.name), terminal::counted(l.plan.points.size(), "pose"));
  if (!made.started.empty()) {
    text +=
        fmt::format("started     {} on the tracker's clock ({})\n", made.started, l.file.dates.why);
  }
  text += frame_text(l);
  text += fmt::format(
      "nests       in-plane residual rms {} um, out of plane up to {} um, height "
      "within {} um\n",
      um_text(made.rms_mm), um_text(made.out_of_plane_mm), um_text(made.height_spread_mm));
  for (const SideSeen& s : made.poses.sides) {
    text += fmt::format("side        {}: measured - layout {:+.1f} um, scatter {} um\n",
                        printable(s.side), rounded(s.off_mm * 1000, 1), um_text(s.scatter_mm));
  }
  text += fmt::format("a pose      known to {} um in x and y, {:.5f} deg in phi (one sigma)\n",
                      um_text(sigma.xy_mm), deg_from_rad(sigma.phi_rad));
  for (const DroppedRow& d : made.poses.dropped) {
    text += fmt::format("left out    line{} {}: {}\n", d.lines.size() > 1 ? "s" : "",
                        fmt::join(d.lines, ", "), printable(d.why));
  }
  return text;
}

}  // namespace

std::string um_text(double mm) { return fmt::format("{:.1f}", rounded(mm * 1000, 1)); }

ExitCode import_points(const CampaignImportOptions& o, Context& context) {
  Loaded loaded = load(o);
  Campaign& campaign = loaded.made.file.campaign;
  return import_campaign(
      {.campaign = campaign,
       .store_it =
           [&](store::Connection& db) {
             return store::import_campaign(
                 db, campaign,
                 {.raw_reply = loaded.made.raw_reply, .settings_json = provenance_json(loaded)});
           },
       .text = [&loaded] { return made_text(loaded); },
       .add_fields = [&loaded](Json& fields) { fields["points"] = points_json(loaded); }},
      o, context);
}

}  // namespace trammel::cli
