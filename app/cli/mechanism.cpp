#include "app/cli/mechanism.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "app/cli/machine_values.hpp"
#include "app/cli/mechanism_maps.hpp"
#include "app/files/commands_csv.hpp"
#include "app/files/machine_json.hpp"
#include "app/files/mechanism_json.hpp"
#include "app/files/numbers.hpp"
#include "app/files/plan_json.hpp"
#include "core/calibrate/machine_rank.hpp"
#include "core/mechanism/machine_kinematics.hpp"
#include "core/units.hpp"

namespace trammel::cli {

namespace {

struct MechanismOptions {
  std::string file;
  std::vector<double> values;  // poses or displacements, one after the other
  std::string batch;           // ik: plan file or grid; fk: CSV of commands
  std::vector<double> velocity;
  std::vector<double> acceleration;
  std::vector<double> start;
  bool jacobians = false;
};

/// Of the machine's drives, or of its chains.
Json drives_json(const Machine& machine, const Eigen::Vector3d& v) {
  Json json = Json::array();
  for (int i = 0; i < machine.kind->n_chains; ++i) json.push_back(v[i]);
  return json;
}

Json degrees_json(const Machine& machine, const Eigen::Vector3d& rad) {
  return drives_json(machine, rad.unaryExpr([](double r) { return deg_from_rad(r); }));
}

[[noreturn]] void need(const char* one, const char* other) {
  throw UsageError({.what = "nothing to solve", .expected = fmt::format("{} or {}", one, other)});
}

/// One such, zeros where nothing is typed.
Eigen::Vector3d rates(const Machine& machine, const std::vector<double>& typed, const char* field) {
  if (typed.empty()) return Eigen::Vector3d::Zero();
  const auto all = typed_poses(machine, typed, field);
  if (all.size() == 1) return all.front();
  throw UsageError({.what = "one group of numbers is expected",
                    .where = {.field = field},
                    .got = fmt::format("{} numbers", typed.size())});
}

/// Drives like the first are not named again.
std::string drives_text(const Machine& machine) {
  std::string text;
  for (int i = 0; i < machine.kind->n_chains; ++i) {
    const Drive& drive = machine.drives[static_cast<std::size_t>(i)];
    if (i > 0 && drive == machine.drives[0]) continue;
    text += fmt::format("{}{}screw lead {} mm, stroke {} to {} mm", text.empty() ? "" : "; ",
                        i > 0 ? fmt::format("drive {}: ", i + 1) : "", drive.lead_mm,
                        drive.limits.l_min_mm, drive.limits.l_max_mm);
  }
  return text;
}

std::vector<std::string> sentences(const MachineRank& rank) {
  std::vector<std::string> all;
  for (const NullDirection& d : rank.of.null_space) all.push_back(d.sentence);
  return all;
}

/// The machine as today's 3-PRR files have it, others as machine/1.
Json machine_fields(const Machine& machine) {
  if (machine.kind != find_machine_kind("3-PRR")) return machine_json(machine);
  const bool alike =
      machine.drives[1] == machine.drives[0] && machine.drives[2] == machine.drives[0];
  return alike ? mechanism_json(mechanism_of(machine)) : machine_json(machine);
}

/// "all coordinates", "x", "x and phi": what the machine has of them and an instrument reads.
std::string measured_words(const Machine& machine) {
  std::vector<std::string_view> names;
  for (std::size_t c = 0; c < static_cast<std::size_t>(machine.kind->n_chains); ++c) {
    if (machine.measured[c]) names.push_back(kCoordinateNames[c]);
  }
  if (std::ssize(names) == machine.kind->n_chains) return "all coordinates";
  return fmt::format("{}", fmt::join(names, " and "));
}

std::string ranks_text(const Machine& machine, const std::vector<MachineRank>& ranks) {
  std::string text = fmt::format("what readings of {} can show of the parameters, however precise:",
                                 measured_words(machine));
  for (const MachineRank& r : ranks) {
    text +=
        fmt::format("\n  orientation {}: rank {} of {}{}", r.orientation, r.of.rank,
                    r.of.identified.size(), r.parameters == "all" ? "" : " (" + r.parameters + ")");
  }
  const auto widest = std::ranges::max_element(
      ranks, {}, [](const MachineRank& r) { return r.parameters == "all" ? r.of.rank : -1; });
  const std::vector<std::string> untold = sentences(*widest);
  text += fmt::format("\nwhat they never show, with the orientation {}:{}", widest->orientation,
                      untold.empty() ? " nothing" : "");
  for (const std::string& sentence : untold) text += "\n  " + sentence;
  return text;
}

ExitCode run_check(const MechanismOptions& options, Context& context) {
  const Machine machine = read_machine_file(options.file);
  const Reach home = reach(machine, machine.home);
  if (!home.ok()) {
    if (context.json) {
      context.print("mechanism-check",
                    {{"mechanism", machine_fields(machine)}, {"home", name_of(home.status)}});
    } else {
      context.print(fmt::format("the home pose is not usable: {}, chain {}", name_of(home.status),
                                home.chain + 1));
    }
    return ExitCode::not_acceptable;
  }
  const std::vector<MachineRank> ranks = machine_ranks(machine);
  if (context.json) {
    Json rows = Json::array();
    for (const MachineRank& r : ranks) {
      rows.push_back({{"orientation", r.orientation},
                      {"parameters", r.parameters},
                      {"n_parameters", r.of.identified.size()},
                      {"rank", r.of.rank},
                      {"not_identified", sentences(r)}});
    }
    context.print("mechanism-check", {{"mechanism", machine_fields(machine)},
                                      {"home", name_of(home.status)},
                                      {"home_l_mm", drives_json(machine, home.at.q_mm)},
                                      {"stroke_left_mm", home.stroke_left_mm},
                                      {"singularity_margin", home.singularity.margin()},
                                      {"ranks", rows}});
  } else {
    context.print(fmt::format(
        "{}, {}\nhome: l = {} mm, {:.1f} mm of stroke left, singularity "
        "margin {:.3f} (0 singular, 1 best)\n{}",
        machine.kind->name, drives_text(machine), cells_of(machine, home.at.q_mm, 0, 4, ", "),
        home.stroke_left_mm, home.singularity.margin(), ranks_text(machine, ranks)));
  }
  return ExitCode::ok;
}

/// The first rows and columns of a matrix as they are computed: mm and rad.
template <class Matrix>
Json matrix_json(const Matrix& M, Eigen::Index rows, Eigen::Index columns) {
  Json all = Json::array();
  for (Eigen::Index i = 0; i < rows; ++i) {
    Json row = Json::array();
    for (Eigen::Index j = 0; j < columns; ++j) row.push_back(M(i, j));
    all.push_back(row);
  }
  return all;
}

/// Rates of drives and links under those of the platform (Eqs. 5-8), as lines of text and fields of
/// `row`.
std::string add_rates(const MechanismOptions& options, const Machine& machine, const DrivesAt& at,
                      Json& row) {
  std::string text;
  const auto add = [&](const char* order, const char* per, const char* unit,
                       const Eigen::Vector3d& l, std::size_t derivative) {
    row[fmt::format("l_{}_mm_{}", order, per)] = drives_json(machine, l);
    if (at.angle) {
      row[fmt::format("theta_{}_deg_{}", order, per)] =
          degrees_json(machine, (*at.angle)[derivative]);
    }
    text += fmt::format("{:>32} {}  {}\n", fmt::format("l {}", order), cells_of(machine, l, 11, 6),
                        unit);
  };
  if (!options.velocity.empty()) add("velocity", "s", "mm/s", at.velocity_mm_s, 1);
  if (!options.acceleration.empty()) {
    add("acceleration", "s2", "mm/s^2", at.acceleration_mm_s2, 2);
  }
  return text;
}

std::vector<Pose> poses_of(const MechanismOptions& options, const Machine& machine) {
  std::vector<Pose> poses;
  for (const Eigen::Vector3d& v : typed_poses(machine, options.values, "--pose")) {
    poses.push_back(pose_on(machine, v));
  }
  if (!options.batch.empty()) {
    for (const PlannedPoint& p : plan_of(options.batch).points) {
      if (pose_on(machine, p.target.vector()) != p.target) {
        throw InputError({.what = fmt::format("this plan is of another machine: an {} machine does "
                                              "not go there",
                                              machine.kind->name),
                          .where = {.file = options.batch, .point = fmt::format("seq {}", p.seq)}});
      }
      poses.push_back(p.target);
    }
  }
  if (poses.empty()) need("--pose", "--plan");
  return poses;
}

/// What is to be said of a pose that is not ok.
std::string status_words(const Reach& at) {
  switch (at.status) {
    case Reach::Status::other_assembly:
      return "other assembly: no way from home leads there but through a singular pose";
    case Reach::Status::singular:
      return "singular: the drives do not decide where the platform goes";
    case Reach::Status::ok:
      return "";
    default:
      return fmt::format("{}, chain {}", name_of(at.status), at.chain + 1);
  }
}

bool names_chain(const Reach& at) {
  return at.status == Reach::Status::unreachable || at.status == Reach::Status::limit;
}

ExitCode run_ik(const MechanismOptions& options, Context& context) {
  const Machine machine = read_machine_file(options.file);
  const int n = machine.kind->n_chains;
  const Eigen::Vector3d X_dot = rates(machine, options.velocity, "--velocity");
  const Eigen::Vector3d X_ddot = rates(machine, options.acceleration, "--acceleration");
  Json rows = Json::array();
  std::string text = pose_header(machine, 10) + " " + drive_header(machine, 11) + "  margin\n";
  bool all_ok = true;
  for (const Pose& pose : poses_of(options, machine)) {
    const Reach at = reach(machine, pose);
    all_ok = all_ok && at.ok();
    Json row = {{"pose", pose_json(machine, pose)}, {"status", name_of(at.status)}};
    text += cells_of(machine, shown_pose(pose), 10, 4);
    std::string more;
    if (at.at.reached()) {
      row["l_mm"] = drives_json(machine, at.at.q_mm);
      if (at.at.angle) row["theta_deg"] = degrees_json(machine, (*at.at.angle)[0]);
      row["stroke_left_mm"] = at.stroke_left_mm;
      row["singularity_margin"] = at.singularity.margin();
      row["assembly"] = assembly_name(at.assembly);
      text += fmt::format(" {}  {:>6.3f}", cells_of(machine, at.at.q_mm, 11, 6),
                          at.singularity.margin());
    }
    if (at.at.reached() && at.status != Reach::Status::singular) {
      more = add_rates(options, machine, drives_at(machine, pose, X_dot, X_ddot), row);
      if (options.jacobians) {
        const Closures here = closures(machine, at.at.q_mm, pose);
        const ParameterColumns J_e = error_jacobian(here);
        row["J_V_mm_rad"] = matrix_json(velocity_jacobian(here), n, n);
        row["J_e_mm_rad"] = matrix_json(J_e, n, J_e.cols());
      }
    }
    if (names_chain(at)) row["chain"] = at.chain + 1;
    if (!at.ok()) text += "  " + status_words(at);
    text += "\n" + more;
    rows.push_back(row);
  }
  context.json ? context.print("mechanism-ik", {{"poses", rows}}) : context.print(text);
  return all_ok ? ExitCode::ok : ExitCode::not_acceptable;
}

std::vector<Displacements> displacements_of(const MechanismOptions& options,
                                            const Machine& machine) {
  std::vector<Displacements> all = groups(machine, options.values, "--l");
  if (!options.batch.empty()) {
    for (const CommandRow& row : read_commands_csv(options.batch, machine)) {
      all.push_back(row.conditions.cmd_mm);
    }
  }
  if (all.empty()) need("--l", "--commands");
  return all;
}

ExitCode run_fk(const MechanismOptions& options, Context& context) {
  const Machine machine = read_machine_file(options.file);
  const Pose start = options.start.empty()
                         ? machine.home
                         : pose_on(machine, rates(machine, options.start, "--start"));
  Json rows = Json::array();
  std::string text = drive_header(machine, 10) + " " + pose_header(machine, 11) + "\n";
  bool all_ok = true;
  for (const Displacements& l : displacements_of(options, machine)) {
    const MachinePose at = forward(machine, l, start);
    const Reach there = at.ok() ? reach(machine, at.pose) : Reach{};
    const bool other = there.status == Reach::Status::other_assembly;
    all_ok = all_ok && at.ok() && !other;
    Json row = {{"l_mm", drives_json(machine, l)},
                {"status", other ? name_of(there.status) : name_of(at.status)}};
    text += cells_of(machine, l, 10, 4);
    if (at.ok()) {
      row["pose"] = pose_json(machine, at.pose);
      row["assembly"] = assembly_name(there.assembly);
      row["iterations"] = at.iterations;
      text += " " + cells_of(machine, shown_pose(at.pose), 11, 6);
      if (other) text += "  " + status_words(there);
    } else if (at.status == MachinePose::Status::unreachable) {
      row["chain"] = at.chain + 1;
      text += fmt::format("  {}, chain {}", name_of(at.status), at.chain + 1);
    } else {
      text += fmt::format("  {}: so is the pose to start from", name_of(at.status));
    }
    text += "\n";
    rows.push_back(row);
  }
  context.json ? context.print("mechanism-fk", {{"displacements", rows}}) : context.print(text);
  return all_ok ? ExitCode::ok : ExitCode::not_acceptable;
}

}  // namespace

void setup_mechanism(Command app, Context& context) {
  Command mechanism = noun(app, "mechanism", "Kinematics of a machine's file");
  const auto verb = [&](const char* name, const char* what,
                        ExitCode (*run)(const MechanismOptions&, Context&)) {
    Command command = mechanism.command(name, what);
    auto options = std::make_shared<MechanismOptions>();
    command.option("file", options->file, "machine, mechanism, campaign or robot JSON").required();
    on_run(command, context, options, run);
    return std::pair(command, options.get());
  };
  verb("check", "Is it usable, and where is home", run_check);
  const auto [ik, ik_options] = verb("ik", "Displacements that reach poses", run_ik);
  ik.option("--pose", ik_options->values,
            "x mm, y mm, phi deg, as far as the machine has them (repeatable)");
  ik.option("--plan", ik_options->batch, "the targets of a plan: file, or name of a grid")
      .type("PLAN");
  ik.option("--velocity", ik_options->velocity,
            "of the platform, mm/s mm/s deg/s: what the rails do at each pose (Eq. 6)");
  ik.option("--acceleration", ik_options->acceleration,
            "of the platform, mm/s^2 mm/s^2 deg/s^2 (Eq. 8)");
  ik.flag("--jacobians", ik_options->jacobians,
          "with --json: J_V (Eq. 13) and J_e (Eq. 19; of a 3-PRR the paper's 18 columns, then h_1 "
          "h_2 h_3), in mm and rad");
  const auto [fk, fk_options] = verb("fk", "Poses at displacements", run_fk);
  fk.option("--l", fk_options->values, "l1 l2 l3 in mm, one per drive (repeatable)");
  fk.option("--start", fk_options->start,
            "x mm, y mm, phi deg: where to look first, and in whose assembly (home)");
  fk.option("--commands", fk_options->batch, "CSV with cmd_l1_mm … cmd_l3_mm, as readings.csv")
      .type("FILE");
  setup_mechanism_maps(mechanism, context);
}

}  // namespace trammel::cli
