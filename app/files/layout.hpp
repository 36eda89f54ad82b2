#pragma once
// layout/1: what a tracker's file of points means, so that readings can be made of it.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "app/files/points_file.hpp"
#include "core/measure/nests.hpp"

namespace trammel {

/// Where the base frame comes from.
enum class FrameFrom {
  robot,       // the points are in the robot's frame O_A-XY already
  base_nests,  // nests on the base, measured in the same file
  zeroing,     // the plane of motion, and the platform standing at home: as in the paper
};

struct Layout {
  struct Frame {
    FrameFrom from = FrameFrom::robot;
    std::vector<NestPoint> base = {};               // base_nests: their places in the robot's frame
    Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  // zeroing: tracker's axis on the side of +Z
    double false_alarm = 0.001;  // of the check that the base nests have not moved
  };
  /// How rows become poses.
  struct Rows {
    bool by_name = false;
    // by name: how the file writes them; {pose}, {nest}, {repeat} stand for what differs
    std::string point = {};
    std::string group = {};
    // by order
    std::vector<std::string> nests = {};  // of one round
    int repeats = 1;                      // rounds at each pose
    int base_every = 0;  // base nests come first, after so many poses, and last; 0: first only
    // both
    bool mean_of_samples = false;  // the rows of a nest at a pose are samples of one reading
  };

  std::string file;  // the layout's own, as errors show it
  std::string name;  // of the campaign
  bool simulated = false;
  std::string mechanism = {};  // files, relative to the layout's folder; empty: from the options
  std::string plan = {};
  PointsOptions points = {};
  NestFrame body = {};  // nests, u_nest, false alarm; T_B_T is found later
  double sigma_mm = 0;  // of one coordinate of one point
  Frame frame = {};
  Rows rows = {};
  std::map<std::string, std::string> facts = {};
};

/// Throws InputError with file, line and field: an unknown field, no unit, no kind, nests that are
/// less than two or share a name, a template without {pose} or {nest}. NotFoundError. Proof:
/// layout_test.cpp; examples/tracker-files; schemas/layout.schema.json.
Layout read_layout(const std::filesystem::path& path);

}  // namespace trammel
