#pragma once
// What a points file holds, place by place, before anybody makes readings of it.

#include <optional>
#include <string>
#include <vector>

#include "app/files/points_file.hpp"
#include "core/measure/point_outliers.hpp"

namespace trammel {

/// Which rows show the same place: those of one name, of one group, or all.
enum class PlaceBy { name, group, file };

struct PlaceLook {
  struct MissedRow {
    int line = 0;
    Miss why = Miss::zero;
  };
  struct Outlier {
    int line = 0;
    double distance_mm = 0;  // from the median
  };
  std::string place;
  int n = 0;  // points: neither missed nor outliers
  std::vector<MissedRow> misses;
  std::vector<Outlier> outliers;
  std::optional<double> limit_mm;  // beyond it a point is an outlier; none: too few points
  Eigen::Vector3d median_mm = Eigen::Vector3d::Zero();
  double rms_mm = 0;              // of the points' distances from the median, outliers left out
  std::optional<double> RP_l_mm;  // ISO 9283 with this n; from five points on
};

struct PointsLook {
  PlaceBy by = PlaceBy::name;
  int cycle = 0;  // rows without names went round so many nests; 0: they did not
  std::vector<PlaceLook> places;
  int n_without_u95 = 0;  // rows that state U(95) = 0: no estimate, not a perfect one
};

/// Looks at every place. Without `by`: by name where a name comes back, else by group, else the
/// whole file. `cycle` > 0: rows go round so many nests, "1" to "cycle", whatever they are called.
/// Throws InputError when the rows do not go round, and names the line where a named row is out of
/// turn. Proof: points_look_test.cpp.
PointsLook look_at(const PointsFile& file, std::optional<PlaceBy> by = {}, int cycle = 0,
                   const OutlierRule& rule = {});

}  // namespace trammel
