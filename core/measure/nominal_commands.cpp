#include "core/measure/nominal_commands.hpp"

#include <algorithm>

#include "core/mechanism/machine_solver.hpp"

namespace trammel {

std::vector<double> command_off_mm(const Campaign& c) {
  const MachineSolver solver(c.machine);
  std::vector<double> off_mm;
  for (const Reading& r : c.readings) {
    const InverseResult at = solver.drives(r.target);
    off_mm.push_back(at.ok() ? (r.conditions.cmd_mm - at.l_mm).cwiseAbs().maxCoeff() : 0);
  }
  return off_mm;
}

bool single_far_command(const std::vector<double>& off_mm, std::size_t reading) {
  const auto is_far = [](double mm) { return mm > kMostCorrectionMm; };
  return is_far(off_mm[reading]) && 2 * std::ranges::count_if(off_mm, is_far) < std::ssize(off_mm);
}

std::vector<std::size_t> under_a_correction(const Campaign& c) {
  const std::vector<double> off_mm = command_off_mm(c);
  const auto is_other = [](double off) { return off > kNominalCommandMm; };
  std::vector<std::size_t> corrected;
  if (std::ranges::all_of(off_mm, is_other)) return corrected;
  for (std::size_t k = 0; k < off_mm.size(); ++k) {
    if (is_other(off_mm[k]) && off_mm[k] < kMostCorrectionMm) corrected.push_back(k);
  }
  return corrected;
}

}  // namespace trammel
