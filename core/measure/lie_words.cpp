#include "core/measure/lie_words.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/measure/printed.hpp"
#include "core/units.hpp"

namespace trammel {

using namespace poses;

namespace {

constexpr double kOneUnit = 0.02;     // two scales are one unit
constexpr double kTurnedAlike = 0.2;  // two turns are one within it

}  // namespace

const char* unit_of(double scale) {
  constexpr std::array<std::pair<double, const char*>, 6> kUnits = {
      {{1e-3, "metres"},
       {1 / 25.4, "inches"},
       {0.1, "centimetres"},
       {1 / 304.8, "feet"},
       {1e3, "micrometres"},
       {25.4, "converted from inches twice"}}};
  for (const auto& [unit, name] : kUnits) {
    if (std::abs(scale / unit - 1) < kOneUnit) return name;
  }
  return nullptr;
}

std::string unit_words(double scale) {
  const char* unit = unit_of(scale);
  return unit ? std::string("are ") + unit : printed("are %.4g times too large", scale);
}

std::vector<LiePart> parts_of(const Lie& l, const std::string& column) {
  std::vector<LiePart> parts;
  const Similarity& p = l.place;
  const double turn_deg = deg_from_rad(p.turn_rad);
  const bool similar = l.similar();
  const double offset = l.angle.offset_rad;
  const bool as_orientations =  // a turn of both, of which one alone passes the bound
      std::abs(offset) > kMostTurnedRad &&
      std::abs(wrapped(offset - p.turn_rad)) < kTurnedAlike * std::abs(offset);
  const bool turned = similar && (std::abs(p.turn_rad) > kMostTurnedRad || as_orientations);
  if (similar && std::abs(p.scale - 1) > kMostScaled) {
    parts.push_back({Mistake::scale, column + " x and y " + unit_words(p.scale)});
  }
  const bool sign = l.angle.slope == -1;
  if (similar && p.mirrored) {
    const auto is = [&](double deg) {
      return std::abs(std::remainder(turn_deg - deg, 360)) < deg_from_rad(kMostTurnedRad);
    };
    const std::string how = is(0)     ? "y has the wrong sign"
                            : is(180) ? "x has the wrong sign"
                            : is(90)  ? "x and y have changed places"
                            : is(-90) ? "x and y have changed places, both with the wrong sign"
                                      : printed("mirrored, and turned by %.3g deg", turn_deg);
    parts.push_back(
        {Mistake::frame_mirrored, "the frame of the " + column + " poses is mirrored: " + how +
                                      (sign ? ", orientations count the other way" : "")});
  } else if (sign) {
    parts.push_back({Mistake::frame_mirrored, column + " orientations count the wrong way round"});
  }
  if (turned && !p.mirrored) {
    const bool with_them = std::abs(wrapped(l.angle.offset_rad - p.turn_rad)) < kMostTurnedRad;
    parts.push_back({Mistake::frame_turned,
                     (with_them ? "the frame of the " + column + " poses is turned by "
                                : column + " positions are turned about the origin by ") +
                         printed("%.3g deg", turn_deg) +
                         (with_them ? "" : ", orientations are not")});
  }
  if (similar) {
    const Complex middle = p.shift_mm;
    if (std::abs(middle) > kMostShiftedMm * p.scale) {
      parts.push_back({Mistake::frame_shifted,
                       (parts.empty() ? "the frame of the " + column + " poses is shifted by "
                                      : std::string("shifted by ")) +
                           printed("(%.4g, %.4g) mm", middle.real(), middle.imag())});
    }
  }
  const auto unit = std::ranges::find(kAngleUnits, l.angle.slope, &AngleUnit::slope);
  if (unit != kAngleUnits.end()) {
    parts.push_back({Mistake::radians, column + " orientations " + unit->words +
                                           printed(" (slope %.4g)", unit->slope)});
  }
  const double own = wrapped(l.angle.offset_rad - (turned && !p.mirrored ? p.turn_rad : 0));
  const bool with_turn = turned && std::abs(l.angle.offset_rad) < kMostTurnedRad;
  if (l.angle.slope == 1 && !p.mirrored && !with_turn && std::abs(own) > kMostTurnedRad) {
    parts.push_back(
        {Mistake::phi_offset,
         "all " + column + printed(" orientations are %.4g deg off", deg_from_rad(own))});
  }
  return parts;
}

}  // namespace trammel
