#pragma once
// One walk through the points that are left. Used by session.cpp alone.

#include <chrono>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/session/hands.hpp"
#include "app/session/session.hpp"
#include "app/session/settings.hpp"
#include "app/session/wishes.hpp"
#include "app/terminal/progress.hpp"
#include "store/campaign.hpp"
#include "store/place.hpp"

namespace trammel::session {

/// Everything that stays the same while a session is measured.
struct Course {
  store::CampaignRow campaign;
  store::SessionRow session;
  Settings settings;
  Plan plan;
  std::vector<Displacements> planned_mm;  // one per point, as checked
  Correction correction;
};

/// A command this far from what was checked is not sent.
inline constexpr double kMaxFromPlannedMm = 1.0;

/// The command for one move: of any machine without a correction, of a 3-PRR with one.
InverseResult command_for(const Correction& correction, const Machine& machine, const Move& move);

/// Displacements to command for every point, each move from the one before, from home. Throws
/// InputError that names the first point the correction cannot reach.
std::vector<Displacements> planned_commands(const Plan& plan, const Machine& machine,
                                            const Correction& correction);

class Runner {
 public:
  Runner(store::Connection& connection, std::shared_ptr<device::Devices> devices,
         const Course& course, const Surroundings& surroundings);

  /// Homes and measures what is left. `resuming`: a new epoch, reference points first. On any
  /// error the stage is stopped first. Throws StoreError when the database does not take what it
  /// must; a reading that was in hand is then in the side file (side_file.hpp).
  Outcome walk(bool resuming, bool new_set_up);

 private:
  /// Something that is tried until it is measured, or may not be tried again.
  struct Task {
    store::Id session = 0;
    std::string session_name;
    int seq = 0;  // of the session's point
    store::Epoch epoch;
    bool walks = false;  // through the states of a point: not a visit of a reference
    std::function<Failure(store::NewReading&)> once;
  };
  /// How the reference points were found.
  struct Visit {
    Failure failure;
    std::string off;  // the first that is beyond the tolerance, in words
    int epoch = 0;
  };

  /// What no look at the base nests vouches for.
  struct Doubt {
    std::vector<PlannedPoint> points;
    bool moved = false;  // the last look has found them moved
  };

  // runner.cpp: from state to state
  Outcome walk_on(bool resuming, bool new_set_up);
  void advance(Event event);
  void note(const char* kind, const std::string& detail);
  void fail(const std::string& detail, ExitCode code);
  void end_with(const Failure& failure, const std::string& where);
  [[nodiscard]] bool asked_to_stop();
  [[nodiscard]] bool wait_while_paused();
  void measure_open(bool resuming);
  void learn_stored();
  [[nodiscard]] int found_by_name() const;
  void count();
  [[nodiscard]] Outcome outcome() const;

  // point.cpp: one point
  [[nodiscard]] bool measure_point(const PlannedPoint& point);
  Failure try_point(const PlannedPoint& point, store::NewReading& stored);
  Failure try_hard(const Task& task, store::NewReading& reading);
  Failure wait_for_another_try(const Failure& failure);
  int commit(const Task& task, store::Id attempt, const store::NewReading& reading);
  Failure stand_before(const PlannedPoint& point);
  Failure drive(const PlannedPoint& point, const device::Occasion& occasion, Reading& reading);
  Failure read(const device::Occasion& occasion, store::NewReading& stored);
  [[nodiscard]] Failure judge(const store::NewReading& stored) const;
  [[nodiscard]] Failure beyond_gate(const store::NewReading& stored, const std::string& how) const;
  [[nodiscard]] Campaign so_far() const;
  [[nodiscard]] bool sound_so_far();
  [[nodiscard]] Failure look_for_step(const store::NewReading& stored) const;
  void learn_step(int seq);
  [[nodiscard]] std::string exclude(const std::vector<PlannedPoint>& points,
                                    const std::string& why);
  [[nodiscard]] Failure with_those_in_doubt(Failure failure);
  [[nodiscard]] Standing start_of(const PlannedPoint& point) const;
  [[nodiscard]] device::Occasion occasion_of(const PlannedPoint& point);

  // set_up.cpp: homing, epochs, reference points
  [[nodiscard]] bool set_up(bool resuming, bool new_set_up);
  [[nodiscard]] std::vector<PlannedPoint> references() const;
  [[nodiscard]] Doubt doubt() const;
  [[nodiscard]] bool references_hold();
  [[nodiscard]] bool settle(const Doubt& doubt, const std::string& when);
  void begin_epoch(int number);
  Visit visit(const std::vector<PlannedPoint>& points, store::SetUp set_up,
              const ReferenceTolerance& tolerance, const PlannedPoint& next);
  Failure revisit(const store::StoredReading& before, const device::Occasion& occasion,
                  store::NewReading& again);
  [[nodiscard]] ReferenceTolerance at_least_noise(ReferenceTolerance tolerance) const;

  // conditions.cpp: what is waited out
  [[nodiscard]] bool conditions_hold(const PlannedPoint& point);
  struct Found {
    Failure failure;
    std::string bad;  // in words; empty: good
  };
  Found look_at_conditions(const PlannedPoint& point, bool suspended);
  Found look_at_base(const PlannedPoint& point, bool suspended);
  void look_at_base_once_more();
  void believe(const PlannedPoint& point);
  void pass(double seconds, Wish until = Wish::stop);

  store::Connection& connection_;
  store::Place place_;
  std::shared_ptr<device::Devices> devices_;
  const Course& course_;
  const Surroundings& surroundings_;
  Wishes wishes_;
  Hands hands_;
  State state_ = State::checked;
  store::Epoch epoch_;
  std::map<int, Standing> stood_;                 // by seq of the points that are stored
  std::map<int, store::StoredReading> measured_;  // the same, without those that are excluded
  PoseGate gate_;
  double usual_mm_ = 0;  // the largest difference between the deviations of neighbours so far
  std::string stepped_;  // what has made a step, in words, until the set-up was looked at
  int believed_ = 0;     // seq of the point at which the set-up was found to be where it was
  std::vector<PlannedPoint> open_;
  std::optional<terminal::Progress> progress_;
  std::string trail_;  // of the try that goes on
  std::chrono::steady_clock::time_point try_began_;
  int n_before_ = 0;
  int n_stored_ = 0;
  int n_visits_ = 0;     // of reference points in this epoch
  int since_visit_ = 0;  // points
  int since_base_ = 0;   // the same, since the base nests were measured
  std::string detail_;
  ExitCode fault_ = ExitCode::device;
};

}  // namespace trammel::session
