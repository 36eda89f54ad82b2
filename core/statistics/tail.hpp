#pragma once
// How rarely chance alone goes as far as it went.

namespace trammel {

/// P(|T| > |t|) for Student's t of `degrees` of freedom: what student_limit turns round.
/// Precondition: degrees > 0. Proof: tests/core/statistics/limits_test.cpp.
double student_tail(double t, double degrees);

}  // namespace trammel
