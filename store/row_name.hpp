#pragma once
// How a row is named whose number may be what the damage made of it.

#include <string>

#include "store/statement.hpp"

namespace trammel::store {

/// What goes behind a row's name: the row before it, unless the number is the one that follows.
/// Without a name for that one it is the first row.
inline std::string after(Id id, Id previous, const std::string& previous_name) {
  if (id == previous + 1) return "";
  return previous_name.empty() ? ", the first row" : ", the row after " + previous_name;
}

}  // namespace trammel::store
