#pragma once
// A correction as a table of one drive: what controllers take that correct each drive by its own
// position alone.

#include <span>
#include <vector>

namespace trammel {

/// Values at evenly spaced knots, straight between them, constant beyond the ends.
struct DriveTable {
  double first_mm = 0;
  double step_mm = 1;
  std::vector<double> values_mm;

  [[nodiscard]] double at(double position_mm) const;
  [[nodiscard]] double knot_mm(std::size_t k) const {
    return first_mm + step_mm * static_cast<double>(k);
  }
};

/// The correction of a drive where it stands.
struct DriveSample {
  double position_mm = 0;
  double correction_mm = 0;
};

/// The table at multiples of `step_mm` over all positions that leaves least of the samples,
///   minimise sum_s (c_s - t(l_s))^2 + w sum_k (t_k-1 - 2 t_k + t_k+1)^2
/// the second sum (w = 1e-6 samples a knot) so that knots without samples lie straight between
/// others. Proof: drive_table_test.cpp.
/// @throws InputError  no samples, a step that is not positive, fewer than 2 or more than
///                     `most_knots` knots
DriveTable fit_drive_table(std::span<const DriveSample> samples, double step_mm,
                           std::size_t most_knots);

/// What a table leaves of the samples.
struct TableError {
  double rms_mm = 0, max_mm = 0;
};
TableError error_left(std::span<const DriveSample> samples, const DriveTable& table);

}  // namespace trammel
