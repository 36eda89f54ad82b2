#include "app/cli/mechanism_maps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "app/files/mechanism_json.hpp"
#include "core/mechanism/sensitivity.hpp"
#include "core/mechanism/workspace.hpp"
#include "core/plan/grids.hpp"
#include "core/units.hpp"

namespace trammel::cli {

namespace {

struct MapOptions {
  std::string file;
  double half_width_mm = 100;
  double step_mm = 10;
  double phi_deg = 0;
  double angle_deg = 0.001;
  double length_mm = 0.05;
};

ExitCode run_sensitivity(const MapOptions& options, Context& context) {
  const Mechanism mechanism = read_mechanism_file(options.file);
  std::vector<Pose> poses = lattice(options.half_width_mm, options.step_mm);
  for (Pose& pose : poses) pose.phi_rad = rad_from_deg(options.phi_deg);
  const SensitivityShares shares =
      sensitivity(mechanism.geometry, poses, {rad_from_deg(options.angle_deg), options.length_mm});
  Json rows = Json::array();
  std::string text = fmt::format(
      "share of each error source in the pose error, mean of {} poses (Eq. 20)\n"
      "errors of {:g} deg and {:g} mm; grid of +-{:g} mm every {:g} mm at phi {:g} deg\n"
      "source      share of dx   of dy   of dphi\n",
      poses.size(), options.angle_deg, options.length_mm, options.half_width_mm, options.step_mm,
      options.phi_deg);
  for (int j = 0; j < kPaperParameters; ++j) {
    const std::string& name = geometry_parameters()[static_cast<std::size_t>(j)].name;
    rows.push_back(
        {{"source", name}, {"x", shares(0, j)}, {"y", shares(1, j)}, {"phi", shares(2, j)}});
    text += fmt::format("{:<10} {:>10.2f} % {:>6.2f} % {:>6.2f} %\n", name, 100 * shares(0, j),
                        100 * shares(1, j), 100 * shares(2, j));
  }
  const int of_chain = kPaperParameters / kChains;
  for (int i = 0; i < kChains; ++i) {  // Table II: which chain leads
    const Eigen::Vector3d sum = 100 * shares.middleCols(of_chain * i, of_chain).rowwise().sum();
    text += fmt::format("{:<10} {:>10.2f} % {:>6.2f} % {:>6.2f} %\n",
                        fmt::format("chain {}", i + 1), sum[0], sum[1], sum[2]);
  }
  if (context.json) {
    context.print("mechanism-sensitivity", {{"angle_deg", options.angle_deg},
                                            {"length_mm", options.length_mm},
                                            {"n_poses", poses.size()},
                                            {"shares", rows}});
  } else {
    context.print(text);
  }
  return ExitCode::ok;
}

/// One character per cell: how far from singular in tenths, or why it cannot be reached.
std::string map_text(const std::vector<WorkspaceCell>& map, const MapOptions& options) {
  const std::map<Reach::Status, char> kSigns = {{Reach::Status::unreachable, '.'},
                                                {Reach::Status::limit, '-'},
                                                {Reach::Status::not_finite, '?'}};
  std::vector<std::string> lines;
  double y = 0;
  for (const WorkspaceCell& cell : map) {
    if (lines.empty() || cell.pose.y_mm != y) lines.emplace_back();
    y = cell.pose.y_mm;
    const int tenths = std::min(9, static_cast<int>(10 * cell.reach.singularity.margin()));
    lines.back() +=
        cell.reach.ok() ? static_cast<char>('0' + tenths) : kSigns.at(cell.reach.status);
  }
  std::reverse(lines.begin(), lines.end());  // y upwards
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  const auto n_ok = std::count_if(map.begin(), map.end(),
                                  [](const WorkspaceCell& cell) { return cell.reach.ok(); });
  const double edge = map.back().pose.x_mm;
  return text +
         fmt::format(
             "x from {:g} to {:g} mm to the right, y from {:g} to {:g} mm upwards, every {:g} mm; "
             "phi {:g} deg\n"
             "digits: singularity margin in tenths; '-': beyond a stroke limit; '.': out of reach\n"
             "{} of {} poses are reachable",
             -edge, edge, -edge, edge, options.step_mm, options.phi_deg, n_ok, map.size());
}

ExitCode run_workspace(const MapOptions& options, Context& context) {
  const Mechanism mechanism = read_mechanism_file(options.file);
  const auto map =
      workspace(mechanism, {options.half_width_mm, options.step_mm, rad_from_deg(options.phi_deg)});
  if (!context.json) {
    context.print(map_text(map, options));
    return ExitCode::ok;
  }
  Json cells = Json::array();
  std::size_t n_ok = 0;
  for (const WorkspaceCell& cell : map) {
    Json row = {
        {"x_mm", cell.pose.x_mm}, {"y_mm", cell.pose.y_mm}, {"status", name_of(cell.reach.status)}};
    if (cell.reach.ok()) {
      row["stroke_left_mm"] = cell.reach.stroke_left_mm;
      row["singularity_margin"] = cell.reach.singularity.margin();
      ++n_ok;
    }
    cells.push_back(row);
  }
  context.print("mechanism-workspace", {{"phi_deg", options.phi_deg},
                                        {"n_cells", map.size()},
                                        {"n_reachable", n_ok},
                                        {"cells", cells}});
  return ExitCode::ok;
}

void grid_options(Command command, MapOptions& options) {
  command.option("--half-width", options.half_width_mm, "of the grid, mm").shown_default();
  command.option("--step", options.step_mm, "of the grid, mm").shown_default();
  command.option("--phi", options.phi_deg, "orientation, deg").shown_default();
}

}  // namespace

void setup_mechanism_maps(Command mechanism, Context& context) {
  const auto verb = [&](const char* name, const char* what,
                        ExitCode (*run)(const MapOptions&, Context&)) {
    Command command = mechanism.command(name, what);
    auto options = std::make_shared<MapOptions>();
    command.option("file", options->file, "mechanism, campaign or robot JSON").required();
    grid_options(command, *options);
    on_run(command, context, options, run);
    return std::pair(command, options.get());
  };
  const auto [shares, options] =
      verb("sensitivity", "Share of each error source in the pose error (Eq. 20)", run_sensitivity);
  shares.option("--angle", options->angle_deg, "error of all angles, deg").shown_default();
  shares.option("--length", options->length_mm, "error of all lengths, mm").shown_default();
  verb("workspace", "What is reachable, and how far from singular", run_workspace);
}

}  // namespace trammel::cli
