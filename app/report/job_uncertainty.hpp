#pragma once
// U of the targets of a stored job, the same for every command that prints it.

#include <optional>
#include <string>
#include <vector>

#include "app/job/fitted_range.hpp"
#include "app/report/measured.hpp"
#include "core/calibrate/uncertainty.hpp"
#include "core/measure/noise.hpp"

namespace trammel::report {

/// The fitted readings, each under a correction that never saw its spatial block.
struct CrossValidated {
  int blocks = 0;
  std::vector<Pose> after;
  std::vector<std::string>
      outside;  // why it is out of what its correction was fitted to; "": in it
};

struct JobUncertainty {
  std::vector<Reading> fitted;
  FittedRange range;
  std::optional<CrossValidated> cross_validated;  // only where no reading is held out
  std::string why_not_validated;
  std::optional<PointUncertainty> of;  // none without a sigma, or with too few readings to know
  std::optional<double> rms_mm;        // of the standard uncertainties of what judges it, in range
};

/// What the correction knows of itself, widened by what its held-out errors in range show beyond it
/// (calibrated), else by these alone: all baseline readings that its fit has not seen, or the
/// fitted ones cross-validated over spatial blocks where there are none. It points into `measured`.
/// Throws as trained_on. Proof: assess_test.cpp, speakers_agree_test.cpp.
JobUncertainty uncertainty_of(store::Connection& connection, const Measured& measured,
                              const store::Job& job, const std::optional<NoiseLevel>& noise);

}  // namespace trammel::report
