#include "app/job/identification.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

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
  const bool identified = of.known.identified[k];
  Json json = object_of(5);
  json["name"] = p.name;
  json["unit"] = !p.unit.empty() ? p.unit : p.is_angle ? "deg" : "mm";
  json["identified"] = identified;
  if (identified) {
    json["change"] = shown(p.is_angle, of.values[row]);
    json["standard_uncertainty"] = shown(p.is_angle, std::sqrt(s.covariance(row, row)));
  } else {
    json["why"] = "not identifiable by itself from these readings";
  }
  return json;
}

Json base_json(const IdentifiedCombination& c) {
  Json json = object_of(5);
  json["name"] = c.name;
  json["unit"] = c.unit;
  json["alone"] = c.alone;
  json["change"] = shown(c.is_angle, *c.value);
  json["standard_uncertainty"] = shown(c.is_angle, c.standard_uncertainty);
  return json;
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
  const std::string ratio = fmt::format("residuals are {:.2f} times the noise, ", g.ratio);
  if (g.explained) return ratio + "as chance may leave them: the model explains these readings";
  return ratio + fmt::format(
                     "more than chance ({:.2f} in 1 of {:.0f}): something is there that the model "
                     "cannot explain; uncertainties are widened by as much",
                     g.limit, 1 / kFalseMisfit);
}

Json details_of(const Identification& of, const Scaled& s, const std::vector<Beyond>& beyond) {
  const Observability& o = of.known.observability;
  Json json = {
      {"columns", of.known.singular.size()},
      {"rank", of.known.rank},
      {"rank_machine", of.known.rank_machine},
      {"sigma_ratio", of.goodness.ratio},
      {"uncertainty_scale", of.goodness.scale},
      {"explained", of.goodness.explained},
      {"observability", {{"O1", o.O1}, {"O2", o.O2}, {"O3", o.O3}, {"O4", o.O4}, {"O5", o.O5}}}};
  for (std::size_t k = 0; k < of.parameters.size(); ++k) {
    json["parameters"].push_back(parameter_json(of, s, k));
  }
  json["identified"] = json["correlations"] = json["beyond_tolerance"] = Json::array();
  for (const IdentifiedCombination& c : s.base) json["identified"].push_back(base_json(c));
  for (const Correlation& c : s.correlated) {
    json["correlations"].push_back({{"a", s.base[static_cast<std::size_t>(c.a)].name},
                                    {"b", s.base[static_cast<std::size_t>(c.b)].name},
                                    {"r", c.r}});
  }
  for (const Beyond& b : beyond) {
    json["beyond_tolerance"].push_back({{"name", b.name}, {"tolerances", b.tolerances}});
  }
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
    text += fmt::format("  {:<40}{:>12}{:>14}{}\n", c["name"].get<std::string>(),
                        plain ? fmt::format("{:.4f}", c["change"].get<double>())
                              : fmt::format("{:.4g}", c["change"].get<double>()),
                        plain ? fmt::format("+- {:.4f}", U) : fmt::format("+- {:.2g}", U),
                        unit == "1" ? "" : " " + unit);
  }
  return text;
}

}  // namespace trammel::job
