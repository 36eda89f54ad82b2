#include "app/protocol/protocol.hpp"

#include <algorithm>
#include <array>
#include <map>

#include "app/files/fields.hpp"
#include "app/files/format.hpp"
#include "app/files/plan_json.hpp"
#include "app/files/published_json.hpp"
#include "app/job/stages.hpp"

namespace trammel::protocol {

namespace {

/// What later steps need to know of a step.
struct Earlier {
  std::string kind;
  bool may_be_skipped = false;  // the points it measures are suggested by a diagnosis
};
using EarlierSteps = std::map<std::string, Earlier>;  // by name

/// The step of one of these kinds; else an error at `field`.
const Earlier& require_earlier(const Fields& fields, const std::string& field,
                               const std::string& name, const EarlierSteps& earlier,
                               const std::vector<std::string>& kinds) {
  const auto found = earlier.find(name);
  if (found != earlier.end() &&
      std::find(kinds.begin(), kinds.end(), found->second.kind) != kinds.end()) {
    return found->second;
  }
  std::string wanted;
  for (const std::string& kind : kinds) wanted += (wanted.empty() ? "" : " or ") + kind;
  fields.refuse(field, "'" + name + "' names no earlier step of kind " + wanted,
                "the name of a step that stands before this one");
}

/// Suggested points are measured as suggested: uncompensated, for fitting, each from its direction.
Step read_next_points(Fields& fields, const EarlierSteps& earlier) {
  Fields plan = fields.object("plan");
  MeasureStep step;
  step.next_points_of = plan.text("next_points_of");
  require_earlier(plan, "next_points_of", step.next_points_of, earlier, {"diagnose"});
  plan.done();
  return {.name = {}, .what = step};
}

Step read_measure(Fields& fields, const EarlierSteps& earlier) {
  if (fields.has("plan") && fields.value().at("plan").is_object()) {
    return read_next_points(fields, earlier);
  }
  MeasureStep step;
  step.plan = fields.choice("plan", {"paper-80", "paper-48", "circles"});
  step.approach = read_approach(fields);
  step.set = fields.choice("set", {"identify", "validate"}, "identify") == "validate"
                 ? ReadingSet::validate
                 : ReadingSet::identify;
  step.compensate = fields.optional_text("compensate");
  if (step.compensate) {
    require_earlier(fields, "compensate", *step.compensate, earlier, {"calibrate", "diagnose"});
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

std::vector<std::string> read_sessions(Fields& fields, const EarlierSteps& earlier) {
  std::vector<std::string> sessions = fields.texts("sessions");
  if (sessions.empty()) fields.refuse("sessions", "no session to work on");
  bool certain = false;
  for (const std::string& name : sessions) {
    certain =
        !require_earlier(fields, "sessions", name, earlier, {"measure"}).may_be_skipped || certain;
  }
  if (!certain) {
    fields.refuse("sessions", "all of these sessions may be skipped",
                  "at least one whose plan is no diagnosis's suggestion");
  }
  return sessions;
}

Step read_calibrate(Fields& fields, const EarlierSteps& earlier) {
  CalibrateStep step;
  std::vector<std::string> methods;
  for (const job::Stage& stage : job::stages()) {
    if (stage.name != "diagnose") methods.push_back(stage.name);  // a kind of step of its own
  }
  step.method = fields.choice("method", methods);
  step.sessions = read_sessions(fields, earlier);
  step.parameters = read_parameters(fields, step.method);
  return {.name = {}, .what = step};
}

Step read_diagnose(Fields& fields, const EarlierSteps& earlier) {
  DiagnoseStep step;
  step.sessions = read_sessions(fields, earlier);
  step.parameters = read_parameters(fields, "diagnose");
  return {.name = {}, .what = step};
}

bool may_be_skipped(const Step& step) {
  const auto* measure = std::get_if<MeasureStep>(&step.what);
  return measure != nullptr && !measure->next_points_of.empty();
}

struct Kind {
  const char* name;
  Step (*read)(Fields&, const EarlierSteps&);
};

/// A new kind of step is a line here, one in run.cpp, and one in the schema.
constexpr std::array<Kind, 3> kKinds = {
    {{"measure", read_measure}, {"calibrate", read_calibrate}, {"diagnose", read_diagnose}}};

std::string read_name(Fields& fields) {
  std::string name = fields.text("name");
  if (name.empty() || name.size() > 200) {
    fields.refuse("name", "a name that can't be used", "1 to 200 letters");
  }
  return name;
}

Step read_step(Fields& fields, EarlierSteps& earlier) {
  const std::string name = read_name(fields);
  std::vector<std::string> names;
  for (const Kind& kind : kKinds) names.emplace_back(kind.name);
  const std::string wanted = fields.choice("kind", names);
  for (const Kind& kind : kKinds) {
    if (kind.name != wanted) continue;
    Step step = kind.read(fields, earlier);
    fields.done();
    step.name = name;
    if (!earlier.emplace(name, Earlier{wanted, may_be_skipped(step)}).second) {
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
  const std::string robot = top.text("robot");
  if (robot.empty()) top.refuse("robot", "no file is named");
  protocol.robot = path.parent_path() / robot;
  if (auto published = top.optional_object("published")) {
    protocol.published = read_published(*published);
  }
  std::vector<Fields> steps = top.objects("steps");
  if (steps.empty() || steps.size() > kMaxSteps) {
    top.refuse("steps", "wrong number of steps", "1 to 1000");
  }
  EarlierSteps earlier;
  for (Fields& step : steps) protocol.steps.push_back(read_step(step, earlier));
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
