#include "app/cli/mechanism_maps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "app/cli/machine_values.hpp"
#include "app/files/machine_json.hpp"
#include "core/mechanism/sensitivity.hpp"
#include "core/mechanism/workspace.hpp"
#include "core/units.hpp"

namespace trammel::cli {

namespace {

struct MapOptions {
  std::string file;
  std::optional<double> half_width_mm;
  std::optional<double> step_mm;
  double phi_deg = 0;
  double angle_deg = 0.001;
  double length_mm = 0.05;
};

/// The orientation of a grid, for a machine that turns.
double grid_phi_rad(const Machine& machine, const MapOptions& options) {
  if (!machine.kind->has_point_platform() || options.phi_deg == 0) {
    return rad_from_deg(options.phi_deg);
  }
  throw UsageError(
      {.what = fmt::format("phi is no coordinate of an {} machine", machine.kind->name),
       .where = {.field = "--phi"}});
}

WorkspaceGrid grid_of(const Machine& machine, const MapOptions& options) {
  const double half_width_mm = options.half_width_mm.value_or(usual_half_width_mm(machine));
  return {half_width_mm, options.step_mm.value_or(usual_step_mm(half_width_mm)),
          grid_phi_rad(machine, options)};
}

/// "alpha_1         18.40 %  12.02 %   3.10 %"
std::string share_line(const std::string& name, const Eigen::VectorXd& shares) {
  std::string text = fmt::format("{:<10} {:>10.2f} %", name, 100 * shares[0]);
  for (Eigen::Index i = 1; i < shares.size(); ++i)
    text += fmt::format(" {:>6.2f} %", 100 * shares[i]);
  return text + "\n";
}

ExitCode run_sensitivity(const MapOptions& options, Context& context) {
  const Machine machine = read_machine_file(options.file);
  const WorkspaceGrid grid = grid_of(machine, options);
  const std::vector<Pose> poses = grid_poses(machine, grid);
  const SensitivityShares shares =
      sensitivity(machine, poses, {rad_from_deg(options.angle_deg), options.length_mm});
  const auto n = static_cast<std::size_t>(machine.kind->n_chains);
  Json rows = Json::array();
  std::string text = fmt::format(
      "share of each error source in the pose error, mean of {} poses (Eq. 20)\n"
      "errors of {:g} deg and {:g} mm; grid of +-{:g} mm every {:g} mm{}\n"
      "source      share of dx",
      poses.size(), options.angle_deg, options.length_mm, grid.half_width_mm, grid.step_mm,
      machine.kind->has_point_platform() ? "" : fmt::format(" at phi {:g} deg", options.phi_deg));
  for (std::size_t i = 1; i < n; ++i) text += fmt::format("   of d{}", kCoordinateNames[i]);
  text += "\n";
  Eigen::MatrixXd of_chain = Eigen::MatrixXd::Zero(shares.of.rows(), machine.kind->n_chains);
  for (std::size_t j = 0; j < shares.sources.size(); ++j) {
    const Eigen::VectorXd share = shares.of.col(static_cast<Eigen::Index>(j));
    Json row = {{"source", shares.sources[j].name}};
    for (std::size_t i = 0; i < n; ++i) {
      row[std::string(kCoordinateNames[i])] = share[static_cast<Eigen::Index>(i)];
    }
    rows.push_back(row);
    text += share_line(shares.sources[j].name, share);
    of_chain.col(shares.sources[j].chain) += share;
  }
  for (Eigen::Index i = 0; i < of_chain.cols(); ++i) {  // Table II: which chain leads
    text += share_line(fmt::format("chain {}", i + 1), of_chain.col(i));
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
std::string map_text(const Machine& machine, const std::vector<WorkspaceCell>& map,
                     const WorkspaceGrid& grid) {
  const std::map<Reach::Status, char> kSigns = {{Reach::Status::unreachable, '.'},
                                                {Reach::Status::limit, '-'},
                                                {Reach::Status::not_finite, '?'},
                                                {Reach::Status::singular, 'x'},
                                                {Reach::Status::other_assembly, 'x'}};
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
  text += fmt::format("x from {:g} to {:g} mm to the right", map.front().pose.x_mm,
                      map.back().pose.x_mm);
  if (machine.kind->n_chains > 1) {
    text += fmt::format(", y from {:g} to {:g} mm upwards", map.front().pose.y_mm,
                        map.back().pose.y_mm);
  }
  text += fmt::format(", every {:g} mm", grid.step_mm);
  if (!machine.kind->has_point_platform())
    text += fmt::format("; phi {:g} deg", deg_from_rad(grid.phi_rad));
  return text + fmt::format(
                    "\ndigits: singularity margin in tenths; '-': beyond a stroke limit; 'x': "
                    "singular, or beyond a singularity in the other assembly; '.': out of reach\n"
                    "{} of {} poses are reachable",
                    n_ok, map.size());
}

/// A lattice as wide and as fine, on the same machine.
void suggest_lattice(const WorkspaceGrid& grid, const Context& context) {
  context.next(
      fmt::format("trammel plan create lattice --half-width {:g} --step {:g} --out plan.json",
                  grid.half_width_mm, grid.step_mm));
}

ExitCode run_workspace(const MapOptions& options, Context& context) {
  const Machine machine = read_machine_file(options.file);
  const WorkspaceGrid grid = grid_of(machine, options);
  const auto map = workspace(machine, grid);
  if (!context.json) {
    context.print(map_text(machine, map, grid));
    suggest_lattice(grid, context);
    return ExitCode::ok;
  }
  Json cells = Json::array();
  std::size_t n_ok = 0;
  for (const WorkspaceCell& cell : map) {
    Json row = pose_json(machine, cell.pose);
    row.erase("phi_deg");
    row["status"] = name_of(cell.reach.status);
    if (cell.reach.ok()) {
      row["stroke_left_mm"] = cell.reach.stroke_left_mm;
      row["singularity_margin"] = cell.reach.singularity.margin();
      ++n_ok;
    }
    cells.push_back(row);
  }
  Json found = {{"n_cells", map.size()}, {"n_reachable", n_ok}, {"cells", cells}};
  if (!machine.kind->has_point_platform()) found["phi_deg"] = options.phi_deg;
  context.print("mechanism-workspace", found);
  return ExitCode::ok;
}

void grid_options(Command command, MapOptions& options) {
  command.option("--half-width", options.half_width_mm,
                 "of the grid, mm (100, or half the longest stroke)");
  command.option("--step", options.step_mm,
                 "of the grid, mm (10, or a tenth of a small half-width)");
  command.option("--phi", options.phi_deg, "orientation, deg").shown_default();
}

}  // namespace

void setup_mechanism_maps(Command mechanism, Context& context) {
  const auto verb = [&](const char* name, const char* what,
                        ExitCode (*run)(const MapOptions&, Context&)) {
    Command command = mechanism.command(name, what);
    auto options = std::make_shared<MapOptions>();
    command.option("file", options->file, "machine, mechanism, campaign or robot JSON").required();
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
