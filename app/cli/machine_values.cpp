#include "app/cli/machine_values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "app/files/numbers.hpp"
#include "core/error.hpp"
#include "core/units.hpp"

namespace trammel::cli {

std::vector<double> numbers_of(const Machine& machine, const std::vector<std::string>& typed,
                               const char* field) {
  std::vector<double> all;
  for (const std::string& word : typed) {
    int count = 0;
    for (std::size_t from = 0; from <= word.size(); ++count) {
      const std::size_t to = std::min(word.find(',', from), word.size());
      const auto number = parse_number(std::string_view(word).substr(from, to - from));
      if (!number) {
        throw UsageError({.what = "no number", .where = {.field = field}, .got = word});
      }
      all.push_back(*number);
      from = to + 1;
    }
    if (count > 1 && count != machine.kind->n_chains) {
      throw UsageError({.what = "not a pose of this machine",
                        .where = {.field = field},
                        .got = word,
                        .expected = fmt::format("{} numbers of an {} machine: {}",
                                                machine.kind->n_chains, machine.kind->name,
                                                "x mm, y mm, phi deg, as far as it has them")});
    }
  }
  return all;
}

std::vector<Eigen::Vector3d> groups(const Machine& machine, const std::vector<double>& values,
                                    const char* field) {
  const auto n = static_cast<std::size_t>(machine.kind->n_chains);
  constexpr std::array<const char*, 3> kTimes = {"one by one", "in twos", "in threes"};
  if (values.size() % n != 0) {
    throw UsageError({.what = fmt::format("numbers of this {} machine come {}", machine.kind->name,
                                          kTimes[n - 1]),
                      .where = {.field = field},
                      .got = fmt::format("{} numbers", values.size())});
  }
  std::vector<Eigen::Vector3d> all;
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (k % n == 0) all.emplace_back(Eigen::Vector3d::Zero());
    all.back()[static_cast<Eigen::Index>(k % n)] = values[k];
    if (!std::isfinite(values[k])) {
      throw UsageError({.what = "a number that is not finite", .where = {.field = field}});
    }
  }
  return all;
}

std::vector<Eigen::Vector3d> typed_poses(const Machine& machine, const std::vector<double>& typed,
                                         const char* field) {
  std::vector<Eigen::Vector3d> all = groups(machine, typed, field);
  for (Eigen::Vector3d& v : all) v[2] = rad_from_deg(v[2]);
  return all;
}

Pose pose_on(const Machine& machine, const Eigen::Vector3d& values) {
  Eigen::Vector3d pose = machine.home.vector();
  const int n = machine.kind->n_chains;
  pose.head(n) = values.head(n);
  return Pose::from(pose);
}

std::string cells_of(const Machine& machine, const Eigen::Vector3d& v, int width, int decimals,
                     const char* between) {
  std::string text;
  for (int i = 0; i < machine.kind->n_chains; ++i) {
    text += fmt::format("{}{:>{}.{}f}", i == 0 ? "" : between, rounded(v[i], decimals), width,
                        decimals);
  }
  return text;
}

std::string pose_header(const Machine& machine, int width) {
  constexpr std::array<const char*, 3> kHeads = {"x mm", "y mm", "phi deg"};
  std::string text;
  for (std::size_t c = 0; c < static_cast<std::size_t>(machine.kind->n_chains); ++c) {
    text += fmt::format("{}{:>{}}", c == 0 ? "" : " ", kHeads[c], width);
  }
  return text;
}

std::string drive_header(const Machine& machine, int width) {
  std::string text;
  for (int i = 1; i <= machine.kind->n_chains; ++i) {
    text += fmt::format("{}{:>{}}", i == 1 ? "" : " ", fmt::format("l{} mm", i), width);
  }
  return text;
}

double usual_half_width_mm(const Machine& machine) {
  double half_stroke_mm = 0;
  for (int i = 0; i < machine.kind->n_chains; ++i) {
    const Limits& limits = machine.drives[static_cast<std::size_t>(i)].limits;
    half_stroke_mm = std::max(half_stroke_mm, (limits.l_max_mm - limits.l_min_mm) / 2);
  }
  return std::min(100.0, half_stroke_mm);
}

double usual_step_mm(double half_width_mm) {
  constexpr double kSmallMm = 20, kStepMm = 10;
  return half_width_mm < kSmallMm ? half_width_mm / 10 : kStepMm;
}

Eigen::Vector3d shown_pose(const Pose& pose) {
  return {pose.x_mm, pose.y_mm, deg_from_rad(pose.phi_rad)};
}

}  // namespace trammel::cli
