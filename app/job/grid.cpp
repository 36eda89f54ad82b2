#include "app/job/grid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/files/plan_json.hpp"
#include "app/job/next_points_plan.hpp"
#include "core/plan/named.hpp"
#include "core/plane/extent.hpp"
#include "core/plane/hull.hpp"

namespace trammel::job {

namespace {

constexpr double kStepMm = 10, kPaper48StepMm = 20, kOptimalStepMm = 20, kHalfWidthMm = 100;
constexpr int kCirclePoints = 72, kOptimalPoints = 40;
const std::vector<double> kOptimalOrientationsDeg = {-5, 0, 5};

/// Of the square of a lattice: what holds the bounds, where they are given.
double half_width_of(const GridRequest& r) {
  if (r.half_width_mm || r.hull.empty()) return r.half_width_mm.value_or(kHalfWidthMm);
  const Extent all = extent(r.hull);
  return std::max({std::abs(all.low.x_mm), std::abs(all.low.y_mm), std::abs(all.high.x_mm),
                   std::abs(all.high.y_mm)});
}

std::vector<TargetGroup> groups_of(const GridRequest& r) {
  if (r.grid == "paper-80") return {{"", paper_80(r.step_mm.value_or(kStepMm), r.count)}};
  if (r.grid == "paper-48") return {{"", paper_48(r.step_mm.value_or(kPaper48StepMm))}};
  if (r.grid == "lattice") return {{"", lattice(half_width_of(r), r.step_mm.value_or(kStepMm))}};
  if (r.grid == "circle") {
    return {{"circle 1", circle({r.centre_mm[0], r.centre_mm[1], r.radius_mm},
                                r.points.value_or(kCirclePoints))}};
  }
  return named_groups(r.grid);
}

std::vector<double> turns_rad(const GridRequest& r, const std::vector<double>& otherwise) {
  std::vector<double> all;
  for (const double deg : r.orientations_deg.empty() ? otherwise : r.orientations_deg) {
    all.push_back(rad_from_deg(deg));
  }
  return all;
}

Plan optimal_of(const GridRequest& r, const std::string& name, const Machine& machine) {
  return optimal_plan(machine, {.name = name,
                                .points = r.points.value_or(kOptimalPoints),
                                .criterion = r.criterion,
                                .effects = r.effects,
                                .sigma = r.sigma,
                                .half_width_mm = half_width_of(r),
                                .step_mm = r.step_mm.value_or(kOptimalStepMm),
                                .within = r.hull,
                                .orientations_rad = turns_rad(r, kOptimalOrientationsDeg),
                                .approach_mm = r.approach_mm,
                                .seed = static_cast<std::uint64_t>(r.seed),
                                .set = r.set})
      .plan;
}

/// Whether the pose, from each direction and at each orientation that is asked for, is safe.
bool safe(const Pose& pose, const PlanRequest& request, const Machine& machine) {
  for (const double turn_rad : request.orientations_rad) {
    for (const Approach& approach : request.approaches) {
      const Pose turned{pose.x_mm, pose.y_mm, pose.phi_rad + turn_rad};
      const Plan one{"", request.approach_mm, {{.seq = 1, .target = turned, .approach = approach}}};
      if (!check(one, machine).empty()) return false;
    }
  }
  return true;
}

/// What a machine does not move stands at home: of a lattice an axis visits the one line through
/// it, and no direction is asked of a drive that it has not.
void keep_on_machine(PlanRequest& request, const Machine& machine) {
  const int n = machine.kind->n_chains;
  const Eigen::Vector3d home = machine.home.vector();
  for (TargetGroup& group : request.groups) {
    std::erase_if(group.poses, [&](const Pose& pose) {
      return n < 2 && std::abs(pose.y_mm - home[1]) > kStandstillMm;
    });
    for (Pose& pose : group.poses) {
      Eigen::Vector3d X = pose.vector();
      for (int c = n; c < 3; ++c) X[c] = home[c];
      pose = Pose::from(X);
    }
  }
}

template <class T>
T value_named(Fields& fields, const char* field,
              const std::vector<std::pair<std::string, T>>& values, T absent) {
  if (!fields.has(field)) return absent;
  std::vector<std::string> names;
  for (const auto& [name, value] : values) names.push_back(name);
  const std::string wanted = fields.choice(field, names);
  return std::ranges::find(values, wanted, &std::pair<std::string, T>::first)->second;
}

std::vector<double> pair_of(Fields& fields, const char* field, std::vector<double> absent) {
  if (!fields.has(field)) return absent;
  std::vector<double> pair = fields.numbers(field);
  if (pair.size() != 2) fields.refuse(field, "wrong number of values", "two of them");
  return pair;
}

}  // namespace

const std::vector<std::string>& grids() {
  static const std::vector<std::string> all = [] {
    std::vector<std::string> names = grid_names();
    names.insert(names.end(), {"lattice", "circle", "rail", "optimal"});
    return names;
  }();
  return all;
}

const std::vector<std::pair<std::string, Order>>& orders() {
  static const std::vector<std::pair<std::string, Order>> all = {
      {"listed", Order::as_listed}, {"random", Order::random}, {"nearest", Order::nearest}};
  return all;
}

const std::vector<std::pair<std::string, Criterion>>& criteria() {
  static const std::vector<std::pair<std::string, Criterion>> all = {
      {"D", Criterion::D}, {"A", Criterion::A}, {"E", Criterion::E}};
  return all;
}

bool GridField::used_by(const std::string& grid) const {
  return (std::ranges::find(grids, grid) != grids.end()) != but;
}

std::string GridField::users() const {
  return fmt::format("{}{}", but ? "a grid other than " : "", fmt::join(grids, ", "));
}

const std::vector<GridField>& grid_fields() {
  static const std::vector<std::string> chosen = {"rail", "optimal", kNextPoints};
  static const std::vector<GridField> all = {
      {"--step", "step_mm", {"paper-80", "paper-48", "lattice", "optimal"}},
      {"--count", "count", {"paper-80"}},
      {"--half-width", "half_width_mm", {"lattice", "optimal"}},
      {"--within", "within_mm", {"rail", kNextPoints}, true},
      {"--centre", "centre_mm", {"circle"}},
      {"--radius", "radius_mm", {"circle"}},
      {"--points", "points", {"circle", "optimal"}},
      {"--mechanism", "", {kNextPoints}, true},
      {"--travel", "travel_mm", {"rail"}},
      {"--targets", "targets", {"rail"}},
      {"--runs", "runs", {"rail"}},
      {"--criterion", "criterion", {"optimal"}},
      {"--sigma-xy", "sigma_xy_mm", {"optimal"}},
      {"--sigma-phi", "sigma_phi_deg", {"optimal"}},
      {"--effects", "effects", {"optimal"}},
      {"--job", "", {kNextPoints}},
      {"--orientations", "orientations_deg", {"rail", kNextPoints}, true},
      {"--seed", "seed", {"rail", kNextPoints}, true},
      {"--set", "", {"rail", kNextPoints}, true},
      {"--approach-distance", "approach_mm", {kNextPoints}, true},
      {"--approach", "approaches", chosen, true},
      {"--repeats", "repeats", chosen, true},
      {"--order", "order", chosen, true},
      {"--references", "references", chosen, true}};
  return all;
}

GridRequest read_grid(Fields& fields) {
  GridRequest r;
  r.grid = fields.choice("grid", grids());
  for (const GridField& field : grid_fields()) {
    if (*field.field == '\0' || field.used_by(r.grid)) continue;
    if (fields.value().contains(field.field)) {
      fields.refuse(field.field, "this does nothing for the grid " + r.grid, field.users());
    }
  }
  r.name = fields.text("name", "");
  r.step_mm = fields.optional_number("step_mm");
  r.count = fields.integer("count", r.count);
  r.half_width_mm = fields.optional_number("half_width_mm");
  const std::vector<double> within = pair_of(fields, "within_mm", {});
  if (!within.empty()) {
    if (!(within[0] < within[1])) fields.refuse("within_mm", "no bounds", "the lower bound first");
    r.hull = square_hull(within[0], within[1]);
  }
  r.centre_mm = pair_of(fields, "centre_mm", r.centre_mm);
  r.radius_mm = fields.number("radius_mm", r.radius_mm);
  if (fields.has("points")) r.points = fields.integer("points");
  if (fields.has("orientations_deg")) r.orientations_deg = fields.numbers("orientations_deg");
  if (fields.has("approaches")) r.approaches = read_approaches(fields);
  r.approach_mm = fields.number("approach_mm", r.approach_mm);
  r.repeats = fields.integer("repeats", r.repeats);
  r.order = value_named(fields, "order", orders(), r.order);
  r.seed = fields.integer("seed", r.seed);
  if (r.seed < 0) fields.refuse("seed", "no seed", "0 or more");
  r.references = fields.integer("references", r.references);
  r.travel_mm = fields.number("travel_mm", r.travel_mm);
  r.targets = fields.integer("targets", r.targets);
  r.runs = fields.integer("runs", r.runs);
  r.criterion = value_named(fields, "criterion", criteria(), r.criterion);
  r.sigma.xy_mm = fields.number("sigma_xy_mm", r.sigma.xy_mm);
  r.sigma.phi_rad = rad_from_deg(fields.number("sigma_phi_deg", deg_from_rad(r.sigma.phi_rad)));
  if (fields.has("effects")) r.effects = fields.texts("effects");
  fields.done();
  return r;
}

GridPlan grid_plan(const GridRequest& r, const Machine& machine, bool only_safe) {
  const std::string name = r.name.empty() ? r.grid : r.name;
  if (r.grid == "optimal") return {.plan = optimal_of(r, name, machine)};
  if (r.grid == "rail") {
    return {.plan = rail_plan(machine, {name, r.travel_mm, r.targets, r.runs, r.approach_mm})};
  }
  PlanRequest request{.name = name, .groups = groups_of(r)};
  request.orientations_rad = turns_rad(r, {0});
  request.approaches = r.approaches;
  request.repeats = r.repeats;
  request.set = r.set;
  request.order = r.order;
  request.seed = static_cast<std::uint64_t>(r.seed);
  request.approach_mm = r.approach_mm;
  request.references = r.references;
  keep_on_machine(request, machine);
  GridPlan grid;
  for (TargetGroup& group : request.groups) {
    grid.n_all += group.poses.size();
    grid.n_out += std::erase_if(group.poses, [&](const Pose& pose) {
      return !(r.hull.empty() || inside(r.hull, {pose.x_mm, pose.y_mm})) ||
             (only_safe && !safe(pose, request, machine));
    });
  }
  std::erase_if(request.groups, [](const TargetGroup& group) { return group.poses.empty(); });
  if (grid.n_all == 0) {
    throw InputError({.what = "no point of the grid " + r.grid + " lies on the machine's axis",
                      .hint = "a lattice or the grid rail"});
  }
  if (grid.n_out > 0 && grid.n_out == grid.n_all) {
    throw InputError(
        {.what = fmt::format(
             "all {} points of the grid are {}", grid.n_all,
             only_safe ? "outside the bounds, or not safe on the machine" : "outside the bounds"),
         .hint = "wider --within, or another grid"});
  }
  grid.plan = build_plan(request);
  return grid;
}

}  // namespace trammel::job
