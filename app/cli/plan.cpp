#include "app/cli/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/cli/approach.hpp"
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
#include "core/units.hpp"
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
  std::string campaign;  // next-points: of its last diagnosis
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

std::vector<TargetGroup> groups_of(const CreateOptions& o) {
  if (o.grid == "paper-80") return {{"", paper_80(o.step_mm.value_or(kStepMm), o.count)}};
  if (o.grid == "paper-48") return {{"", paper_48(o.step_mm.value_or(kPaper48StepMm))}};
  if (o.grid == "lattice") return {{"", lattice(o.half_width_mm, o.step_mm.value_or(kStepMm))}};
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

OptimalPlan optimal_for(const CreateOptions& o) {
  const std::map<std::string, Criterion> kCriteria = {
      {"D", Criterion::D}, {"A", Criterion::A}, {"E", Criterion::E}};
  return optimal_plan(mechanism_of(o.mechanism),
                      {.name = o.name.empty() ? o.grid : o.name,
                       .points = o.points.value_or(kOptimalPoints),
                       .criterion = kCriteria.at(o.criterion),
                       .effects = o.design.effects,
                       .sigma = o.design.sigma(),
                       .half_width_mm = o.half_width_mm,
                       .step_mm = o.step_mm.value_or(kOptimalStepMm),
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

Plan plan_for(const CreateOptions& o, const Context& context) {
  if (o.grid == job::kNextPoints) return suggested_points(o, context);
  if (o.grid == "optimal") return optimal_for(o).plan;
  const std::string name = o.name.empty() ? o.grid : o.name;
  if (o.grid == "rail") {
    return rail_plan(mechanism_of(o.mechanism),
                     {name, o.travel_mm, o.targets, o.runs, o.approach_mm});
  }
  PlanRequest request{.name = name, .groups = groups_of(o)};
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
  return build_plan(request);
}

/// Options that shape some grids only.
struct Use {
  const char* option;
  std::vector<std::string> grids;
  bool but = false;  // all grids but these
};
const std::vector<Use>& uses() {
  static const std::vector<Use> all = {{"--step", {"paper-80", "paper-48", "lattice", "optimal"}},
                                       {"--count", {"paper-80"}},
                                       {"--half-width", {"lattice", "optimal"}},
                                       {"--centre", {"circle"}},
                                       {"--radius", {"circle"}},
                                       {"--points", {"circle", "optimal"}},
                                       {"--mechanism", {"rail", "optimal"}},
                                       {"--travel", {"rail"}},
                                       {"--targets", {"rail"}},
                                       {"--runs", {"rail"}},
                                       {"--criterion", {"optimal"}},
                                       {"--sigma-xy", {"optimal"}},
                                       {"--sigma-phi", {"optimal"}},
                                       {"--effects", {"optimal"}},
                                       {"--orientations", {"rail"}, true},
                                       {"--seed", {"rail"}, true},
                                       {"--set", {"rail"}, true},
                                       {"--approach", {"rail", "optimal"}, true},
                                       {"--repeats", {"rail", "optimal"}, true},
                                       {"--order", {"rail", "optimal"}, true},
                                       {"--references", {"rail", "optimal"}, true}};
  return all;
}

/// An option that would do nothing is refused, not passed over.
void require_used(const CreateOptions& o) {
  for (const Use& use : uses()) {
    const bool listed = std::find(use.grids.begin(), use.grids.end(), o.grid) != use.grids.end();
    if (!o.given(use.option) || listed != use.but) continue;
    throw UsageError({.what = "this option does nothing for the grid " + o.grid,
                      .where = {.field = use.option},
                      .expected = fmt::format("{}{}", use.but ? "a grid other than " : "",
                                              fmt::join(use.grids, ", "))});
  }
}

ExitCode run_create(const CreateOptions& options, Context& context) {
  require_used(options);
  const Plan plan = plan_for(options, context);
  const std::string text = plan_json(plan).dump(1) + "\n";
  if (options.grid == "optimal") {
    context.say(beside_paper_80(plan, mechanism_of(options.mechanism), options.design));
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
  if (!options.dry_run) context.next("trammel plan check " + shell_word(options.out));
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
    if (watch_s) text += "\n" + device::watch_text(*watch_s);
    context.print(design ? design_text(*design) + text : text);
  }
  return violations.empty() ? ExitCode::ok : ExitCode::not_acceptable;
}

void grid_options(Command c, CreateOptions& o) {
  c.option("--step", o.step_mm, "mm (10; paper-48, optimal: 20)");
  c.option("--count", o.count, "paper-80: points on each of its 8 arms").shown_default();
  c.option("--half-width", o.half_width_mm, "lattice, optimal: of the square, mm").shown_default();
  c.option("--centre", o.centre_mm, "circle: x y in mm").expected(2);
  c.option("--radius", o.radius_mm, "circle: mm").shown_default();
  c.option("--points", o.points, "how many (circle: 72; optimal: 40)");
  c.option("--mechanism", o.mechanism, "rail, optimal: mechanism file (the paper's)").type("FILE");
  c.option("--travel", o.travel_mm, "rail: mm to either side of home").shown_default();
  c.option("--targets", o.targets, "rail: targets per run").shown_default();
  c.option("--runs", o.runs, "rail: runs, each in both directions").shown_default();
  c.option("--criterion", o.criterion, "optimal: D (volume), A (mean variance), E (worst)")
      .one_of({"D", "A", "E"})
      .shown_default();
  c.option("--campaign", o.campaign, "next-points: those of its last diagnosis").type("CAMPAIGN");
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
