#include "core/calibrate/joint_error.hpp"

#include <cmath>
#include <string>

#include "core/error.hpp"
#include "core/plane/place.hpp"

namespace trammel {

Eigen::Vector3d joint_error_mm(const NominalMachine& machine, const Reading& reading) {
  const auto point = [&] { return "seq " + std::to_string(reading.seq); };
  if (!reading.measured) {
    throw InputError({.what = "this reading has no measured pose", .where = {.point = point()}});
  }
  const InverseResult at = machine.chains(*reading.measured);
  if (!at.ok()) {
    throw InputError({.what = "the measured pose is out of the nominal robot's reach",
                      .where = {.point = point()},
                      .got = "chain " + std::to_string(at.chain + 1) + " cannot reach it",
                      .hint = "exclude the reading with a reason if it is an outlier"});
  }
  return at.l_mm - reading.conditions.cmd_mm;
}

void require_all_measured(const NominalMachine& machine) {
  if (machine.measures_all()) return;
  std::string read, moved;
  for (std::size_t c = 0; c < 3; ++c) {
    const std::string name = (read.empty() ? "" : ", ") + std::string(kCoordinateNames[c]);
    if (machine.machine().measured[c]) read += name;
    if (static_cast<int>(c) < machine.machine().kind->n_chains)
      moved += (moved.empty() ? "" : ", ") + std::string(kCoordinateNames[c]);
  }
  throw InputError(
      {.what = "a map of joint errors needs every coordinate that the machine moves",
       .where = {.field = "measured"},
       .got = read,
       .expected = moved,
       .hint = "`trammel calibrate geometry` and `trammel diagnose` fit what is measured"});
}

std::vector<JointSample> joint_samples(const NominalMachine& machine,
                                       std::span<const Reading> readings) {
  std::vector<JointSample> samples;
  samples.reserve(readings.size());
  require_all_measured(machine);
  for (const Reading& r : readings) {
    samples.push_back({r.target.x_mm, r.target.y_mm, joint_error_mm(machine, r)});
  }
  return samples;
}

std::vector<JointSample> merge_places(std::span<const JointSample> samples) {
  std::vector<Place> places;
  for (const JointSample& s : samples) places.push_back({s.x_mm, s.y_mm});
  const std::vector<std::size_t> groups = group_places(places);
  std::vector<JointSample> merged;
  std::vector<double> counts;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (groups[k] == merged.size()) {
      merged.push_back(samples[k]);
      counts.push_back(1);
    } else {
      merged[groups[k]].error_mm += samples[k].error_mm;
      counts[groups[k]] += 1;
    }
  }
  for (std::size_t k = 0; k < merged.size(); ++k) {
    if (counts[k] > 1) merged[k].error_mm /= counts[k];
  }
  return merged;
}

void require_places(std::span<const JointSample> samples, std::size_t needed) {
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const JointSample& s = samples[k];
    if (std::isfinite(s.x_mm) && std::isfinite(s.y_mm) && s.error_mm.allFinite()) continue;
    throw InputError({.what = "a sample of the map is not finite",
                      .where = {.point = "sample " + std::to_string(k + 1)},
                      .expected = "finite numbers"});
  }
  const std::size_t places = merge_places(samples).size();
  if (places >= needed) return;
  throw InputError({.what = "a map of position cannot be made from these readings",
                    .got = std::to_string(samples.size()) +
                           (samples.size() == 1 ? " reading in " : " readings in ") +
                           std::to_string(places) + (places == 1 ? " place" : " places"),
                    .expected = "at least " + std::to_string(needed) + " different places",
                    .hint = "measure points spread over the workspace"});
}

}  // namespace trammel
