#pragma once
// The stage and tracker that never were, of any kind of machine. Written apart from whatever is
// fitted to it: it knows the machine's exact loop closures and nothing else of this program.

#include <cstdint>

#include "core/measure/reading.hpp"
#include "core/mechanism/machine_solver.hpp"
#include "core/simulate/truth.hpp"

namespace trammel::simulate {

class VirtualRobot {
 public:
  /// Sets the joint zeros of a robot that is zeroed at home: at the commanded home, cold, at rest
  /// and at time 0 the platform stands at (home.x, home.y, phi_zero). Throws InputError when the
  /// truth is not usable.
  explicit VirtualRobot(Truth truth);

  [[nodiscard]] const Truth& truth() const { return truth_; }

  /// Where the platform is, in the base frame. Deterministic: a function of the conditions alone.
  /// temp_degc absent: as temperature_degc(time_s); time_s absent: 0.
  [[nodiscard]] MachinePose true_pose(const Conditions& conditions) const;

  /// Drives at the commanded home.
  [[nodiscard]] const Displacements& home_mm() const { return l_home_mm_; }

  /// What a tracker without noise reads there: frame of the epoch, drift, scale, shifts. As
  /// Reading::measured: coordinates that are not measured are 0.
  [[nodiscard]] MachinePose seen_pose(const Conditions& conditions) const;

  /// The same for whatever stands at `pose` in the base frame then, as a reflector on the base.
  [[nodiscard]] Pose seen(Pose pose, const Conditions& conditions) const;

  /// One reading, with the noise of the stream `reading` (its number in the campaign): the same
  /// number gives the same bits, whatever was read before.
  [[nodiscard]] MachinePose read(const Conditions& conditions, std::uint64_t reading) const;

  /// T(t) of the machine as its thermometer shows it.
  [[nodiscard]] double temperature_degc(double time_s) const;

  /// Duration of a move, all rails in proportion, without settling.
  [[nodiscard]] double travel_s(const Displacements& from_mm, const Displacements& to_mm) const;

 private:
  void set_joint_zeros();
  [[nodiscard]] Displacements joint_errors(const Conditions& conditions) const;
  [[nodiscard]] Machine bent(const Displacements& s_mm, const Pose& at) const;
  [[nodiscard]] MachinePose solve(const Conditions& conditions) const;
  [[nodiscard]] const EpochTruth& epoch(int number) const;
  [[nodiscard]] double structure_temperature_degc(const Conditions& conditions) const;

  Truth truth_;
  Displacements l_home_mm_ = Displacements::Zero();
};

/// What noise adds to reading number `reading` (x, y in mm, phi in rad). Correlated noise is a sum
/// over the readings before, so that it too depends on the number alone.
Pose reading_noise(const TrackerTruth& tracker, std::uint64_t seed, std::uint64_t reading);

}  // namespace trammel::simulate
