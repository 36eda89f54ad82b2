// A real controller reads the files that are written for it: LinuxCNC in simulation, as Debian
// packages it. Not in scripts/setup: it brings a desktop with it.

#include <unistd.h>

#include <cmath>
#include <sstream>

#include "app/job/controller_tables.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/program.hpp"
#include "tests/support/skip.hpp"

using namespace trammel;
using namespace trammel::job;

namespace {

/// LinuxCNC with three sliding joints whose motors are where they are told to be.
const char* const kIni = R"([EMC]
VERSION = 1.1
MACHINE = trammel
[DISPLAY]
DISPLAY = @FOLDER@/drive.py
[TASK]
TASK = milltask
CYCLE_TIME = 0.010
[RS274NGC]
PARAMETER_FILE = sim.var
[EMCMOT]
EMCMOT = motmod
COMM_TIMEOUT = 4.0
SERVO_PERIOD = 1000000
[EMCIO]
EMCIO = io
CYCLE_TIME = 0.100
[HAL]
HALFILE = sim.hal
[TRAJ]
COORDINATES = XYZ
LINEAR_UNITS = mm
ANGULAR_UNITS = degree
MAX_LINEAR_VELOCITY = 1000
[KINS]
KINEMATICS = trivkins
JOINTS = 3
)";
const char* const kLimits = R"(MIN_LIMIT = -1
MAX_LIMIT = 700
MAX_VELOCITY = 1000
MAX_ACCELERATION = 10000
)";
const char* const kJoint = R"(TYPE = LINEAR
HOME = 0
HOME_SEQUENCE = 0
STEPGEN_MAXACCEL = 20000
FERROR = 100
MIN_FERROR = 100
)";
const char* const kHal = R"(loadrt [KINS]KINEMATICS
loadrt [EMCMOT]EMCMOT servo_period_nsec=[EMCMOT]SERVO_PERIOD num_joints=[KINS]JOINTS
addf motion-command-handler servo-thread
addf motion-controller servo-thread
net J0 joint.0.motor-pos-cmd => joint.0.motor-pos-fb
net J1 joint.1.motor-pos-cmd => joint.1.motor-pos-fb
net J2 joint.2.motor-pos-cmd => joint.2.motor-pos-fb
net estop-loop iocontrol.0.user-enable-out iocontrol.0.emc-enable-in
)";
/// In the place of the operator's screen: homes, goes up and down, and writes down what the motors
/// are told.
const char* const kDrive = R"(#!/usr/bin/python3
import time
import hal
import linuxcnc

probe = hal.component("probe")
probe.ready()
command, status = linuxcnc.command(), linuxcnc.stat()


def then(_):
    command.wait_complete(10)


then(command.state(linuxcnc.STATE_ESTOP_RESET))
then(command.state(linuxcnc.STATE_ON))
then(command.mode(linuxcnc.MODE_MANUAL))
command.home(-1)
for _ in range(200):
    status.poll()
    if all(status.homed[:3]):
        break
    time.sleep(0.05)
then(command.teleop_enable(1))
then(command.mode(linuxcnc.MODE_MDI))
places = [190, 213.7, 241.2, 263, 290.5, 318, 330]
with open("@FOLDER@/told.txt", "w") as told:
    for direction, way in ((1, places), (-1, places[-2::-1])):
        for x in way:
            then(command.mdi(f"G0 X{x} Y{x} Z{x}"))
            time.sleep(0.2)
            motors = [hal.get_value(f"joint.{j}.motor-pos-cmd") for j in range(3)]
            print(direction, x, *motors, file=told)
)";

std::string in_folder(std::string text, const std::filesystem::path& folder) {
  const std::string mark = "@FOLDER@";
  for (auto at = text.find(mark); at != std::string::npos; at = text.find(mark)) {
    text.replace(at, mark.size(), folder.string());
  }
  return text;
}

/// The INI with our own lines for each joint.
std::string ini_for(const std::vector<ControllerFile>& files, const std::filesystem::path& folder) {
  std::string text = in_folder(kIni, folder);
  for (const char* axis : {"X", "Y", "Z"}) {
    text += "[AXIS_" + std::string(axis) + "]\n" + kLimits;
  }
  for (std::size_t j = 0; j < files.size(); ++j) {
    const std::string ours = linuxcnc_ini(files), head = "[JOINT_" + std::to_string(j) + "]\n";
    const std::size_t at = ours.find(head);
    text += ours.substr(at, ours.find("[JOINT_", at + 1) - at) + kLimits + kJoint;
  }
  return text;
}

/// LinuxCNC refuses root.
std::vector<std::string> as_anybody(const std::filesystem::path& folder) {
  std::vector<std::string> words;
  if (::geteuid() == 0) {
    words = {"setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"};
    std::filesystem::permissions(folder, std::filesystem::perms::all);
  }
  words.insert(words.end(), {"env", "HOME=" + folder.string(), "timeout", "60", "linuxcnc",
                             (folder / "sim.ini").string()});
  return words;
}

}  // namespace

TEST_CASE("LinuxCNC moves each motor as the correction says, from both sides", "[job][release]") {
  if (tests::run_command({"sh", "-c", "command -v linuxcnc"}, "/").exit_code != 0) {
    return tests::skip("LinuxCNC is not here: apt-get install linuxcnc-uspace");
  }
  RobotModel robot = nominal_model(paper_mechanism());
  robot.effects = {{&find_effect("lead_scale"), Eigen::Vector3d(0.0003, -0.0002, 0.0001)},
                   {&find_effect("lead_curvature"), Eigen::Vector3d(1e-6, 0, -2e-6)},
                   {&find_effect("backlash"), Eigen::Vector3d(0.08, 0, 0.02)}};
  const ControllerTables tables =
      controller_tables(ModelCorrection{robot}, robot.mechanism(), {}, 5);
  const tests::TemporaryFolder folder;
  const auto files = linuxcnc_files(tables, "cnc");
  for (const ControllerFile& file : files) folder.write(file.name, file.text);
  folder.write("sim.ini", ini_for(files, folder.path()));
  folder.write("sim.hal", kHal);
  std::filesystem::permissions(folder.write("drive.py", in_folder(kDrive, folder.path())),
                               std::filesystem::perms(0755));
  const auto run = tests::run_command(as_anybody(folder.path()), folder.path());
  INFO(run.out << run.err);
  std::istringstream told(tests::read_text(folder.path() / "told.txt"));
  int n = 0;
  double direction = 0, at_mm = 0, motor_mm[3];
  while (told >> direction >> at_mm >> motor_mm[0] >> motor_mm[1] >> motor_mm[2]) {
    ++n;
    for (std::size_t j = 0; j < 3; ++j) {
      CAPTURE(direction, at_mm, j);
      const DriveTables& d = tables.drives[j];
      const double expected_mm = at_mm + (direction > 0 ? d.forward : d.reverse).at(at_mm);
      // Six decimals in the file; LinuxCNC's own sums differ by 2e-7 from table to table.
      CHECK_THAT(motor_mm[j], WithinAbs(expected_mm, 2e-6));
    }
  }
  CHECK(n == 13);
  CHECK(tables.drives[0].before.max_mm > 0.04);  // sign and size of something that is there
}
