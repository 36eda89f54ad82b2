#include "app/device/stage_json.hpp"

#include "app/files/fields.hpp"
#include "app/files/files.hpp"
#include "app/files/format.hpp"
#include "app/files/machine_json.hpp"
#include "core/error.hpp"
#include "core/mechanism/machine_solver.hpp"

namespace trammel::device {

namespace {

GalilAxis read_axis(Fields& fields, const Drive& drive, double home_mm) {
  GalilAxis axis;
  const std::string letter = fields.text("axis");
  if (letter.size() != 1) fields.refuse("axis", "no letter of an axis", "A to H");
  axis.letter = letter[0];
  axis.lead_mm = fields.number("lead_mm", drive.lead_mm);
  axis.counts_per_rev = fields.number("counts_per_rev");
  axis.gear = fields.number("gear", axis.gear);
  axis.sign = fields.integer("sign", axis.sign);
  axis.zero_mm = fields.number("zero_mm", home_mm);
  fields.done();
  return axis;
}

void read_axes(Fields& top, GalilSettings& galil) {
  const Machine& machine = galil.machine;
  const InverseResult home = MachineSolver(machine).drives(machine.home);
  if (!home.ok()) top.refuse("mechanism", "the home pose is out of reach");
  std::vector<Fields> axes = top.objects("axes");
  const auto n = static_cast<std::size_t>(machine.kind->n_chains);
  if (axes.size() != n) {
    top.refuse(
        "axes", "wrong number of axes: " + std::to_string(axes.size()),
        std::to_string(n) + ", one for each drive of the " + std::string(machine.kind->name));
  }
  for (std::size_t i = 0; i < n; ++i) {
    galil.axes.push_back(read_axis(axes[i], machine.drives[i], home.l_mm[static_cast<int>(i)]));
  }
}

void read_motion(Fields motion, GalilSettings& s) {
  s.speed_mm_s = motion.number("speed_mm_s", s.speed_mm_s);
  s.acceleration_mm_s2 = motion.number("acceleration_mm_s2", s.acceleration_mm_s2);
  s.poll_s = motion.number("poll_s", s.poll_s);
  s.margin_s = motion.number("margin_s", s.margin_s);
  s.settle_band_mm = motion.number("settle_band_mm", s.settle_band_mm);
  s.settle_s = motion.number("settle_s", s.settle_s);
  s.settle_timeout_s = motion.number("settle_timeout_s", s.settle_timeout_s);
  s.following_mm = motion.number("following_mm", s.following_mm);
  motion.done();
}

void read_controller(Fields fields, GalilSettings& s) {
  fields.choice("type", {"galil"});
  s.controller.host = fields.text("host");
  s.controller.port = fields.integer("port", 23);
  if (s.controller.port < 1 || s.controller.port > 65'535) {
    fields.refuse("port", "no TCP port", "1 to 65535");
  }
  s.connect_timeout_s = fields.number("connect_timeout_s", s.connect_timeout_s);
  s.reply_timeout_s = fields.number("reply_timeout_s", s.reply_timeout_s);
  s.watch_host_s = fields.number("watch_host_s", s.watch_host_s);
  fields.done();
}

StageFile read_stage_fields(Fields top) {
  take_format(top, "stage/1");
  static_cast<void>(top.text("name", ""));
  static_cast<void>(top.text("why", ""));
  StageFile stage;
  stage.emulated = top.boolean("emulated", false);
  read_controller(top.object("controller"), stage.galil);
  stage.galil.machine = read_any_machine(top.object("mechanism"));
  read_axes(top, stage.galil);
  if (auto motion = top.optional_object("motion")) read_motion(*motion, stage.galil);
  if (auto homing = top.optional_object("homing")) {
    stage.galil.homing_speed_mm_s = homing->number("speed_mm_s", stage.galil.homing_speed_mm_s);
    stage.galil.homing_timeout_s = homing->number("timeout_s", stage.galil.homing_timeout_s);
    homing->done();
  }
  top.done();
  return stage;
}

}  // namespace

StageFile parse_stage(std::string_view text, const std::string& name) {
  const JsonFile file = parse_json(text, name);
  StageFile stage = read_stage_fields(Fields(file));
  try {
    validate(stage.galil);
  } catch (const InputError& error) {
    throw located(error, file);
  }
  return stage;
}

StageFile read_stage(const std::filesystem::path& path) {
  return parse_stage(read_file(path, kMaxJsonBytes), path.string());
}

}  // namespace trammel::device
