#include "app/files/positions_campaign.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <vector>

#include "app/files/numbers.hpp"
#include "core/error.hpp"
#include "core/mechanism/machine_solver.hpp"

namespace trammel {

namespace {

class Maker {
 public:
  Maker(const PositionsFile& file, const PositionsUse& use) : file_(file), use_(use) {}

  Campaign campaign() {
    out_.name = use_.name.empty() ? std::filesystem::path(file_.name).stem().string() : use_.name;
    out_.simulated = use_.simulated;
    out_.tracker = use_.sigma;
    out_.facts = file_.facts;
    out_.facts["file"] = std::filesystem::path(file_.name).filename().string();
    out_.facts["format"] = file_.format;
    set_machine();
    make_readings();
    choose_sets();
    return std::move(out_);
  }

 private:
  [[noreturn]] void refuse(const std::string& what, const std::string& field,
                           const std::string& got, const std::string& expected,
                           const std::string& hint = "") const {
    throw InputError({.what = what,
                      .where = {.file = file_.name, .field = field},
                      .got = got,
                      .expected = expected,
                      .hint = hint});
  }

  void set_machine() {
    const MachineKind& kind = *find_machine_kind(use_.kind);
    const std::string name(kind.name);
    if (use_.machine && use_.machine->kind != &kind) {
      refuse("the file is of another machine", "mechanism", std::string(use_.machine->kind->name),
             name + (kind.n_chains == 1 ? ": the file holds one axis" : ": the file holds a grid"));
    }
    const auto n = static_cast<std::size_t>(kind.n_chains);
    for (std::size_t c = 0; c < 3; ++c) {
      const std::string coordinate(kCoordinateNames[c]);
      if (c < n && !file_.targeted[c]) {
        refuse("the file has no column of a coordinate", coordinate, "",
               "x and y, commanded and measured", "an axis alone is imported by --axis");
      }
      if (c >= n && file_.targeted[c]) {
        refuse("an " + name + " machine does not go along a coordinate that the file commands",
               coordinate, "", n == 1 ? "x alone" : "x and y");
      }
      if (file_.measured[c] && !kind.measurable[c]) {
        refuse(coordinate + " cannot be measured on an " + name + " machine", coordinate, "",
               "x alone: its model has nothing to compare another one with");
      }
      if (use_.machine && use_.machine->measured[c] && !file_.measured[c]) {
        refuse("the machine measures a coordinate of which the file has no column", coordinate, "",
               "a column of it, or a machine file with \"measured\" as the file has it");
      }
    }
    out_.machine = use_.machine ? *use_.machine : assumed(kind);
    out_.machine.measured = file_.measured;
    if (file_.measured[2] && use_.sigma && !(use_.sigma->phi_rad > 0)) {
      refuse("the file measures phi, and nothing states how well", "sigma_phi_deg", "",
             "a positive angle", "--sigma-phi beside --sigma-xy, or neither");
    }
  }

  /// As its kind's starting machine: square guides and a lead of 10 mm, so that commands are the
  /// targets.
  Machine assumed(const MachineKind& kind) {
    Machine machine = starting_machine(kind.name);
    Eigen::Vector3d low = file_.rows.front().target.vector(), high = low;
    for (const PositionRow& row : file_.rows) {
      low = low.cwiseMin(row.target.vector());
      high = high.cwiseMax(row.target.vector());
    }
    const bool holds_origin = (low.array() <= 0).all() && (high.array() >= 0).all();
    if (!holds_origin) machine.home = Pose::from((low + high) / 2);
    for (int i = 0; i < kind.n_chains; ++i) {
      // A stroke as wide again as the grid: where it ends the file does not say.
      const double beyond = std::max(1.0, high[i] - low[i]) / 2;
      machine.drives[static_cast<std::size_t>(i)].limits = {low[i] - beyond, high[i] + beyond};
    }
    out_.facts["machine"] = fmt::format(
        "assumed, no machine file was given: {}, square guides, screw lead 10 mm, home {}",
        kind.name, holds_origin ? "the origin" : "the middle of the targets");
    return machine;
  }

  /// Of an axis: to the nearest other target.
  [[nodiscard]] double approach_mm() const {
    std::vector<double> targets;
    for (const PositionRow& row : file_.rows) targets.push_back(row.target.x_mm);
    std::ranges::sort(targets);
    double least = INFINITY;
    for (std::size_t k = 1; k < targets.size(); ++k) {
      const double gap = targets[k] - targets[k - 1];
      if (gap > kStandstillMm) least = std::min(least, gap);
    }
    return std::isfinite(least) ? least : 1;
  }

  void make_readings() {
    const MachineSolver solver(out_.machine);
    const InverseResult home = solver.drives(out_.machine.home);
    if (!home.ok()) refuse("the home pose is out of reach", "mechanism.home", "", "");
    const bool directed =
        std::ranges::any_of(file_.rows, [](const PositionRow& row) { return row.direction != 0; });
    if (directed && out_.machine.kind->n_chains != 1) {
      refuse("a direction of a move in a plane says of no drive how it came", "direction", "",
             "no such column; rows in the order in which they were measured: --in-order");
    }
    const double approach = directed ? approach_mm() : 0;
    mark_order(directed, approach);
    Displacements before = home.l_mm;
    for (const PositionRow& row : file_.rows) {
      Reading r;
      r.seq = static_cast<int>(out_.readings.size()) + 1;
      r.target = target_of(row);
      const InverseResult at = solver.drives(r.target);
      if (!at.ok()) {
        throw InputError({.what = "a target is out of reach of the machine",
                          .where = {.file = file_.name, .line = row.line}});
      }
      r.conditions.cmd_mm = at.l_mm;
      r.conditions.from_mm = use_.in_order ? before : at.l_mm;
      if (directed) r.conditions.from_mm[0] = at.l_mm[0] - row.direction * approach;
      r.conditions.time_s = row.time_s;
      r.conditions.temp_degc = row.temp_degc;
      r.measured = row.measured;
      before = at.l_mm;
      out_.readings.push_back(r);
    }
  }

  void mark_order(bool directed, double approach) {
    out_.facts["approach"] =
        directed ? fmt::format(
                       "directions as in the file, each from {} mm away (assumed: the "
                       "nearest other target)",
                       number_text(approach))
        : use_.in_order ? "each position from the row before"
                        : "not known: the file does not say in which order its rows were measured";
  }

  /// Coordinates that the file has not stand at home.
  [[nodiscard]] Pose target_of(const PositionRow& row) const {
    Eigen::Vector3d target = row.target.vector();
    const Eigen::Vector3d home = out_.machine.home.vector();
    for (int c = out_.machine.kind->n_chains; c < 3; ++c) target[c] = home[c];
    return Pose::from(target);
  }

  /// The number of its line among all lines of targets in one coordinate.
  [[nodiscard]] static std::size_t line_of(const std::vector<double>& lines, double at) {
    return static_cast<std::size_t>(
        std::lower_bound(lines.begin(), lines.end(), at - kStandstillMm) - lines.begin());
  }

  void choose_sets() {
    if (use_.fit_every <= 1) return;
    std::array<std::vector<double>, 2> lines;
    for (const Reading& r : out_.readings) {
      lines[0].push_back(r.target.x_mm);
      lines[1].push_back(r.target.y_mm);
    }
    for (std::vector<double>& all : lines) {
      std::ranges::sort(all);
      const auto same = [](double a, double b) { return b - a <= kStandstillMm; };
      all.erase(std::unique(all.begin(), all.end(), same), all.end());
    }
    const auto every = static_cast<std::size_t>(use_.fit_every);
    for (Reading& r : out_.readings) {
      const bool fitted = line_of(lines[0], r.target.x_mm) % every == 0 &&
                          line_of(lines[1], r.target.y_mm) % every == 0;
      r.set = fitted ? ReadingSet::identify : ReadingSet::validate;
    }
  }

  const PositionsFile& file_;
  const PositionsUse& use_;
  Campaign out_;
};

}  // namespace

Campaign campaign_of_positions(const PositionsFile& file, const PositionsUse& use) {
  return Maker(file, use).campaign();
}

}  // namespace trammel
