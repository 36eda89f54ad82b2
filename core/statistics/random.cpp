#include "core/statistics/random.hpp"

#include <cmath>

namespace trammel {

namespace {

std::uint64_t splitmix64(std::uint64_t z) {
  z += 0x9e3779b97f4a7c15ULL;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

}  // namespace

std::uint64_t mix(std::uint64_t seed, std::string_view text, std::uint64_t index) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  return splitmix64(splitmix64(splitmix64(seed) ^ hash) ^ index);
}

Random Random::stream(std::uint64_t seed, std::string_view purpose, std::uint64_t index) {
  return Random(mix(seed, purpose, index));
}

double Random::uniform() { return static_cast<double>(engine_() >> 11) * 0x1.0p-53; }

double Random::uniform(double low, double high) { return low + (high - low) * uniform(); }

double Random::normal() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  double u = 0, v = 0, s = 0;
  do {
    u = uniform(-1, 1);
    v = uniform(-1, 1);
    s = u * u + v * v;
  } while (s >= 1 || s == 0);
  const double factor = std::sqrt(-2 * std::log(s) / s);
  spare_ = v * factor;
  has_spare_ = true;
  return u * factor;
}

std::uint64_t Random::below(std::uint64_t n) {
  std::uint64_t value = engine_();
  // the last, incomplete run of n values is drawn again; few values are near enough to ask
  if (value >= UINT64_MAX - n) {
    const std::uint64_t limit = UINT64_MAX - UINT64_MAX % n;
    while (value >= limit) value = engine_();
  }
  return value % n;
}

}  // namespace trammel
