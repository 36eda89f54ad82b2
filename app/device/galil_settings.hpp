#pragma once

#include "app/device/galil_axis.hpp"
#include "app/device/tcp.hpp"
#include "core/mechanism/machine.hpp"

namespace trammel::device {

/// All that the driver of a Galil stage must be told. stage_json.hpp reads it from a file.
struct GalilSettings {
  Endpoint controller;
  double connect_timeout_s = 5;
  double reply_timeout_s = 5;
  double watch_host_s = 0;  // the controller stops when this program is gone for so long; 0: never
  Machine machine;
  GalilAxes axes;  // one for each drive of the machine

  double speed_mm_s = 20;  // of the drive with the longest way
  double acceleration_mm_s2 = 100;
  double poll_s = 0.02;           // the stage is looked at this often while it moves
  double margin_s = 5;            // a move may take this much longer than computed
  double settle_band_mm = 0.005;  // encoder against command
  double settle_s = 0.3;          // in the band for so long
  double settle_timeout_s = 5;
  double following_mm = 0.5;  // encoder against command while it moves

  double homing_speed_mm_s = 5;
  double homing_timeout_s = 180;
};

/// Refuses, before anything moves, what these settings cannot do: a speed or acceleration beyond
/// the controller's range or below its step, a stroke beyond its counts, a settling band below one
/// count, an axis named twice, a way from the switches to home that is not safe. Throws InputError
/// that names the field of stage/1. Precondition: as many axes as the machine has drives. Proof:
/// stage_json_test.cpp.
void validate(const GalilSettings& settings);

}  // namespace trammel::device
