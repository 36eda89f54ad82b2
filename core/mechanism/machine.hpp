#pragma once
// A planar machine on linear axes: a platform tied to the ground by chains of one kind.

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/mechanism/chain_kind.hpp"
#include "core/mechanism/geometry.hpp"
#include "core/mechanism/pose.hpp"

namespace trammel {

/// x, y, phi: those that a machine has, or that are measured.
using Coordinates = std::array<bool, 3>;
inline constexpr std::array<std::string_view, 3> kCoordinateNames = {"x", "y", "phi"};

/// A machine has as many drives as chains, and as many coordinates: the first of x, y, phi. The
/// others stand still at home, and its platform is a point.
struct MachineKind {
  std::string_view name;
  const ChainKind* chain = nullptr;
  int n_chains = 0;
  Coordinates measurable = {};  // phi of an XY stage is a parasitic angle, not a coordinate

  [[nodiscard]] bool has_point_platform() const { return n_chains < 3; }
  [[nodiscard]] bool has_parameter(const ChainParameter& p) const {
    return !(p.platform && has_point_platform());
  }
};

/// 3-PRR, 3-PPR (UVW, XXY), 3-RPR, XY, X.
std::span<const MachineKind> machine_kinds();
/// Null where no kind has this name.
const MachineKind* find_machine_kind(std::string_view name);

struct Drive {
  double lead_mm = 10;
  Limits limits;
  bool operator==(const Drive& o) const {
    return lead_mm == o.lead_mm && limits.l_min_mm == o.limits.l_min_mm &&
           limits.l_max_mm == o.limits.l_max_mm;
  }
};

struct Machine {
  const MachineKind* kind = &machine_kinds().front();
  std::array<ChainValues, kChains> chains = {};
  std::array<Drive, kChains> drives = {};
  Pose home;  // pose at which the stage was zeroed
  Coordinates measured = {};

  bool operator==(const Machine&) const = default;
};

/// A parameter of a whole machine.
struct MachineParameter {
  std::string name;        // "alpha_1"
  int chain = 0;           // from 0
  std::size_t place = 0;   // in the chain's values
  bool is_angle = false;   // rad inside, deg outside; else mm
  double tolerance = 0;    // one standard deviation of machining and assembly, rad or mm
  bool completes = false;  // not of the paper
};

/// Chain by chain in the order of the chain's kind, then what completes each chain: for the 3-PRR
/// the order of geometry_parameters().
const std::vector<MachineParameter>& parameters_of(const MachineKind& kind);

/// Places in parameters_of(kind) of what moves each chain as its drive does, and across its guide;
/// -1: there is none.
struct ChainColumns {
  std::array<int, kChains> zero = {-1, -1, -1}, offset = {-1, -1, -1};
};
const ChainColumns& chain_columns(const MachineKind& kind);

/// "rails", "axes", "cylinders"
std::string drives_name(const MachineKind& kind);
/// "rail 2"; of a point platform by the direction of its drive: "x axis".
std::string drive_name(const Machine& machine, int chain);
/// Of the guide across which the chain holds the platform: "rail 2", "guide 2", "y axis".
std::string guide_name(const Machine& machine, int chain);

/// Throws InputError that names the first field which is not finite, or out of its range, and a
/// home that is singular ("chains[1].r_mm", "drives[0].lead_mm", "home").
void validate(const Machine& machine);

/// A machine of each kind to start from: the paper's 3-PRR; a UVW stage of 100 mm radius and +-5
/// mm; three cylinders; an XY stage and an axis of 300 mm. Throws NotFoundError for another name.
Machine starting_machine(std::string_view kind);

/// Between the paper's robot as the rest of the program has it, and a machine. mechanism_of throws
/// InputError for another kind, and for drives whose leads or limits differ.
Machine machine_of(const Mechanism& mechanism);
Mechanism mechanism_of(const Machine& machine);
/// Of the parameters alone. Precondition: the machine is a 3-PRR.
Geometry geometry_of(const Machine& machine);
void set_geometry(Machine& machine, const Geometry& geometry);

}  // namespace trammel
