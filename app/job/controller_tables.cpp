#include "app/job/controller_tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/plan/grids.hpp"

namespace trammel::job {

namespace {

using Samples = std::array<std::vector<DriveSample>, kChains>;

constexpr std::size_t kMostKnots = 10'000;  // a finer table, to judge the step by
constexpr double kUm = 1000;

/// The corrections at one target from one side; false when it can't be reached.
bool add_samples(const Correction& correction, const NominalMachine& machine,
                 const TableRequest& request, const Pose& target, int direction, Samples& samples) {
  const InverseResult nominal = machine.drives(target);
  if (!nominal.ok()) return false;
  Move move{.target = target,
            .from_mm = nominal.l_mm,
            .epoch = request.epoch,
            .time_s = request.time_s,
            .temp_degc = request.temp_degc};
  const auto n = static_cast<std::size_t>(machine.machine().kind->n_chains);
  std::fill_n(move.approach.begin(), n, direction);
  const InverseResult at = commanded(correction, machine, move);
  if (!at.ok() || !within_limits(machine.machine(), at.l_mm)) return false;
  for (std::size_t i = 0; i < n; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    samples[i].push_back({nominal.l_mm[row], at.l_mm[row] - nominal.l_mm[row]});
  }
  return true;
}

TableError worse(const TableError& a, const TableError& b) {
  return {std::sqrt((a.rms_mm * a.rms_mm + b.rms_mm * b.rms_mm) / 2), std::max(a.max_mm, b.max_mm)};
}

/// What one table differs by from a finer one at the samples.
TableError apart(const std::vector<DriveSample>& samples, const DriveTable& fine,
                 const DriveTable& table) {
  std::vector<DriveSample> of_fine = samples;
  for (DriveSample& s : of_fine) s.correction_mm = fine.at(s.position_mm);
  return error_left(of_fine, table);
}

DriveTables tables_of(const std::vector<DriveSample>& up, const std::vector<DriveSample>& down,
                      double knot_mm) {
  const DriveTable none{0, 1, {0, 0}};
  DriveTables of;
  of.forward = fit_drive_table(up, knot_mm, kLinuxCncKnots);
  of.reverse = fit_drive_table(down, knot_mm, kLinuxCncKnots);
  of.before = worse(error_left(up, none), error_left(down, none));
  of.left = worse(error_left(up, of.forward), error_left(down, of.reverse));
  of.grid = worse(apart(up, fit_drive_table(up, knot_mm / 2, kMostKnots), of.forward),
                  apart(down, fit_drive_table(down, knot_mm / 2, kMostKnots), of.reverse));
  return of;
}

}  // namespace

ControllerTables controller_tables(const Correction& correction, const NominalMachine& machine,
                                   const TableRequest& grid, double knot_mm) {
  ControllerTables tables;
  const auto n = static_cast<std::size_t>(machine.machine().kind->n_chains);
  Samples up, down;
  for (const double phi_rad : grid.phi_rad) {
    for (Pose target : lattice(grid.half_width_mm, grid.step_mm)) {
      target.phi_rad = phi_rad;
      if (!moves_to(machine.machine(), target)) continue;
      ++tables.n_targets;
      Samples both;
      const bool reached = add_samples(correction, machine, grid, target, 1, both) &&
                           add_samples(correction, machine, grid, target, -1, both);
      tables.n_unreachable += reached ? 0 : 1;
      for (std::size_t i = 0; reached && i < n; ++i) {
        up[i].push_back(both[i][0]);
        down[i].push_back(both[i][1]);
      }
    }
  }
  if (2 * tables.n_unreachable > tables.n_targets) {  // zeros would stand where nothing is known
    throw InputError(
        {.what = "most targets of the table's grid are out of reach",
         .where = {.field = "--half-width-mm"},
         .got = fmt::format("{:g} mm, {} of {} targets out of reach", grid.half_width_mm,
                            tables.n_unreachable, tables.n_targets),
         .expected = "a grid within what the machine reaches",
         .hint = "--half-width-mm, --step-mm and --knot-mm say how large it is"});
  }
  for (std::size_t i = 0; i < n; ++i) tables.drives.push_back(tables_of(up[i], down[i], knot_mm));
  return tables;
}

std::vector<ControllerFile> linuxcnc_files(const ControllerTables& tables,
                                           const std::string& stem) {
  std::vector<ControllerFile> files;
  for (std::size_t i = 0; i < tables.drives.size(); ++i) {
    const DriveTables& d = tables.drives[i];
    std::string text;
    for (std::size_t k = 0; k < d.forward.values_mm.size(); ++k) {
      text += fmt::format("{:.6f} {:.6f} {:.6f}\n", d.forward.knot_mm(k), d.forward.values_mm[k],
                          d.reverse.values_mm[k]);
    }
    files.push_back({fmt::format("{}.{}.comp", stem, i), text});
  }
  return files;
}

std::string linuxcnc_ini(const std::vector<ControllerFile>& files) {
  std::string text;
  for (std::size_t i = 0; i < files.size(); ++i) {
    text += fmt::format("[JOINT_{}]\nCOMP_FILE = {}\nCOMP_FILE_TYPE = 1\n", i, files[i].name);
  }
  return text;
}

std::string left_in_words(const std::string& who, const TableError& before, const TableError& left,
                          const TableError& grid, double step_mm) {
  return fmt::format(
      "{}: of a correction of {:.1f} um rms ({:.1f} um at most) the table leaves {:.1f} um rms "
      "({:.1f} um at most), {:.1f} um at most of it by its knots every {:g} mm",
      who, kUm * before.rms_mm, kUm * before.max_mm, kUm * left.rms_mm, kUm * left.max_mm,
      kUm * grid.max_mm, step_mm);
}

std::optional<std::string> sides_in_words(const std::string& who, double gap_mm) {
  constexpr double kShown_um = 0.5;
  if (kUm * gap_mm <= kShown_um) return std::nullopt;
  return fmt::format(
      "{}: from its two sides the corrections differ by up to {:.1f} um, which this controller "
      "can't carry: half of that is left on either side",
      who, kUm * gap_mm);
}

std::string aerotech_head(const std::string& what) {
  return "' Corrections of " + what +
         ", mm, added to the command; the mean of both directions.\n"
         "' Written from general knowledge of the form: hold it against the manual of the\n"
         "' controller before use.\n";
}

ControllerFile aerotech_file(const ControllerTables& tables, const std::string& name) {
  std::string text = aerotech_head("each axis by its own position");
  for (std::size_t i = 0; i < tables.drives.size(); ++i) {
    const DriveTables& d = tables.drives[i];
    text += fmt::format(
        ":START1D INAXIS={0} OUTAXIS={0} POSUNIT=METRIC CORUNIT=METRIC SAMPLEDIST={1:.6f} "
        "OFFSET={2:.6f}\n",
        i + 1, d.forward.step_mm, d.forward.first_mm);
    for (std::size_t k = 0; k < d.forward.values_mm.size(); ++k) {
      text += fmt::format("{:.6f}\n", (d.forward.values_mm[k] + d.reverse.values_mm[k]) / 2);
    }
    text += ":END\n";
  }
  return {name, text};
}

std::vector<std::string> table_words(const ControllerTables& tables, bool both_directions) {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < tables.drives.size(); ++i) {
    const DriveTables& d = tables.drives[i];
    const std::string who = fmt::format("drive {}", i + 1);
    words.push_back(left_in_words(who, d.before, d.left, d.grid, d.forward.step_mm));
    double gap_mm = 0;
    for (std::size_t k = 0; k < d.forward.values_mm.size(); ++k) {
      gap_mm = std::max(gap_mm, std::abs(d.forward.values_mm[k] - d.reverse.values_mm[k]));
    }
    if (both_directions) continue;
    if (const auto sides = sides_in_words(who, gap_mm)) words.push_back(*sides);
  }
  if (tables.drives.size() < 2) return words;
  words.emplace_back(
      "a table of one drive can't carry what depends on the other drives or on the orientation: "
      "that is what is left beyond the knots' distance");
  return words;
}

}  // namespace trammel::job
