#pragma once

#include <string>

namespace trammel::terminal {

/// Decimals of errors in mm or deg, in all tables and sentences for a person: four, a tenth of a
/// micrometre, where a tracker reads 10; of a finer machine as many as show two digits of `least`,
/// what a perfect reading has (GUM 7.2.6: an uncertainty is stated to two digits). At most nine.
/// Proof: text_test.cpp.
int decimals_of(double least);

/// One value to so many decimals as show two digits of it, four at least; never "-0.0000".
std::string figure_text(double value);

}  // namespace trammel::terminal
#include "app/terminal/decimals.hpp"
