#pragma once
// Which row of a points file is which nest at which pose: by name, or by order.

#include <map>
#include <optional>
#include <regex>
#include <string>
#include <vector>

#include "app/files/layout.hpp"
#include "core/plan/plan.hpp"

namespace trammel {

using RowsOfNest = std::map<std::string, std::vector<const PointRow*>>;  // by nest, in file order

/// One standing of the platform that becomes one reading: a repeat, or all samples.
struct PoseRows {
  int pose = 0;    // seq in the plan
  int repeat = 1;  // from 1
  RowsOfNest rows;
};

/// One visit to the base nests, before the pose `before` (place in `poses`).
struct BaseRows {
  std::size_t before = 0;
  RowsOfNest rows;
};

struct AssignedRows {
  std::vector<PoseRows> poses;  // in the order of the file
  std::vector<BaseRows> base;
};

/// A row marked as deleted has been shot again and holds no place; other misses hold theirs. Every
/// other row is somebody's: throws InputError that names the line of a row that fits nowhere, a
/// pose that the plan lacks, a row out of turn (where the file names its points), or says how many
/// rows there should be and why. A planned pose without rows is no error: it was not measured.
/// Proof: points_campaign_test.cpp.
AssignedRows assign_rows(const PointsFile& file, const Layout& layout, const Plan& plan);

/// A name as a layout writes it: "p{pose}-{nest}". {pose} and {repeat} are digits, {nest} anything.
class NamePattern {
 public:
  explicit NamePattern(const std::string& pattern);

  /// What stands at the places, by their names; none: `text` does not fit.
  [[nodiscard]] std::optional<std::map<std::string, std::string>> match(
      const std::string& text) const;

 private:
  std::regex expression_;
  std::vector<std::string> places_;
};

}  // namespace trammel
