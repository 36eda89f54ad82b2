// What a model is for: poses predicted, and tables for controllers.

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <span>

#include "app/cli/approach.hpp"
#include "app/cli/machine_values.hpp"
#include "app/cli/model.hpp"
#include "app/files/commands_csv.hpp"
#include "app/files/files.hpp"
#include "app/files/numbers.hpp"
#include "app/job/compensation_table.hpp"
#include "app/job/controller_tables.hpp"
#include "app/job/fitted_range.hpp"
#include "app/job/model_json.hpp"
#include "app/job/plane_table.hpp"
#include "app/job/run.hpp"
#include "app/terminal/counted.hpp"
#include "app/terminal/table.hpp"
#include "core/mechanism/machine_kinematics.hpp"
#include "core/units.hpp"
#include "store/campaign.hpp"
#include "store/job.hpp"
#include "store/open.hpp"

namespace trammel::cli {

namespace {

using job::StoredModel;

constexpr const char* kPlaneFormat = "aerotech-2d";

/// Under what the model is asked.
struct Circumstances {
  int epoch = 1;
  std::optional<double> temp_degc;
  std::optional<double> time_s;
};

struct PredictOptions {
  std::string campaign, version;
  std::vector<std::string> poses;
  std::string commands;
  std::string approach = "000";
  Circumstances at;
};

struct ExportOptions {
  std::string campaign, version = "last", file;
  std::string format;  // empty: as the file's ending says
  std::string job;     // controllers: this job's correction instead of the model's
  std::optional<double> knot_mm, step_mm, half_width_mm;  // none: as wide as the machine goes
  std::vector<double> phi_deg = {0};
  Circumstances at;
  bool dry_run = false;
};

void require_epoch(const StoredModel& model, int epoch) {
  if (epoch == 1 || model.robot.epochs.contains(epoch)) return;
  throw NotFoundError({.what = "the model knows no such epoch",
                       .where = {.field = "epoch"},
                       .got = std::to_string(epoch),
                       .expected = fmt::format("1 to {}", model.robot.epochs.size() + 1)});
}

[[noreturn]] void out_of_reach(std::size_t number, int chain) {
  throw InputError({.what = fmt::format("the pose is out of reach of chain {}", chain + 1),
                    .where = {.field = "--pose", .point = fmt::format("pose {}", number)}});
}

/// What is asked, and where the nominal robot stands under it: ok is its assembly of home.
struct Question {
  CommandRow row;
  Pose nominal;
  Reach::Status status = Reach::Status::ok;
};

/// Limits are not asked for: a model says where the robot would go.
Reach::Status assembly_status(const Reach& at) {
  const bool stands = at.status == Reach::Status::ok || at.status == Reach::Status::limit;
  return stands ? Reach::Status::ok : at.status;
}

/// Commands that a controller without correction gives for the poses.
std::vector<Question> commands_for(const Machine& machine, const PredictOptions& options) {
  const Approach approach = parse_approach(options.approach);
  require_drives(approach, machine);
  const MachineSolver solver(machine);
  Displacements before_mm = solver.drives(machine.home).l_mm;
  std::vector<Question> all;
  for (const Eigen::Vector3d& typed :
       typed_poses(machine, numbers_of(machine, options.poses, "--pose"), "--pose")) {
    const Pose pose = pose_on(machine, typed);
    const InverseResult at = solver.drives(pose);
    if (!at.ok()) out_of_reach(all.size() + 1, at.chain);
    CommandRow row{.seq = static_cast<int>(all.size()) + 1,
                   .conditions = {.cmd_mm = at.l_mm,
                                  .from_mm = before_mm,
                                  .epoch = options.at.epoch,
                                  .time_s = options.at.time_s,
                                  .temp_degc = options.at.temp_degc}};
    for (int i = 0; i < machine.kind->n_chains; ++i) {
      const int sign = approach[static_cast<std::size_t>(i)];
      if (sign != 0) row.conditions.from_mm[i] = at.l_mm[i] - sign;  // any length: a direction
    }
    before_mm = at.l_mm;
    all.push_back({row, pose, assembly_status(reach(machine, pose))});
  }
  return all;
}

std::vector<Question> questions(const StoredModel& model, const PredictOptions& options) {
  if (options.poses.empty() == options.commands.empty()) {
    throw UsageError({.what = "predict takes poses or a file of commands, one of them",
                      .hint = "--pose x,y,phi or --commands FILE"});
  }
  const Machine& machine = model.robot.nominal;
  if (options.commands.empty()) return commands_for(machine, options);
  std::vector<Question> all;
  for (const CommandRow& row : read_commands_csv(options.commands, machine)) {
    const MachinePose at = forward(machine, row.conditions.cmd_mm, machine.home);
    all.push_back({row, at.pose, at.ok() ? Reach::Status::ok : Reach::Status::unreachable});
  }
  return all;
}

/// Where the model's robot stands, and whether it is in the assembly of home.
struct Answer {
  Reach::Status status = Reach::Status::ok;
  Pose pose;  // ok only
};

Answer answer(const RobotModel& robot, const Question& question) {
  if (question.status != Reach::Status::ok) return {question.status, {}};
  const Prediction at = predict(robot, question.row.conditions);
  if (!at.ok()) return {Reach::Status::unreachable, {}};
  return {assembly_status(reach(robot.machine, at.pose)), at.pose};
}

/// Where the model was not fitted, in words; nothing for a version that no job fitted.
std::vector<std::string> beyond_fit(store::Connection& db, const StoredModel& model,
                                    std::span<const Pose> targets, const std::string& point,
                                    const std::string& of = "") {
  if (!model.row.data.job_id) return {};
  const FittedRange range = job::fitted_range(db, store::get_job(db, *model.row.data.job_id));
  return job::extrapolation_words(range, targets, point, of);
}

constexpr std::array<const char*, 3> kPoseFields = {"x_mm", "y_mm", "phi_deg"};
constexpr std::array<const char*, 3> kPoseHeads = {"x mm", "y mm", "phi deg"};

Json drives_json(const Machine& machine, const Displacements& l_mm) {
  return std::vector<double>(l_mm.begin(), l_mm.begin() + machine.kind->n_chains);
}

/// Moved by the machine, or measured beside that: phi of an XY stage.
bool shows(const Machine& machine, std::size_t coordinate) {
  return coordinate < static_cast<std::size_t>(machine.kind->n_chains) ||
         machine.measured[coordinate];
}

Json prediction_json(const Machine& machine, const CommandRow& row, const Answer& at) {
  Json json = {{"seq", row.seq},
               {"cmd_mm", drives_json(machine, row.conditions.cmd_mm)},
               {"from_mm", drives_json(machine, row.conditions.from_mm)},
               {"epoch", row.conditions.epoch},
               {"status", name_of(at.status)}};
  const Eigen::Vector3d pose = shown_pose(at.pose);
  for (std::size_t c = 0; at.status == Reach::Status::ok && c < kPoseFields.size(); ++c) {
    if (shows(machine, c)) json[kPoseFields[c]] = pose[static_cast<Eigen::Index>(c)];
  }
  return json;
}

std::string predictions_text(const Machine& machine, const Json& predictions) {
  std::vector<std::string> heads = {"seq"};
  for (int i = 1; i <= machine.kind->n_chains; ++i) heads.push_back(fmt::format("cmd l{} mm", i));
  const std::size_t first = heads.size();
  for (std::size_t c = 0; c < kPoseHeads.size(); ++c) {
    if (shows(machine, c)) heads.emplace_back(kPoseHeads[c]);
  }
  Table table(heads);
  for (const Json& p : predictions) {
    std::vector<std::string> cells = {std::to_string(p["seq"].get<int>())};
    for (const Json& l : p["cmd_mm"]) cells.push_back(fmt::format("{:.5f}", l.get<double>()));
    for (std::size_t c = 0; c < kPoseFields.size(); ++c) {
      if (!shows(machine, c)) continue;
      const char* name = kPoseFields[c];
      cells.push_back(p.contains(name) ? fmt::format("{:.5f}", p[name].get<double>()) : "");
    }
    if (!p.contains(kPoseFields[0])) cells[first] = p["status"].get<std::string>();
    table.add(std::move(cells));
  }
  return table.text();
}

std::vector<std::string> idle_in(const StoredModel& model, const std::vector<Question>& asked) {
  const auto all = [&asked](auto has) { return std::ranges::all_of(asked, has, &Question::row); };
  return job::idle_effects(
      model.robot, all([](const CommandRow& r) { return r.conditions.temp_degc.has_value(); }),
      all([](const CommandRow& r) { return r.conditions.time_s.has_value(); }));
}

ExitCode run_predict(const PredictOptions& options, Context& context) {
  store::Connection db = store::open(context.db(), store::Access::read_only);
  const store::CampaignRow campaign = store::require_campaign(db, options.campaign);
  const StoredModel model = job::find_model(db, campaign, options.version);
  const std::vector<Question> asked = questions(model, options);
  Json predictions = Json::array();
  std::vector<Pose> nominal;
  bool all_ok = true;
  for (const Question& question : asked) {
    require_epoch(model, question.row.conditions.epoch);
    const Answer at = answer(model.robot, question);
    all_ok = all_ok && at.status == Reach::Status::ok;
    predictions.push_back(prediction_json(model.robot.nominal, question.row, at));
    if (question.status == Reach::Status::ok) nominal.push_back(question.nominal);
  }
  const std::vector<std::string> idle = idle_in(model, asked);
  const std::vector<std::string> beyond = beyond_fit(db, model, nominal, "pose");
  if (context.json) {
    context.print("model-predict", {{"campaign", campaign.name},
                                    {"version", model.row.version},
                                    {"name", model.row.data.name},
                                    {"left_out", idle},
                                    {"warnings", beyond},
                                    {"predictions", predictions}});
  } else {
    context.print(predictions_text(model.robot.nominal, predictions));
    for (const std::string& effect : idle) context.say("left out: " + effect);
    for (const std::string& words : beyond) context.say("warning: " + words);
  }
  return all_ok ? ExitCode::ok : ExitCode::not_acceptable;
}

/// What the controller must know before it uses the table.
std::vector<std::string> table_words(store::Connection& db, const StoredModel& model,
                                     const job::CompensationTable& table,
                                     const ExportOptions& options) {
  std::vector<Pose> targets;
  for (const job::TableRow& row : table.rows) {  // rows of one target stand together
    if (targets.empty() || targets.back() != row.target) targets.push_back(row.target);
  }
  std::vector<std::string> words = beyond_fit(db, model, targets, "target", " of the table");
  for (const std::string& effect : job::idle_effects(model.robot, options.at.temp_degc.has_value(),
                                                     options.at.time_s.has_value())) {
    words.push_back("left out: " + effect);
  }
  for (const ActiveEffect& active : model.robot.effects) {
    if (!active.effect->name.starts_with("tracker_")) continue;
    words.push_back(active.effect->name +
                    " is of the instrument: the table makes the tracker read the targets");
  }
  return words;
}

bool ends_with(const std::string& text, std::string_view end) {
  return text.size() > end.size() && text.ends_with(end);
}

job::TableRequest request_of(const ExportOptions& options, const Machine& machine) {
  job::TableRequest request;
  request.half_width_mm = options.half_width_mm.value_or(usual_half_width_mm(machine));
  request.step_mm = options.step_mm.value_or(usual_step_mm(request.half_width_mm));
  request.phi_rad.clear();
  for (const double deg : options.phi_deg) request.phi_rad.push_back(rad_from_deg(deg));
  request.epoch = options.at.epoch;
  request.temp_degc = options.at.temp_degc;
  request.time_s = options.at.time_s;
  return request;
}

double knot_mm_of(const ExportOptions& options, const job::TableRequest& request) {
  return options.knot_mm.value_or(usual_step_mm(request.half_width_mm) / 2);
}

Json export_table(store::Connection& db, const StoredModel& model, const ExportOptions& options,
                  Existing existing) {
  require_epoch(model, options.at.epoch);
  const job::CompensationTable table =
      job::compensation_table(model.robot, request_of(options, model.robot.nominal));
  if (!options.dry_run) write_output(options.file, job::table_csv(table), existing);
  return {{"kind", "table"},
          {"n_targets", table.n_targets},
          {"n_unreachable", table.n_unreachable},
          {"n_rows", table.rows.size()},
          {"directed_rails", table.directed},
          {"words", table_words(db, model, table, options)}};
}

Json error_row(std::size_t knots, const TableError& before, const TableError& left,
               const TableError& grid) {
  return {{"knots", knots},
          {"before_max_mm", before.max_mm},
          {"left_rms_mm", left.rms_mm},
          {"left_max_mm", left.max_mm},
          {"grid_max_mm", grid.max_mm}};
}

/// A file for a controller that corrects a stage's two axes by where both stand.
Json export_plane(const Correction& correction, const Machine& machine,
                  const ExportOptions& options, Existing existing) {
  const job::TableRequest request = request_of(options, machine);
  const job::PlaneTable table =
      job::plane_table(correction, machine, request, knot_mm_of(options, request));
  const job::ControllerFile file = job::aerotech_file(table, options.file);
  if (!options.dry_run) write_output(file.name, file.text, existing);
  Json drives = Json::array();
  for (std::size_t axis = 0; axis < 2; ++axis) {
    drives.push_back(
        error_row(table.values_mm.size(), table.before[axis], table.left[axis], table.grid[axis]));
  }
  return {{"kind", options.format}, {"files", {file.name}}, {"n_targets", table.values_mm.size()},
          {"n_unreachable", 0},     {"drives", drives},     {"words", job::table_words(table)}};
}

/// Files for a controller that corrects each drive by its own position, from any correction.
Json export_controller(const Correction& correction, const Machine& machine,
                       const ExportOptions& options, Existing existing) {
  if (options.format == kPlaneFormat) return export_plane(correction, machine, options, existing);
  const bool linuxcnc = options.format == "linuxcnc";
  const job::TableRequest request = request_of(options, machine);
  const job::ControllerTables tables =
      job::controller_tables(correction, machine, request, knot_mm_of(options, request));
  const std::vector<job::ControllerFile> files =
      linuxcnc ? job::linuxcnc_files(tables, options.file)
               : std::vector{job::aerotech_file(tables, options.file)};
  Json names = Json::array(), drives = Json::array();
  for (const job::ControllerFile& file : files) {
    if (!options.dry_run) write_output(file.name, file.text, existing);
    names.push_back(file.name);
  }
  for (const job::DriveTables& d : tables.drives) {
    drives.push_back(error_row(d.forward.values_mm.size(), d.before, d.left, d.grid));
  }
  Json done = {{"kind", options.format},
               {"files", names},
               {"n_targets", tables.n_targets},
               {"n_unreachable", tables.n_unreachable},
               {"drives", drives},
               {"words", job::table_words(tables, linuxcnc)}};
  if (linuxcnc) done["ini"] = job::linuxcnc_ini(files);
  return done;
}

std::string export_text(const Json& done) {
  std::vector<std::string> names = {done["file"]};  // a controller has a file a drive
  if (done.contains("files")) names = done["files"].get<std::vector<std::string>>();
  for (std::string& name : names) name = printable(name);
  std::string text = fmt::format("{} {}", done["dry_run"].get<bool>() ? "would write" : "wrote",
                                 fmt::join(names, ", "));
  if (done["kind"] == "model") return text + ": the model as JSON";
  if (done.contains("files")) {
    text += fmt::format(": {} of {}, from {}", done["drives"].size() == 1 ? "the table" : "tables",
                        terminal::counted(done["drives"].size(), "drive"),
                        terminal::counted(done["n_targets"].get<int>(), "target"));
  } else {
    text += fmt::format(": {} for {}", terminal::counted(done["n_rows"].get<int>(), "row"),
                        terminal::counted(done["n_targets"].get<int>(), "target"));
  }
  if (done["n_unreachable"] > 0) {
    text += fmt::format(", {} of them out of reach and left out", done["n_unreachable"].get<int>());
  }
  for (const Json& sentence : done["words"]) text += "\n" + sentence.get<std::string>();
  if (done.contains("ini")) text += "\nINI file:\n" + done["ini"].get<std::string>();
  return text;
}

/// As named, else as the file's ending says.
std::string format_of(const ExportOptions& options) {
  if (!options.format.empty()) return options.format;
  for (const char* format : {"csv", "json"}) {
    if (ends_with(options.file, std::string(".") + format)) return format;
  }
  throw UsageError({.what = "neither --format nor the file's ending says what is written",
                    .where = {.field = "--out"},
                    .got = options.file,
                    .expected = "NAME.csv for a compensation table, NAME.json for the model",
                    .hint = "--format linuxcnc, aerotech or aerotech-2d for controllers"});
}

/// A campaign without a model may have calibrations, which --job writes.
void require_model(store::Connection& db, const store::CampaignRow& campaign,
                   const ExportOptions& options) {
  const auto jobs = store::list_jobs(db, campaign.id);
  if (jobs.empty() || !store::list_models(db, campaign.id).empty()) return;
  const store::JobRow& last = *std::ranges::max_element(jobs, {}, &store::JobRow::id);
  throw NotFoundError(
      {.what = "the campaign has no model that could be written",
       .where = {.field = "campaign"},
       .got = campaign.name,
       .hint = fmt::format("`trammel model export {} --format {} --out {} --job {}` writes the "
                           "correction of its calibration, {}",
                           shell_word(campaign.name), options.format, shell_word(options.file),
                           last.id, last.stage)});
}

ExitCode run_export(const ExportOptions& given, Context& context) {
  ExportOptions options = given;
  options.format = format_of(given);
  const bool controller = options.format != "csv" && options.format != "json";
  if (!options.job.empty() && !controller) {
    throw UsageError({.what = "a job's correction is written for controllers alone",
                      .where = {.field = "--job"},
                      .expected = "--format linuxcnc, aerotech or aerotech-2d"});
  }
  store::Connection db = store::open(context.db(), store::Access::read_only);
  const store::CampaignRow campaign = store::require_campaign(db, options.campaign);
  Json done = {{"campaign", campaign.name}, {"file", options.file}, {"dry_run", options.dry_run}};
  if (!options.job.empty()) {
    const store::Id id = job::find_compensation(db, options.campaign, options.job);
    const Machine machine = store::load_campaign(db, campaign.id).campaign.machine;
    done["job"] = id;
    done.update(
        export_controller(job::correction_of(db, id), machine, options, context.existing()));
    context.json ? context.print("model-export", done) : context.print(export_text(done));
    return ExitCode::ok;
  }
  if (controller) require_model(db, campaign, options);
  const StoredModel model = job::find_model(db, campaign, options.version);
  done["version"] = model.row.version;
  if (controller) {
    require_epoch(model, options.at.epoch);
    done.update(export_controller(ModelCorrection{model.robot}, model.robot.nominal, options,
                                  context.existing()));
  } else if (options.format == "json") {
    done["kind"] = "model";
    const std::string text = job::model_file_json(model, campaign.name).dump(1) + "\n";
    if (!options.dry_run) write_output(options.file, text, context.existing());
  } else {
    done.update(export_table(db, model, options, context.existing()));
  }
  context.json ? context.print("model-export", done) : context.print(export_text(done));
  return ExitCode::ok;
}

void circumstances(Command c, Circumstances& at) {
  c.option("--epoch", at.epoch, "Homing and set-up").positive().shown_default();
  c.option("--temp-degc", at.temp_degc, "Temperature of the machine (none: not compensated)")
      .range(-273.15, 1000.0);
  c.option("--time-s", at.time_s, "Since the campaign's start (none: no drift)");
}

void setup_predict(Command model, Context& context) {
  Command c = model.command("predict", "Where the robot goes, as a version has it");
  auto o = std::make_shared<PredictOptions>();
  c.option("CAMPAIGN", o->campaign, "Name or uuid").required();
  c.option("VERSION", o->version, "Number of the version, or last").required();
  c.option("--pose", o->poses,
           "x mm,y mm,phi deg, as far as the machine has them (repeatable): commanded to a "
           "controller without correction, one "
           "after the other from home");
  c.option("--approach", o->approach, "Of every pose: +, - or 0 (as it comes) per drive")
      .shown_default();
  c.option("--commands", o->commands, "CSV with cmd_l1_mm, … of each drive, as readings.csv")
      .type("FILE");
  circumstances(c, o->at);
  on_run(c, context, o, run_predict);
}

void setup_export(Command model, Context& context) {
  Command c =
      model.command("export", "A correction for a controller, a table of it, or the model itself");
  auto o = std::make_shared<ExportOptions>();
  c.option("CAMPAIGN", o->campaign, "Name or uuid").required();
  c.option("VERSION", o->version, "Number of the version, or last (last)");
  c.option("--out,FILE", o->file, "NAME.csv, NAME.json; linuxcnc: NAME of NAME.0.comp, …")
      .required()
      .type("FILE");
  c.option("--format", o->format,
           "csv: commands for a grid of targets; json: model/1; aerotech-2d: a table over the "
           "plane of an XY stage; linuxcnc, aerotech: a table for "
           "each drive (as the file's ending says)")
      .one_of({"csv", "json", "linuxcnc", "aerotech", kPlaneFormat});
  c.option("--job", o->job, "controllers: this job's correction, whatever its method");
  c.option("--knot-mm", o->knot_mm, "controllers: between knots of a table (half a step)")
      .positive();
  c.option("--step-mm", o->step_mm, "Of the targets (10, or a tenth of a small half-width)");
  c.option("--half-width-mm", o->half_width_mm,
           "Of the square of targets about O_A (100, or half the longest stroke)");
  c.option("--phi-deg", o->phi_deg, "Orientations, several with commas")
      .delimiter(',')
      .shown_default();
  circumstances(c, o->at);
  c.flag("--dry-run", o->dry_run, "Compute and print, write nothing");
  on_run(c, context, o, run_export);
}

}  // namespace

void setup_model_use(Command model, Context& context) {
  setup_predict(model, context);
  setup_export(model, context);
}

}  // namespace trammel::cli
