#include "app/cli/emulate.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/serving.hpp"
#include "app/emulate/galil.hpp"
#include "app/emulate/stage_link.hpp"
#include "app/emulate/tracker.hpp"
#include "app/files/robot_json.hpp"

namespace trammel::cli {

namespace {

using emulate::Emulated;
using emulate::EmulatedRobot;
using emulate::Faults;

struct EmulateOptions {
  std::string robot;
  emulate::ServerOptions server;
  double speedup = 1;
  std::vector<std::string> faults, tracker_faults;
  // the stage
  emulate::RailSetup rail;
  std::vector<double> sign = {1}, home_mm, lead_error = {0}, start_mm = {0};
  std::optional<int> tracker_port;
  // the tracker
  std::string stage;
  std::string nests;
};

/// One value for all drives, or one for each.
double of_drive(const std::vector<double>& values, int drive, int n_drives, const char* option) {
  if (values.size() != 1 && static_cast<int>(values.size()) != n_drives) {
    throw UsageError({.what = fmt::format("one value for all drives, or {}", n_drives),
                      .where = {.field = option},
                      .got = std::to_string(values.size()) + " values"});
  }
  return values.size() == 1 ? values[0] : values[static_cast<std::size_t>(drive)];
}

EmulatedRobot::Rails rails_of(const EmulateOptions& o, int n_drives) {
  EmulatedRobot::Rails rails;
  for (int i = 0; i < n_drives; ++i) {
    emulate::RailSetup& rail = rails[static_cast<std::size_t>(i)];
    rail = o.rail;
    rail.sign = of_drive(o.sign, i, n_drives, "--sign") < 0 ? -1 : 1;
    rail.lead_error = of_drive(o.lead_error, i, n_drives, "--lead-error");
    rail.start_mm = of_drive(o.start_mm, i, n_drives, "--start-mm");
    if (!o.home_mm.empty()) rail.home_mm = of_drive(o.home_mm, i, n_drives, "--home-mm");
  }
  return rails;
}

void add_faults(Faults& faults, const std::vector<std::string>& words, Emulated device) {
  for (const std::string& word : words) faults.add(emulate::parse_fault(word, device));
}

emulate::TrackerSetup tracker_setup(const EmulateOptions& o) {
  return o.nests.empty() ? emulate::default_tracker() : emulate::read_tracker_setup(o.nests);
}

constexpr const char* kNote = "Ctrl-C ends it";

ExitCode run_galil(const EmulateOptions& o, Context& context) {
  Faults faults, tracker_faults;
  add_faults(faults, o.faults, Emulated::stage);
  add_faults(tracker_faults, o.tracker_faults, Emulated::tracker);
  const simulate::VirtualRobot virtual_robot(read_robot(o.robot));
  EmulatedRobot robot(virtual_robot, rails_of(o, virtual_robot.truth().nominal.kind->n_chains),
                      emulate::wall_clock(o.speedup));
  emulate::Galil galil(robot, faults);
  emulate::EmulatedTracker tracker(
      robot.robot(), tracker_setup(o), [&robot] { return robot.standing(); }, tracker_faults,
      o.speedup);
  const sigset_t ends = hold_signals();
  emulate::ServerOptions controller = o.server;
  controller.meanwhile = [&galil] { return galil.programs.work(); };
  const emulate::Server server(controller, emulate::galil_conversations(galil, faults));
  std::optional<emulate::Server> second;
  std::string text =
      fmt::format("emulated Galil DMC-4183 on {}:{}", o.server.address, server.port());
  Json object = {{"schema", "trammel/emulate-galil/1"},
                 {"address", o.server.address},
                 {"port", server.port()}};
  if (o.tracker_port) {
    emulate::ServerOptions there = o.server;
    there.port = *o.tracker_port;
    second.emplace(there, emulate::tracker_conversations(tracker, tracker_faults));
    text += fmt::format("\nemulated tracker on {}:{}", there.address, second->port());
    object["tracker_port"] = second->port();
  }
  object["speedup"] = o.speedup;
  serve_until_told(text, object, kNote, ends, context);
  return ExitCode::ok;
}

ExitCode run_tracker(const EmulateOptions& o, Context& context) {
  Faults faults;
  add_faults(faults, o.faults, Emulated::tracker);
  const simulate::VirtualRobot robot(read_robot(o.robot));
  emulate::EmulatedTracker::Look look = [&o] { return emulate::ask_standing(o.stage); };
  if (o.stage.empty()) {  // nothing moves it: it stands at home
    const EmulatedRobot at_home(robot, {}, [] { return 0.0; });
    look = [standing = at_home.standing()] { return standing; };
  } else {
    look();  // a stage that is not there is said now
  }
  emulate::EmulatedTracker tracker(robot, tracker_setup(o), look, faults, o.speedup);
  const sigset_t ends = hold_signals();
  const emulate::Server server(o.server, emulate::tracker_conversations(tracker, faults));
  serve_until_told(fmt::format("emulated tracker on {}:{}", o.server.address, server.port()),
                   {{"schema", "trammel/emulate-tracker/1"},
                    {"address", o.server.address},
                    {"port", server.port()},
                    {"speedup", o.speedup}},
                   kNote, ends, context);
  return ExitCode::ok;
}

Command add_device(Command emulate, const char* name, const char* what, EmulateOptions& o,
                   Emulated device) {
  Command c = emulate.command(name, what);
  c.option("--robot", o.robot, "the virtual robot, robot/1").required().type("FILE");
  c.option("--port", o.server.port, "0: any that is free").shown_default();
  c.option("--address", o.server.address, "by default this machine alone").shown_default();
  c.option("--speedup", o.speedup, "seconds there for each one here")
      .shown_default()
      .range(1e-3, 1e6);
  c.option("--fault", o.faults,
           "KIND@N or KIND@N:TEXT, at the N-th command (with TEXT in it), move or "
           "measurement; KIND: " +
               emulate::fault_kinds(device))
      .type("KIND@N");
  c.option("--nests", o.nests, "reflectors and stand of the tracker, emulated-tracker/1")
      .type("FILE");
  return c;
}

void setup_galil(Command emulate, Context& context) {
  auto o = std::make_shared<EmulateOptions>();
  Command c = add_device(emulate, "galil", "A Galil DMC-4183 that moves a virtual robot", *o,
                         Emulated::stage);
  c.option("--lead-mm", o->rail.lead_mm, "of the screws, mm a turn").shown_default();
  c.option("--counts-per-rev", o->rail.counts_per_rev, "of the encoders").shown_default();
  c.option("--gear", o->rail.gear, "motor turns a screw turn").shown_default();
  c.option("--sign", o->sign,
           "1 or -1: counts against displacement (one value, or one for each drive)")
      .delimiter(',')
      .one_of({"1", "-1"});
  c.option("--home-mm", o->home_mm, "displacement at the home switches (the robot's home)")
      .delimiter(',');
  c.option("--lead-error", o->lead_error, "share by which a screw is too long").delimiter(',');
  c.option("--start-mm", o->start_mm, "where the drives stand at power-up, from home")
      .delimiter(',');
  c.option("--tracker-port", o->tracker_port, "serve the tracker too, 0: any that is free");
  c.option("--tracker-fault", o->tracker_faults, "a --fault of that tracker").type("KIND@N");
  on_run(c, context, o, run_galil);
}

void setup_tracker(Command emulate, Context& context) {
  auto o = std::make_shared<EmulateOptions>();
  Command c = add_device(emulate, "tracker", "A laser tracker that sees a virtual robot", *o,
                         Emulated::tracker);
  c.option("--stage", o->stage, "the emulated stage that moves it (it stands at home)")
      .type("HOST:PORT");
  on_run(c, context, o, run_tracker);
}

}  // namespace

void setup_emulate(Command app, Context& context) {
  Command emulate = noun(app, "emulate", "Devices that are not there, as servers");
  setup_galil(emulate, context);
  setup_tracker(emulate, context);
}

}  // namespace trammel::cli
