#pragma once

#include "core/simulate/truth.hpp"

namespace trammel::simulate {

/// Throws InputError that names the first field of the truth that makes no robot: not finite, a
/// negative sigma, a time constant or speed that is not positive, a rail that is not 0, 1, 2.
void check(const Truth& truth);

}  // namespace trammel::simulate
