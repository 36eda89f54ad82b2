#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "app/device/device.hpp"

namespace trammel::device {

/// A tracker as its file tells it. Nothing is connected yet.
struct TrackerFile {
  std::string kind;       // "t2sa", "file"
  bool emulated = false;  // what answers is a program: its campaigns are simulated ones
  TrackerSigma sigma;     // of a pose
  double measure_s = 0;   // one pose takes about so long
  std::unique_ptr<Tracker> tracker;
  std::unique_ptr<Thermometer> thermometer;
};

/// "format": "tracker/1" with "source" {type "t2sa", host, port, …} or {type "file", file, …},
/// two or three "nests" {name, x_mm, y_mm, z_mm, point} in the platform's frame (or, behind t2sa,
/// an "object" {group, reference, sigma_xy_mm, sigma_phi_deg}), "base_frame" (the tracker's frame
/// in the base's) or, behind t2sa, "base_nests" to find it by, "sigma_mm", "u_nest_mm",
/// "out_of_plane_mm", "symmetric_because" (a reason for a triangle with equal sides) and
/// "temperature" {source "fixed", "file" or "tracker"}. Files are looked for beside this one.
/// Throws InputError with file, line and field. Proof: tracker_json_test.cpp.
TrackerFile read_tracker(const std::filesystem::path& path);

/// The same from text; `path` stands in errors, and the files it names are beside it.
TrackerFile parse_tracker(std::string_view text, const std::filesystem::path& path);

}  // namespace trammel::device
