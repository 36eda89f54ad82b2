#pragma once
// Is there structure in residuals? Many tests, one calibrated false-alarm rate.

#include <cstdint>
#include <string>
#include <vector>

#include "core/diagnose/dictionary.hpp"
#include "core/diagnose/residual_space.hpp"

namespace trammel {

/// Where residuals are not white, with the p of that one test (not corrected for the others).
struct Finding {
  std::string where;
  std::string when;
  double p = 1;
  double chi2 = 0;  // what the shape takes out of the sum of squares, in units of the noise
  int terms = 0;
};

inline constexpr const char* kSuccessiveAgree = "successive readings agree";
inline constexpr const char* kSuccessiveAlternate = "successive readings alternate";

struct StructureOptions {
  int replicates = 2000;  // where the smallest p leaves it open; a tenth of them otherwise
  double level = 0.005;   // the smallest p above this can't be significant for the family
  std::uint64_t seed = 1;
  int threads = 2;        // never changes a result
  bool exchange = false;  // null: the residuals of the readings, in another order and with random
                          // signs, in place of normal noise: whatever their distribution is
};

struct StructureTest {
  double family_p = 1;  // of the smallest p among all tests, by parametric bootstrap
  int tests = 0;
  std::vector<Finding> findings;  // by rising p
};

/// Tests the residual of `space` against every shape, and against neighbours in space and in time.
///
/// A shape with orthonormal basis U of M D takes q = |U' r|^2 out of the sum; F = (q / k) / s^2
/// with s^2 = (|r|^2 - q) / (dof - k), its p by chi^2(k). Neighbours: Moran's I over the 4 nearest
/// readings in the plane, and the correlation of successive readings, as |z| against the bootstrap.
/// The null of the smallest p: white noise through the same projection (the refit), `replicates`
/// times. False alarms: counted on clean campaigns in core/diagnose/README.md.
StructureTest test_structure(const ResidualSpace& space, const std::vector<Shape>& shapes,
                             const StructureOptions& options = {});

/// How many standard deviations successive readings of an epoch agree more than white noise would,
/// once `removed` has been fitted to them as well.
double successive_agreement(const ResidualSpace& space, const std::vector<Shape>& removed);

}  // namespace trammel
