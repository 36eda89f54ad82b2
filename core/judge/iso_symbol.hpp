#pragma once

#include <optional>
#include <string>

namespace trammel {

/// A figure under the name a standard gives it, or the reason why it may not carry that name.
struct IsoSymbol {
  std::string name;             // "AP_p", "RP_l (n = 10)"
  bool is_angle = false;        // rad; else mm
  std::optional<double> value;  // absent: refused
  std::optional<double> floor;  // what a perfect robot would read of it, where that is known
  std::string reason;           // why refused, or the reserve under which it is given; may be empty
};

}  // namespace trammel
