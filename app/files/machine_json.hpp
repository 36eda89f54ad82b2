#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/files/fields.hpp"
#include "core/mechanism/machine.hpp"

namespace trammel {

/// "format": "machine/1": {kind, chains, drives, home, measured}. A chain holds the parameters of
/// its kind (chain_kind.hpp: those that may be left out are 0), a drive {lead_mm, limits}, home the
/// machine's coordinates (absent: the origin), "measured" some of x, y, phi (absent: the machine's
/// coordinates). Throws InputError with file, line and field; the machine has passed `validate`.
/// Proof: machine_json_test.cpp.
Machine read_machine(Fields fields);

/// The same object, every parameter stated; read_machine gives the same numbers back, bit for bit.
nlohmann::ordered_json machine_json(const Machine& machine);

/// The machine of a campaign/2: {type, chains, drives, home} with a drive's limits beside its lead,
/// and the campaign's own field "measured".
Machine read_campaign_machine(Fields& campaign);
/// "mechanism" and "measured" of the same.
void write_campaign_machine(const Machine& machine, nlohmann::ordered_json& campaign);

/// {x_mm, y_mm, phi_deg}, those that the machine has.
nlohmann::ordered_json pose_json(const Machine& machine, const Pose& pose);

/// A machine/1 file, or one that holds a 3-PRR as read_mechanism_file() reads it.
Machine read_machine_file(const std::filesystem::path& path);

}  // namespace trammel
