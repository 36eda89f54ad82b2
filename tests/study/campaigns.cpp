#include "tests/study/campaigns.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

#include "core/calibrate/geometry_fit.hpp"
#include "core/mechanism/machine_solver.hpp"
#include "core/plan/grids.hpp"
#include "core/simulate/virtual_robot.hpp"
#include "core/statistics/random.hpp"
#include "core/units.hpp"
#include "tests/support/workspace.hpp"

namespace trammel::tests {

namespace {

using Eigen::Vector3d;
using simulate::Truth;

/// One to all of `n` drives, each with a size of either sign; never all zero.
Vector3d on_some_drives(Random& random, int n, bool positive = false) {
  Vector3d v = Vector3d::Zero();
  const auto most = static_cast<std::uint64_t>(n);
  const int drives = 1 + static_cast<int>(random.below(most));
  for (int i = 0; i < drives; ++i) {
    const double sign = positive || random.uniform() < 0.5 ? 1 : -1;
    v[static_cast<int>(random.below(most))] = sign * random.uniform(0.5, 1);
  }
  return v;
}

int drives(const Truth& t) { return t.nominal.kind->n_chains; }
int one_drive(Random& random, const Truth& t) {
  return static_cast<int>(random.below(static_cast<std::uint64_t>(drives(t))));
}
/// In the middle of what a campaign reaches.
double middle_mm(const Truth& t, int drive) {
  return t.nominal.kind->chain == &kPrrChain ? 262 : drives_of(t.nominal, t.nominal.home)[drive];
}

Random dice(std::uint64_t seed) { return Random::stream(seed, "family"); }

std::vector<Family> make_families() {
  return {
      {"lead_scale", true,
       [](Truth& t, double size, std::uint64_t seed) {
         auto r = dice(seed);
         t.drive.lead_scale = size * 1e-3 * on_some_drives(r, drives(t));
       }},
      {"lead_curvature", true,
       [](Truth& t, double size, std::uint64_t seed) {
         auto r = dice(seed);
         t.drive.lead_curvature_per_mm = size * 5e-6 * on_some_drives(r, drives(t));
       }},
      {"screw_periodic", true,
       [](Truth& t, double size, std::uint64_t seed) {
         auto r = dice(seed);
         const Vector3d a = size * 0.02 * on_some_drives(r, drives(t));
         for (int i = 0; i < 3; ++i) {
           const double phase = r.uniform(0, 2 * kPi);
           t.drive.screw_sin_mm[i] = a[i] * std::cos(phase);
           t.drive.screw_cos_mm[i] = a[i] * std::sin(phase);
         }
       }},
      {"backlash", true,
       [](Truth& t, double size, std::uint64_t seed) {
         auto r = dice(seed);
         t.drive.backlash_mm = size * 0.03 * on_some_drives(r, drives(t), true);
       }},
      {"thermal_growth", true,
       [](Truth& t, double size, std::uint64_t seed) {
         auto r = dice(seed);
         t.drive.thermal_growth_per_k = size * 1.5e-5 * on_some_drives(r, drives(t), true);
       }},
      {"axis_crosstalk", true,
       [](Truth& t, double size, std::uint64_t seed) {
         auto r = dice(seed);
         const auto i = static_cast<int>(r.below(3));
         t.drive.axis_crosstalk(i, (i + 1 + static_cast<int>(r.below(2))) % 3) =
             size * 1e-3 * (r.uniform() < 0.5 ? 1 : -1);
       }},
      {"platform_load", true,
       [](Truth& t, double size, std::uint64_t seed) {
         auto r = dice(seed);
         t.drive.load_mm = size * 0.5 * Eigen::Vector2d(r.uniform(-1, 1), r.uniform(-1, 1));
         t.drive.load_mm2 = size * 10 * r.uniform(-1, 1);
       }},
      {"guide_bow", true,
       [](Truth& t, double size, std::uint64_t seed) {
         auto r = dice(seed);
         t.drive.guide_bow_per_mm = size * 1e-5 * on_some_drives(r, drives(t));
       }},
      {"tracker_drift", true,
       [](Truth& t, double size, std::uint64_t seed) {
         auto r = dice(seed);
         const double angle = drives(t) > 1 ? r.uniform(0, 2 * kPi) : 0;
         t.tracker.drift_per_h = {size * 0.05 * std::cos(angle), size * 0.05 * std::sin(angle), 0};
       }},
      {"tracker_scale", true,
       [](Truth& t, double size, std::uint64_t seed) {
         auto r = dice(seed);
         t.tracker.scale = size * 1e-4 * (r.uniform() < 0.5 ? 1 : -1);
       }},
      {"guide_yaw", true,  // of a passive guide
       [](Truth& t, double size, std::uint64_t seed) {
         auto r = dice(seed);
         t.drive.guide_yaw_rad_per_mm = size * rad_from_deg(3e-5) * on_some_drives(r, drives(t));
       }},
      // outside the catalogue
      {"setup_shift", false,
       [](Truth& t, double size, std::uint64_t seed) {
         auto r = dice(seed);
         const double angle = r.uniform(0, 2 * kPi);
         // while what is fitted is read, which takes less than half as long on a stage of axes
         const double share = t.nominal.kind->has_point_platform() ? 0.45 : 1;
         t.shifts.push_back({share * r.uniform(2000, 6500),
                             {size * 0.03 * std::cos(angle), size * 0.03 * std::sin(angle), 0}});
       }},
      {"cubic_lead", false,
       [](Truth& t, double size, std::uint64_t seed) {
         auto r = dice(seed);
         t.drive.lead_cubic_per_mm2 = size * 5e-8 * on_some_drives(r, drives(t));
       }},
      {"rail_bump", false,
       [](Truth& t, double size, std::uint64_t seed) {
         auto r = dice(seed);
         const int drive = one_drive(r, t);
         const double centre_mm = middle_mm(t, drive) + r.uniform(-60, 60);
         t.bumps.push_back({drive, centre_mm, r.uniform(12, 30), size * 0.05});
       }},
      {"half_turn", false,
       [](Truth& t, double size, std::uint64_t seed) {
         auto r = dice(seed);
         const double phase = r.uniform(0, 2 * kPi);
         t.harmonics.push_back(
             {one_drive(r, t), 5, size * 0.02 * std::cos(phase), size * 0.02 * std::sin(phase)});
       }},
      {"belt_period", false,
       [](Truth& t, double size, std::uint64_t seed) {
         auto r = dice(seed);
         const double phase = r.uniform(0, 2 * kPi);
         t.harmonics.push_back({one_drive(r, t), r.uniform(13, 37), size * 0.02 * std::cos(phase),
                                size * 0.02 * std::sin(phase)});
       }},
      {"start_transient", false,
       [](Truth& t, double size, std::uint64_t seed) {
         auto r = dice(seed);
         t.drive.transient_mm = size * 0.1 * on_some_drives(r, drives(t));
         t.drive.transient_tau_s = r.uniform(300, 1200);
       }},
      {"lost_motion", false,
       [](Truth& t, double size, std::uint64_t seed) {
         auto r = dice(seed);
         t.drive.stick_slip = size * 2e-3 * on_some_drives(r, drives(t), true);
       }},
      {"tracker_swirl", false,
       [](Truth& t, double size, std::uint64_t seed) {
         auto r = dice(seed);
         t.tracker.swirl_rad_per_mm = size * 2e-6 * (r.uniform() < 0.5 ? 1 : -1);
       }},
      {"thermal_lag", false,
       [](Truth& t, double size, std::uint64_t seed) {
         auto r = dice(seed);
         t.drive.thermal_growth_per_k = size * 1.5e-5 * on_some_drives(r, drives(t), true);
         t.drive.thermal_lag_s = r.uniform(1200, 2400);
       }},
      {"hysteresis", true, nullptr,
       [](Beyond& b, double size, std::uint64_t seed) {
         auto r = dice(seed);
         b.play_mm = size * 0.02 * on_some_drives(r, b.drives, true);
         b.radii_mm.clear();
         for (const double radius : {2.0, 4.0, 8.0, 16.0, 32.0}) {
           if (r.uniform() < 0.6) b.radii_mm.push_back(radius);
         }
         if (b.radii_mm.empty()) b.radii_mm = {12};
       }},
      {"lagged_growth", true, nullptr,
       [](Beyond& b, double size, std::uint64_t seed) {
         auto r = dice(seed);
         b.late_growth_per_k = size * 1.5e-5 * on_some_drives(r, b.drives, true);
         b.late_s = r.uniform(600, 3600);
       }},
      {"move_memory", true, nullptr,
       [](Beyond& b, double size, std::uint64_t seed) {
         auto r = dice(seed);
         b.memory_mm = size * 0.02 * on_some_drives(r, b.drives, true);
         b.memory_length_mm = r.uniform(1.5, 6);
       }},
      {"overshoot", false, nullptr,
       [](Beyond& b, double size, std::uint64_t seed) {
         auto r = dice(seed);
         b.memory_mm = -size * 0.02 * on_some_drives(r, b.drives, true);
         b.memory_length_mm = 1e6;
       }},
      {"plane_tilt", false, nullptr,
       [](Beyond& b, double size, std::uint64_t seed) {
         auto r = dice(seed);
         b.tilt = size * 2e-4;
         b.azimuth_rad = r.uniform(0, kPi);
       }},
  };
}

struct Visit {
  Pose target;
  ReadingSet set;
};

/// Places of a point platform, by chance: those of a lattice would meet a screw at one phase. A
/// quarter is visited twice.
std::vector<Visit> visits_of_axes(const Design& design, int n_axes, Random& random) {
  const double half_mm = 100 * design.reach;
  std::vector<Visit> all;
  const auto place = [&](ReadingSet set) {
    const double x_mm = random.uniform(-half_mm, half_mm);
    all.push_back({{x_mm, n_axes > 1 ? random.uniform(-half_mm, half_mm) : 0, 0}, set});
  };
  const int fitted = static_cast<int>(120 * design.thinning);
  for (int i = 0; i < fitted; ++i) place(ReadingSet::identify);
  for (int i = 0; i < fitted / 4; ++i) {
    all.push_back(all[random.below(static_cast<std::uint64_t>(fitted))]);
  }
  for (int i = 0; i < 40; ++i) place(ReadingSet::validate);
  return all;
}

std::vector<Visit> visits(const Design& design, Random& random) {
  const MachineKind& kind = *find_machine_kind(design.machine);
  if (kind.has_point_platform()) return visits_of_axes(design, kind.n_chains, random);
  std::vector<Visit> all;
  const std::vector<double> turns_deg =
      design.name == "paper" ? std::vector<double>{0} : std::vector<double>{-4, 0, 4};
  for (const double turn : turns_deg) {
    for (Pose pose : paper_80(10 * design.reach)) {
      pose.phi_rad = rad_from_deg(design.reach * turn);
      all.push_back({pose, ReadingSet::identify});
    }
  }
  if (design.name != "paper") {
    for (int i = 0; i < 37; ++i) all.push_back(all[random.below(240)]);
    for (std::size_t i = all.size() - 1; i > 0; --i) std::swap(all[i], all[random.below(i + 1)]);
  }
  if (design.thinning < 1) {
    std::erase_if(all, [&](const Visit&) { return random.uniform() > design.thinning; });
  }
  for (const double turn :
       design.name == "paper" ? std::vector<double>{0} : std::vector<double>{-3, 3}) {
    for (Pose pose : paper_48(20 * design.reach)) {
      pose.phi_rad = rad_from_deg(design.reach * turn);
      all.push_back({pose, ReadingSet::validate});
    }
  }
  return all;
}

std::vector<Reading> plan_readings(const Design& design, const Machine& machine,
                                   std::uint64_t seed) {
  Random random = Random::stream(seed, "plan");
  std::vector<Reading> readings;
  const MachineSolver solver(machine);
  Displacements at = solver.drives(machine.home).l_mm;
  const std::vector<Visit> all = visits(design, random);
  double time_s = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    Reading r;
    r.seq = static_cast<int>(i) + 1;
    r.target = all[i].target;
    r.set = all[i].set;
    r.conditions.cmd_mm = solver.drives(r.target).l_mm;
    r.conditions.from_mm = at;
    if (design.name != "paper") {
      for (int k = 0; k < machine.kind->n_chains; ++k)
        r.conditions.from_mm[k] =
            r.conditions.cmd_mm[k] + (random.uniform() < 0.5 && !design.one_direction ? 1 : -1) *
                                         design.reach * random.uniform(2, 10);
    }
    const auto of_set = static_cast<std::size_t>(
        std::count_if(all.begin(), all.end(), [&](const Visit& v) { return v.set == all[i].set; }));
    const auto before = static_cast<std::size_t>(
        std::count_if(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(i),
                      [&](const Visit& v) { return v.set == all[i].set; }));
    r.conditions.epoch =
        1 + static_cast<int>(before * static_cast<std::size_t>(design.epochs) / of_set);
    time_s += random.uniform(20, 30);
    r.conditions.time_s = time_s;
    at = r.conditions.cmd_mm;
    readings.push_back(r);
  }
  return readings;
}

/// The machine as the campaign states it.
Machine stated(const Design& design) {
  Machine machine = starting_machine(design.machine);
  if (machine.kind->chain != &kPrrChain) return machine;
  for (Drive& drive : machine.drives) drive.lead_mm = design.lead_mm;
  return machine;
}

Truth make_truth(const Design& design, std::uint64_t seed) {
  Random random = Random::stream(seed, "truth");
  Truth truth;
  truth.nominal = stated(design);
  for (Drive& drive : truth.nominal.drives) drive.lead_mm *= 1 + design.lead_error;
  truth.actual = truth.nominal.chains;
  if (truth.nominal.kind->chain == &kPrrChain) {
    Machine built = truth.nominal;
    set_geometry(built, random_geometry(random, 1));
    truth.actual = built.chains;
  } else {
    const MachineKind& kind = *truth.nominal.kind;
    for (const MachineParameter& p : parameters_of(kind)) {
      // An angle of a square axis acts as its cosine alone, which is an error of its lead.
      const bool cosine = p.is_angle && kind.has_point_platform();
      if (cosine && (kind.n_chains == 1 || p.name.starts_with("alpha"))) continue;
      truth.actual[static_cast<std::size_t>(p.chain)][p.place] += p.tolerance * random.normal();
    }
  }
  for (int e = 0; e < design.epochs; ++e) {
    simulate::EpochTruth epoch;
    for (int i = 0; e > 0 && i < drives(truth); ++i) epoch.l_zero_mm[i] = 0.05 * random.normal();
    if (e > 0)
      epoch.frame = {0.05 * random.normal(), 0.05 * random.normal(),
                     rad_from_deg(0.01) * random.normal()};
    truth.epochs.push_back(epoch);
  }
  truth.tracker.sigma_xy_mm = design.sigma_xy_mm;
  truth.tracker.sigma_phi_rad = rad_from_deg(design.sigma_phi_deg);
  truth.tracker.correlation = std::max(0.0, design.correlation);
  truth.temperature = {random.uniform(18.5, 20.5), random.uniform(3, 6),
                       random.uniform(1500, 3500)};
  truth.seed = mix(seed, "noise", 0);
  return truth;
}

/// Displacements that the drives miss along the path, reading by reading.
std::vector<Displacements> along_path(const std::vector<Reading>& readings, const Beyond& b,
                                      const Displacements& home_mm) {
  std::vector<Displacements> off(readings.size(), Displacements::Zero());
  std::map<std::pair<int, std::size_t>, Displacements> F;  // of each epoch and radius
  // the rails' temperature, in steps of a second from the thermometer's broken line
  double late_degc = readings.empty() ? 0 : *readings.front().conditions.temp_degc;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const Conditions& c = readings[i].conditions;
    if (i > 0) {
      const Conditions& last = readings[i - 1].conditions;
      const double seconds = *c.time_s - *last.time_s;
      const int steps = std::max(1, static_cast<int>(seconds));
      for (int s = 0; s < steps; ++s) {
        const double shown = *last.temp_degc + (*c.temp_degc - *last.temp_degc) * (s + 0.5) / steps;
        late_degc += (shown - late_degc) * -std::expm1(-seconds / steps / b.late_s);
      }
    }
    off[i] += (late_degc - 20) * b.late_growth_per_k.cwiseProduct(c.cmd_mm);
    const Displacements move = c.cmd_mm - c.from_mm;
    for (int k = 0; k < kChains; ++k) {
      const double sign = move[k] > 0 ? 1 : -1;
      off[i][k] -= b.memory_mm[k] * sign * std::exp(-std::abs(move[k]) / b.memory_length_mm);
    }
    for (std::size_t n = 0; n < b.radii_mm.size(); ++n) {
      const double r = b.radii_mm[n];
      Displacements& at = F.try_emplace({c.epoch, n}, home_mm).first->second;
      for (const Displacements& l : {c.from_mm, c.cmd_mm}) {
        for (int k = 0; k < kChains; ++k) at[k] = std::clamp(at[k], l[k] - r, l[k] + r);
      }
      const double share = 1 / (r * static_cast<double>(b.radii_mm.size()));
      off[i] -= share * b.play_mm.cwiseProduct(c.cmd_mm - at);
    }
  }
  return off;
}

/// Student's t of 3 … degrees, scaled to a standard deviation of 1.
double student(Random& random, double degrees) {
  double chi2 = 0;
  for (int k = 0; k < static_cast<int>(degrees); ++k) chi2 += std::pow(random.normal(), 2);
  return random.normal() / std::sqrt(chi2 / (degrees - 2));
}

/// One coordinate's noise of a kind that the virtual tracker does not have, over its sigma.
double other_noise(Random& random, const Design& design) {
  return design.student > 0 ? student(random, design.student) : random.normal();
}

/// Fills in what robot and tracker do at the planned commands; without noise when `still`.
void measure(std::vector<Reading>& readings, const Truth& truth, const Beyond& beyond,
             const Design& design, bool still) {
  const simulate::VirtualRobot robot(truth);
  const bool own_noise = !still && (design.student > 0 || design.correlation < 0);
  const double rho = std::min(0.0, design.correlation);
  Vector3d noise = Vector3d::Zero();
  Random random = Random::stream(truth.seed, "other noise");
  for (Reading& r : readings) r.conditions.temp_degc = robot.temperature_degc(*r.conditions.time_s);
  const auto off = along_path(readings, beyond, robot.home_mm());
  const double c = std::cos(beyond.azimuth_rad), s = std::sin(beyond.azimuth_rad);
  for (std::size_t i = 0; i < readings.size(); ++i) {
    Reading& r = readings[i];
    Conditions done = r.conditions;
    done.cmd_mm += off[i];
    done.from_mm += off[i];
    const auto number = static_cast<std::uint64_t>(r.seq);
    const MachinePose seen = still || own_noise ? robot.seen_pose(done) : robot.read(done, number);
    if (!seen.ok()) throw std::runtime_error("the virtual robot can't reach a planned point");
    r.measured = seen.pose;
    const double along = beyond.tilt * (c * seen.pose.x_mm + s * seen.pose.y_mm);
    r.measured->x_mm -= c * along;
    r.measured->y_mm -= s * along;
    if (!own_noise) continue;
    const double kept = i > 0 ? rho : 0;
    for (double& e : noise) e = kept * e + std::sqrt(1 - kept * kept) * other_noise(random, design);
    const simulate::TrackerTruth& t = truth.tracker;
    Vector3d sigma(t.sigma_xy_mm, t.sigma_xy_mm, t.sigma_phi_rad);
    for (int k = 0; k < 3; ++k) {
      if (!truth.nominal.measured[static_cast<std::size_t>(k)]) sigma[k] = 0;
    }
    r.measured = Pose::from(r.measured->vector() + noise.cwiseProduct(sigma));
  }
}

void put_in(const Family& family, double size, std::uint64_t seed, Truth& truth, Beyond& beyond) {
  if (family.hide != nullptr) family.hide(truth, size, seed);
  if (family.beyond != nullptr) family.beyond(beyond, size, seed);
}

/// Makes `count` of the fitted readings wrong by 0.3 mm.
void spoil(HiddenCase& c, int count, std::uint64_t seed) {
  Random random = Random::stream(seed, "outliers");
  while (static_cast<int>(c.bad.size()) < count) {
    const std::size_t at = random.below(c.campaign.readings.size());
    Reading& r = c.campaign.readings[at];
    if (r.set != ReadingSet::identify || std::count(c.bad.begin(), c.bad.end(), at) > 0) continue;
    const double angle = random.uniform(0, 2 * kPi);
    r.measured->x_mm += 0.3 * std::cos(angle);
    r.measured->y_mm += 0.3 * std::sin(angle);
    c.bad.push_back(at);
  }
}

double surviving_chi2(const Machine& machine, const std::vector<Reading>& readings,
                      const TrackerSigma& sigma) {
  std::vector<Reading> fitted;
  std::copy_if(readings.begin(), readings.end(), std::back_inserter(fitted),
               [](const Reading& r) { return r.set == ReadingSet::identify; });
  return fit_geometry(nominal_model(machine), fitted, sigma).chi2;
}

}  // namespace

const std::vector<Family>& families() {
  static const std::vector<Family> all = make_families();
  return all;
}

const Family& family(const std::string& name) {
  for (const Family& f : families()) {
    if (f.name == name) return f;
  }
  throw std::runtime_error("no family " + name);
}

HiddenCase make_case(const Design& design, const std::vector<const Family*>& hidden, double rho,
                     std::uint64_t seed) {
  HiddenCase result;
  Campaign& campaign = result.campaign;
  campaign.name = "hidden-" + std::to_string(seed);
  campaign.simulated = true;
  campaign.machine = stated(design);
  campaign.tracker = TrackerSigma{design.sigma_xy_mm * design.stated_over_true,
                                  rad_from_deg(design.sigma_phi_deg) * design.stated_over_true};
  campaign.readings = plan_readings(design, campaign.machine, seed);
  const TrackerSigma sigma{design.sigma_xy_mm, rad_from_deg(design.sigma_phi_deg)};
  Truth truth = make_truth(design, seed);
  const int n_drives = campaign.machine.kind->n_chains;
  Beyond beyond{.drives = n_drives};
  for (std::size_t k = 0; k < hidden.size(); ++k) {
    const std::uint64_t own = mix(seed, hidden[k]->name, k);
    Truth alone = make_truth(design, seed);
    Beyond beside{.drives = n_drives};
    put_in(*hidden[k], 1, own, alone, beside);
    measure(campaign.readings, alone, beside, design, true);
    const double chi2 = surviving_chi2(campaign.machine, campaign.readings, sigma);
    put_in(*hidden[k], chi2 > 1e-6 ? rho / std::sqrt(chi2) : 0, own, truth, beyond);
    result.hidden.push_back(hidden[k]->name);
    result.in_catalogue = result.in_catalogue && hidden[k]->in_catalogue;
  }
  result.still = campaign.readings;
  measure(result.still, truth, beyond, design, true);
  measure(campaign.readings, truth, beyond, design, false);
  spoil(result, design.outliers, seed);
  result.truth = truth;
  result.beyond = beyond;
  std::sort(result.hidden.begin(), result.hidden.end());
  return result;
}

Campaign with_points(const HiddenCase& hidden, const NextPoints& next) {
  Campaign campaign = hidden.campaign;
  Truth truth = hidden.truth;
  Random random = Random::stream(truth.seed, "next");
  simulate::EpochTruth epoch;
  for (int i = 0; i < drives(truth); ++i) epoch.l_zero_mm[i] = 0.05 * random.normal();
  epoch.frame = {0.05 * random.normal(), 0.05 * random.normal(),
                 rad_from_deg(0.01) * random.normal()};
  truth.epochs.push_back(epoch);
  const simulate::VirtualRobot robot(truth);
  const MachineSolver solver(campaign.machine);
  const std::size_t first = campaign.readings.size();
  double time_s =
      *campaign.readings.back().conditions.time_s + 3600 * next.state.wait_h.value_or(0.1);
  for (const NextPoint& point : next.points) {
    Reading r;
    r.seq = campaign.readings.back().seq + 1;
    r.target = point.target;
    r.set = ReadingSet::identify;
    Conditions& c = r.conditions;
    c.epoch = static_cast<int>(truth.epochs.size());
    c.cmd_mm = c.from_mm = solver.drives(r.target).l_mm;
    for (int k = 0; k < drives(truth); ++k)
      c.from_mm[k] -= next.state.approach_mm * point.approach[static_cast<std::size_t>(k)];
    c.time_s = time_s += random.uniform(20, 30);
    c.temp_degc = next.state.temp_degc.value_or(robot.temperature_degc(time_s));
    campaign.readings.push_back(r);
  }
  const auto off = along_path(campaign.readings, hidden.beyond, robot.home_mm());
  for (std::size_t i = first; i < campaign.readings.size(); ++i) {
    Reading& r = campaign.readings[i];
    Conditions done = r.conditions;
    done.cmd_mm += off[i];
    done.from_mm += off[i];
    const MachinePose seen = robot.read(done, static_cast<std::uint64_t>(r.seq));
    if (!seen.ok())
      throw std::runtime_error("the virtual robot can't reach a point it was sent to");
    r.measured = seen.pose;
  }
  return campaign;
}

Design design_of(const std::string& machine) {
  if (find_machine_kind(machine)->has_point_platform()) {
    return {.machine = machine, .sigma_xy_mm = 0.0005, .sigma_phi_deg = 0.0003};
  }
  if (machine != "3-PPR") return {.machine = machine};
  return {.machine = machine, .reach = 0.03, .sigma_xy_mm = 0.0005, .sigma_phi_deg = 0.0003};
}

HiddenCase hide(const std::vector<std::string>& names, double rho, std::uint64_t seed,
                const Design& design) {
  std::vector<const Family*> hidden;
  for (const std::string& name : names) hidden.push_back(&family(name));
  return make_case(design, hidden, rho, seed);
}

std::map<std::string, double> parameters_of(const HiddenCase& hidden) {
  const simulate::Truth& t = hidden.truth;
  const Beyond& b = hidden.beyond;
  std::map<std::string, double> all;
  for (int i = 0; i < kChains; ++i) {
    const std::string n = std::to_string(i + 1);
    all["lead_scale k_" + n] = t.drive.lead_scale[i];
    all["lead_curvature q_" + n] = t.drive.lead_curvature_per_mm[i];
    all["screw_periodic a_" + n] = t.drive.screw_sin_mm[i];
    all["screw_periodic b_" + n] = t.drive.screw_cos_mm[i];
    all["backlash w_" + n] = t.drive.backlash_mm[i];
    all["thermal_growth c_" + n] = t.drive.thermal_growth_per_k[i];
    all["guide_bow c_" + n] = t.drive.guide_bow_per_mm[i];
    all["guide_yaw k_" + n] = deg_from_rad(t.drive.guide_yaw_rad_per_mm[i]);
    all["move_memory v_" + n] = b.memory_mm[i];
    all["hysteresis v_" + n] = b.play_mm[i];
    all["lagged_growth c_" + n] = b.late_growth_per_k[i];
    for (int j = 0; j < kChains; ++j) {
      if (i == j) continue;
      all["axis_crosstalk m_" + n + std::to_string(j + 1)] = t.drive.axis_crosstalk(i, j);
    }
  }
  if (!b.memory_mm.isZero(0)) all["move_memory d"] = b.memory_length_mm;
  if (!b.late_growth_per_k.isZero(0)) all["lagged_growth tau"] = b.late_s;
  all["platform_load fx"] = t.drive.load_mm[0];
  all["platform_load fy"] = t.drive.load_mm[1];
  all["platform_load m"] = t.drive.load_mm2;
  all["tracker_drift vx"] = t.tracker.drift_per_h.x_mm;
  all["tracker_drift vy"] = t.tracker.drift_per_h.y_mm;
  all["tracker_drift vphi"] = 0;  // no family turns
  all["tracker_scale m"] = t.tracker.scale;
  return all;
}

}  // namespace trammel::tests
