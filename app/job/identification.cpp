#include "app/job/identification.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ranges>

#include "core/units.hpp"

namespace trammel::job {

namespace {

constexpr double kAbsorbed = 4.0;  // tolerances: a machined part is not that far off

struct Scaled {
  Eigen::MatrixXd covariance;  // widened by what the residuals show
  std::vector<IdentifiedCombination> base;
  std::vector<Correlation> correlated;
};

Scaled scaled(const Identification& of) {
  Scaled s;
  s.covariance = of.goodness.scale * of.goodness.scale * of.covariance;
  s.base = identified_combinations(of.known, of.parameters, s.covariance, of.values);
  const auto dropped = [&](int k) { return of.covariance(k, k) == 0; };
  std::erase_if(s.base, [&](const IdentifiedCombination& c) {
    return std::ranges::all_of(c.members, dropped);
  });
  s.correlated = strong_correlations(s.base, s.covariance);
  return s;
}

double shown(bool is_angle, double value) { return is_angle ? deg_from_rad(value) : value; }

/// A number stands only beside a parameter that is identified.
Json parameter_json(const Identification& of, const Scaled& s, std::size_t k) {
  const ScaledParameter& p = of.parameters[k];
  const auto row = static_cast<Eigen::Index>(k);
  const char* const unit = !p.unit.empty() ? p.unit.c_str() : p.is_angle ? "deg" : "mm";
  if (!of.known.identified[k]) {
    return object_with("name", p.name, "unit", unit, "identified", false, "why",
                       "not identifiable by itself from these readings");
  }
  return object_with("name", p.name, "unit", unit, "identified", true, "change",
                     shown(p.is_angle, of.values[row]), "standard_uncertainty",
                     shown(p.is_angle, std::sqrt(s.covariance(row, row))));
}

Json combination_json(const IdentifiedCombination& c) {
  return object_with("name", c.name, "unit", c.unit, "alone", c.alone, "change",
                     shown(c.is_angle, *c.value), "standard_uncertainty",
                     shown(c.is_angle, c.standard_uncertainty));
}

struct Beyond {
  std::string name;
  double tolerances = 0;
};

/// Base parameters of the machined geometry that are further off than machining puts them, by more
/// than the reading's noise explains (of.covariance: what the model lacks is no excuse here, it is
/// what the alarm looks for).
std::vector<Beyond> beyond_tolerance(const Identification& of, const Scaled& s) {
  std::vector<Beyond> found;
  for (const IdentifiedCombination& c : s.base) {
    double square = 0;
    bool machined = true;
    for (const int k : c.members) {
      const auto at = static_cast<std::size_t>(k);
      machined = machined && at < of.n_geometry;
      square += std::pow(c.of[k] * of.parameters[at].tolerance, 2);
    }
    const double tolerance = std::sqrt(square);
    const double off = std::abs(*c.value);
    const double uncertainty = c.standard_uncertainty / of.goodness.scale;
    if (machined && off - 2 * uncertainty > kAbsorbed * tolerance) {
      found.push_back({c.name, off / tolerance});
    }
  }
  return found;
}

std::string goodness_words(const Goodness& g) {
  if (g.dof <= 0) {
    return "no degrees of freedom are left: the residuals cannot tell whether the model is right";
  }
  const std::string chance = fmt::format("{:.2f} to {:.2f} in all but 1 of {:.0f} fits", g.least,
                                         g.limit, 0.5 / kFalseMisfit);
  if (g.too_good) {
    return fmt::format(
        "residuals are {:.2g} of the noise, less than noise leaves ({}): is sigma in the right "
        "unit, or are these no readings?",
        g.ratio, chance);
  }
  const std::string ratio = fmt::format("residuals are {:.2f} times the noise, ", g.ratio);
  if (g.explained)
    return ratio + "within what noise alone leaves (" + chance +
           "): the model explains these readings";
  return ratio + fmt::format(
                     "more than noise alone leaves ({}): something is there that the model cannot "
                     "explain; uncertainties are widened by as much",
                     chance);
}

Json details_of(const Identification& of, const Scaled& s, const std::vector<Beyond>& beyond) {
  const auto list = [](const auto& of_each, const auto& json_of) {
    Json::array_t rows;
    rows.reserve(of_each.size());
    for (const auto& each : of_each) rows.push_back(json_of(each));
    return rows;
  };
  const Observability& o = of.known.observability;
  Json json = object_of(24);  // the stage has more to say
  json["columns"] = of.known.singular.size();
  json["rank"] = of.known.rank;
  json["rank_machine"] = of.known.rank_machine;
  json["sigma_ratio"] = of.goodness.ratio;
  json["uncertainty_scale"] = of.goodness.scale;
  json["explained"] = of.goodness.explained;
  json["too_good"] = of.goodness.too_good;
  json["observability"] = object_with("O1", o.O1, "O2", o.O2, "O3", o.O3, "O4", o.O4, "O5", o.O5);
  json["parameters"] = list(std::views::iota(std::size_t{0}, of.parameters.size()),
                            [&](std::size_t k) { return parameter_json(of, s, k); });
  json["identified"] = list(s.base, combination_json);
  json["correlations"] = list(s.correlated, [&](const Correlation& c) {
    return object_with("a", s.base[static_cast<std::size_t>(c.a)].name, "b",
                       s.base[static_cast<std::size_t>(c.b)].name, "r", c.r);
  });
  json["beyond_tolerance"] = list(beyond, [](const Beyond& b) {
    return object_with("name", b.name, "tolerances", b.tolerances);
  });
  return json;
}

std::vector<std::string> words_of(const Identification& of, const Scaled& s,
                                  const std::vector<Beyond>& beyond) {
  std::vector<std::string> words = in_words(of.known, of.parameters, s.base, s.correlated);
  for (const Beyond& b : beyond) {
    words.push_back(fmt::format(
        "absorption alarm: {} is {:.1f} tolerances from nominal: probably soaking up an unmodelled "
        "effect",
        b.name, b.tolerances));
  }
  words.push_back(goodness_words(of.goodness));
  return words;
}

}  // namespace

IdentificationReport identification_report(const Identification& of) {
  const Scaled s = scaled(of);
  const std::vector<Beyond> beyond = beyond_tolerance(of, s);
  return {details_of(of, s, beyond), words_of(of, s, beyond)};
}

std::string identified_table(const Json& details) {
  const Json base = details.value("identified", Json::array());
  if (base.empty()) return {};
  std::string text =
      fmt::format("  {:<40}{:>12}{:>14}\n", "identified, change from nominal", "", "U (k = 2)");
  for (const Json& c : base) {
    const double U = 2 * c["standard_uncertainty"].get<double>();
    const std::string unit = c["unit"].get<std::string>();
    const bool plain = unit == "mm" || unit == "deg";
    const int decimals = U < 0.001 ? 6 : 4;  // of a stage that is known to tenths of micrometres
    text +=
        fmt::format("  {:<40}{:>12}{:>14}{}\n", c["name"].get<std::string>(),
                    plain ? fmt::format("{:.{}f}", c["change"].get<double>(), decimals)
                          : fmt::format("{:.4g}", c["change"].get<double>()),
                    plain ? fmt::format("+- {:.{}f}", U, decimals) : fmt::format("+- {:.2g}", U),
                    unit == "1" ? "" : " " + unit);
  }
  return text;
}

}  // namespace trammel::job
