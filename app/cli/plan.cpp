#include "app/cli/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/cli/approach.hpp"
#include "app/cli/command_tree.hpp"
#include "app/cli/margins.hpp"
#include "app/cli/plan_design.hpp"
#include "app/device/device.hpp"
#include "app/device/stage_json.hpp"
#include "app/files/fields.hpp"
#include "app/files/files.hpp"
#include "app/files/json_file.hpp"
#include "app/files/mechanism_json.hpp"
#include "app/files/numbers.hpp"
#include "app/files/plan_json.hpp"
#include "app/job/next_points_plan.hpp"
#include "app/job/run.hpp"
#include "app/session/plan_record.hpp"
#include "core/plan/named.hpp"
#include "core/plane/extent.hpp"
#include "core/plane/hull.hpp"
#include "core/units.hpp"
#include "store/campaign.hpp"
#include "store/open.hpp"

namespace trammel::cli {

namespace {

struct CreateOptions {
  std::function<bool(const char*)> given;  // an option stands on the line
  std::string grid;
  std::string name;  // default: the grid's
  std::string out;
  bool dry_run = false;
  std::optional<double> step_mm;
  int count = 10;
  double half_width_mm = 100;
  std::vector<double> within;  // low, high, mm
  std::vector<double> centre_mm = {0, 0};
  double radius_mm = 50;
  std::optional<int> points;
  std::vector<double> orientations_deg;
  std::vector<std::string> approaches = {"000"};
  double approach_mm = 5;
  int repeats = 1;
  std::string order = "listed";
  int seed = 1;
  std::string set = "identify";
  int references = 0;
  std::string mechanism;
  double travel_mm = 50;
  int targets = 11;
  int runs = 5;
  std::string criterion = "D";
  std::string campaign;  // next-points: of its last diagnosis; else the bounds
  std::string job;       // next-points: of this diagnosis
  DesignOptions design = {.effects = {"lead_scale", "backlash"}};
};

constexpr double kStepMm = 10, kPaper48StepMm = 20, kOptimalStepMm = 20;
constexpr int kCirclePoints = 72, kOptimalPoints = 40;
const std::vector<double> kOptimalOrientationsDeg = {-5, 0, 5};

struct FileOptions {
  std::string file;
  std::string mechanism;
  CheckOptions check;
  bool identifiability = false;
  DesignOptions design;
  std::string record;  // file to write
  bool dry_run = false;
};

Mechanism mechanism_of(const std::string& file) {
  return file.empty() ? paper_mechanism() : read_mechanism_file(file);
}

/// Where points may lie, and of which machine they are to be safe.
struct Bounds {
  std::vector<Place> hull;             // none: anywhere
  std::optional<Mechanism> mechanism;  // none: not asked

  [[nodiscard]] bool hold(const Pose& pose) const {
    return hull.empty() || inside(hull, {pose.x_mm, pose.y_mm});
  }
};

/// As the line says, else where the campaign was measured and on its machine.
Bounds bounds_of(const CreateOptions& o, const Context& context) {
  Bounds bounds;
  if (!o.campaign.empty() && o.grid != job::kNextPoints) {
    store::Connection db = store::open(context.db(), store::Access::read_only);
    const Campaign campaign =
        store::load_campaign(db, store::require_campaign(db, o.campaign).id).campaign;
    std::vector<Place> places;
    for (const Reading& r : campaign.readings) {
      if (r.measured) places.push_back({r.target.x_mm, r.target.y_mm});
    }
    bounds.hull = convex_hull(places);
    bounds.mechanism = mechanism_of(campaign.machine);
  }
  if (!o.within.empty()) {
    if (!(o.within[0] < o.within[1])) {
      throw UsageError({.what = "no bounds",
                        .where = {.field = "--within"},
                        .got = fmt::format("{} {}", o.within[0], o.within[1]),
                        .expected = "the lower bound first"});
    }
    bounds.hull = square_hull(o.within[0], o.within[1]);
  }
  if (!o.mechanism.empty()) bounds.mechanism = read_mechanism_file(o.mechanism);
  return bounds;
}

/// Of the square of a lattice: what holds the bounds, where they are given.
double half_width_mm(const CreateOptions& o, const Bounds& bounds) {
  if (o.given("--half-width") || bounds.hull.empty()) return o.half_width_mm;
  const Extent all = extent(bounds.hull);
  return std::max({std::abs(all.low.x_mm), std::abs(all.low.y_mm), std::abs(all.high.x_mm),
                   std::abs(all.high.y_mm)});
}

std::vector<TargetGroup> groups_of(const CreateOptions& o, const Bounds& bounds) {
  if (o.grid == "paper-80") return {{"", paper_80(o.step_mm.value_or(kStepMm), o.count)}};
  if (o.grid == "paper-48") return {{"", paper_48(o.step_mm.value_or(kPaper48StepMm))}};
  if (o.grid == "lattice")
    return {{"", lattice(half_width_mm(o, bounds), o.step_mm.value_or(kStepMm))}};
  if (o.grid == "circle") {
    return {{"circle 1", circle({o.centre_mm[0], o.centre_mm[1], o.radius_mm},
                                o.points.value_or(kCirclePoints))}};
  }
  return named_groups(o.grid);
}

std::vector<double> orientations_rad(const CreateOptions& o, const std::vector<double>& otherwise) {
  std::vector<double> all;
  for (const double deg : o.orientations_deg.empty() ? otherwise : o.orientations_deg) {
    all.push_back(rad_from_deg(deg));
  }
  return all;
}

ReadingSet set_of(const CreateOptions& o) {
  return o.set == "validate" ? ReadingSet::validate : ReadingSet::identify;
}

OptimalPlan optimal_for(const CreateOptions& o, const Bounds& bounds) {
  const std::map<std::string, Criterion> kCriteria = {
      {"D", Criterion::D}, {"A", Criterion::A}, {"E", Criterion::E}};
  return optimal_plan(bounds.mechanism.value_or(paper_mechanism()),
                      {.name = o.name.empty() ? o.grid : o.name,
                       .points = o.points.value_or(kOptimalPoints),
                       .criterion = kCriteria.at(o.criterion),
                       .effects = o.design.effects,
                       .sigma = o.design.sigma(),
                       .half_width_mm = half_width_mm(o, bounds),
                       .step_mm = o.step_mm.value_or(kOptimalStepMm),
                       .within = bounds.hull,
                       .orientations_rad = orientations_rad(o, kOptimalOrientationsDeg),
                       .approach_mm = o.approach_mm,
                       .seed = static_cast<std::uint64_t>(o.seed),
                       .set = set_of(o)});
}

/// The points that a stored diagnosis suggests.
Plan suggested_points(const CreateOptions& o, const Context& context) {
  if (o.campaign.empty() == o.job.empty()) {
    throw UsageError({.what = "next-points are those of a diagnosis: name the campaign or the job",
                      .hint = "--campaign NAME (its last diagnosis), or --job JOB"});
  }
  store::Connection db = store::open(context.db(), store::Access::read_only);
  Plan plan = job::stored_next_points(o.job.empty() ? job::last_diagnosis(db, o.campaign)
                                                    : job::find(db, o.job));
  if (!o.name.empty()) plan.name = o.name;
  return plan;
}

/// Whether the pose lies within the bounds, and from each direction and at each orientation that is
/// asked for it is safe.
bool admitted(const Pose& pose, const PlanRequest& request, const Bounds& bounds) {
  if (!bounds.hold(pose)) return false;
  if (!bounds.mechanism) return true;
  for (const double turn_rad : request.orientations_rad) {
    for (const Approach& approach : request.approaches) {
      const Pose turned{pose.x_mm, pose.y_mm, pose.phi_rad + turn_rad};
      const Plan one{"", request.approach_mm, {{.seq = 1, .target = turned, .approach = approach}}};
      if (!check(one, *bounds.mechanism).empty()) return false;
    }
  }
  return true;
}

void leave_out(PlanRequest& request, const Bounds& bounds, const Context& context) {
  std::size_t n_all = 0, n_out = 0;
  for (TargetGroup& group : request.groups) {
    n_all += group.poses.size();
    n_out += std::erase_if(group.poses,
                           [&](const Pose& pose) { return !admitted(pose, request, bounds); });
  }
  std::erase_if(request.groups, [](const TargetGroup& group) { return group.poses.empty(); });
  if (n_out == 0) return;
  const char* why =
      bounds.mechanism ? "outside the bounds, or not safe on the machine" : "outside the bounds";
  if (n_out == n_all) {
    throw InputError({.what = fmt::format("all {} points of the grid are {}", n_all, why),
                      .hint = "wider --within, or another grid"});
  }
  context.say(fmt::format("{} of {} points are left out: {}", n_out, n_all, why));
}

Plan plan_for(const CreateOptions& o, const Bounds& bounds, const Context& context) {
  if (o.grid == job::kNextPoints) return suggested_points(o, context);
  if (o.grid == "optimal") return optimal_for(o, bounds).plan;
  const std::string name = o.name.empty() ? o.grid : o.name;
  if (o.grid == "rail") {
    return rail_plan(bounds.mechanism.value_or(paper_mechanism()),
                     {name, o.travel_mm, o.targets, o.runs, o.approach_mm});
  }
  PlanRequest request{.name = name, .groups = groups_of(o, bounds)};
  request.orientations_rad = orientations_rad(o, {0});
  request.approaches.clear();
  for (const std::string& text : o.approaches) request.approaches.push_back(parse_approach(text));
  request.repeats = o.repeats;
  request.set = set_of(o);
  const std::map<std::string, Order> kOrders = {
      {"listed", Order::as_listed}, {"random", Order::random}, {"nearest", Order::nearest}};
  request.order = kOrders.at(o.order);
  request.seed = static_cast<std::uint64_t>(o.seed);
  request.approach_mm = o.approach_mm;
  request.references = o.references;
  leave_out(request, bounds, context);
  return build_plan(request);
}

/// Options that shape some grids only.
struct Use {
  const char* option;
  std::vector<std::string> grids;
  bool but = false;  // all grids but these

  [[nodiscard]] bool by(const std::string& grid) const {
    return (std::ranges::find(grids, grid) != grids.end()) != but;
  }
};
const std::vector<Use>& uses() {
  static const std::vector<std::string> chosen = {"rail", "optimal", job::kNextPoints};
  static const std::vector<Use> all = {{"--step", {"paper-80", "paper-48", "lattice", "optimal"}},
                                       {"--count", {"paper-80"}},
                                       {"--half-width", {"lattice", "optimal"}},
                                       {"--within", {"rail", job::kNextPoints}, true},
                                       {"--centre", {"circle"}},
                                       {"--radius", {"circle"}},
                                       {"--points", {"circle", "optimal"}},
                                       {"--mechanism", {job::kNextPoints}, true},
                                       {"--travel", {"rail"}},
                                       {"--targets", {"rail"}},
                                       {"--runs", {"rail"}},
                                       {"--criterion", {"optimal"}},
                                       {"--sigma-xy", {"optimal"}},
                                       {"--sigma-phi", {"optimal"}},
                                       {"--effects", {"optimal"}},
                                       {"--job", {job::kNextPoints}},
                                       {"--orientations", {"rail", job::kNextPoints}, true},
                                       {"--seed", {"rail", job::kNextPoints}, true},
                                       {"--set", {"rail", job::kNextPoints}, true},
                                       {"--approach-distance", {job::kNextPoints}, true},
                                       {"--approach", chosen, true},
                                       {"--repeats", chosen, true},
                                       {"--order", chosen, true},
                                       {"--references", chosen, true}};
  return all;
}

/// An option that would do nothing is refused, not passed over.
void require_used(const CreateOptions& o) {
  for (const Use& use : uses()) {
    if (!o.given(use.option) || use.by(o.grid)) continue;
    throw UsageError({.what = "this option does nothing for the grid " + o.grid,
                      .where = {.field = use.option},
                      .expected = fmt::format("{}{}", use.but ? "a grid other than " : "",
                                              fmt::join(use.grids, ", ")),
                      .hint = fmt::format("see trammel plan create {} --help", o.grid)});
  }
}

/// `plan create lattice --help` shows what shapes a lattice.
void show_only_used(Command c) {
  const auto words = positionals_of(c).front().words();
  if (words.empty()) return;
  for (const Use& use : uses()) {
    const auto option = find_option(c, use.option);
    if (option && !use.by(words.front())) option->hide();
  }
}

ExitCode run_create(const CreateOptions& options, Context& context) {
  require_used(options);
  const Bounds bounds = bounds_of(options, context);
  const Plan plan = plan_for(options, bounds, context);
  const std::string text = plan_json(plan).dump(1) + "\n";
  if (options.grid == "optimal") {
    context.say(
        beside_paper_80(plan, bounds.mechanism.value_or(paper_mechanism()), options.design));
  }
  if (options.out.empty()) {
    context.print_as_is(text);
    return ExitCode::ok;
  }
  if (!options.dry_run) write_output(options.out, text, context.existing());
  if (context.json) {
    context.print("plan-create", {{"plan", plan.name},
                                  {"file", options.out},
                                  {"n_points", plan.points.size()},
                                  {"dry_run", options.dry_run}});
  }
  context.say(fmt::format("{} points {} {}", plan.points.size(),
                          options.dry_run ? "would be written to" : "written to",
                          printable(options.out)));
  if (!options.dry_run) {
    const std::string& file = options.mechanism;
    context.next("trammel plan check " + shell_word(options.out) +
                 (file.empty() ? "" : " --mechanism " + shell_word(file)));
  }
  return ExitCode::ok;
}

ExitCode run_show(const FileOptions& options, Context& context) {
  const Plan plan = plan_of(options.file);
  if (context.json) {
    Json fields = plan_json(plan);
    fields.erase("schema");  // this is the plan as a command's answer
    fields["n_points"] = plan.points.size();
    context.print("plan-show", fields);
    return ExitCode::ok;
  }
  std::string text = fmt::format(
      "{}: {} points\n seq       x mm       y mm   phi deg  approach  "
      "repeat  set       group\n",
      printable(plan.name), plan.points.size());
  for (const PlannedPoint& p : plan.points) {
    text += fmt::format("{:>4} {:>10.4f} {:>10.4f} {:>9.4f}  {:<8}  {:>6}  {:<8}  {}{}\n", p.seq,
                        rounded(p.target.x_mm, 4), rounded(p.target.y_mm, 4),
                        rounded(deg_from_rad(p.target.phi_rad), 4), approach_text(p.approach),
                        p.repeat, p.set == ReadingSet::validate ? "validate" : "identify",
                        printable(p.group), p.reference ? " (reference)" : "");
  }
  context.print(text);
  return ExitCode::ok;
}

/// Of a mechanism that a stage file states; nothing for any other.
std::optional<double> watch_of(const std::string& file) {
  if (file.empty()) return std::nullopt;
  const JsonFile json = read_json(file);
  if (!Fields(json).has("controller")) return std::nullopt;
  return device::read_stage(file).galil.watch_host_s;
}

ExitCode run_check(const FileOptions& options, Context& context) {
  const Plan plan = plan_of(options.file);
  const std::optional<double> watch_s = watch_of(options.mechanism);
  const Mechanism mechanism = mechanism_of(options.mechanism);
  const auto violations = check(plan, mechanism, options.check);
  std::optional<PlanDesign> design;
  if (options.identifiability) design = design_of(plan, mechanism, options.design);
  const bool records = !options.record.empty() && violations.empty() && !options.dry_run;
  if (records) {
    session::write_plan_record(options.record, plan, mechanism, options.check, context.existing());
  }
  if (context.json) {
    Json fields = {{"plan", plan.name},
                   {"n_points", plan.points.size()},
                   {"plan_sha256", session::plan_sha256(plan, mechanism)},
                   {"recorded", records},
                   {"safe", violations.empty()},
                   {"mechanism", options.mechanism.empty() ? Json() : Json(options.mechanism)},
                   {"violations", violations_json(violations)}};
    if (watch_s) fields["watch_host_s"] = *watch_s;
    if (design) fields["identifiability"] = design_json(*design);
    context.print("plan-check", fields);
  } else {
    std::string text;
    for (const Violation& v : violations) text += describe(v) + "\n";
    text += violations.empty()
                ? fmt::format("{}: {} points, every target and path is safe", printable(plan.name),
                              plan.points.size())
                : fmt::format("{}: {} violations", printable(plan.name), violations.size());
    if (options.mechanism.empty()) {
      text += "\non the paper's 3-PRR, which was assumed: no --mechanism is given";
    }
    if (watch_s) text += "\n" + device::watch_text(*watch_s);
    context.print(design ? design_text(*design) + text : text);
  }
  if (options.mechanism.empty()) {  // safe on a robot that may not be there
    context.next(fmt::format("trammel plan check {} --mechanism FILE", shell_word(options.file)));
  }
  return violations.empty() ? ExitCode::ok : ExitCode::not_acceptable;
}

void grid_options(Command c, CreateOptions& o) {
  c.option("--step", o.step_mm, "mm (10; paper-48, optimal: 20)");
  c.option("--count", o.count, "paper-80: points on each of its 8 arms").shown_default();
  const Option half_width =
      c.option("--half-width", o.half_width_mm, "lattice, optimal: of the square, mm")
          .shown_default();
  c.option("--within", o.within, "leave out points whose x or y is not: low high, mm")
      .expected(2)
      .excludes(half_width);
  c.option("--centre", o.centre_mm, "circle: x y in mm").expected(2);
  c.option("--radius", o.radius_mm, "circle: mm").shown_default();
  c.option("--points", o.points, "how many (circle: 72; optimal: 40)");
  c.option("--mechanism", o.mechanism,
           "leave out points that are not safe on it; rail, optimal: of it (the paper's)")
      .type("FILE");
  c.option("--travel", o.travel_mm, "rail: mm to either side of home").shown_default();
  c.option("--targets", o.targets, "rail: targets per run").shown_default();
  c.option("--runs", o.runs, "rail: runs, each in both directions").shown_default();
  c.option("--criterion", o.criterion, "optimal: D (volume), A (mean variance), E (worst)")
      .one_of({"D", "A", "E"})
      .shown_default();
  c.option("--campaign", o.campaign,
           "next-points: of its last diagnosis; else within what was measured, on its machine")
      .type("CAMPAIGN");
  c.option("--job", o.job, "next-points: those of this diagnosis").type("JOB");
  design_options(c, o.design);
}

void setup_create(Command plan, Context& context) {
  Command c = plan.command("create", "Make a plan and print it, or write it to a file");
  auto o = std::make_shared<CreateOptions>();
  o->given = [c](const char* option) { return c.given(option); };
  std::vector<std::string> grids = grid_names();
  grids.insert(grids.end(), {"lattice", "circle", "rail", "optimal", job::kNextPoints});
  c.option("grid", o->grid, "which points").required().one_of(grids);
  c.option("--out", o->out, "file to write (stdout)").type("FILE");
  c.flag("--dry-run", o->dry_run, "make the plan, write no file");
  c.option("--name", o->name, "of the plan (the grid's)").type("NAME");
  grid_options(c, *o);
  c.option("--orientations", o->orientations_deg, "deg, added to each pose (0; optimal: -5,0,5)")
      .delimiter(',');
  c.option("--approach", o->approaches, "+, - or 0 per rail, several with commas: +++,---")
      .delimiter(',');
  c.option("--approach-distance", o->approach_mm, "length of the last move, mm").shown_default();
  c.option("--repeats", o->repeats, "times all points are visited, round by round").shown_default();
  c.option("--order", o->order, "of each round")
      .one_of({"listed", "random", "nearest"})
      .shown_default();
  c.option("--seed", o->seed, "of the random order").non_negative().shown_default();
  c.option("--set", o->set, "identify or validate")
      .one_of({"identify", "validate"})
      .shown_default();
  c.option("--references", o->references, "this many first points serve as references")
      .non_negative()
      .shown_default();
  context.before_help.push_back([c] { show_only_used(c); });
  on_run(c, context, o, run_create);
}

}  // namespace

void setup_plan(Command app, Context& context) {
  Command plan = noun(app, "plan", "Which poses a session measures, and how it comes to them");
  setup_create(plan, context);
  Command show = plan.command("show", "List the points of a plan");
  auto shown = std::make_shared<FileOptions>();
  show.option("plan", shown->file, "file, or the name of a grid").required();
  on_run(show, context, shown, run_show);
  Command checked = plan.command("check", "Every target and every path; lists all faults");
  auto options = std::make_shared<FileOptions>();
  checked.option("plan", options->file, "file, or the name of a grid").required();
  checked.option("--mechanism", options->mechanism, "mechanism file (the paper's)").type("FILE");
  margin_options(checked, options->check);
  checked.option("--speed", options->check.speed_mm_s, "of the fastest rail, mm/s").shown_default();
  checked
      .option("--record", options->record,
              "write that the plan is safe, for `session run --plan-check`")
      .type("FILE");
  checked.flag("--dry-run", options->dry_run, "check, write no record");
  checked.flag("--identifiability", options->identifiability,
               "say what the readings will tell: rank, what stays unknown, uncertainty");
  design_options(checked, options->design);
  on_run(checked, context, options, run_check);
}

}  // namespace trammel::cli
