#pragma once
// What a campaign measured: the data every calibration starts from.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/mechanism/machine.hpp"
#include "core/mechanism/pose.hpp"

namespace trammel {

/// Validation readings are never fitted; a predict row has no measured pose.
enum class ReadingSet { identify, validate, predict };

/// Under what a reading was taken: all a model may use to predict it. Drives that the machine has
/// not are 0, and so are coordinates of a measured pose that `Machine::measured` leaves out.
struct Conditions {
  Displacements cmd_mm = Displacements::Zero();  // commanded joint displacements
  Displacements from_mm =
      Displacements::Zero();  // where each rail's last move began: gives the approach direction
  int epoch = 1;              // one homing and frame set-up, from 1
  std::optional<double> time_s = {};  // since the campaign's start
  std::optional<double> temp_degc = {};
};

struct Reading {
  int seq = 0;  // order in which the readings were taken, from 1
  ReadingSet set = ReadingSet::identify;
  Pose target;
  Conditions conditions;
  std::optional<Pose> measured;  // absent in predict rows
};

/// One standard deviation of one pose reading.
struct TrackerSigma {
  double xy_mm = 0;
  double phi_rad = 0;
};

struct Campaign {
  std::string name;
  bool simulated = false;
  Machine machine;
  std::optional<TrackerSigma> tracker;
  std::map<std::string, std::string> facts;
  std::vector<Reading> readings;  // by seq
};

}  // namespace trammel
