#include "app/cli/mechanism.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <vector>

#include "app/exchange/mechanism_json.hpp"
#include "app/exchange/numbers.hpp"
#include "core/mechanism/forward.hpp"
#include "core/mechanism/sensitivity.hpp"
#include "core/mechanism/workspace.hpp"
#include "core/plan/grids.hpp"
#include "core/units.hpp"

namespace trammel::cli {

namespace {

struct MechanismOptions {
  std::string file;
  std::vector<double> values;  // poses or displacements, three by three
  double half_width_mm = 100;
  double step_mm = 10;
  double phi_deg = 0;
  double angle_deg = 0.001;
  double length_mm = 0.05;
};

Json rails_json(const Displacements& l_mm) { return {l_mm[0], l_mm[1], l_mm[2]}; }

std::vector<Eigen::Vector3d> triples(const std::vector<double>& values, const char* field) {
  if (values.empty() || values.size() % 3 != 0) {
    throw UsageError({.what = "numbers come in threes",
                      .where = {.field = field},
                      .got = fmt::format("{} numbers", values.size())});
  }
  std::vector<Eigen::Vector3d> all;
  for (std::size_t k = 0; k < values.size(); k += 3) {
    all.emplace_back(values[k], values[k + 1], values[k + 2]);
    if (!all.back().allFinite()) {
      throw UsageError({.what = "a number that is not finite", .where = {.field = field}});
    }
  }
  return all;
}

ExitCode run_check(const MechanismOptions& options, Context& context) {
  const Mechanism mechanism = read_mechanism_file(options.file);
  const Reach home = reach(mechanism, mechanism.home);
  if (context.json) {
    Json fields = {{"mechanism", mechanism_json(mechanism)}, {"home", name_of(home.status)}};
    if (home.ok()) {
      fields["home_l_mm"] = rails_json(home.at.l_mm);
      fields["stroke_left_mm"] = home.stroke_left_mm;
      fields["singularity_margin"] = home.singularity.margin();
    }
    context.print("mechanism-check", fields);
  } else if (home.ok()) {
    const Displacements& l = home.at.l_mm;
    context.print(
        fmt::format("3-PRR, screw lead {} mm, stroke {} to {} mm\n"
                    "home: l = {:.4f}, {:.4f}, {:.4f} mm, {:.1f} mm of stroke left, "
                    "singularity margin {:.3f}",
                    mechanism.screw_lead_mm, mechanism.limits.l_min_mm, mechanism.limits.l_max_mm,
                    l[0], l[1], l[2], home.stroke_left_mm, home.singularity.margin()));
  } else {
    context.print(fmt::format("the home pose is not usable: {}, chain {}", name_of(home.status),
                              home.chain + 1));
  }
  return home.ok() ? ExitCode::ok : ExitCode::not_acceptable;
}

ExitCode run_ik(const MechanismOptions& options, Context& context) {
  const Mechanism mechanism = read_mechanism_file(options.file);
  Json rows = Json::array();
  std::string text =
      "      x mm       y mm    phi deg       l1 mm       l2 mm       l3 mm  margin\n";
  bool all_ok = true;
  for (const Eigen::Vector3d& v : triples(options.values, "--pose")) {
    const Pose pose{v[0], v[1], rad_from_deg(v[2])};
    const Reach at = reach(mechanism, pose);
    all_ok = all_ok && at.ok();
    Json row = {{"pose", pose_json(pose)}, {"status", name_of(at.status)}};
    text += fmt::format("{:>10.4f} {:>10.4f} {:>10.4f}", v[0], v[1], v[2]);
    if (at.at.ok()) {
      row["l_mm"] = rails_json(at.at.l_mm);
      row["theta_deg"] = {deg_from_rad(at.at.theta_rad[0]), deg_from_rad(at.at.theta_rad[1]),
                          deg_from_rad(at.at.theta_rad[2])};
      row["stroke_left_mm"] = at.stroke_left_mm;
      row["singularity_margin"] = at.singularity.margin();
      text += fmt::format(" {:>11.6f} {:>11.6f} {:>11.6f}  {:>6.3f}", at.at.l_mm[0], at.at.l_mm[1],
                          at.at.l_mm[2], at.singularity.margin());
    }
    if (!at.ok()) {
      row["chain"] = at.chain + 1;
      text += fmt::format("  {}, chain {}", name_of(at.status), at.chain + 1);
    }
    text += "\n";
    rows.push_back(row);
  }
  context.json ? context.print("mechanism-ik", {{"poses", rows}}) : context.print(text);
  return all_ok ? ExitCode::ok : ExitCode::not_acceptable;
}

const char* name_of_status(ForwardResult::Status status) {
  constexpr const char* kNames[] = {"ok", "unreachable", "singular", "not converged"};
  return kNames[static_cast<int>(status)];
}

ExitCode run_fk(const MechanismOptions& options, Context& context) {
  const Mechanism mechanism = read_mechanism_file(options.file);
  Json rows = Json::array();
  std::string text = "     l1 mm      l2 mm      l3 mm        x mm        y mm     phi deg\n";
  bool all_ok = true;
  for (const Eigen::Vector3d& l : triples(options.values, "--l")) {
    const ForwardResult at = forward(mechanism.geometry, l, mechanism.home);
    all_ok = all_ok && at.ok();
    Json row = {{"l_mm", rails_json(l)}, {"status", name_of_status(at.status)}};
    text += fmt::format("{:>10.4f} {:>10.4f} {:>10.4f}", l[0], l[1], l[2]);
    if (at.ok()) {
      row["pose"] = pose_json(at.pose);
      row["iterations"] = at.iterations;
      text += fmt::format(" {:>11.6f} {:>11.6f} {:>11.7f}\n", at.pose.x_mm, at.pose.y_mm,
                          deg_from_rad(at.pose.phi_rad));
    } else {
      text += fmt::format("  {}\n", name_of_status(at.status));
    }
    rows.push_back(row);
  }
  context.json ? context.print("mechanism-fk", {{"displacements", rows}}) : context.print(text);
  return all_ok ? ExitCode::ok : ExitCode::not_acceptable;
}

ExitCode run_sensitivity(const MechanismOptions& options, Context& context) {
  const Mechanism mechanism = read_mechanism_file(options.file);
  std::vector<Pose> poses = lattice(options.half_width_mm, options.step_mm);
  for (Pose& pose : poses) pose.phi_rad = rad_from_deg(options.phi_deg);
  const SensitivityShares shares =
      sensitivity(mechanism.geometry, poses, {rad_from_deg(options.angle_deg), options.length_mm});
  Json rows = Json::array();
  std::string text = "source      share of dx   of dy   of dphi\n";
  for (int j = 0; j < kPaperParameters; ++j) {
    const std::string& name = geometry_parameters()[static_cast<std::size_t>(j)].name;
    rows.push_back(
        {{"source", name}, {"x", shares(0, j)}, {"y", shares(1, j)}, {"phi", shares(2, j)}});
    text += fmt::format("{:<10} {:>10.2f} % {:>6.2f} % {:>6.2f} %\n", name, 100 * shares(0, j),
                        100 * shares(1, j), 100 * shares(2, j));
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
std::string map_text(const std::vector<WorkspaceCell>& map) {
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
  return text +
         "digits: singularity margin in tenths; '-': beyond a stroke limit; '.': out of reach";
}

ExitCode run_workspace(const MechanismOptions& options, Context& context) {
  const Mechanism mechanism = read_mechanism_file(options.file);
  const auto map =
      workspace(mechanism, {options.half_width_mm, options.step_mm, rad_from_deg(options.phi_deg)});
  if (!context.json) {
    context.print(map_text(map));
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

void grid_options(CLI::App& command, MechanismOptions& options) {
  command.add_option("--half-width", options.half_width_mm, "of the grid, mm")
      ->capture_default_str();
  command.add_option("--step", options.step_mm, "of the grid, mm")->capture_default_str();
  command.add_option("--phi", options.phi_deg, "orientation, deg")->capture_default_str();
}

}  // namespace

void setup_mechanism(CLI::App& app, Context& context) {
  CLI::App& mechanism = noun(app, "mechanism", "Kinematics of a mechanism file");
  const auto verb = [&](const char* name, const char* what,
                        ExitCode (*run)(const MechanismOptions&, Context&)) {
    CLI::App& command = *mechanism.add_subcommand(name, what);
    auto options = std::make_shared<MechanismOptions>();
    command.add_option("file", options->file, "mechanism, campaign or robot JSON")->required();
    on_run(command, context, options, run);
    return std::pair<CLI::App*, MechanismOptions*>(&command, options.get());
  };
  verb("check", "Is it usable, and where is home", run_check);
  const auto ik = verb("ik", "Displacements that reach poses", run_ik);
  ik.first->add_option("--pose", ik.second->values, "x mm, y mm, phi deg (repeatable)")->required();
  const auto fk = verb("fk", "Poses at displacements", run_fk);
  fk.first->add_option("--l", fk.second->values, "l1 l2 l3 in mm (repeatable)")->required();
  const auto shares =
      verb("sensitivity", "Share of each error source in the pose error (Eq. 20)", run_sensitivity);
  grid_options(*shares.first, *shares.second);
  shares.first->add_option("--angle", shares.second->angle_deg, "error of all angles, deg")
      ->capture_default_str();
  shares.first->add_option("--length", shares.second->length_mm, "error of all lengths, mm")
      ->capture_default_str();
  const auto map = verb("workspace", "What is reachable, and how far from singular", run_workspace);
  grid_options(*map.first, *map.second);
}

}  // namespace trammel::cli
