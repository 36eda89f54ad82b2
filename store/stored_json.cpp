#include "store/stored_json.hpp"

#include <algorithm>

namespace trammel::store {

namespace {

constexpr int kDeepest = 64;

int depth_of(std::string_view json) {
  int depth = 0, deepest = 0;
  bool in_text = false;
  for (std::size_t k = 0; k < json.size(); ++k) {
    const char c = json[k];
    if (in_text && c == '\\') {
      ++k;
    } else if (c == '"') {
      in_text = !in_text;
    } else if (!in_text && (c == '[' || c == '{')) {
      deepest = std::max(deepest, ++depth);
    } else if (!in_text && (c == ']' || c == '}')) {
      --depth;
    }
  }
  return deepest;
}

}  // namespace

std::string stored_json(const Statement& row, int column) {
  std::string json = row.text(column);
  if (depth_of(json) > kDeepest) {
    throw StoreError({.what = "stored JSON is nested too deeply",
                      .expected = "at most " + std::to_string(kDeepest) + " levels",
                      .hint = "this program did not write it: see `trammel db verify`"});
  }
  return json;
}

}  // namespace trammel::store
