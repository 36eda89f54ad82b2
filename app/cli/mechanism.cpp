#include "app/cli/mechanism.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <vector>

#include "app/cli/mechanism_maps.hpp"
#include "app/files/commands_csv.hpp"
#include "app/files/mechanism_json.hpp"
#include "app/files/numbers.hpp"
#include "app/files/plan_json.hpp"
#include "core/mechanism/error_model.hpp"
#include "core/mechanism/forward.hpp"
#include "core/mechanism/velocity.hpp"
#include "core/mechanism/workspace.hpp"
#include "core/units.hpp"

namespace trammel::cli {

namespace {

struct MechanismOptions {
  std::string file;
  std::vector<double> values;  // poses or displacements, three by three
  std::string batch;           // ik: plan file or grid; fk: CSV of commands
  std::vector<double> velocity;
  std::vector<double> acceleration;
  bool jacobians = false;
};

Json rails_json(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }

Json degrees_json(const Eigen::Vector3d& rad) {
  return {deg_from_rad(rad[0]), deg_from_rad(rad[1]), deg_from_rad(rad[2])};
}

std::vector<Eigen::Vector3d> triples(const std::vector<double>& values, const char* field) {
  if (values.size() % 3 != 0) {
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

[[noreturn]] void need(const char* one, const char* other) {
  throw UsageError({.what = "nothing to solve", .expected = fmt::format("{} or {}", one, other)});
}

/// x', y' in mm/s and phi' in deg/s (or per s^2) as typed, in rad inside.
Eigen::Vector3d rates(const std::vector<double>& typed, const char* field) {
  if (typed.empty()) return Eigen::Vector3d::Zero();
  Eigen::Vector3d v = triples(typed, field).front();
  v[2] = rad_from_deg(v[2]);
  return v;
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
                    "singularity margin {:.3f} (0 singular, 1 best)",
                    mechanism.screw_lead_mm, mechanism.limits.l_min_mm, mechanism.limits.l_max_mm,
                    l[0], l[1], l[2], home.stroke_left_mm, home.singularity.margin()));
  } else {
    context.print(fmt::format("the home pose is not usable: {}, chain {}", name_of(home.status),
                              home.chain + 1));
  }
  return home.ok() ? ExitCode::ok : ExitCode::not_acceptable;
}

/// Rows of a matrix as they are computed: mm and rad.
template <class Matrix>
Json matrix_json(const Matrix& M) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < M.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index j = 0; j < M.cols(); ++j) row.push_back(M(i, j));
    rows.push_back(row);
  }
  return rows;
}

/// Joint rates under platform rates (Eqs. 5-8), as lines of text and fields of `row`.
std::string add_rates(const MechanismOptions& options, const Geometry& geometry, const Pose& pose,
                      const InverseResult& at, Json& row) {
  std::string text;
  const auto add = [&](const char* order, const char* per, const JointRates& r) {
    row[fmt::format("l_{}_mm_{}", order, per)] = rails_json(r.l);
    row[fmt::format("theta_{}_deg_{}", order, per)] = degrees_json(r.theta);
    text += fmt::format("{:>32} {:>11.6f} {:>11.6f} {:>11.6f}  mm/{}\n", fmt::format("l {}", order),
                        r.l[0], r.l[1], r.l[2], std::string(per) == "s" ? "s" : "s^2");
  };
  const Eigen::Vector3d X_dot = rates(options.velocity, "--velocity");
  if (!options.velocity.empty()) add("velocity", "s", joint_velocity(geometry, pose, at, X_dot));
  if (!options.acceleration.empty()) {
    const Eigen::Vector3d X_ddot = rates(options.acceleration, "--acceleration");
    add("acceleration", "s2", joint_acceleration(geometry, pose, at, X_dot, X_ddot));
  }
  return text;
}

std::vector<Pose> poses_of(const MechanismOptions& options) {
  std::vector<Pose> poses;
  for (const Eigen::Vector3d& v : triples(options.values, "--pose")) {
    poses.push_back({v[0], v[1], rad_from_deg(v[2])});
  }
  if (!options.batch.empty()) {
    for (const PlannedPoint& p : plan_of(options.batch).points) poses.push_back(p.target);
  }
  if (poses.empty()) need("--pose", "--plan");
  return poses;
}

ExitCode run_ik(const MechanismOptions& options, Context& context) {
  const Mechanism mechanism = read_mechanism_file(options.file);
  Json rows = Json::array();
  std::string text =
      "      x mm       y mm    phi deg       l1 mm       l2 mm       l3 mm  margin\n";
  bool all_ok = true;
  const RailFrames frames = rail_frames(mechanism.geometry);
  for (const Pose& pose : poses_of(options)) {
    const Reach at = reach(mechanism, pose);
    all_ok = all_ok && at.ok();
    Json row = {{"pose", pose_json(pose)}, {"status", name_of(at.status)}};
    text += fmt::format("{:>10.4f} {:>10.4f} {:>10.4f}", rounded(pose.x_mm, 4),
                        rounded(pose.y_mm, 4), rounded(deg_from_rad(pose.phi_rad), 4));
    std::string more;
    if (at.at.ok()) {
      row["l_mm"] = rails_json(at.at.l_mm);
      row["theta_deg"] = degrees_json(at.at.theta_rad);
      row["stroke_left_mm"] = at.stroke_left_mm;
      row["singularity_margin"] = at.singularity.margin();
      text += fmt::format(" {:>11.6f} {:>11.6f} {:>11.6f}  {:>6.3f}", at.at.l_mm[0], at.at.l_mm[1],
                          at.at.l_mm[2], at.singularity.margin());
      more = add_rates(options, mechanism.geometry, pose, at.at, row);
      if (options.jacobians) {
        const VelocityEquation equation = velocity_equation(mechanism.geometry, pose, at.at);
        row["J_V_mm_rad"] = matrix_json(velocity_jacobian(equation));
        row["J_e_mm_rad"] = matrix_json(error_jacobian(frames, chains_at(frames, pose.vector())));
      }
    }
    if (!at.ok()) {
      row["chain"] = at.chain + 1;
      text += fmt::format("  {}, chain {}", name_of(at.status), at.chain + 1);
    }
    text += "\n" + more;
    rows.push_back(row);
  }
  context.json ? context.print("mechanism-ik", {{"poses", rows}}) : context.print(text);
  return all_ok ? ExitCode::ok : ExitCode::not_acceptable;
}

const char* name_of_status(ForwardResult::Status status) {
  constexpr const char* kNames[] = {"ok", "unreachable", "singular", "not converged"};
  return kNames[static_cast<int>(status)];
}

std::vector<Displacements> displacements_of(const MechanismOptions& options,
                                            const Mechanism& mechanism) {
  std::vector<Displacements> all = triples(options.values, "--l");
  if (!options.batch.empty()) {
    for (const CommandRow& row : read_commands_csv(options.batch, mechanism)) {
      all.push_back(row.conditions.cmd_mm);
    }
  }
  if (all.empty()) need("--l", "--commands");
  return all;
}

ExitCode run_fk(const MechanismOptions& options, Context& context) {
  const Mechanism mechanism = read_mechanism_file(options.file);
  Json rows = Json::array();
  std::string text = "     l1 mm      l2 mm      l3 mm        x mm        y mm     phi deg\n";
  bool all_ok = true;
  for (const Displacements& l : displacements_of(options, mechanism)) {
    const ForwardResult at = forward(mechanism.geometry, l, mechanism.home);
    all_ok = all_ok && at.ok();
    Json row = {{"l_mm", rails_json(l)}, {"status", name_of_status(at.status)}};
    text += fmt::format("{:>10.4f} {:>10.4f} {:>10.4f}", l[0], l[1], l[2]);
    if (at.ok()) {
      row["pose"] = pose_json(at.pose);
      row["iterations"] = at.iterations;
      text += fmt::format(" {:>11.6f} {:>11.6f} {:>11.7f}\n", rounded(at.pose.x_mm, 6),
                          rounded(at.pose.y_mm, 6), rounded(deg_from_rad(at.pose.phi_rad), 7));
    } else if (at.status == ForwardResult::Status::singular) {
      text += fmt::format("  {}\n", name_of_status(at.status));
    } else {
      row["chain"] = at.chain + 1;
      text += fmt::format("  {}, chain {}\n", name_of_status(at.status), at.chain + 1);
    }
    rows.push_back(row);
  }
  context.json ? context.print("mechanism-fk", {{"displacements", rows}}) : context.print(text);
  return all_ok ? ExitCode::ok : ExitCode::not_acceptable;
}

}  // namespace

void setup_mechanism(Command app, Context& context) {
  Command mechanism = noun(app, "mechanism", "Kinematics of a mechanism file");
  const auto verb = [&](const char* name, const char* what,
                        ExitCode (*run)(const MechanismOptions&, Context&)) {
    Command command = mechanism.command(name, what);
    auto options = std::make_shared<MechanismOptions>();
    command.option("file", options->file, "mechanism, campaign or robot JSON").required();
    on_run(command, context, options, run);
    return std::pair(command, options.get());
  };
  verb("check", "Is it usable, and where is home", run_check);
  const auto [ik, ik_options] = verb("ik", "Displacements that reach poses", run_ik);
  ik.option("--pose", ik_options->values, "x mm, y mm, phi deg (repeatable)");
  ik.option("--plan", ik_options->batch, "the targets of a plan: file, or name of a grid")
      .type("PLAN");
  ik.option("--velocity", ik_options->velocity,
            "of the platform, mm/s mm/s deg/s: what the rails do at each pose (Eq. 6)")
      .expected(3);
  ik.option("--acceleration", ik_options->acceleration,
            "of the platform, mm/s^2 mm/s^2 deg/s^2 (Eq. 8)")
      .expected(3);
  ik.flag("--jacobians", ik_options->jacobians,
          "with --json: J_V (Eq. 13) and J_e (Eq. 19, the paper's 18 columns, then h_1 h_2 "
          "h_3), in mm and rad");
  const auto [fk, fk_options] = verb("fk", "Poses at displacements", run_fk);
  fk.option("--l", fk_options->values, "l1 l2 l3 in mm (repeatable)");
  fk.option("--commands", fk_options->batch, "CSV with cmd_l1_mm … cmd_l3_mm, as readings.csv")
      .type("FILE");
  setup_mechanism_maps(mechanism, context);
}

}  // namespace trammel::cli
