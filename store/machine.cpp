#include "store/machine.hpp"

#include <algorithm>

namespace trammel::store {

namespace {

std::size_t n_drives(const Machine& machine) {
  return static_cast<std::size_t>(machine.kind->n_chains);
}

StoreError not_whole(std::string got) {
  return StoreError({.what = "the campaign's machine is not whole",
                     .got = std::move(got),
                     .hint = "see `trammel db verify`"});
}

}  // namespace

std::string column_of(const ChainParameter& parameter) {
  std::string name(parameter.field);
  if (parameter.is_angle()) name.replace(name.size() - 3, 3, "rad");
  return name;
}

Digest& operator<<(Digest& digest, const Machine& machine) {
  digest << machine.kind->name;
  for (std::size_t i = 0; i < n_drives(machine); ++i) {
    for (std::size_t k = 0; k < machine.kind->chain->parameters.size(); ++k) {
      digest << machine.chains[i][k];
    }
    const Drive& drive = machine.drives[i];
    digest << drive.lead_mm << drive.limits.l_min_mm << drive.limits.l_max_mm;
  }
  digest << machine.home.x_mm << machine.home.y_mm << machine.home.phi_rad;
  for (const bool measured : machine.measured) digest << static_cast<int>(measured);
  return digest;
}

void add_machine(Connection& connection, Id campaign_id, const Machine& machine) {
  Statement row(connection, "INSERT INTO machine VALUES (?,?,?,?,?,?,?,?)");
  row << campaign_id << machine.kind->name << machine.home.x_mm << machine.home.y_mm
      << machine.home.phi_rad;
  for (const bool measured : machine.measured) row << measured;
  row.run();
  Statement parameter(connection, "INSERT INTO machine_chain VALUES (?,?,?,?)");
  Statement drive(connection, "INSERT INTO drive VALUES (?,?,?,?,?)");
  for (std::size_t i = 0; i < n_drives(machine); ++i) {
    const int number = static_cast<int>(i) + 1;
    for (std::size_t k = 0; k < machine.kind->chain->parameters.size(); ++k) {
      parameter << campaign_id << number << column_of(machine.kind->chain->parameters[k])
                << machine.chains[i][k];
      parameter.run();
      parameter.reset();
    }
    const Drive& d = machine.drives[i];
    drive << campaign_id << number << d.lead_mm << d.limits.l_min_mm << d.limits.l_max_mm;
    drive.run();
    drive.reset();
  }
}

Machine load_machine(Connection& connection, Id campaign_id) {
  Statement row(connection,
                "SELECT kind, home_x_mm, home_y_mm, home_phi_rad, measures_x, measures_y, "
                "measures_phi FROM machine WHERE campaign_id = ?");
  row << campaign_id;
  if (!row.step()) throw not_whole("no row of machine");
  const MachineKind* kind = find_machine_kind(row.text(0));
  if (kind == nullptr) throw not_whole("kind " + row.text(0));
  Machine machine{.kind = kind,
                  .home = {row.real(1), row.real(2), row.real(3)},
                  .measured = {row.integer(4) != 0, row.integer(5) != 0, row.integer(6) != 0}};
  Statement values(connection,
                   "SELECT chain, parameter, value FROM machine_chain WHERE campaign_id = ?");
  values << campaign_id;
  std::size_t n = 0;
  while (values.step()) {
    const auto chain = static_cast<std::size_t>(values.integer(0) - 1);
    const auto parameter = std::ranges::find(kind->chain->parameters, values.text(1), column_of);
    if (chain >= n_drives(machine) || parameter == kind->chain->parameters.end()) {
      throw not_whole(values.text(1) + " of chain " + values.text(0));
    }
    const auto k = static_cast<std::size_t>(parameter - kind->chain->parameters.begin());
    machine.chains[chain][k] = values.real(2);
    ++n;
  }
  Statement drives(connection,
                   "SELECT drive, lead_mm, l_min_mm, l_max_mm FROM drive WHERE campaign_id = ?");
  drives << campaign_id;
  while (drives.step()) {
    const auto i = static_cast<std::size_t>(drives.integer(0) - 1);
    if (i >= n_drives(machine)) throw not_whole("drive " + drives.text(0));
    machine.drives[i] = {drives.real(1), {drives.real(2), drives.real(3)}};
    ++n;
  }
  const std::size_t expected = n_drives(machine) * (kind->chain->parameters.size() + 1);
  if (n != expected)
    throw not_whole(std::to_string(n) + " of " + std::to_string(expected) + " values");
  return machine;
}

}  // namespace trammel::store
