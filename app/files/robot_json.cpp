#include "app/files/robot_json.hpp"

#include <array>
#include <string>

#include "app/files/fields.hpp"
#include "app/files/format.hpp"
#include "app/files/machine_json.hpp"
#include "app/files/mechanism_json.hpp"
#include "core/error.hpp"
#include "core/simulate/truth_check.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

using namespace simulate;

std::string how_many(int n) {
  constexpr std::array<const char*, 4> kWords = {"no", "one", "two", "three"};
  return kWords[static_cast<std::size_t>(n)];
}

/// Reads what is stated by rail, for a machine of so many.
struct Rails {
  int n = kChains;

  void read(Fields& fields, const char* name, Eigen::Vector3d& into) const {
    if (!fields.has(name)) return;
    const std::vector<double> values = fields.numbers(name);
    if (static_cast<int>(values.size()) != n) {
      fields.refuse(name, "wrong number of rails", how_many(n) + (n == 1 ? " number" : " numbers"));
    }
    into.setZero();
    for (int i = 0; i < n; ++i) into[i] = values[static_cast<std::size_t>(i)];
  }
  [[nodiscard]] int number(Fields& fields) const {
    const int rail = fields.integer("rail");
    if (rail < 1 || rail > n) {
      fields.refuse("rail", "no such rail", n == 3 ? "1, 2 or 3" : n == 2 ? "1 or 2" : "1");
    }
    return rail - 1;
  }
};

std::vector<Fields> list(Fields& fields, const char* name) {
  return fields.has(name) ? fields.objects(name) : std::vector<Fields>{};
}

std::array<ChainValues, kChains> read_errors(Fields fields, const Machine& nominal) {
  std::array<ChainValues, kChains> actual = nominal.chains;
  const int n = nominal.kind->n_chains;
  std::vector<Fields> chains = fields.objects("chains");
  if (static_cast<int>(chains.size()) != n) {
    fields.refuse("chains", "wrong number of chains",
                  how_many(n) + (n == 1 ? " chain" : " chains"));
  }
  const auto parameters = nominal.kind->chain->parameters;
  for (std::size_t i = 0; i < chains.size(); ++i) {
    for (std::size_t k = 0; k < parameters.size(); ++k) {
      if (!nominal.kind->has_parameter(parameters[k])) continue;
      const double error = chains[i].number(parameters[k].field, 0);
      actual[i][k] += parameters[k].is_angle() ? rad_from_deg(error) : error;
    }
    chains[i].done();
  }
  fields.done();
  return actual;
}

void read_crosstalk(Fields& fields, int n, Eigen::Matrix3d& into) {
  if (!fields.has("axis_crosstalk")) return;
  // m_12 m_13 m_21 m_23 m_31 m_32: the diagonal is lead_scale.
  const std::vector<double> m = fields.numbers("axis_crosstalk");
  const auto terms = static_cast<std::size_t>(n * (n - 1));
  if (m.size() != terms) {
    fields.refuse("axis_crosstalk", "wrong number of terms",
                  terms == 6 ? "six numbers" : std::to_string(terms) + " numbers");
  }
  auto next = m.begin();
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) into(i, j) = i == j ? 0 : *next++;
  }
}

DriveTruth read_drive_truth(Fields fields, const Rails& rails) {
  DriveTruth d;
  rails.read(fields, "lead_scale", d.lead_scale);
  rails.read(fields, "lead_curvature_per_mm", d.lead_curvature_per_mm);
  rails.read(fields, "screw_sin_mm", d.screw_sin_mm);
  rails.read(fields, "screw_cos_mm", d.screw_cos_mm);
  rails.read(fields, "backlash_mm", d.backlash_mm);
  rails.read(fields, "thermal_growth_per_k", d.thermal_growth_per_k);
  read_crosstalk(fields, rails.n, d.axis_crosstalk);
  rails.read(fields, "guide_bow_per_mm", d.guide_bow_per_mm);
  rails.read(fields, "guide_yaw_deg_per_mm", d.guide_yaw_rad_per_mm);
  for (double& k : d.guide_yaw_rad_per_mm) k = rad_from_deg(k);
  if (auto load = fields.optional_object("platform_load")) {
    d.load_mm = {load->number("fx_mm", 0), load->number("fy_mm", 0)};
    d.load_mm2 = load->number("m_mm2", 0);
    load->done();
  }
  rails.read(fields, "lead_cubic_per_mm2", d.lead_cubic_per_mm2);
  rails.read(fields, "stick_slip", d.stick_slip);
  rails.read(fields, "transient_mm", d.transient_mm);
  d.transient_tau_s = fields.number("transient_tau_s", d.transient_tau_s);
  d.thermal_lag_s = fields.number("thermal_lag_s", d.thermal_lag_s);
  fields.done();
  return d;
}

TrackerTruth read_tracker(Fields fields) {
  TrackerTruth t;
  t.sigma_xy_mm = fields.number("sigma_xy_mm", 0);
  t.sigma_phi_rad = rad_from_deg(fields.number("sigma_phi_deg", 0));
  t.correlation = fields.number("correlation", 0);
  t.drift_per_h = {fields.number("drift_x_mm_h", 0), fields.number("drift_y_mm_h", 0),
                   rad_from_deg(fields.number("drift_phi_deg_h", 0))};
  t.scale = fields.number("scale", 0);
  t.swirl_rad_per_mm = rad_from_deg(fields.number("swirl_deg_per_mm", 0));
  t.outlier_share = fields.number("outlier_share", 0);
  t.outlier_mm = fields.number("outlier_mm", 0);
  if (fields.has("outliers")) {
    for (const double seq : fields.numbers("outliers")) {
      if (!(seq >= 0 && seq < 1e15)) fields.refuse("outliers", "no number of a reading");
      t.outliers.push_back(static_cast<std::uint64_t>(seq));
    }
  }
  fields.done();
  return t;
}

void read_lists(Fields& top, const Rails& rails, Truth& truth) {
  for (Fields& bump : list(top, "bumps")) {
    truth.bumps.push_back({rails.number(bump), bump.number("centre_mm"), bump.number("width_mm"),
                           bump.number("height_mm")});
    bump.done();
  }
  for (Fields& wave : list(top, "harmonics")) {
    truth.harmonics.push_back({rails.number(wave), wave.number("period_mm"),
                               wave.number("sin_mm", 0), wave.number("cos_mm", 0)});
    wave.done();
  }
  for (Fields& shift : list(top, "shifts")) {
    truth.shifts.push_back({shift.number("time_s"), read_pose(shift.object("by"))});
    shift.done();
  }
  for (Fields& fields : list(top, "epochs")) {
    EpochTruth epoch;
    rails.read(fields, "l_zero_mm", epoch.l_zero_mm);
    if (auto frame = fields.optional_object("frame")) epoch.frame = read_pose(*frame);
    fields.done();
    truth.epochs.push_back(epoch);
  }
}

Truth read_truth(Fields top) {
  take_format(top, "robot/1");
  static_cast<void>(top.text("name", ""));
  static_cast<void>(top.text("why", ""));
  Truth truth;
  truth.nominal = read_any_machine(top.object("mechanism"));
  truth.actual = truth.nominal.chains;
  const Rails rails{truth.nominal.kind->n_chains};
  if (auto errors = top.optional_object("geometry_errors")) {
    truth.actual = read_errors(*errors, truth.nominal);
  }
  truth.zeroed = top.boolean("zeroed_at_home", false);
  truth.phi_zero_rad = rad_from_deg(top.number("phi_zero_deg", 0));
  if (auto drive = top.optional_object("drive")) truth.drive = read_drive_truth(*drive, rails);
  if (auto tracker = top.optional_object("tracker")) truth.tracker = read_tracker(*tracker);
  if (auto t = top.optional_object("temperature")) {
    truth.temperature = {t->number("start_degc", truth.temperature.start_degc),
                         t->number("rise_k", 0), t->number("tau_s", truth.temperature.tau_s)};
    t->done();
  }
  if (auto m = top.optional_object("motion")) {
    truth.motion = {m->number("speed_mm_s", truth.motion.speed_mm_s),
                    m->number("settle_s", truth.motion.settle_s),
                    m->number("measure_s", truth.motion.measure_s)};
    m->done();
  }
  read_lists(top, rails, truth);
  const int seed = top.integer("seed", 1);
  if (seed < 0) top.refuse("seed", "a negative seed");
  truth.seed = static_cast<std::uint64_t>(seed);
  top.done();
  return truth;
}

Truth checked(const JsonFile& file) {
  Truth truth = read_truth(Fields(file));
  try {
    check(truth);
  } catch (const InputError& error) {
    throw located(error, file);
  }
  return truth;
}

}  // namespace

Truth read_robot(const std::filesystem::path& path) { return checked(read_json(path)); }

Truth parse_robot(std::string_view text, const std::string& name) {
  return checked(parse_json(text, name));
}

}  // namespace trammel
