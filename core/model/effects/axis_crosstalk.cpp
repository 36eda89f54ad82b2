#include "core/model/effect.hpp"

namespace trammel {

namespace {

struct Pair {
  int to, from;
};
constexpr Pair kPairs[] = {{0, 1}, {0, 2}, {1, 0}, {1, 2}, {2, 0}, {2, 1}};

}  // namespace

/// dl_i = sum over j != i of m_ij s_j
Effect axis_crosstalk() {
  std::vector<EffectParameter> parameters;
  for (const Pair& p : kPairs) {
    parameters.push_back(
        {"m_" + std::to_string(p.to + 1) + std::to_string(p.from + 1), "1", p.to, 5e-3});
    parameters.back().on = On::platform;
  }
  return {
      .name = "axis_crosstalk",
      .sentence = "one rail's travel moves another: a shared base that bends, or coupled drives",
      .needs = {Need::travel},
      .parameters = parameters,
      .basis = [](const Moment& m, int k) {
        Deviation d;
        d.dl_mm[kPairs[k].to] = m.s_mm[kPairs[k].from];
        return d;
      }};
}

}  // namespace trammel
