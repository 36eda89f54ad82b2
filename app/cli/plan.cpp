#include "app/cli/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
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
#include "app/files/machine_json.hpp"
#include "app/files/numbers.hpp"
#include "app/files/plan_json.hpp"
#include "app/job/grid.hpp"
#include "app/job/next_points_plan.hpp"
#include "app/job/run.hpp"
#include "app/session/plan_record.hpp"
#include "app/terminal/counted.hpp"
#include "core/plane/extent.hpp"
#include "core/plane/hull.hpp"
#include "core/units.hpp"
#include "store/campaign.hpp"
#include "store/machine.hpp"
#include "store/open.hpp"

namespace trammel::cli {

namespace {

struct CreateOptions {
  std::function<bool(const char*)> given;  // an option stands on the line
  job::GridRequest grid;
  std::string out;
  bool dry_run = false;
  std::vector<double> within;  // low, high, mm
  std::vector<std::string> approaches = {"000"};
  std::string order = "listed";
  std::string set = "identify";
  std::string mechanism;
  std::string criterion = "D";
  std::string campaign;  // next-points: of its last diagnosis; else the bounds
  std::string job;       // next-points: of this diagnosis
  DesignOptions design = {.effects = {"lead_scale", "backlash"}};
};

struct FileOptions {
  std::string file;
  std::string mechanism;
  std::string campaign;
  CheckOptions check;
  std::optional<double> speed_mm_s;  // none: the stage's
  bool identifiability = false;
  DesignOptions design;
  std::string record;  // file to write
  bool dry_run = false;
};

Machine machine_for(const FileOptions& o, const Context& context) {
  if (!o.mechanism.empty()) return read_machine_file(o.mechanism);
  if (o.campaign.empty()) return machine_of(paper_mechanism());
  store::Connection db = store::open(context.db(), store::Access::read_only);
  return store::load_machine(db, store::require_campaign_id(db, o.campaign));
}

/// Where points may lie, and of which machine they are to be safe.
struct Bounds {
  std::vector<Place> hull;         // none: anywhere
  std::optional<Machine> machine;  // none: not asked
};

/// As the line says, else where the campaign was measured and on its machine.
Bounds bounds_of(const CreateOptions& o, const Context& context) {
  Bounds bounds;
  if (!o.campaign.empty() && o.grid.grid != job::kNextPoints) {
    store::Connection db = store::open(context.db(), store::Access::read_only);
    const Campaign campaign =
        store::load_campaign(db, store::require_campaign(db, o.campaign).id).campaign;
    std::vector<Place> places;
    for (const Reading& r : campaign.readings) {
      if (r.measured) places.push_back({r.target.x_mm, r.target.y_mm});
    }
    bounds.hull = convex_hull(places);
    bounds.machine = campaign.machine;
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
  if (!o.mechanism.empty()) bounds.machine = read_machine_file(o.mechanism);
  return bounds;
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
  if (!o.grid.name.empty()) plan.name = o.grid.name;
  return plan;
}

template <class T>
T named(const std::vector<std::pair<std::string, T>>& values, const std::string& name) {
  return std::ranges::find(values, name, &std::pair<std::string, T>::first)->second;
}

job::GridRequest grid_of(const CreateOptions& o, const Bounds& bounds) {
  job::GridRequest grid = o.grid;
  grid.hull = bounds.hull;
  const Machine machine = bounds.machine.value_or(machine_of(paper_mechanism()));
  grid.approaches.clear();
  for (const std::string& text : o.approaches) {
    grid.approaches.push_back(parse_approach(text));
    require_drives(grid.approaches.back(), machine);
  }
  grid.order = named(job::orders(), o.order);
  grid.criterion = named(job::criteria(), o.criterion);
  grid.set = o.set == "validate" ? ReadingSet::validate : ReadingSet::identify;
  grid.sigma = o.design.sigma();
  grid.effects = o.design.effects;
  return grid;
}

Plan plan_for(const CreateOptions& o, const Bounds& bounds, const Context& context) {
  if (o.grid.grid == job::kNextPoints) return suggested_points(o, context);
  const bool only_safe = bounds.machine.has_value();
  const job::GridPlan grid = job::grid_plan(
      grid_of(o, bounds), bounds.machine.value_or(machine_of(paper_mechanism())), only_safe);
  if (grid.n_out > 0) {
    context.say(fmt::format("{} of {} points are left out: outside the bounds{}", grid.n_out,
                            grid.n_all, only_safe ? ", or not safe on the machine" : ""));
  }
  return grid.plan;
}

/// An option that would do nothing is refused, not passed over.
void require_used(const CreateOptions& o) {
  for (const job::GridField& field : job::grid_fields()) {
    if (!o.given(field.option) || field.used_by(o.grid.grid)) continue;
    throw UsageError({.what = "this option does nothing for the grid " + o.grid.grid,
                      .where = {.field = field.option},
                      .expected = field.users(),
                      .hint = fmt::format("see trammel plan create {} --help", o.grid.grid)});
  }
}

/// `plan create lattice --help` shows what shapes a lattice.
void show_only_used(Command c) {
  const auto words = positionals_of(c).front().words();
  if (words.empty()) return;
  for (const job::GridField& field : job::grid_fields()) {
    const auto option = find_option(c, field.option);
    if (option && !field.used_by(words.front())) option->hide();
  }
}

ExitCode run_create(const CreateOptions& options, Context& context) {
  require_used(options);
  const Bounds bounds = bounds_of(options, context);
  const Plan plan = plan_for(options, bounds, context);
  const std::string text = plan_json(plan).dump(1) + "\n";
  const Machine machine = bounds.machine.value_or(machine_of(paper_mechanism()));
  if (options.grid.grid == "optimal") {
    context.say(machine.kind->chain == &kPrrChain
                    ? beside_paper_80(plan, machine, options.design)
                    : design_text(design_of(plan, machine, options.design)));
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
  context.say(fmt::format("{} {} {}", terminal::counted(plan.points.size(), "point"),
                          options.dry_run ? "would be written to" : "written to",
                          printable(options.out)));
  if (!options.dry_run) {
    const bool of_campaign = options.mechanism.empty() && !options.campaign.empty();
    context.next("trammel plan check " + shell_word(options.out) +
                 (of_campaign ? " --campaign " + shell_word(options.campaign) : ""));
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
      "{}: {}\n seq       x mm       y mm   phi deg  approach  "
      "repeat  set       group\n",
      printable(plan.name), terminal::counted(plan.points.size(), "point"));
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

/// Where the machine of a file stands, if it says so: a controller's or a virtual one.
struct Stands {
  std::optional<device::GalilSettings> galil;
  std::string stage;  // --stage
};

Stands stands_of(const std::string& file) {
  if (file.empty()) return {.galil = {}, .stage = "STAGE"};
  const JsonFile json = read_json(file);
  Fields fields(json);
  if (fields.has("controller")) {
    return {.galil = device::read_stage(file).galil, .stage = "galil:" + shell_word(file)};
  }
  const bool is_virtual = fields.has("drive") || fields.has("seed");
  return {.galil = {}, .stage = is_virtual ? "sim:" + shell_word(file) : "STAGE"};
}

/// A look at a robot that may not be there is to be had again; a controller asks for a record.
void suggest_after_check(const FileOptions& o, const Stands& stands, bool safe, bool records,
                         const Context& context) {
  const std::string plan = shell_word(o.file);
  if (o.mechanism.empty() && o.campaign.empty()) {
    context.next("trammel plan check " + plan + " --mechanism FILE");
  } else if (!safe) {
    context.next("trammel plan show " + plan);
  } else if (stands.galil && !records) {
    const std::string record = std::filesystem::path(o.file).stem().string() + ".check.json";
    context.next("trammel plan check " + plan + " --record " + shell_word(record));
  } else {
    context.next(fmt::format(
        "trammel session run {} --plan {} --stage {}{}",
        o.campaign.empty() ? "CAMPAIGN" : shell_word(o.campaign), plan, stands.stage,
        stands.galil ? " --tracker t2sa:tracker.json --plan-check " + shell_word(o.record) : ""));
  }
}

ExitCode run_check(const FileOptions& options, Context& context) {
  const Plan plan = plan_of(options.file);
  const Stands stands = stands_of(options.mechanism);
  const auto& stage = stands.galil;
  const Machine machine = machine_for(options, context);
  CheckOptions margins = options.check;
  if (stage) margins.speed_mm_s = stage->speed_mm_s;
  margins.speed_mm_s = options.speed_mm_s.value_or(margins.speed_mm_s);
  const auto violations = check(plan, machine, margins);
  std::optional<PlanDesign> design;
  if (options.identifiability) design = design_of(plan, machine, options.design);
  const bool records = !options.record.empty() && violations.empty() && !options.dry_run;
  if (records) {
    session::write_plan_record(options.record, plan, machine, margins, context.existing());
  }
  if (context.json) {
    Json fields = {{"plan", plan.name},
                   {"n_points", plan.points.size()},
                   {"plan_sha256", session::plan_sha256(plan, machine)},
                   {"recorded", records},
                   {"safe", violations.empty()},
                   {"mechanism", options.mechanism.empty() ? Json() : Json(options.mechanism)},
                   {"campaign", options.campaign.empty() ? Json() : Json(options.campaign)},
                   {"violations", violations_json(violations)}};
    if (stage) fields["watch_host_s"] = stage->watch_host_s;
    if (design) fields["identifiability"] = design_json(*design);
    context.print("plan-check", fields);
  } else {
    std::string text;
    for (const Violation& v : violations) text += describe(v) + "\n";
    text += violations.empty()
                ? fmt::format("{}: {}, every target and path is safe", printable(plan.name),
                              terminal::counted(plan.points.size(), "point"))
                : fmt::format("{}: {}", printable(plan.name),
                              terminal::counted(violations.size(), "violation"));
    if (options.mechanism.empty() && options.campaign.empty()) {
      text += "\non the paper's 3-PRR, which was assumed: no --mechanism is given";
    }
    if (stage) text += "\n" + device::watch_text(stage->watch_host_s);
    context.print(design ? design_text(*design) + text : text);
  }
  if (!options.dry_run) {
    suggest_after_check(options, stands, violations.empty(), records, context);
  }
  return violations.empty() ? ExitCode::ok : ExitCode::not_acceptable;
}

void grid_options(Command c, CreateOptions& o) {
  c.option("--step", o.grid.step_mm, "mm (10; paper-48, optimal: 20)");
  c.option("--count", o.grid.count, "paper-80: points on each of its 8 arms").shown_default();
  const Option half_width =
      c.option("--half-width", o.grid.half_width_mm, "lattice, optimal: of the square, mm (100)");
  c.option("--within", o.within, "leave out points whose x or y is not: low high, mm")
      .expected(2)
      .excludes(half_width);
  c.option("--centre", o.grid.centre_mm, "circle: x y in mm").expected(2);
  c.option("--radius", o.grid.radius_mm, "circle: mm").shown_default();
  c.option("--points", o.grid.points, "how many (circle: 72; optimal: 40)");
  c.option("--mechanism", o.mechanism,
           "leave out points that are not safe on it; rail, optimal: of it (the paper's)")
      .type("FILE");
  c.option("--travel", o.grid.travel_mm, "rail: mm to either side of home").shown_default();
  c.option("--targets", o.grid.targets, "rail: targets per run").shown_default();
  c.option("--runs", o.grid.runs, "rail: runs, each in both directions").shown_default();
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
  std::vector<std::string> grids = job::grids();
  grids.emplace_back(job::kNextPoints);
  c.option("grid", o->grid.grid, "which points").required().one_of(grids);
  c.option("--out", o->out, "file to write (stdout)").type("FILE");
  c.flag("--dry-run", o->dry_run, "make the plan, write no file");
  c.option("--name", o->grid.name, "of the plan (the grid's)").type("NAME");
  grid_options(c, *o);
  c.option("--orientations", o->grid.orientations_deg,
           "deg, added to each pose (0; optimal: -5,0,5)")
      .delimiter(',');
  c.option("--approach", o->approaches, "+, - or 0 per rail, several with commas: +++,---")
      .delimiter(',');
  c.option("--approach-distance", o->grid.approach_mm, "length of the last move, mm")
      .shown_default();
  c.option("--repeats", o->grid.repeats, "times all points are visited, round by round")
      .shown_default();
  c.option("--order", o->order, "of each round")
      .one_of({"listed", "random", "nearest"})
      .shown_default();
  c.option("--seed", o->grid.seed, "of the random order").non_negative().shown_default();
  c.option("--set", o->set, "identify or validate")
      .one_of({"identify", "validate"})
      .shown_default();
  c.option("--references", o->grid.references, "this many first points serve as references")
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
  const Option file =
      checked.option("--mechanism", options->mechanism, "mechanism file (the paper's)")
          .type("FILE");
  checked.option("--campaign", options->campaign, "on the machine of this campaign")
      .type("CAMPAIGN")
      .excludes(file);
  margin_options(checked, options->check);
  checked.option("--speed", options->speed_mm_s,
                 "of the fastest drive, mm/s (the stage's; else 20)");
  checked
      .option("--record", options->record,
              "write that the plan is safe, for `session run --plan-check`")
      .type("FILE");
  checked.flag("--dry-run", options->dry_run, "check, write no record");
  checked.flag("--identifiability", options->identifiability,
               "print what the readings will show: rank, what stays unknown, uncertainty");
  design_options(checked, options->design);
  on_run(checked, context, options, run_check);
}

}  // namespace trammel::cli
