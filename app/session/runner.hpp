#pragma once
// One walk through the points that are left. Used by session.cpp alone.

#include <map>
#include <string>
#include <vector>

#include "app/device/device.hpp"
#include "app/session/progress.hpp"
#include "app/session/session.hpp"
#include "app/session/settings.hpp"
#include "store/campaign.hpp"

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

/// How often a point is tried before the session stops.
inline constexpr int kMaxTries = 3;
/// A command this far from what was checked is not sent.
inline constexpr double kMaxFromPlannedMm = 1.0;

/// Displacements to command for every point, each move from the one before, from home. Throws
/// InputError that names the first point the correction cannot reach.
std::vector<Displacements> planned_commands(const Plan& plan, const Mechanism& mechanism,
                                            const Correction& correction);

class Runner {
 public:
  Runner(store::Connection& connection, device::Devices& devices, const Course& course,
         const Surroundings& surroundings);

  /// Homes and measures what is left. `resuming`: a new epoch, reference points first.
  Outcome walk(bool resuming, bool new_set_up);

 private:
  /// Where rails stand and where their last moves began.
  struct Standing {
    Displacements l_mm = Displacements::Zero();
    Displacements from_mm = Displacements::Zero();
  };
  struct Failure {
    device::Status status = device::Status::ok;
    std::string detail = {};
    [[nodiscard]] bool any() const { return status != device::Status::ok; }
  };

  void advance(Event event);
  [[nodiscard]] Failure move(const Displacements& to_mm);
  [[nodiscard]] Failure home();
  [[nodiscard]] Failure stand_before(const PlannedPoint& point);
  [[nodiscard]] Failure drive(const PlannedPoint& point, const device::Occasion& occasion,
                              Reading& reading);
  [[nodiscard]] Failure read(const device::Occasion& occasion, Reading& reading,
                             store::NewReading& stored);
  [[nodiscard]] bool measure_point(const PlannedPoint& point);
  [[nodiscard]] bool set_up(bool resuming, bool new_set_up);
  [[nodiscard]] bool references_hold(int& epoch_number);
  [[nodiscard]] Failure revisit(const store::StoredReading& before, std::uint64_t number,
                                store::NewReading& again);
  [[nodiscard]] std::string moved(const store::StoredReading& before, const Reading& now) const;
  [[nodiscard]] Standing start_of(const PlannedPoint& point) const;
  [[nodiscard]] device::Occasion occasion_of(const PlannedPoint& point);
  void learn_stored();
  void measure_open(bool resuming);
  void count();
  void fail(const std::string& detail);
  [[nodiscard]] bool asked_to_stop(int least) const;
  Outcome outcome() const;

  store::Connection& connection_;
  device::Devices& devices_;
  const Course& course_;
  const Surroundings& surroundings_;
  State state_ = State::checked;
  Standing home_;
  Standing stage_;
  bool on_course_ = true;  // stage_ is where it stands; not after a move that was cut off
  store::Epoch epoch_;
  std::map<int, Standing> stood_;                 // by seq of the points that are stored
  std::map<int, store::StoredReading> measured_;  // the same, of earlier runs
  std::vector<PlannedPoint> open_;
  int n_before_ = 0;
  int n_stored_ = 0;
  std::string detail_;
};

}  // namespace trammel::session
