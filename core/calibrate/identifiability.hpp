#pragma once
// What a set of readings can tell about parameters, and what it cannot, in numbers and in words.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace trammel {

/// A parameter of a linearised model, in mm or rad (shown in mm or deg), or in a unit of its own.
struct ScaledParameter {
  std::string name;
  bool is_angle = false;
  double tolerance =
      0;  // one standard deviation of machining and assembly: the unit columns are in
  std::string unit = {};  // where it is neither a length nor an angle
};

/// Observability indices of the identifiable directions (m = rank), from the singular values s_1 >=
/// … >= s_m of the whitened Jacobian in tolerances, N poses. Unspecified scaling in the literature:
/// compare designs with each other, not with other programs.
struct Observability {
  double O1 = 0;  // (prod s)^(1/m) / sqrt(N)
  double O2 = 0;  // s_m / s_1
  double O3 = 0;  // s_m
  double O4 = 0;  // s_m^2 / s_1
  double O5 = 0;  // 1 / sum(1 / s_i)
};

/// A combination of parameters that no reading feels.
struct NullDirection {
  Eigen::VectorXd change;    // mm, rad; the largest is one tolerance
  int pivot = 0;             // changes in this direction alone: the parameter that it gives up
  std::vector<int> members;  // whose change is more than 5 % of a tolerance
  std::string sentence;
};

/// Rank, base directions and null space of a whitened Jacobian.
///
/// In tolerances, a singular value s says: moving the model by one tolerance along this direction
/// moves all readings together by s standard deviations; 1/s tolerances is the standard deviation
/// the readings give it. A direction counts when s >= kLeastSignal: what is known no better than
/// 1/kLeastSignal tolerances is not known. rank_machine counts what rounding alone leaves nonzero:
/// a larger number than rank means directions that only noise fills.
struct Identifiability {
  Eigen::VectorXd singular;  // falling, shape (n)
  int rank = 0;
  int rank_machine = 0;
  int n_poses = 0;
  Eigen::MatrixXd directions;  // orthonormal in tolerances, the first `rank` are identified, (n, n)
  std::vector<bool> identified;  // parameter k by itself, not only in combinations
  std::vector<NullDirection> null_space;
  Observability observability;
};

inline constexpr double kLeastSignal = 0.05;

/// `A`: rows in standard deviations, columns in tolerances, shape (3 n_poses, n). Proof: ranks of
/// an independent program, sentences for known ties (identifiability_test.cpp).
Identifiability identifiability(const Eigen::MatrixXd& A,
                                const std::vector<ScaledParameter>& parameters);
/// The same of a square `A` that a QR has left of the rows of `n_poses`.
Identifiability identifiability(const Eigen::MatrixXd& A,
                                const std::vector<ScaledParameter>& parameters, int n_poses);

/// A base parameter: what readings know of one parameter that no null direction gives up.
struct IdentifiedCombination {
  std::string name;             // "S_2"; "l_2 - R_2": the parameter, and what acts together with it
  std::string unit;             // deg, mm, or the parameter's own
  bool is_angle = false;        // value in rad, unit deg
  bool alone = true;            // one parameter by itself
  std::vector<int> members;     // the parameters of the name, the leading one first
  Eigen::VectorXd of;           // coefficients of all parameters, shape (n)
  std::optional<double> value;  // of . parameters, mm or rad, once they have been fitted
  double standard_uncertainty = 0;
};

/// The `rank` base parameters of a linearised model (the standard reduction of robot calibration:
/// Khalil and Dombre 2002, Ch. 9): with every null direction n_i written so that it alone changes
/// its pivot,
///   b_j = p_j - sum_i (n_i[j] / n_i[pivot_i]) p_(pivot_i),   j no pivot,
/// which no null direction changes. `values` (mm, rad; may be empty) and their `covariance` give
/// value and uncertainty. Proof: unmoved by every null direction, as many as the rank, and 95 %
/// intervals that cover (identifiability_test.cpp).
std::vector<IdentifiedCombination> identified_combinations(
    const Identifiability& of, const std::vector<ScaledParameter>& parameters,
    const Eigen::MatrixXd& covariance, const Eigen::VectorXd& values = {});

/// Two base parameters that the readings tell apart badly.
struct Correlation {
  int a = 0, b = 0;  // places among the combinations
  double r = 0;
};
inline constexpr double kStrongCorrelation = 0.9;

/// Pairs with |r| of kStrongCorrelation or more, the strongest first.
std::vector<Correlation> strong_correlations(const std::vector<IdentifiedCombination>& of,
                                             const Eigen::MatrixXd& covariance);

/// Covariance of the parameters in mm and rad, on the identified directions alone (GUM, known
/// noise).
Eigen::MatrixXd covariance(const Identifiability& of,
                           const std::vector<ScaledParameter>& parameters);

/// Sentences for a person: the rank, what is judged by it, one per direction that is missing, what
/// is known of the parameters in it with U (k = 2), and what is strongly correlated.
std::vector<std::string> in_words(const Identifiability& of,
                                  const std::vector<ScaledParameter>& parameters,
                                  const std::vector<IdentifiedCombination>& known,
                                  const std::vector<Correlation>& correlated = {});

}  // namespace trammel
