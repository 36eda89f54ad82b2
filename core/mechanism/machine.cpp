#include "core/mechanism/machine.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/mechanism/machine_kinematics.hpp"
#include "core/mechanism/machine_solver.hpp"

namespace trammel {

namespace {

constinit const std::array<MachineKind, 5> kMachineKinds = {{
    {"3-PRR", &kPrrChain, 3, {true, true, true}},
    {"3-PPR", &kPprChain, 3, {true, true, true}},
    {"3-RPR", &kRprChain, 3, {true, true, true}},
    {"XY", &kPprChain, 2, {true, true, true}},
    {"X", &kPprChain, 1, {true, false, false}},
}};

std::vector<MachineParameter> list_parameters(const MachineKind& kind) {
  std::vector<MachineParameter> all;
  for (const bool completes : {false, true}) {
    for (int chain = 0; chain < kind.n_chains; ++chain) {
      for (std::size_t k = 0; k < kind.chain->parameters.size(); ++k) {
        const ChainParameter& p = kind.chain->parameters[k];
        if (p.completes != completes || !kind.has_parameter(p)) continue;
        all.push_back({std::string(p.symbol) + "_" + std::to_string(chain + 1), chain, k,
                       p.is_angle(), p.tolerance(), completes});
      }
    }
  }
  return all;
}

/// "chains[1]"
std::string numbered(const char* list, std::size_t i) {
  std::string text = list;
  text += '[';
  text += std::to_string(i);
  text += ']';
  return text;
}

void require_machine(bool ok, const std::string& field, const std::string& got,
                     const std::string& expected) {
  if (ok) return;
  throw InputError({.what = "the mechanism is not usable",
                    .where = {.field = field},
                    .got = got,
                    .expected = expected});
}

/// No machine on a bench is longer, and nothing that squares a length overflows.
constexpr double kLongestMm = 1e5;
constexpr double kMostLeadMm = 1e4;  // of a rack, a turn

bool within_range(ValueRange range, double value) {
  return std::abs(value) <= kLongestMm && (range == ValueRange::any || value > 0 ||
                                           (range == ValueRange::not_negative && value == 0));
}

void validate_chain(const MachineKind& kind, const ChainValues& values, const std::string& chain) {
  constexpr std::array<const char*, 3> kExpected = {"a number within 1e5",
                                                    "a positive length within 1e5 mm",
                                                    "no negative length, nor one over 1e5 mm"};
  for (std::size_t k = 0; k < kind.chain->parameters.size(); ++k) {
    const ChainParameter& p = kind.chain->parameters[k];
    require_machine(within_range(p.range, values[k]), chain + "." + std::string(p.field),
                    std::to_string(values[k]), kExpected[static_cast<std::size_t>(p.range)]);
    if (kind.has_parameter(p)) continue;
    require_machine(values[k] == 0, chain + "." + std::string(p.field), std::to_string(values[k]),
                    "0: the platform of an " + std::string(kind.name) + " machine is a point");
  }
  const auto fault = kind.chain->fault(values);
  if (fault) throw InputError({.what = std::string(*fault), .where = {.field = chain}});
}

}  // namespace

std::span<const MachineKind> machine_kinds() { return kMachineKinds; }

const MachineKind* find_machine_kind(std::string_view name) {
  const auto* at = std::ranges::find(kMachineKinds, name, &MachineKind::name);
  return at == kMachineKinds.end() ? nullptr : &*at;
}

const std::vector<MachineParameter>& parameters_of(const MachineKind& kind) {
  static const auto kLists = [] {
    std::array<std::vector<MachineParameter>, kMachineKinds.size()> lists;
    std::ranges::transform(kMachineKinds, lists.begin(), list_parameters);
    return lists;
  }();
  return kLists[static_cast<std::size_t>(&kind - kMachineKinds.data())];
}

const ChainColumns& chain_columns(const MachineKind& kind) {
  static const auto kColumns = [] {
    std::array<ChainColumns, kMachineKinds.size()> columns;
    for (std::size_t k = 0; k < columns.size(); ++k) {
      const ChainKind& chain = *kMachineKinds[k].chain;
      const auto& parameters = parameters_of(kMachineKinds[k]);
      for (std::size_t j = 0; j < parameters.size(); ++j) {
        const auto i = static_cast<std::size_t>(parameters[j].chain);
        if (parameters[j].place == chain.zero) columns[k].zero[i] = static_cast<int>(j);
        if (parameters[j].place == chain.offset) columns[k].offset[i] = static_cast<int>(j);
      }
    }
    return columns;
  }();
  return kColumns[static_cast<std::size_t>(&kind - kMachineKinds.data())];
}

namespace {

std::string axis_along(double angle_rad) {
  return std::abs(std::cos(angle_rad)) >= std::abs(std::sin(angle_rad)) ? "x axis" : "y axis";
}

}  // namespace

std::string drives_name(const MachineKind& kind) {
  return kind.chain->drive_word == "axis" ? "axes" : std::string(kind.chain->drive_word) + "s";
}

std::string drive_name(const Machine& machine, int chain) {
  if (machine.kind->has_point_platform()) {
    return axis_along(machine.chains[static_cast<std::size_t>(chain)][0]);
  }
  return std::string(machine.kind->chain->drive_word) + " " + std::to_string(chain + 1);
}

std::string guide_name(const Machine& machine, int chain) {
  if (machine.kind->has_point_platform()) {
    return axis_along(machine.chains[static_cast<std::size_t>(chain)][1]);
  }
  return machine.kind->chain == &kPrrChain ? drive_name(machine, chain)
                                           : "guide " + std::to_string(chain + 1);
}

void validate(const Machine& machine) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(machine.kind->n_chains); ++i) {
    validate_chain(*machine.kind, machine.chains[i], numbered("chains", i));
    const Drive& drive = machine.drives[i];
    require_machine(drive.lead_mm > 0 && drive.lead_mm <= kMostLeadMm,
                    numbered("drives", i) + ".lead_mm", std::to_string(drive.lead_mm),
                    "a positive length within 1e4 mm");
    const Limits& limits = drive.limits;
    require_machine(std::abs(limits.l_min_mm) <= kLongestMm &&
                        std::abs(limits.l_max_mm) <= kLongestMm &&
                        limits.l_min_mm < limits.l_max_mm,
                    numbered("drives", i) + ".limits.l_max_mm", std::to_string(limits.l_max_mm),
                    "more than l_min_mm, both within 1e5 mm");
  }
  require_machine((machine.home.vector().array().abs() <= kLongestMm).all(), "home",
                  std::to_string(machine.home.x_mm), "a pose within 1e5 mm of the origin");
  require_machine(machine.measured[0] || machine.measured[1], "measured",
                  machine.measured[2] ? "phi alone" : "nothing",
                  "x or y: by positions everything is judged");
  const Reach home = reach(machine, machine.home);
  if (home.status == Reach::Status::singular) {
    throw InputError({.what = "the machine is singular at home: there its drives do not decide "
                              "where the platform goes",
                      .where = {.field = "home"},
                      .got = "singularity margin " + std::to_string(home.singularity.margin()),
                      .expected = "a home well away from every singular pose",
                      .hint = machine.kind->chain == &kRprChain
                                  ? "a platform that is the base's triangle on a smaller scale is "
                                    "singular wherever the two are parallel: turn one of them"
                                  : ""});
  }
}

Machine starting_machine(std::string_view name) {
  const MachineKind* kind = find_machine_kind(name);
  if (kind == nullptr) {
    throw NotFoundError({.what = "no such kind of machine",
                         .got = std::string(name),
                         .expected = "3-PRR, 3-PPR, 3-RPR, XY or X"});
  }
  if (kind->chain == &kPrrChain) return machine_of(paper_mechanism());
  Machine machine{.kind = kind, .home = {}, .measured = {true, true, kind->n_chains == 3}};
  if (kind->n_chains == 1) machine.measured = kind->measurable;
  const auto deg = [](double d) { return rad_from_deg(d); };
  if (name == "3-PPR") {  // alpha, gamma, l, c, r, beta: two drives along x, one along y
    machine.chains = {{{deg(0), deg(90), 0, 0, 100, deg(90)},
                       {deg(0), deg(90), 0, 0, 100, deg(270)},
                       {deg(90), deg(0), 0, 0, 100, deg(0)}}};
    // With r, a guide is offset by its joint's arm, so that every drive stands at 0 at home.
    for (ChainValues& p : machine.chains) p[3] = p[4] * std::sin(p[5] - p[1]);
    machine.drives.fill({.lead_mm = 1, .limits = {-5, 5}});
  } else if (name == "3-RPR") {  // Ax, Ay, l, r, beta: base of 400 mm, platform turned by 60 deg
    for (std::size_t i = 0; i < kChains; ++i) {
      const double at = deg(90 + 120.0 * static_cast<double>(i));
      machine.chains[i] = {400 * std::cos(at), 400 * std::sin(at), 0, 100, at + deg(60)};
    }
    machine.drives.fill({.lead_mm = 5, .limits = {200, 600}});
  } else {  // a drive along x with its guide along y, and one along y with its guide along x
    machine.chains[0] = {deg(0), deg(90)};
    machine.chains[1] = {deg(90), deg(0)};
    machine.drives.fill({.lead_mm = 10, .limits = {-150, 150}});
    if (kind->n_chains == 1) machine.chains[1] = {};
  }
  for (std::size_t i = static_cast<std::size_t>(kind->n_chains); i < kChains; ++i) {
    machine.drives[i] = {};
  }
  return machine;
}

Machine machine_of(const Mechanism& mechanism) {
  Machine machine{
      .kind = &kMachineKinds[0], .home = mechanism.home, .measured = {true, true, true}};
  set_geometry(machine, mechanism.geometry);
  machine.drives.fill({mechanism.screw_lead_mm, mechanism.limits});
  return machine;
}

Mechanism mechanism_of(const Machine& machine) {
  if (machine.kind != &kMachineKinds[0]) {
    throw InputError({.what = "this serves a 3-PRR alone so far",
                      .where = {.field = "kind"},
                      .got = std::string(machine.kind->name),
                      .expected = "3-PRR",
                      .hint = "`trammel mechanism` knows every kind of machine"});
  }
  const Drive& drive = machine.drives[0];
  for (std::size_t i = 1; i < kChains; ++i) {
    if (machine.drives[i] == drive) continue;
    throw InputError({.what = "the drives differ, which this does not know so far",
                      .where = {.field = numbered("drives", i)},
                      .expected = "the lead and limits of the first drive",
                      .hint = "`trammel mechanism` knows them apart"});
  }
  return {.geometry = geometry_of(machine),
          .screw_lead_mm = drive.lead_mm,
          .home = machine.home,
          .limits = drive.limits};
}

Geometry geometry_of(const Machine& machine) {
  TRAMMEL_ASSERT(machine.kind->chain == &kPrrChain);
  Geometry geometry;
  for (std::size_t i = 0; i < kChains; ++i) {
    const ChainValues& p = machine.chains[i];
    geometry.chains[i] = {p[0], p[1], p[2], p[3], p[4], p[5], p[6]};
  }
  return geometry;
}

void set_geometry(Machine& machine, const Geometry& geometry) {
  for (std::size_t i = 0; i < kChains; ++i) {
    const Chain& c = geometry.chains[i];
    machine.chains[i] = {c.alpha_rad, c.beta_rad, c.r_mm, c.S_mm, c.l_zero_mm, c.R_mm, c.h_mm};
  }
}

}  // namespace trammel
