#pragma once
// What a session drives: a stage, a tracker, a thermometer, a clock. Simulated ones are in
// simulated.hpp; a real device is one file pair more and one line in open.cpp.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/measure/base_frame.hpp"
#include "core/measure/reading.hpp"
#include "core/mechanism/machine.hpp"
#include "core/plan/plan.hpp"

namespace trammel::device {

/// How a device answered. All of these are expected; what is done about each is the runner's.
enum class Status {
  ok,
  beam_broken,      // tracker: the reflector is lost
  timeout,          // no answer, or not in position in time
  unstable,         // tracker: the readings scatter more than they may
  limit,            // stage: a limit switch or soft limit
  following_error,  // stage: a rail does not follow its command
  fault,            // the device says that it is broken, or makes no sense
};

/// "ok", "beam broken", …
const char* name_of(Status status);

/// Whether the controller of a stage stops the rails by itself when this program is gone: within so
/// many seconds, or, 0, not at all.
std::string watch_text(double watch_host_s);

/// Trying again may help: beam_broken, timeout, unstable. Never after a limit or a fault.
bool may_retry(Status status);

/// The moment of a measurement as the program knows it. A real instrument has no use for it; a
/// simulated one derives everything from it, so that a resumed session reads the same bits.
struct Occasion {
  std::uint64_t reading = 0;  // number of the reading among all that could ever be taken
  double time_s = 0;          // since the campaign's start
  int epoch = 1;
  double moved_mm = 0;  // of the platform since the last measurement that succeeded
};

struct [[nodiscard]] StageReport {
  Status status = Status::fault;
  std::string detail = {};
  Displacements encoder_mm = Displacements::Zero();    // ok only: where the rails are
  Displacements commanded_mm = Displacements::Zero();  // ok only: where the controller wants them
  [[nodiscard]] bool ok() const { return status == Status::ok; }
};

/// Asked by a stage once per poll (sample) while it moves, before the first one too. An answer that
/// is not ok stops the stage at once and is the status of its report.
using Watch = std::function<Status()>;

class Stage {
 public:
  virtual ~Stage() = default;
  [[nodiscard]] virtual std::string describe() const = 0;
  [[nodiscard]] virtual bool homed() const = 0;
  virtual StageReport home() = 0;
  /// Moves all rails in proportion; returns when they stand in position, or why they do not.
  virtual StageReport move(const Displacements& to_mm, const Watch& watch) = 0;
  /// Stops what moves, first of all, and says where the rails stand then. Safe to call at any time,
  /// by the watchdog's thread too while another call does not return.
  virtual StageReport stop() = 0;
};

struct [[nodiscard]] PoseReport {
  Status status = Status::fault;
  std::string detail = {};     // why not; or what is worth a line in the session's log
  Pose pose = {};              // ok only
  std::string raw_reply = {};  // as it came
  [[nodiscard]] bool ok() const { return status == Status::ok; }
};

struct [[nodiscard]] BaseReport {
  Status status = Status::fault;
  std::string detail = {};
  BaseDrift drift = {};  // ok only: since the tracker's frame was registered
  [[nodiscard]] bool ok() const { return status == Status::ok; }
};

class Tracker {
 public:
  virtual ~Tracker() = default;
  [[nodiscard]] virtual std::string describe() const = 0;
  /// Is the reflector locked, and the last reading fresh? Cheap: a stage asks at each poll.
  /// ok, beam_broken, timeout (stale), fault.
  [[nodiscard]] virtual Status beam() = 0;
  virtual PoseReport measure(const Occasion& occasion) = 0;
  /// Whether there are nests on the base by which the frame was registered.
  [[nodiscard]] virtual bool sees_base() const { return false; }
  /// Measures them again.
  virtual BaseReport measure_base(const Occasion&) { return {Status::fault, "no base nests"}; }
};

struct [[nodiscard]] TemperatureReport {
  Status status = Status::fault;
  std::string detail = {};
  double temp_degc = 0;  // ok only
  [[nodiscard]] bool ok() const { return status == Status::ok; }
};

class Thermometer {
 public:
  virtual ~Thermometer() = default;
  /// Where the number comes from.
  [[nodiscard]] virtual std::string describe() const = 0;
  virtual TemperatureReport read(const Occasion& occasion) = 0;
};

class Clock {
 public:
  virtual ~Clock() = default;
  /// Called before anything else: the session begins at `start_s` after the campaign's start.
  virtual void start(const Plan& plan, double start_s) = 0;
  /// Time since the campaign's start, now that the point is being measured.
  virtual double time_s(const PlannedPoint& point) = 0;
  /// Estimated end of the session.
  [[nodiscard]] virtual double end_s() const = 0;
};

/// How fast the stage goes. Never lowered in silence: what is too fast is refused.
struct Motion {
  double speed_mm_s = 0;      // of the fastest rail, as the stage is set; 0: it does not say
  double max_speed_mm_s = 0;  // that a rail may go; 0: it does not say
  double following_mm = 0;    // an encoder may be so far from its command; 0: it does not say
};

/// One set of devices around one robot.
struct Devices {
  bool simulated = false;
  bool virtual_time = false;    // time is the plan's own: nothing changes by waiting
  std::string identity = {};    // changes when the devices are not those a session began with
  std::string controller = {};  // "host:port" of what moves a real stage: one runner at a time
  std::optional<double> watch_host_s = {};  // as watch_text says; nothing: no controller
  Machine machine = {};                     // what the controller believes
  Motion motion = {};
  std::optional<TrackerSigma> sigma = {};
  std::unique_ptr<Stage> stage;
  std::unique_ptr<Tracker> tracker;
  std::unique_ptr<Thermometer> thermometer;
  std::unique_ptr<Clock> clock;
};

}  // namespace trammel::device
