#include "app/files/machine_json.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "app/files/format.hpp"
#include "app/files/mechanism_json.hpp"
#include "app/files/numbers.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

constexpr std::array<std::string_view, 3> kCoordinateFields = {"x_mm", "y_mm", "phi_deg"};
constexpr std::array<const ChainKind*, 3> kChainKinds = {&kPrrChain, &kPprChain, &kRprChain};

std::string kind_names() {
  std::vector<std::string_view> names;
  for (const MachineKind& kind : machine_kinds()) names.push_back(kind.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

/// Whose first joint is driven and turns: RRR, RRP; RPR drives its P.
bool is_rotary(std::string_view chain) { return chain.starts_with("RR"); }

[[noreturn]] void refuse_rotary(const Fields& fields, std::string_view name) {
  fields.refuse(name, "rotary drives are not served yet", "linear drives, in mm",
                "kinds of machine: " + kind_names());
}

const MachineKind& read_kind(Fields& fields, const char* field) {
  const std::string name = fields.text(field);
  if (const MachineKind* kind = find_machine_kind(name)) return *kind;
  const bool rotary = name.ends_with("RRR") || name.ends_with("RRP") || name == "five-bar" ||
                      name.find("theta") != std::string::npos;
  if (rotary) refuse_rotary(fields, field);
  fields.refuse(field, "no such kind of machine: " + name, "one of " + kind_names());
}

void refuse_strangers(const Fields& fields, const ChainKind& kind) {
  std::vector<std::string_view> own;
  for (const ChainParameter& p : kind.parameters) own.push_back(p.field);
  for (const auto& [key, value] : fields.value().items()) {
    if (key == "kind" || std::ranges::find(own, key) != own.end()) continue;
    for (const ChainKind* other : kChainKinds) {
      if (std::ranges::find(other->parameters, key, &ChainParameter::field) ==
          other->parameters.end()) {
        continue;
      }
      fields.refuse(
          key, fmt::format("a parameter of a {} chain, and this one is {}", other->name, kind.name),
          fmt::format("{}", fmt::join(own, ", ")));
    }
  }
}

ChainValues read_chain_values(Fields& fields, const MachineKind& machine) {
  const ChainKind& kind = *machine.chain;
  const std::string name = fields.text("kind", kind.name);
  if (is_rotary(name)) refuse_rotary(fields, "kind");
  if (name != kind.name) {
    fields.refuse("kind", "no chain of this machine: " + name,
                  fmt::format("{}, as every chain of this {} machine", kind.name, machine.name));
  }
  refuse_strangers(fields, kind);
  ChainValues values = {};
  for (std::size_t k = 0; k < kind.parameters.size(); ++k) {
    const ChainParameter& p = kind.parameters[k];
    const bool may_be_absent = p.optional || !machine.has_parameter(p);
    const double value = may_be_absent ? fields.number(p.field, 0) : fields.number(p.field);
    values[k] = p.is_angle() ? rad_from_deg(value) : value;
  }
  fields.done();
  return values;
}

Drive read_drive_of_machine(Fields& fields) {
  const std::string type = fields.text("type", "linear");
  if (type == "rotary") refuse_rotary(fields, "type");
  if (type != "linear") fields.refuse("type", "no such type of drive: " + type, "linear");
  Drive drive;
  drive.lead_mm = fields.number("lead_mm");
  if (auto limits = fields.optional_object("limits")) {
    drive.limits = {limits->number("l_min_mm"), limits->number("l_max_mm")};
    limits->done();
  } else {
    drive.limits = {fields.number("l_min_mm"), fields.number("l_max_mm")};
  }
  fields.done();
  return drive;
}

/// The objects of a list that holds one for each drive.
std::vector<Fields> one_per_drive(Fields& fields, const char* name, const MachineKind& kind) {
  std::vector<Fields> list = fields.objects(name);
  const auto n = static_cast<std::size_t>(kind.n_chains);
  const std::string expected =
      fmt::format("{}: a machine of kind {} has {} coordinate{} and as many drives", n, kind.name,
                  n, n == 1 ? "" : "s");
  if (list.size() > n) {
    fields.refuse(name, fmt::format("{} {}, more than the machine has freedom", list.size(), name),
                  expected, "machines with more drives than freedom are not served yet");
  }
  if (list.size() < n) fields.refuse(name, fmt::format("{} {}", list.size(), name), expected);
  return list;
}

Pose read_home(Fields fields, const MachineKind& kind) {
  Eigen::Vector3d home = Eigen::Vector3d::Zero();
  for (int c = 0; c < 3; ++c) {
    const std::string_view name = kCoordinateFields[static_cast<std::size_t>(c)];
    if (c < kind.n_chains) {
      home[c] = fields.number(name);
    } else if (fields.has(name)) {
      fields.refuse(name, fmt::format("{} is no coordinate of an {} machine",
                                      kCoordinateNames[static_cast<std::size_t>(c)], kind.name));
    }
  }
  fields.done();
  return {home[0], home[1], rad_from_deg(home[2])};
}

Coordinates read_measured(Fields& fields, const MachineKind& kind) {
  Coordinates measured = {};
  if (!fields.has("measured")) {
    for (std::size_t c = 0; c < static_cast<std::size_t>(kind.n_chains); ++c) measured[c] = true;
    return measured;
  }
  for (const std::string& name : fields.texts("measured")) {
    const auto* at = std::ranges::find(kCoordinateNames, name);
    if (at == kCoordinateNames.end()) {
      fields.refuse("measured", "no such coordinate: " + name, "some of x, y, phi");
    }
    const auto c = static_cast<std::size_t>(at - kCoordinateNames.begin());
    if (!kind.measurable[c]) {
      fields.refuse("measured",
                    fmt::format("{} cannot be measured on an {} machine: its model "
                                "has nothing to compare it with",
                                name, kind.name),
                    fmt::format("{}", kCoordinateNames[0]));
    }
    if (measured[c]) fields.refuse("measured", name + " is named twice", "each coordinate once");
    measured[c] = true;
  }
  if (measured == Coordinates{}) {
    fields.refuse("measured", "no coordinate is measured", "some of x, y, phi");
  }
  return measured;
}

/// Kind, chains, drives and home.
Machine read_parts(Fields& fields, const char* kind_field) {
  const MachineKind& kind = read_kind(fields, kind_field);
  Machine machine{.kind = &kind, .home = {}};
  std::vector<Fields> chains = one_per_drive(fields, "chains", kind);
  std::vector<Fields> drives = one_per_drive(fields, "drives", kind);
  for (std::size_t i = 0; i < chains.size(); ++i) {
    machine.chains[i] = read_chain_values(chains[i], kind);
    machine.drives[i] = read_drive_of_machine(drives[i]);
  }
  if (const auto home = fields.optional_object("home")) machine.home = read_home(*home, kind);
  return machine;
}

/// core names the field from the machine on; its file and line, or those of what is around it, are
/// known here.
void validate_in(const Machine& machine, const Fields& fields) {
  try {
    validate(machine);
  } catch (const InputError& error) {
    ErrorText text = error.text();
    text.where.field = fields.path(text.where.field);
    throw located(InputError(text), fields.file());
  }
}

}  // namespace

Machine read_machine(Fields fields) {
  take_format(fields, "machine/1");
  static_cast<void>(fields.text("name", ""));
  static_cast<void>(fields.text("why", ""));
  Machine machine = read_parts(fields, "kind");
  machine.measured = read_measured(fields, *machine.kind);
  fields.done();
  validate_in(machine, fields);
  return machine;
}

Machine read_campaign_machine(Fields& campaign) {
  Fields mechanism = campaign.object("mechanism");
  Machine machine = read_parts(mechanism, "type");
  mechanism.done();
  machine.measured = read_measured(campaign, *machine.kind);
  validate_in(machine, mechanism);
  return machine;
}

nlohmann::ordered_json pose_json(const Machine& machine, const Pose& pose) {
  const Eigen::Vector3d values(pose.x_mm, pose.y_mm, exact_deg(pose.phi_rad));
  nlohmann::ordered_json json;
  for (int c = 0; c < machine.kind->n_chains; ++c) {
    json[std::string(kCoordinateFields[static_cast<std::size_t>(c)])] = values[c];
  }
  return json;
}

nlohmann::ordered_json machine_json(const Machine& machine) {
  using Json = nlohmann::ordered_json;
  const MachineKind& kind = *machine.kind;
  Json chains = Json::array(), drives = Json::array(), measured = Json::array();
  for (std::size_t i = 0; i < static_cast<std::size_t>(kind.n_chains); ++i) {
    Json chain = {{"kind", kind.chain->name}};
    for (std::size_t k = 0; k < kind.chain->parameters.size(); ++k) {
      const ChainParameter& p = kind.chain->parameters[k];
      if (!kind.has_parameter(p)) continue;
      const double value = machine.chains[i][k];
      chain[std::string(p.field)] = p.is_angle() ? exact_deg(value) : value;
    }
    chains.push_back(chain);
    const Drive& drive = machine.drives[i];
    drives.push_back(
        {{"lead_mm", drive.lead_mm},
         {"limits", {{"l_min_mm", drive.limits.l_min_mm}, {"l_max_mm", drive.limits.l_max_mm}}}});
  }
  for (std::size_t c = 0; c < 3; ++c) {
    if (machine.measured[c]) measured.push_back(kCoordinateNames[c]);
  }
  return {{"format", "machine/1"},
          {"kind", kind.name},
          {"chains", chains},
          {"drives", drives},
          {"home", pose_json(machine, machine.home)},
          {"measured", measured}};
}

void write_campaign_machine(const Machine& machine, nlohmann::ordered_json& campaign) {
  nlohmann::ordered_json json = machine_json(machine);
  for (auto& drive : json["drives"]) {
    const nlohmann::ordered_json limits = drive["limits"];
    drive.erase("limits");
    drive.update(limits);
  }
  for (auto& chain : json["chains"]) chain.erase("kind");
  campaign["mechanism"] = {{"type", json["kind"]},
                           {"chains", json["chains"]},
                           {"drives", json["drives"]},
                           {"home", json["home"]}};
  campaign["measured"] = json["measured"];
}

Machine read_any_machine(Fields fields) {
  const bool says_nothing = !fields.has("type") && !fields.has("chains");
  if (says_nothing || fields.has("format") || fields.has("kind")) return read_machine(fields);
  const Machine machine = machine_of(read_mechanism(fields));
  validate_in(machine, fields);
  return machine;
}

Machine read_machine_file(const std::filesystem::path& path) {
  const JsonFile file = read_json(path);
  Fields top(file);
  if (!top.has("mechanism")) return read_any_machine(top);
  Fields mechanism = top.object("mechanism");
  if (mechanism.has("type") && mechanism.has("drives")) return read_campaign_machine(top);
  return read_any_machine(mechanism);
}

}  // namespace trammel
