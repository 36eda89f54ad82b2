#pragma once
// Units are converted here and nowhere else: mm and rad inside, degrees and hours at the edges.

#include <numbers>

namespace trammel {

inline constexpr double kPi = std::numbers::pi;

constexpr double rad_from_deg(double deg) { return deg * (kPi / 180.0); }
constexpr double deg_from_rad(double rad) { return rad * (180.0 / kPi); }

inline constexpr double kSecondsPerHour = 3600.0;
inline constexpr double kReferenceTemperatureDegc = 20.0;  // ISO 1

}  // namespace trammel
