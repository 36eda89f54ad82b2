#include "app/protocol/protocol.hpp"

#include <array>
#include <map>

#include "app/exchange/fields.hpp"
#include "app/job/stages.hpp"

namespace trammel::protocol {

namespace {

using StepKinds = std::map<std::string, std::string>;  // kind by name, of the steps so far

void require_earlier(const Fields& fields, const std::string& field, const std::string& name,
                     const StepKinds& earlier, const std::string& kind) {
  const auto found = earlier.find(name);
  if (found != earlier.end() && found->second == kind) return;
  fields.refuse(field, "'" + name + "' names no earlier step of kind " + kind,
                "the name of a step that stands before this one");
}

Step read_measure(Fields& fields, const StepKinds& earlier) {
  MeasureStep step;
  step.plan = fields.choice("plan", {"paper-80", "paper-48", "circles"});
  step.set = fields.choice("set", {"identify", "validate"}, "identify") == "validate"
                 ? ReadingSet::validate
                 : ReadingSet::identify;
  step.compensate = fields.optional_text("compensate");
  if (step.compensate) {
    require_earlier(fields, "compensate", *step.compensate, earlier, "calibrate");
  }
  return {.name = {}, .what = step};
}

/// The stage knows its parameters; the file and line are known here.
void check_parameters(const Fields& fields, const CalibrateStep& step) {
  try {
    (void)job::find_stage(step.method).complete(step.parameters);
  } catch (const InputError& error) {
    ErrorText text = error.text();
    const std::string field = text.where.field;
    text.where = fields.file().where(fields.path("parameters"));
    text.where.field += (field.empty() ? "" : ".") + field;
    throw InputError(text);
  }
}

Step read_calibrate(Fields& fields, const StepKinds& earlier) {
  CalibrateStep step;
  std::vector<std::string> methods;
  for (const job::Stage& stage : job::stages()) methods.push_back(stage.name);
  step.method = fields.choice("method", methods);
  step.sessions = fields.texts("sessions");
  if (step.sessions.empty()) fields.refuse("sessions", "no session to calibrate on");
  for (const std::string& name : step.sessions) {
    require_earlier(fields, "sessions", name, earlier, "measure");
  }
  if (fields.optional_object("parameters")) {
    step.parameters = fields.value().at("parameters");
    check_parameters(fields, step);
  }
  return {.name = {}, .what = step};
}

struct Kind {
  const char* name;
  Step (*read)(Fields&, const StepKinds&);
};

/// A new kind of step is a line here, one in run.cpp, and one in the schema.
constexpr std::array<Kind, 2> kKinds = {{{"measure", read_measure}, {"calibrate", read_calibrate}}};

std::string read_name(Fields& fields) {
  std::string name = fields.text("name");
  if (name.empty() || name.size() > 200) {
    fields.refuse("name", "a name that can't be used", "1 to 200 letters");
  }
  return name;
}

Step read_step(Fields& fields, StepKinds& earlier) {
  const std::string name = read_name(fields);
  std::vector<std::string> names;
  for (const Kind& kind : kKinds) names.emplace_back(kind.name);
  const std::string wanted = fields.choice("kind", names);
  for (const Kind& kind : kKinds) {
    if (kind.name != wanted) continue;
    Step step = kind.read(fields, earlier);
    fields.done();
    step.name = name;
    if (!earlier.emplace(name, wanted).second) {
      fields.refuse("name", "the name stands twice", "a name of its own for each step");
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
  top.choice("format", {"protocol/1"});
  Protocol protocol;
  protocol.name = read_name(top);
  protocol.about = top.text("about", "");
  const std::string robot = top.text("robot");
  if (robot.empty()) top.refuse("robot", "no file is named");
  protocol.robot = path.parent_path() / robot;
  std::vector<Fields> steps = top.objects("steps");
  if (steps.empty() || steps.size() > kMaxSteps) {
    top.refuse("steps", "wrong number of steps", "1 to 1000");
  }
  StepKinds earlier;
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
