#pragma once
// What a fit tells about its parameters, for a person and for a program: the same for the paper's
// linear system and for the nonlinear one.

#include <string>
#include <vector>

#include "app/job/correction_json.hpp"
#include "core/calibrate/goodness.hpp"
#include "core/calibrate/identifiability.hpp"

namespace trammel::job {

/// A fit's parameters: values and covariance in mm and rad, covariance from the noise alone.
struct Identification {
  const Identifiability& known;
  const std::vector<ScaledParameter>& parameters;
  Eigen::VectorXd values;
  Eigen::MatrixXd covariance;
  std::size_t n_geometry = 0;  // the first so many are machined: the others have no tolerance
  Goodness goodness;
};

struct IdentificationReport {
  Json details;
  std::vector<std::string> words;
};

/// In `details` rank, observability, every parameter (a number only beside one that is identified
/// by itself), the base parameters ("identified", less those that were dropped: they have no
/// variance), strong correlations, and parameters far outside their machining tolerance
/// ("beyond_tolerance"). Standard uncertainties are scaled by goodness.scale. In `words` the same
/// in sentences, with U (k = 2): what is identified and what is not, the absorption alarm, and what
/// the residuals say of the model.
IdentificationReport identification_report(const Identification& of);

/// A table of the base parameters in a job's details: name, change from nominal, U (k = 2), unit.
std::string identified_table(const Json& details);

}  // namespace trammel::job
