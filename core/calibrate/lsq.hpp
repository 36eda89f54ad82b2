#pragma once
// The paper's first method: one overdetermined linear system of all readings.

#include <array>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/calibrate/identifiability.hpp"
#include "core/measure/reading.hpp"
#include "core/model/robot_model.hpp"

namespace trammel {

struct LsqOptions {
  bool complete = false;       // the 21 of the complete base instead of the paper's 18
  bool shared_epochs = false;  // no columns of their own for later epochs
  bool basic_solution =
      false;              // what is not identified stays zero (the paper's) instead of least change
  double drop_below = 0;  // repeated identification: sources below this share of their tolerance
                          // are dropped and the rest is solved again; 0: no repetition
  double attitude_weight = 1;  // times 1 / sigma of phi: above 1 where attitude must not pay for
                               // position
};

/// One parameter of the solution. Where it is not identified by itself the value is one of many
/// that fit equally well, and nothing but a computation may use it.
struct LsqParameter {
  ScaledParameter parameter;
  int epoch = 1;                    // later epochs have parameters of their own
  double value = 0;                 // change from nominal, mm or rad
  bool identified = false;          // by itself
  bool dropped = false;             // by repeated identification
  double standard_uncertainty = 0;  // from the readings' sigmas; meaningful when identified
};

struct LsqRound {
  int columns = 0;
  int rank = 0;
  double weighted_rss = 0;
  std::vector<std::string> dropped;  // after this round
};

struct LsqResult {
  std::vector<LsqParameter> parameters;
  Eigen::MatrixXd covariance;        // of the parameters, mm and rad, from the sigmas alone
  Geometry geometry;                 // nominal plus the solution
  std::map<int, EpochShift> epochs;  // of later epochs with columns of their own
  Identifiability identifiability;   // of the full set of columns
  std::vector<LsqRound> rounds;
  int n_equations = 0;
  int steps = 1;                  // times the system was linearised and solved
  int rank = 0;                   // of the last round
  double weighted_rss = 0;        // what was minimised: with phi weighted as asked, last round
  double chi2 = 0;                // sum of squared residuals in the tracker's standard deviations
  double position_rms_sigma = 0;  // residuals of x and y, in the tracker's standard deviations
  double attitude_rms_sigma = 0;  // and of phi
  double sigma_ratio =
      0;  // sqrt(chi2 / (equations - rank)): 1 when noise explains all; 0 when none is left

  [[nodiscard]] Eigen::VectorXd values() const;  // of the parameters, mm and rad
};

/// Identifies the error sources: min over d of sum |W_j (delta X_j - J_e d)|^2              (21)
///   delta X_j = measured pose - nominal forward kinematics of the *commanded* displacements; J_e
///   of error_model.hpp, linearised there (that is the target, for readings without compensation);
///   W = 1 / sigma for x, y [mm] and phi [rad] of the tracker; phi's times the attitude weight.
/// Fits the readings it is given: choose the identify rows before. Every later epoch has three
/// joint zeros and a frame offset (x, y, phi) of its own, unless shared. Solved by QR and the
/// singular value decomposition in tolerances; directions that carry nothing stay at nominal
/// (identifiability.hpp). Throws InputError for readings without pose or out of reach, sigmas that
/// are not positive, and fewer equations than rank leaves free. Source: Zhang et al. 2024,
/// Secs. 3.4, 3.5. Proof: ranks and sums of an independent program to 1e-6, recovery on unseen
/// poses (lsq_test.cpp).
LsqResult identify_linear(const Mechanism& mechanism, std::span<const Reading> readings,
                          const TrackerSigma& sigma, const LsqOptions& options = {});

/// The same, linearised again at what was found and solved for the rest (Gauss-Newton, by the
/// normal equations in the directions that the first system determined), until the next step, as
/// the last ones shrink, would change nothing (1e-6 tolerances), `steps` times at most. The
/// first-order system alone overshoots where an error that it lacks (a drive's gain) drives
/// parameters far from nominal. What the first step dropped, or a basic solution left out, stays
/// out. Values are changes from nominal; rank, rounds and uncertainties are those of the first
/// system. Throws as identify_linear. Proof: the gradient at the end vanishes, with drops and later
/// epochs too (lsq_test.cpp).
LsqResult identify_repeated(const Mechanism& mechanism, std::span<const Reading> readings,
                            const TrackerSigma& sigma, const LsqOptions& options, int steps);

}  // namespace trammel
