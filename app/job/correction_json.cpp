#include "app/job/correction_json.hpp"

#include <span>

namespace trammel::job {

namespace {

template <class... Fs>
struct Overloaded : Fs... {
  using Fs::operator()...;
};

std::vector<double> list(const Eigen::Ref<const Eigen::VectorXd>& values) {
  return {values.begin(), values.end()};
}

Json geometry_json(const Geometry& geometry) {
  Json chains = Json::array();
  for (const Chain& c : geometry.chains) {
    chains.push_back({{"alpha_rad", c.alpha_rad},
                      {"beta_rad", c.beta_rad},
                      {"r_mm", c.r_mm},
                      {"S_mm", c.S_mm},
                      {"l_zero_mm", c.l_zero_mm},
                      {"R_mm", c.R_mm},
                      {"h_mm", c.h_mm}});
  }
  return chains;
}

Geometry read_geometry(Fields& owner) {
  Geometry geometry;
  std::vector<Fields> chains = owner.objects("chains");
  if (chains.size() != kChains) owner.refuse("chains", "a robot has three chains");
  for (std::size_t i = 0; i < kChains; ++i) {
    Fields& f = chains[i];
    geometry.chains[i] = {.alpha_rad = f.number("alpha_rad"),
                          .beta_rad = f.number("beta_rad"),
                          .r_mm = f.number("r_mm"),
                          .S_mm = f.number("S_mm"),
                          .l_zero_mm = f.number("l_zero_mm"),
                          .R_mm = f.number("R_mm"),
                          .h_mm = f.number("h_mm")};
    f.done();
  }
  return geometry;
}

Json map_json(const IdwMap& m) {
  return {{"type", "idw"},    {"power", m.options.power}, {"neighbours", m.options.neighbours},
          {"x_mm", m.x_mm},   {"y_mm", m.y_mm},           {"e1_mm", m.e1_mm},
          {"e2_mm", m.e2_mm}, {"e3_mm", m.e3_mm}};
}

Json map_json(const RbfNetwork& m) {
  return {{"type", "rbf"},
          {"x_mm", list(m.cx_mm.matrix())},
          {"y_mm", list(m.cy_mm.matrix())},
          {"sigma_mm", list(m.sigma_mm.matrix())},
          {"w1_mm", list(m.weights_mm.col(0))},
          {"w2_mm", list(m.weights_mm.col(1))},
          {"w3_mm", list(m.weights_mm.col(2))},
          {"bias_mm", list(m.bias_mm)}};
}

/// A list of `n` numbers; n = 0 takes any length but none.
std::vector<double> numbers(Fields& f, const std::string& name, std::size_t n) {
  std::vector<double> values = f.numbers(name);
  if (values.empty() || (n > 0 && values.size() != n)) {
    f.refuse(name, "this list has the wrong length",
             n > 0 ? std::to_string(n) + " numbers" : "at least one number");
  }
  return values;
}

Eigen::Map<const Eigen::VectorXd> vector(const std::vector<double>& values) {
  return {values.data(), static_cast<Eigen::Index>(values.size())};
}

JointMap read_idw(Fields& f) {
  IdwMap m;
  m.options = {.power = f.number("power"), .neighbours = f.integer("neighbours")};
  m.x_mm = numbers(f, "x_mm", 0);
  const std::size_t n = m.x_mm.size();
  m.y_mm = numbers(f, "y_mm", n);
  m.e1_mm = numbers(f, "e1_mm", n);
  m.e2_mm = numbers(f, "e2_mm", n);
  m.e3_mm = numbers(f, "e3_mm", n);
  if (!(m.options.power > 0)) f.refuse("power", "IDW needs a positive power");
  if (m.options.neighbours < 0 || static_cast<std::size_t>(m.options.neighbours) > n) {
    f.refuse("neighbours", "more neighbours than samples", "0 to " + std::to_string(n));
  }
  return m;
}

JointMap read_rbf(Fields& f) {
  RbfNetwork m;
  m.cx_mm = vector(numbers(f, "x_mm", 0)).array();
  const auto n = static_cast<std::size_t>(m.cx_mm.size());
  m.cy_mm = vector(numbers(f, "y_mm", n)).array();
  m.sigma_mm = vector(numbers(f, "sigma_mm", n)).array();
  if (!(m.sigma_mm > 0).all()) f.refuse("sigma_mm", "a spread is not positive");
  m.weights_mm.resize(m.cx_mm.size(), 3);
  m.weights_mm.col(0) = vector(numbers(f, "w1_mm", n));
  m.weights_mm.col(1) = vector(numbers(f, "w2_mm", n));
  m.weights_mm.col(2) = vector(numbers(f, "w3_mm", n));
  m.bias_mm = vector(numbers(f, "bias_mm", 3));
  return m;
}

JointMap read_map(Fields f) {
  const bool idw = f.choice("type", {"idw", "rbf"}) == "idw";
  JointMap map = idw ? read_idw(f) : read_rbf(f);
  f.done();
  return map;
}

}  // namespace

Json correction_json(const Correction& correction) {
  Json json = {{"kind", kind_of(correction)}};
  std::visit(
      Overloaded{[](const NominalCorrection&) {},
                 [&](const GeometryCorrection& c) { json["chains"] = geometry_json(c.geometry); },
                 [&](const MapCorrection& c) {
                   json["map"] = std::visit([](const auto& m) { return map_json(m); }, c.map);
                 }},
      correction);
  return json;
}

Correction read_correction(Fields f) {
  const std::string kind = f.choice("kind", {"nominal", "geometry", "map"});
  Correction correction = NominalCorrection{};
  if (kind == "geometry") correction = GeometryCorrection{read_geometry(f)};
  if (kind == "map") correction = MapCorrection{read_map(f.object("map"))};
  f.done();
  return correction;
}

Correction correction_of(const std::string& result_json) {
  const JsonFile file = parse_json(result_json, "stored result");
  Fields top(file);
  return read_correction(top.object("correction"));
}

}  // namespace trammel::job
