#include "core/diagnose/audit.hpp"

#include <algorithm>
#include <cmath>

#include "core/model/effect.hpp"

namespace trammel {

namespace {

// One parameter among some 300 tests at 0.5 % family-wise: |z| > 4.2 at the smallest p, + 0.84 for
// power.
constexpr double kVisibleZ = 4.2 + 0.84;
constexpr double kInvisible = 1e-6;  // surviving share that is rounding

struct Signals {
  Eigen::MatrixXd raw, projected;  // per usual size of each parameter
};

Signals signals_of(const Effect& effect, const ResidualSpace& space) {
  Signals s;
  s.raw.resize(space.rows(), static_cast<Eigen::Index>(effect.parameters.size()));
  s.raw.setZero();
  for (int k = 0; k < static_cast<int>(effect.parameters.size()); ++k) {
    if (is_shape(effect, k)) continue;
    s.raw.col(k) =
        effect.parameters[static_cast<std::size_t>(k)].usual_max *
        whitened_signal(space, [&](const Reading&, const Moment& m) { return effect.basis(m, k); });
  }
  s.projected = space.project(s.raw);
  return s;
}

std::string what_is_missing(const Effect& effect, const ResidualSpace& space) {
  for (const Need need : effect.needs) {
    for (const Prediction& at : space.predictions) {
      if ((need == Need::temperature && !at.moment.temp_degc) ||
          (need == Need::time && !at.moment.time_h)) {
        return to_string(need);
      }
    }
  }
  return {};
}

}  // namespace

std::vector<AuditRow> audit_design(const ResidualSpace& space) {
  const auto catalogue = effect_catalogue();
  std::vector<AuditRow> rows;
  std::vector<Signals> signals(catalogue.size());
  std::vector<Eigen::MatrixXd> bases(catalogue.size());
  for (const Effect& effect : catalogue) {
    if (!exists(effect, space.machine)) continue;
    const std::size_t e = rows.size();
    AuditRow row;
    row.effect = effect.name;
    row.unit = effect.parameters.front().unit;
    for (const EffectParameter& p : effect.parameters) {
      if (p.unit == row.unit) row.usual_max = std::max(row.usual_max, p.usual_max);
    }
    row.missing = what_is_missing(effect, space);
    if (row.missing.empty()) {
      signals[e] = signals_of(effect, space);
      const double raw = signals[e].raw.squaredNorm();
      row.surviving_share = raw > 0 ? signals[e].projected.squaredNorm() / raw : 0;
      if (row.surviving_share > kInvisible) {
        bases[e] = orthonormal(signals[e].projected);
        const Eigen::VectorXd seen = signals[e].projected.colwise().norm().transpose();
        double worst = 0;
        for (Eigen::Index k = 0; k < seen.size(); ++k) {
          const auto& parameter = effect.parameters[static_cast<std::size_t>(k)];
          if (parameter.unit != row.unit || !exists(effect, static_cast<int>(k), space.machine))
            continue;
          const double usual = parameter.usual_max;
          worst = std::max(worst, usual * kVisibleZ / seen[k]);
        }
        row.smallest_visible = worst;
      } else {
        row.surviving_share = 0;
        row.missing = effect.needs.empty() ? "" : to_string(effect.needs.front());
      }
    }
    rows.push_back(std::move(row));
  }
  for (std::size_t e = 0; e < rows.size(); ++e) {
    for (std::size_t other = 0; other < rows.size(); ++other) {
      if (other == e || bases[e].cols() == 0 || bases[other].cols() == 0) continue;
      const double shared = transposed_product(bases[other], signals[e].projected).squaredNorm() /
                            signals[e].projected.squaredNorm();
      if (shared > kAliasShare) rows[e].aliases.push_back({rows[other].effect, shared});
    }
  }
  return rows;
}

}  // namespace trammel
