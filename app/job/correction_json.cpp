#include "app/job/correction_json.hpp"

#include <algorithm>
#include <span>

#include "app/files/machine_json.hpp"
#include "app/files/mechanism_json.hpp"

namespace trammel::job {

namespace {

template <class... Fs>
struct Overloaded : Fs... {
  using Fs::operator()...;
};
template <class... Fs>
Overloaded(Fs...) -> Overloaded<Fs...>;

std::vector<double> list(const Eigen::Ref<const Eigen::VectorXd>& values) {
  return {values.begin(), values.end()};
}

Json geometry_json(const Geometry& geometry) {
  Json chains = Json::array();
  for (const Chain& c : geometry.chains) {
    chains.push_back(object_with("alpha_rad", c.alpha_rad, "beta_rad", c.beta_rad, "r_mm", c.r_mm,
                                 "S_mm", c.S_mm, "l_zero_mm", c.l_zero_mm, "R_mm", c.R_mm, "h_mm",
                                 c.h_mm));
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
          {"bias_mm", list(m.bias_mm)},
          {"relative_ridge", m.relative_ridge}};
}

Json map_json(const GpMap& m) {
  Json json = {{"type", "gp"}, {"x_mm", m.x_mm}, {"y_mm", m.y_mm}};
  for (const GpJoint& j : m.joints) {
    json["joints"].push_back({{"mean_mm", j.mean_mm},
                              {"length_mm", j.length_mm},
                              {"signal_mm", j.signal_mm},
                              {"noise_mm", j.noise_mm},
                              {"weights", list(j.weights)}});
  }
  return json;
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
  m.relative_ridge = f.number("relative_ridge", 1e-8);  // older jobs: the paper's
  return m;
}

JointMap read_gp(Fields& f) {
  GpMap m;
  m.x_mm = numbers(f, "x_mm", 0);
  m.y_mm = numbers(f, "y_mm", m.x_mm.size());
  std::vector<Fields> joints = f.objects("joints");
  if (joints.size() != kChains) f.refuse("joints", "a map has three joints");
  for (std::size_t i = 0; i < kChains; ++i) {
    m.joints[i] = {.mean_mm = joints[i].number("mean_mm"),
                   .length_mm = joints[i].number("length_mm"),
                   .signal_mm = joints[i].number("signal_mm"),
                   .noise_mm = joints[i].number("noise_mm"),
                   .weights = vector(numbers(joints[i], "weights", m.x_mm.size()))};
    joints[i].done();
  }
  return m;
}

Json vector3_json(const Eigen::Vector3d& v) { return Json::array({v[0], v[1], v[2]}); }

Json epochs_json(const EpochShifts& shifts) {
  Json epochs = Json::array();
  for (const auto& [epoch, shift] : shifts) {
    epochs.push_back({{"epoch", epoch},
                      {"l_zero_mm", vector3_json(shift.l_zero_mm)},
                      {"frame_mm_rad", vector3_json(shift.frame.vector())}});
  }
  return epochs;
}

/// Parameters in the order of the kind's, rad and mm.
Json chains_json(const Machine& machine) {
  Json chains = Json::array();
  for (std::size_t i = 0; i < static_cast<std::size_t>(machine.kind->n_chains); ++i) {
    const auto n = static_cast<std::ptrdiff_t>(machine.kind->chain->parameters.size());
    const auto first = machine.chains[i].begin();
    chains.push_back({{"values", std::vector<double>(first, first + n)}});
  }
  return chains;
}

/// A 3-PRR as ever, its screws alike; other machines by their kind.
Json model_json(const RobotModel& m) {
  Json json;
  if (m.nominal.kind->chain == &kPrrChain) {
    json = {{"mechanism", mechanism_json(m.mechanism())}, {"chains", geometry_json(m.geometry())}};
  } else {
    json = {{"machine", machine_json(m.nominal)}, {"chains", chains_json(m.machine)}};
  }
  json["epochs"] = epochs_json(m.epochs);
  json["effects"] = Json::array();
  for (const ActiveEffect& active : m.effects) {
    json["effects"].push_back({{"name", active.effect->name}, {"values", list(active.values)}});
  }
  return json;
}

Eigen::Vector3d read_vector3(Fields& f, const std::string& name) {
  return vector(numbers(f, name, 3));
}

EpochShifts read_epochs(Fields& f) {
  EpochShifts shifts;
  for (Fields& e : f.objects("epochs")) {
    EpochShift& shift = shifts[e.integer("epoch")];
    shift.l_zero_mm = read_vector3(e, "l_zero_mm");
    shift.frame = Pose::from(read_vector3(e, "frame_mm_rad"));
    e.done();
  }
  return shifts;
}

void read_chains(Fields& owner, Machine& machine) {
  std::vector<Fields> chains = owner.objects("chains");
  if (std::ssize(chains) != machine.kind->n_chains)
    owner.refuse("chains", "one for each chain of the machine");
  for (std::size_t i = 0; i < chains.size(); ++i) {
    const auto values = numbers(chains[i], "values", machine.kind->chain->parameters.size());
    std::ranges::copy(values, machine.chains[i].begin());
    chains[i].done();
  }
}

RobotModel read_model(Fields f) {
  RobotModel m;
  if (f.has("machine")) {
    m = nominal_model(read_machine(f.object("machine")));
    read_chains(f, m.machine);
  } else {
    m = nominal_model(read_mechanism(f.object("mechanism")));
    set_geometry(m.machine, read_geometry(f));
  }
  m.epochs = read_epochs(f);
  for (Fields& e : f.objects("effects")) {
    const Effect& effect = find_effect(e.text("name"));
    m.effects.push_back({&effect, vector(numbers(e, "values", effect.parameters.size()))});
    e.done();
  }
  f.done();
  return m;
}

JointMap read_map(Fields f) {
  const std::string type = f.choice("type", {"idw", "rbf", "gp"});
  JointMap map = type == "idw" ? read_idw(f) : type == "rbf" ? read_rbf(f) : read_gp(f);
  f.done();
  return map;
}

Json any_map(const JointMap& map) {
  return std::visit([](const auto& m) { return map_json(m); }, map);
}

}  // namespace

Json correction_json(const Correction& correction) {
  Json json = {{"kind", kind_of(correction)}};
  const auto geometry = [&](const GeometryCorrection& c) {
    json["chains"] = geometry_json(c.geometry);
  };
  const auto map = [&](const MapCorrection& c) {
    json["map"] = any_map(c.map);
    if (!c.epochs.empty()) json["epochs"] = epochs_json(c.epochs);
  };
  const auto model = [&](const ModelCorrection& c) { json["model"] = model_json(c.model); };
  const auto hybrid = [&](const HybridCorrection& c) {
    json["model"] = model_json(c.model);
    json["map"] = any_map(c.left);
  };
  std::visit(Overloaded{[](const NominalCorrection&) {}, geometry, map, model, hybrid}, correction);
  return json;
}

Correction read_correction(Fields f) {
  const std::string kind = f.choice("kind", {"nominal", "geometry", "map", "model", "hybrid"});
  Correction correction = NominalCorrection{};
  if (kind == "geometry") correction = GeometryCorrection{read_geometry(f)};
  if (kind == "map") {
    correction =
        MapCorrection{read_map(f.object("map")), f.has("epochs") ? read_epochs(f) : EpochShifts{}};
  }
  if (kind == "model") correction = ModelCorrection{read_model(f.object("model"))};
  if (kind == "hybrid") {
    correction = HybridCorrection{read_model(f.object("model")), read_map(f.object("map"))};
  }
  f.done();
  return correction;
}

Correction correction_of(const std::string& result_json) {
  // Of the correction alone: the points beside it may be more than a file that people write holds.
  const Json correction = {{"correction", Json::parse(result_json).at("correction")}};
  const JsonFile file = parse_json(correction.dump(), "stored result");
  Fields top(file);
  return read_correction(top.object("correction"));
}

}  // namespace trammel::job
