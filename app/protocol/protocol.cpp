#include "app/protocol/protocol.hpp"

#include <algorithm>
#include <array>
#include <map>

#include "app/device/open.hpp"
#include "app/files/fields.hpp"
#include "app/files/format.hpp"
#include "app/files/plan_json.hpp"
#include "app/files/published_json.hpp"
#include "app/job/stages.hpp"
#include "app/session/written.hpp"
#include "core/plan/named.hpp"

namespace trammel::protocol {

namespace {

/// What later steps need to know of a step.
struct Earlier {
  std::string kind;
  bool may_be_skipped = false;  // the points it measures are suggested by a diagnosis
};

/// What a step is read in.
struct Around {
  std::filesystem::path folder;            // of the protocol: other files are named from there
  Setting setting;                         // of the protocol
  std::map<std::string, Earlier> earlier;  // steps by name
};

std::filesystem::path beside(const Around& around, const std::string& file) {
  return std::filesystem::absolute(around.folder / file).lexically_normal();
}

/// A file that is named; "" where none is.
std::filesystem::path optional_file(Fields& fields, const char* field, const Around& around) {
  const auto name = fields.optional_text(field);
  if (name && name->empty()) fields.refuse(field, "no file is named");
  return name ? beside(around, *name) : std::filesystem::path();
}

/// "galil:stage.json" with its file's whole path. `alone`: a kind that has no file.
std::string read_device(Fields& fields, const char* field, const std::vector<std::string>& kinds,
                        const std::string& alone, const Around& around) {
  const std::string device = fields.text(field);
  if (!alone.empty() && device == alone) return device;
  std::string known = alone;
  for (const std::string& kind : kinds) {
    if (device.starts_with(kind) && device.size() > kind.size()) {
      return kind + beside(around, device.substr(kind.size())).string();
    }
    known += (known.empty() ? "" : ", ") + kind + "FILE";
  }
  fields.refuse(field, "no such device", known);
}

/// What the object changes of the setting around it.
Setting read_setting(Fields& fields, const Around& around) {
  Setting setting = around.setting;
  if (fields.has("robot")) {  // the short form of a simulated stage
    if (fields.has("stage")) {
      fields.refuse("robot", "the stage is named twice", "robot (a virtual one), or stage");
    }
    setting.stage = "sim:" + optional_file(fields, "robot", around).string();
    setting.tracker = "sim";
  }
  if (fields.has("stage")) {
    setting.stage = read_device(fields, "stage", device::stage_kinds(), "", around);
  }
  if (fields.has("tracker")) {
    setting.tracker = read_device(fields, "tracker", device::tracker_kinds(), "sim", around);
  }
  if (setting.stage.starts_with("sim:") != (setting.tracker == "sim") && !setting.stage.empty()) {
    fields.refuse(fields.has("tracker") ? "tracker" : "stage",
                  "stage and tracker do not go together",
                  "sim:FILE with sim, galil:FILE with t2sa:FILE or file:FILE");
  }
  if (auto policy = fields.optional_object("policy")) {
    setting.policy = session::read_policy(*policy, setting.policy);
  }
  if (auto check = fields.optional_object("check")) {
    setting.check = session::read_check(*check, setting.check);
  }
  return setting;
}

/// The step of one of these kinds; else an error at `field`.
const Earlier& require_earlier(const Fields& fields, const std::string& field,
                               const std::string& name, const Around& around,
                               const std::vector<std::string>& kinds) {
  const auto found = around.earlier.find(name);
  if (found != around.earlier.end() &&
      std::find(kinds.begin(), kinds.end(), found->second.kind) != kinds.end()) {
    return found->second;
  }
  std::string wanted;
  for (const std::string& kind : kinds) wanted += (wanted.empty() ? "" : " or ") + kind;
  fields.refuse(field, "'" + name + "' names no earlier step of kind " + wanted,
                "the name of a step that stands before this one");
}

/// Core refuses what makes no plan; file and line are known here. Grids that depend on the machine
/// are made when it is known.
void require_plan(const Fields& fields, const job::GridRequest& grid) {
  if (grid.grid == "rail" || grid.grid == "optimal") return;
  try {
    static_cast<void>(job::grid_plan(grid, machine_of(paper_mechanism())));
  } catch (const InputError& error) {
    fields.refuse("plan", error.text().what, error.text().expected);
  }
}

/// "paper-80"; "plan.json"; {"grid": "lattice", …}; {"next_points_of": STEP}.
PlanSource read_plan_source(Fields& fields, const Around& around) {
  if (fields.has("plan") && fields.value().at("plan").is_object()) {
    Fields plan = fields.object("plan");
    if (plan.has("grid")) {
      const job::GridRequest grid = job::read_grid(plan);
      require_plan(fields, grid);
      return grid;
    }
    const NextPointsOf next{plan.text("next_points_of")};
    require_earlier(plan, "next_points_of", next.step, around, {"diagnose"});
    plan.done();
    return next;
  }
  const std::string name = fields.text("plan");
  const std::vector<std::string>& named = grid_names();
  if (std::find(named.begin(), named.end(), name) != named.end()) {
    job::GridRequest grid{.grid = name};
    grid.approaches = {read_approach(fields)};
    return grid;
  }
  if (name.ends_with(".json")) return beside(around, name);
  std::string known;
  for (const std::string& grid : named) known += grid + ", ";
  fields.refuse("plan", "no such plan",
                known + "a plan's file (NAME.json), {\"grid\": …} or {\"next_points_of\": STEP}");
}

/// Suggested points are measured as suggested: uncompensated, for fitting, each from its direction.
Step read_measure(Fields& fields, const Around& around) {
  MeasureStep step{.plan = read_plan_source(fields, around)};
  step.setting = read_setting(fields, around);
  step.plan_check = optional_file(fields, "plan_check", around);
  step.new_set_up = fields.boolean("new_set_up", false);
  if (step.suggested()) return {.name = {}, .what = step};
  if (fields.has("set")) {
    step.set = fields.choice("set", {"identify", "validate"}) == "validate" ? ReadingSet::validate
                                                                            : ReadingSet::identify;
  }
  step.compensate = fields.optional_text("compensate");
  if (step.compensate) {
    require_earlier(fields, "compensate", *step.compensate, around, {"calibrate", "diagnose"});
  }
  return {.name = {}, .what = step};
}

Step read_pause(Fields& fields, const Around&) {
  PauseStep step{.ask = fields.text("ask")};
  if (step.ask.empty()) fields.refuse("ask", "nothing is asked for", "what a person is to do");
  return {.name = {}, .what = step};
}

Step read_report(Fields& fields, const Around& around) {
  ReportStep step;
  step.text = optional_file(fields, "text", around);
  step.json = optional_file(fields, "json", around);
  step.html = optional_file(fields, "html", around);
  step.dcc = optional_file(fields, "dcc", around);
  step.tolerance_mm = fields.optional_number("tolerance_mm");
  if (step.tolerance_mm && !(*step.tolerance_mm > 0)) {
    fields.refuse("tolerance_mm", "no tolerance", "more than 0");
  }
  if (step.text.empty() && step.json.empty() && step.html.empty() && step.dcc.empty() &&
      !step.tolerance_mm) {
    fields.refuse("", "a report that goes nowhere", "text, json, html, dcc or tolerance_mm");
  }
  return {.name = {}, .what = step};
}

/// The stage knows its parameters; the file and line are known here.
nlohmann::ordered_json read_parameters(Fields& fields, const std::string& stage) {
  if (!fields.optional_object("parameters")) return nlohmann::ordered_json::object();
  nlohmann::ordered_json parameters = fields.value().at("parameters");
  try {
    (void)job::completed(job::find_stage(stage), parameters);
  } catch (const InputError& error) {
    ErrorText text = error.text();
    const std::string field = text.where.field;
    text.where = fields.file().where(fields.path("parameters"));
    text.where.field += (field.empty() ? "" : ".") + field;
    throw InputError(text);
  }
  return parameters;
}

std::vector<std::string> read_sessions(Fields& fields, const Around& around) {
  std::vector<std::string> sessions = fields.texts("sessions");
  if (sessions.empty()) fields.refuse("sessions", "no session to work on");
  bool certain = false;
  for (const std::string& name : sessions) {
    certain =
        !require_earlier(fields, "sessions", name, around, {"measure"}).may_be_skipped || certain;
  }
  if (!certain) {
    fields.refuse("sessions", "all of these sessions may be skipped",
                  "at least one whose plan is no diagnosis's suggestion");
  }
  return sessions;
}

Step read_calibrate(Fields& fields, const Around& around) {
  CalibrateStep step;
  std::vector<std::string> methods;
  for (const job::Stage& stage : job::stages()) {
    if (stage.name != "diagnose") methods.push_back(stage.name);  // a kind of step of its own
  }
  step.method = fields.choice("method", methods);
  step.sessions = read_sessions(fields, around);
  step.parameters = read_parameters(fields, step.method);
  return {.name = {}, .what = step};
}

Step read_diagnose(Fields& fields, const Around& around) {
  DiagnoseStep step;
  step.sessions = read_sessions(fields, around);
  step.parameters = read_parameters(fields, "diagnose");
  return {.name = {}, .what = step};
}

bool may_be_skipped(const Step& step) {
  const auto* measure = std::get_if<MeasureStep>(&step.what);
  return measure != nullptr && measure->suggested();
}

struct Kind {
  const char* name;
  Step (*read)(Fields&, const Around&);
};

/// A new kind of step is a line here, one in run.cpp, and one in the schema.
constexpr std::array<Kind, 5> kKinds = {{{"measure", read_measure},
                                         {"calibrate", read_calibrate},
                                         {"diagnose", read_diagnose},
                                         {"pause", read_pause},
                                         {"report", read_report}}};

std::string read_name(Fields& fields) {
  std::string name = fields.text("name");
  if (name.empty() || name.size() > 200) {
    fields.refuse("name", "a name that can't be used", "1 to 200 letters");
  }
  return name;
}

Step read_step(Fields& fields, Around& around) {
  const std::string name = read_name(fields);
  std::vector<std::string> names;
  for (const Kind& kind : kKinds) names.emplace_back(kind.name);
  const std::string wanted = fields.choice("kind", names);
  for (const Kind& kind : kKinds) {
    if (kind.name != wanted) continue;
    Step step = kind.read(fields, around);
    fields.done();
    step.name = name;
    if (!around.earlier.emplace(name, Earlier{wanted, may_be_skipped(step)}).second) {
      fields.refuse("name", "duplicate name", "a name of its own for each step");
    }
    return step;
  }
  fields.refuse("kind", "unknown kind");
}

}  // namespace

namespace {

Protocol protocol_of(const JsonFile& file, const std::filesystem::path& path) {
  constexpr std::size_t kMaxSteps = 1000;
  Fields top(file);
  take_format(top, "protocol/1");
  Protocol protocol;
  protocol.name = read_name(top);
  protocol.about = top.text("about", "");
  Around around{.folder = path.parent_path(), .setting = {}, .earlier = {}};
  around.setting = read_setting(top, around);
  if (around.setting.stage.empty()) static_cast<void>(top.text("stage"));  // refuses: it is missing
  if (auto published = top.optional_object("published")) {
    protocol.published = read_published(*published);
  }
  std::vector<Fields> steps = top.objects("steps");
  if (steps.empty() || steps.size() > kMaxSteps) {
    top.refuse("steps", "wrong number of steps", "1 to 1000");
  }
  for (Fields& step : steps) protocol.steps.push_back(read_step(step, around));
  const auto last =
      std::find_if(protocol.steps.rbegin(), protocol.steps.rend(),
                   [](const Step& step) { return std::holds_alternative<MeasureStep>(step.what); });
  const std::size_t n = static_cast<std::size_t>(protocol.steps.rend() - last);  // steps up to it
  for (std::size_t k = n; k < steps.size(); ++k) {
    if (!std::holds_alternative<PauseStep>(protocol.steps[k].what)) continue;
    steps[k].refuse("kind", "nothing is measured after this pause", "a later step of kind measure");
  }
  top.done();
  return protocol;
}

}  // namespace

Protocol read_protocol(const std::filesystem::path& path) {
  return protocol_of(read_json(path), path);
}

Protocol parse_protocol(std::string_view text, const std::filesystem::path& path) {
  return protocol_of(parse_json(std::string(text), path.string()), path);
}

}  // namespace trammel::protocol
