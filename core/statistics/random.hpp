#pragma once
// Seeded generators of our own: the standard's distributions differ between libraries, and a re-run
// must give the same bits everywhere.

#include <cstdint>
#include <random>
#include <string_view>

namespace trammel {

/// Uniform and normal numbers from mt19937_64 (whose sequence the standard fixes).
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  /// A stream of its own for `purpose` and `index`: what is drawn for one reading does not depend
  /// on how many were drawn before it.
  static Random stream(std::uint64_t seed, std::string_view purpose, std::uint64_t index = 0);

  double uniform();                         // [0, 1), 53 bits
  double uniform(double low, double high);  // [low, high)
  double normal();                          // mean 0, standard deviation 1 (polar method)
  std::uint64_t below(std::uint64_t n);     // 0 … n-1, unbiased

 private:
  std::mt19937_64 engine_;
  double spare_ = 0;
  bool has_spare_ = false;
};

/// 64 bits that depend on every byte of `text` and on `seed` (FNV-1a, then splitmix64).
std::uint64_t mix(std::uint64_t seed, std::string_view text, std::uint64_t index);

}  // namespace trammel
