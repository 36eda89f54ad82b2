#pragma once
// Whether an error meets a tolerance, where the error is only known to +-U.

#include <span>

namespace trammel {

enum class Conformity { passes, fails, undecided };
const char* name_of(Conformity conformity);  // "passes", "fails", "undecided"

/// An error of `error_mm` >= 0, known to `U_mm` (expanded, k = 2), against the largest allowed. The
/// tolerance is narrowed by U to accept, widened by U to reject (the guard band):
///   passes   e + U <= T
///   fails    e - U >  T
///   else     undecided: the readings can't tell
/// Source: ISO 14253-1, its simple acceptance and rejection zones of width U, from general
/// knowledge: to be checked against the standard before anyone certifies by it.
/// @throws InputError  T not positive or not finite, U negative or not finite
/// Proof: tolerance_test.cpp.
Conformity conformity(double error_mm, double U_mm, double tolerance_mm);

/// Of the machine that the points stand for: it fails where one point fails, passes where all do.
/// Undecided without a point.
Conformity conformity_of_all(std::span<const Conformity> points);

}  // namespace trammel
