#pragma once
// A campaign's machine: its rows, and its one canonical form.

#include "core/mechanism/machine.hpp"
#include "store/digest.hpp"

namespace trammel::store {

/// Kind, the parameters of each chain in the kind's order, drives, home, measured coordinates.
/// Equal bytes mean equal machines, and no other.
Digest& operator<<(Digest& digest, const Machine& machine);

/// Rows of machine, machine_chain and drive, in a transaction of the caller's.
void add_machine(Connection& connection, Id campaign_id, const Machine& machine);

/// @throws StoreError  rows are missing, or of a kind or a parameter that there is not
Machine load_machine(Connection& connection, Id campaign_id);

/// "alpha_rad" of the file's "alpha_deg": as the store names a parameter.
std::string column_of(const ChainParameter& parameter);

}  // namespace trammel::store
