#pragma once

namespace trammel {

/// A place in the plane, mm.
struct Place {
  double x_mm = 0;
  double y_mm = 0;
};

}  // namespace trammel
