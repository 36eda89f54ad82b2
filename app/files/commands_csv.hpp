#pragma once

#include <filesystem>
#include <vector>

#include "core/measure/reading.hpp"

namespace trammel {

/// One row of a file of commands.
struct CommandRow {
  int seq = 0;  // as the file says; else the row's number from 1
  Conditions conditions;
};

/// Commands to ask a model for: the columns cmd_l1_mm, …, one for each drive of the machine,
/// and, where they matter, from_l1_mm, … (the previous row's cmd; home for the first), epoch,
/// time_s, temp_degc, seq. The other columns of a campaign's readings.csv, and those that begin
/// with x_, are passed over: such a file can be given as it is. Throws InputError with file, line,
/// column and field, NotFoundError. Proof: commands_csv_test.cpp.
std::vector<CommandRow> read_commands_csv(const std::filesystem::path& path,
                                          const Machine& machine);

}  // namespace trammel
