#pragma once
// A laser tracker behind SpatialAnalyzer, as far as the T2SA line grammar tells: it looks at the
// emulated robot. README.md says what is modelled and what is not.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "app/emulate/faults.hpp"
#include "app/emulate/robot.hpp"
#include "app/emulate/server.hpp"
#include "core/simulate/virtual_robot.hpp"

namespace trammel::emulate {

/// A place for a reflector: on the platform (in its frame O_C) or on the base (in O_A).
struct Nest {
  std::string group;
  std::string point;
  bool on_platform = false;
  Eigen::Vector3d at_mm = Eigen::Vector3d::Zero();
};

struct TrackerSetup {
  std::vector<Nest> nests;
  /// Coordinates of the base frame to those that the tracker gives: p_T = from_base * p_B.
  Eigen::Isometry3d from_base = Eigen::Isometry3d::Identity();
  double warm_up_s = 12;
};

/// A frame that stands at `at_mm`, turned first about x, then y, then z, all of the fixed axes.
Eigen::Isometry3d fixed_frame(const Eigen::Vector3d& at_mm, const Eigen::Vector3d& turned_rad);

/// Two reflectors 15 mm apart on the platform as in the paper, three some 150 mm apart (no two
/// sides equal), four on the base, and a tracker that stands some metres away, turned and not quite
/// level.
TrackerSetup default_tracker();

/// The same from a file, "format": "emulated-tracker/1". Throws InputError with file, line, field.
TrackerSetup read_tracker_setup(const std::filesystem::path& path);

/// The instrument: one for all its connections. Used from one thread, its server's.
class EmulatedTracker {
 public:
  /// Where the platform stands: EmulatedRobot::standing, or that of another process. May throw
  /// DeviceError: then the instrument is not ready.
  using Look = std::function<Standing()>;

  /// `speedup` seconds of the instrument pass for one of the wall, as in `now`.
  EmulatedTracker(simulate::VirtualRobot robot, TrackerSetup setup, Look look, Faults& faults,
                  double speedup);

  /// Answers one line without its end. A measurement takes the time that the robot file states.
  Answer line(std::string_view text);

 private:
  struct Command;
  static const std::vector<Command>& commands();
  /// Fails with a reason that is an answer: "ERR-305 …".
  struct Failed {
    std::string answer;
  };

  Answer status(std::string_view);
  Answer laser_status(std::string_view);
  Answer switch_laser(std::string_view word);
  Answer halt(std::string_view);
  Answer measure_point(std::string_view names);
  Answer measure_group(std::string_view name);
  Answer position(std::string_view group);
  Answer offset(std::string_view names);
  /// One measurement: where the rails stand, and its number, from 1.
  struct Measurement {
    Standing standing;
    std::uint64_t number = 0;
  };
  using Result = std::function<std::string(const Measurement&)>;
  Answer measure(const std::string& what, Result result);
  [[nodiscard]] Standing look() const;
  [[nodiscard]] bool measuring() const { return !measuring_.expired(); }
  [[nodiscard]] double laser_left_s() const;
  [[nodiscard]] Conditions conditions(const Measurement& taken) const;
  [[nodiscard]] Pose seen_platform(const Measurement& taken) const;
  [[nodiscard]] Eigen::Vector3d place(const Nest& nest, const Measurement& taken) const;
  [[nodiscard]] std::string date(const Measurement& taken) const;
  [[nodiscard]] bool is_group(std::string_view group, bool on_platform) const;
  /// The platform as it was measured last by a group's nests, in the base frame.
  struct Seen {
    Eigen::Isometry3d T_B_P = Eigen::Isometry3d::Identity();
    std::string date = {};
  };
  [[nodiscard]] const Seen& seen(std::string_view group) const;

  simulate::VirtualRobot robot_;
  TrackerSetup setup_;
  Look look_;
  Faults& faults_;
  double speedup_;
  NowS now_;
  bool laser_on_ = true;
  double laser_on_s_ = 0;         // since when
  std::uint64_t n_measured_ = 0;  // measurements begun so far, those that failed too
  std::map<std::string, Seen, std::less<>> seen_;  // by group
  std::weak_ptr<bool> measuring_;  // the one that runs, for as long as somebody waits for it
};

/// Conversations with `tracker`.
Server::Make tracker_conversations(EmulatedTracker& tracker, Faults& faults);

}  // namespace trammel::emulate
