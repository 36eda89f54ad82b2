#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/measure/reading.hpp"

namespace trammel {

/// A figure under the name a standard gives it, or the reason why it may not carry that name.
struct IsoSymbol {
  std::string name;             // "AP_p", "RP_l (n = 10)"
  bool is_angle = false;        // rad; else mm
  std::optional<double> value;  // absent: refused
  std::optional<double> floor;  // what a perfect robot would read of it, where that is known
  std::string reason;           // why refused, or the reserve under which it is given; may be empty
};

/// Gives each symbol that has a value the mean size that it takes where a perfect robot is read
/// with this noise: simulated copies of `readings`, each measured pose its target and noise,
/// from a fixed seed. `symbols_of`: the symbols of such a copy, in the order of `symbols`. For n
/// and the number of targets there are: R of ISO 230-2 reads 4 sigma on one target, 6.68 as the
/// largest of 11 with 5 runs each way. Proof: iso230_test.cpp, iso9283_test.cpp.
void add_floors(std::span<IsoSymbol* const> symbols, std::span<const Reading> readings,
                const TrackerSigma& sigma,
                const std::function<std::vector<IsoSymbol>(std::span<const Reading>)>& symbols_of);

/// "", or that visits drift from the first of a series to its last: the slope over the number of
/// the visit, common to all series, beyond chance (t test at `level`). Each series in mm, in the
/// order of its visits. Proof: false alarms counted (iso230_test.cpp).
std::string drift_words(std::span<const std::vector<double>> series_mm, double level = 0.01);

}  // namespace trammel
